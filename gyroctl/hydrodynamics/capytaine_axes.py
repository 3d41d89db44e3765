"""Axes of Capytaine's files: frequencies under any of their names, headings by their unit, degrees of freedom."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.directions import degrees
from gyroctl.hydrodynamics.moving import Told
from gyroctl.hydrodynamics.site import NAMES, Site
from gyroctl.hydrodynamics.table import DOFS, LAYOUT, Floats
from gyroctl.netcdf import Variable, Variables

FREQUENCIES = ("omega", "freq", "period", "wavenumber", "wavelength")
"""Names of the main dimension, and of what may stand along it."""

UNITS = {"omega": "rad/s", "freq": "Hz", "period": "period"}
"""Unit of each name, for --frequency; the other two are no unit that the option has."""

AGREE = 1e-3
"""Relative difference of two axes of one file that say the same."""


class Axis(NamedTuple):
    """The main dimension of a file."""

    dimension: str
    omega: Floats
    """0 and inf for the limits, in the order of the file. [rad/s]"""
    words: str


def axis_of(variables: Variables, source: str, site: Site) -> Axis:
    """Frequencies of a file, whichever of its names is the main dimension.

    Raises
    ------
    InputError
        Where there is none, or two axes contradict each other.
    """
    dimensions = variables["added_mass"].dimensions if "added_mass" in variables else ("omega",)
    sizes = variables["added_mass"].values.shape if "added_mass" in variables else (0,)
    main = [name for name in dimensions if name in FREQUENCIES]
    several = [name for name, size in zip(dimensions, sizes, strict=False) if name in FREQUENCIES and size != 1]
    main = several or main
    if len(main) != 1:
        problem = "has no dimension of frequency" if not main else "has several dimensions of frequency"
        raise InputError(f"{source}: added_mass", dimensions, problem, LAYOUT)
    dimension = main[0]
    along = [name for name in FREQUENCIES if name in variables and variables[name].dimensions == (dimension,)]
    if not along:
        problem = "missing"
        raise InputError(f"{source}: {dimension}", problem, "the file has no such variable", LAYOUT)
    depth, g = _number(variables, "water_depth", math.inf), _number(variables, "g", 9.81)
    found = {name: _omega(name, variables[name], depth, g, source) for name in along}
    # the dimension itself is what was asked of the solver; it decides unless omega stands beside it
    chosen = "omega" if "omega" in found else dimension if dimension in found else along[0]
    omega = found[chosen]
    for name, other in found.items():
        if name in ("wavenumber", "wavelength") and chosen not in (name,):
            continue  # some programs write those of deep water whatever the depth
        with np.errstate(invalid="ignore"):
            same = (omega == other) | (np.abs(omega - other) <= AGREE * np.abs(omega)) | ~np.isfinite(omega)
        if not same.all():
            k = int(np.flatnonzero(~same)[0])
            given = {axis for axis, unit in UNITS.items() if unit == site.frequency}
            if given & set(found):
                return Axis(dimension, found[given.pop()], f"{site.frequency}, by --frequency, against another axis")
            problem = f"is {other[k]:.4g} rad/s where {chosen} is {omega[k]:.4g} rad/s"
            mend = "Say which holds: --frequency rad/s, Hz or period, or mend the file"
            raise InputError(f"{source}: {name}", float(variables[name].values[k]), problem, mend)
    if site.frequency is not None and site.frequency not in {UNITS.get(name) for name in (*found, dimension)}:
        problem = f"differs from {dimension}, the main dimension of {source}"
        raise InputError("hydro.frequency", site.frequency, problem, "Leave the option out")
    return Axis(dimension, omega, f"{dimension}, the main dimension")


def _omega(name: str, variable: Variable, depth: float, g: float, source: str) -> Floats:
    """Frequencies [rad/s] of an axis."""
    if variable.values.dtype.kind not in "biuf":
        raise InputError(f"{source}: {name}", str(variable.values.dtype), "holds no numbers", LAYOUT)
    values = np.asarray(variable.values, dtype=np.float64)
    unit = str(variable.attributes.get("units", "")).strip().lower()
    if np.any(values < 0.0) and name != "omega":
        raise InputError(f"{source}: {name}", float(np.nanmin(values)), "must not be negative", LAYOUT)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        if name == "omega" and unit in ("hz", "1/s", "s-1", "s^-1"):
            if unit != "hz":
                problem = "can be read in two ways"
                raise InputError(f"{source}: {name}", unit, problem, "Give the unit of omega as rad/s or Hz")
            return np.asarray(2.0 * np.pi * values)
        if name == "omega":
            return values
        if name == "freq":
            return values if unit.startswith("rad") else np.asarray(2.0 * np.pi * values)
        if name == "period":
            return np.asarray(2.0 * np.pi / values)
        k = values if name == "wavenumber" else np.asarray(2.0 * np.pi / values)
        finite = np.where(np.isfinite(k), k, 0.0)
        slope = np.tanh(finite * depth) if np.isfinite(depth) else np.ones_like(finite)
        return np.asarray(np.where(np.isfinite(k), np.sqrt(g * finite * slope), k), dtype=np.float64)


def _number(variables: Variables, name: str, usual: float) -> float:
    """A number of the file, where it is one."""
    if name not in variables or variables[name].values.size != 1 or variables[name].values.dtype.kind not in "biuf":
        return usual
    return float(variables[name].values.ravel()[0])


def headings_of(variable: Variable, source: str, site: Site) -> tuple[Floats, str]:
    """Headings of a file [deg], and in words how they were read."""
    unit = str(variable.attributes.get("units", "")).strip().lower()
    told = "deg" if unit.startswith("deg") or unit == "°" else "rad" if unit.startswith("rad") else None
    if unit and told is None and unit not in ("1", "-"):
        raise InputError(f"{source}: wave_direction", unit, "is no unit of an angle", "Give rad or deg")
    found = degrees(variable.values, site.headings, told, "rad", f"{source}: wave_direction")
    return found, f"{site.headings or told or 'rad'}, by {'--headings' if site.headings else unit or 'the format'}"


def dofs_of(labels: Mapping[str, list[str]], source: str, site: Site) -> tuple[dict[int, str], tuple[int, int] | None]:
    """Labels of the modes that the file has, and the two chosen ones; None for a file that has phi1 and phi3.

    Parameters
    ----------
    labels : mapping of str to list of str
        Labels by the dimension.
    source : str
        Name of the file.
    site : Site
        What was given.

    Raises
    ------
    InputError
        Where a chosen mode is missing, or stands there twice.
    """
    if site.modes is None and all(name in found for found in labels.values() for name in DOFS):
        return {}, None
    names: dict[int, str] = {}
    for dimension, found in labels.items():
        for mode in range(1, 7):
            same = [text for text in found if text.lower().rpartition("__")[2] == NAMES[mode - 1]]
            if len(same) > 1 and mode in map(abs, site.chosen):
                raise InputError(
                    f"{source}: {dimension}", same, "names a mode of several bodies", "Give one body alone"
                )
            if same:
                names[mode] = same[0]
        lacking = [mode for mode in map(abs, site.chosen) if mode not in names or names[mode] not in found]
        if lacking:
            words = " and ".join(f"{m} ({NAMES[m - 1]})" if m <= 6 else str(m) for m in lacking)
            if site.modes is None:
                words = " and ".join(name for name in DOFS if name not in found) + f", and of standard modes {words}"
            raise InputError(f"{source}: {dimension}", found, f"lacks {words}", LAYOUT)
    return names, site.chosen


def told_point(variables: Variables, source: str) -> Told:
    """The centre of rotation, where the file tells one; of several bodies they must be the same."""
    if "rotation_center" not in variables:
        return Told({}, where=source)
    values = np.asarray(variables["rotation_center"].values)
    if values.size % 3 or values.dtype.kind not in "biuf":
        raise InputError(f"{source}: rotation_center", values.shape, "must be three numbers", LAYOUT)
    rows = np.unique(values.reshape(-1, 3).astype(np.float64), axis=0)
    rows = rows[np.isfinite(rows).all(axis=1)]
    if len(rows) > 1:
        raise InputError(
            f"{source}: rotation_center", rows.tolist(), "is that of several bodies", "Give one body alone"
        )
    return Told({mode: (float(r[0]), float(r[1]), float(r[2])) for r in rows for mode in (4, 5, 6)}, where=source)
