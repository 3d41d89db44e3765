"""Spectra from files: text of two columns, with its units, and what buoys and wave models write."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from os import PathLike

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import NOT_GIVEN, InputError
from gyroctl.waves.checks import check_text, finite, heading_angle, positive
from gyroctl.waves.columns import read_columns
from gyroctl.waves.directional import DirectionalSpectrum, within_turn
from gyroctl.waves.measured import FORMATS, Measured, read_one
from gyroctl.waves.record_files import scale_factor
from gyroctl.waves.tabulated import DENSITY_MAX, TabulatedSpectrum
from gyroctl.waves.units import of_spectrum
from gyroctl.waves.watershed import part_of_hills

PARTITIONS = ("swell", "wind sea")

SPLITS = ("frequency", "watershed")
"""By what swell and wind sea are told apart."""

DIRECTIONS = ("from", "to")

_WHAT = "f [Hz], S [m2/Hz] or omega [rad/s], S [m2 s/rad]"


def read_spectrum(
    path: str | PathLike[str],
    heading: float = 0.0,
    *,
    format: str = "csv",
    unit: str | None = None,
    clock: str | None = None,
    column: str | None = None,
    time: str | None = None,
    site: float | None = None,
    partition: str | None = None,
    split: float | None = None,
    split_by: str = "frequency",
    directional: bool = False,
    axis: float | None = None,
    direction: str = "from",
    scale: float = 1.0,
) -> TabulatedSpectrum | DirectionalSpectrum:
    """Read a spectrum: from columns of text, see `read_columns`, or a file of a buoy or a wave model.

    Of columns the heading says the units, as ``f [Hz], S [m2/Hz]`` or ``omega [rad/s], S [m2 s/rad]``; the name omega
    alone means rad/s. Without such a heading `unit` has to. What was done stands in `notes` of the sea.

    Parameters
    ----------
    path : str or Path
        The file.
    heading : float
        Direction the waves travel to, of a directional spectrum without `axis` their mean one. [deg]
    format : str
        "csv"; "ndbc", "datawell", "spotter", "triaxys" or "swan", which need the extra `seas`.
    unit : str, optional
        Of columns, "Hz": frequencies in Hz, densities in m^2/Hz; "rad/s": in rad/s and m^2 s/rad.
    clock, column : str, optional
        Names of the columns of frequencies and densities; without them the first, and the second of two.
    time : str, optional
        Time stamp of the spectrum, or as much of its beginning as tells it from the others.
    site : int, optional
        Number of the place in a file of several, from 1.
    partition : str, optional
        "swell": what is slower than `split`; "wind sea": the rest.
    split : float, optional
        Frequency between the two; without it the one that a real-time file of NDBC sets. [Hz]
    split_by : str
        "frequency"; or "watershed", for files with directions: the steep hills of the spectrum are the wind sea.
    directional : bool
        Keep the directions of the file. Those of NDBC stand in files beside it.
    axis : float, optional
        Bearing of the device's axis x3, clockwise from north. Without it the device faces the mean direction. [deg]
    direction : str
        Whether the file's directions are those the waves come "from", as buoys and SWAN have them, or travel "to".
    scale : float
        Length of what was measured over that of the model, by Froude: heights shrink by it, frequencies grow by its
        root. [-]

    Returns
    -------
    TabulatedSpectrum or DirectionalSpectrum
        In rad/s and m^2 s, with what was converted in `notes`.

    Raises
    ------
    InputError
        Field ``sea.file`` for the file, ``sea.NAME`` for an option, the fields of `TabulatedSpectrum` for its numbers.
    """
    shrink = scale_factor(scale)
    _check(format, unit, clock, column, time, site, partition, split, split_by, directional, axis, direction)
    hills = split_by == "watershed"
    if format == "csv":
        first, second = read_columns(path, _WHAT, (clock, column))
        turn, factor, said = of_spectrum(unit, (first.name, first.unit), (second.name, second.unit))
        mend = f"Give a text file with two columns of numbers: {_WHAT}"
        omega = first.numbers(os.fspath(path), mend) * turn
        density = second.numbers(os.fspath(path), mend) * factor
        notes = [*([said] if said else []), *first.notes, *second.notes]
        if turn != 1.0 or factor != 1.0:
            was = f"{unit or first.unit or 'rad/s'}, {second.unit or 'm2 per that'}"
            notes.append(f"converted from {was} to rad/s, m2 s/rad")
        found = Measured(omega / (2.0 * math.pi), None, density, None, tuple(notes))
    else:
        found = _read(path, format, time, site, directional, hills)
        if hills:
            found = _hills(found, str(partition), directional)
        omega, density = 2.0 * math.pi * found.frequency, found.density / (2.0 * math.pi)
        notes = list(found.notes)
    if not hills:
        omega, density = _part(omega, density, partition, split or found.split, notes)
    if shrink != 1.0:
        omega, density = omega * math.sqrt(shrink), density / shrink**2.5
        notes.append(f"scaled by Froude 1:{shrink:g}")
    if found.directions is None:
        return TabulatedSpectrum(omega, density, heading, tuple(notes))
    return _directional(omega, found.directions, density, heading, axis, direction, notes)


def _check(
    format: object,
    unit: object,
    clock: object,
    column: object,
    time: object,
    site: object,
    partition: object,
    split: object,
    split_by: object,
    directional: object,
    axis: object,
    direction: object,
) -> None:
    """Refuse options that are none, or of no use for this format."""
    columns = {"unit": unit, "clock": clock, "column": column}
    buoys = {"time": time, "site": site, "axis": axis, "directional": directional or None}
    texts = {"format": format, "direction": direction, "split_by": split_by, **columns, "time": time}
    for name, value in texts.items():
        if value is not None:
            check_text(f"sea.{name}", value)
    known = ("csv", *FORMATS)
    if format not in known:
        raise InputError("sea.format", format, "unknown format", f"Choose one of {', '.join(known)}")
    for name, value in (buoys if format == "csv" else columns).items():
        if value is not None:
            raise InputError(f"sea.{name}", value, f"is of no use for a file of {format}", "Leave it out")
    if not isinstance(directional, bool):
        raise InputError("sea.directional", directional, "must be true or false", "Give true or false")
    if axis is not None:
        if not directional:
            problem = "is of no use without directions"
            raise InputError("sea.axis", axis, problem, "Give directional = true too, or heading instead")
        finite("sea.axis", axis, "Give the bearing of the axis x3 in degrees, clockwise from north")
    if direction not in DIRECTIONS:
        raise InputError("sea.direction", direction, "unknown", f"Choose one of {', '.join(DIRECTIONS)}")
    if site is not None and finite("sea.site", site, "Give a number from 1") % 1.0:
        raise InputError("sea.site", site, "must be a whole number", "Give a number from 1")
    if partition is not None and partition not in PARTITIONS:
        raise InputError("sea.partition", partition, "unknown", f"Choose one of {', '.join(PARTITIONS)}")
    if split_by not in SPLITS:
        raise InputError("sea.split_by", split_by, "unknown", f"Choose one of {', '.join(SPLITS)}")
    if split_by == "watershed" and (partition is None or split is not None or format == "csv"):
        problem = "takes a partition, no frequency, and a file with directions"
        raise InputError("sea.split_by", split_by, problem, f"Give partition = {' or '.join(PARTITIONS)}, and no split")
    if split is not None:
        positive("sea.split", split, "Give the frequency between swell and wind sea in Hz, for example 0.1")
        if partition is None:
            mend = 'Give partition = "swell" or partition = "wind sea" too'
            raise InputError("sea.split", split, "is of no use without a partition", mend)


def _read(
    path: str | PathLike[str], format: str, time: str | None, site: float | None, directional: bool, hills: bool
) -> Measured:
    """One spectrum of a file, with its directions where they are wanted or needed."""
    place = None if site is None else int(site)
    try:
        return read_one(path, format, time, place, directional or hills)
    except InputError as error:
        if hills and not directional and error.field == "sea.directional":
            problem = "needs directions, and the file holds none"
            raise InputError("sea.split_by", "watershed", problem, "Give split in Hz instead") from None
        raise


def _hills(found: Measured, partition: str, directional: bool) -> Measured:
    """The steep hills of a spectrum, or the others; over all directions together where these are not kept."""
    directions = found.directions
    if directions is None:
        raise InputError("sea.split_by", "watershed", "needs directions, and the file holds none", "Give split in Hz")
    kept = part_of_hills(found.frequency, directions, found.density, partition)
    notes = (*found.notes, f"{partition} alone, by watershed and steepness")
    if directional:
        return found._replace(density=kept, notes=notes)
    step = float(np.diff(directions).mean())
    return found._replace(directions=None, density=kept.sum(axis=1) * step, notes=notes)


def _part(
    omega: NDArray[np.float64],
    density: NDArray[np.float64],
    partition: str | None,
    split: float | None,
    notes: list[str],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Swell or wind sea: the table up to the split, or from there on; the two have the area of the whole."""
    if partition is None:
        return omega, density
    if split is None:
        mend = "Give split = the frequency between them [Hz], for example 0.1"
        raise InputError("sea.split", NOT_GIVEN, "where swell ends and wind sea begins is not said", mend)
    at = 2.0 * math.pi * split
    if not omega[0] < at < omega[-1]:
        low, high = omega[0] / (2.0 * math.pi), omega[-1] / (2.0 * math.pi)
        raise InputError("sea.split", split, "lies outside the spectrum", f"Give Hz, between {low:.3g} and {high:.3g}")
    row = int(np.searchsorted(omega, at, side="right")) - 1
    part = (at - omega[row]) / (omega[row + 1] - omega[row])
    edge = ((1.0 - part) * density[row] + part * density[row + 1])[None]
    notes.append(f"{partition} alone, {'below' if partition == 'swell' else 'above'} {split:.4g} Hz")
    slower = omega < at
    if partition == "swell":
        return np.append(omega[slower], at), np.concatenate((density[slower], edge))
    faster = omega > at
    return np.insert(omega[faster], 0, at), np.concatenate((edge, density[faster]))


def _directional(
    omega: NDArray[np.float64],
    directions: NDArray[np.float64],
    density: NDArray[np.float64],
    heading: float,
    axis: float | None,
    direction: str,
    notes: Sequence[str],
) -> DirectionalSpectrum:
    """Turn compass directions into headings of the device: clockwise from north into anticlockwise from x3."""
    towards = directions + (180.0 if direction == "from" else 0.0)
    mean = np.trapezoid(np.minimum(density, DENSITY_MAX) @ np.exp(1j * np.radians(towards)), omega)
    if not (np.all(np.isfinite(directions)) and np.isfinite(mean)):
        problem = "are no numbers, or cannot be summed up"
        raise InputError("sea.directional", True, f"the directions of the file {problem}", "Leave directional out")
    course = math.degrees(float(np.angle(mean))) % 360.0
    said = f"waves come from {(course + 180.0) % 360.0:.0f} deg on the mean"
    if axis is None:
        turned = heading_angle(heading) + course - towards
        said += f", which is taken as heading {heading:g} deg"
    else:
        if heading != 0.0:
            raise InputError(
                "sea.heading", heading, "is set by the axis and the directions of the file", "Leave it out"
            )
        turned = axis - towards
    headings, table = turned[::-1], density[:, ::-1] * (180.0 / math.pi)
    return DirectionalSpectrum(omega, within_turn(headings), table, (*notes, said))
