"""What a database holds and how good it is, in numbers and in words; printed at the end of an import."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gyroctl.hydrodynamics.database import load, shipped
from gyroctl.hydrodynamics.kramers_kronig import added_mass_inf
from gyroctl.hydrodynamics.radiation import RadiationFit, assess, fit_radiation, makes_none, slow_mode
from gyroctl.hydrodynamics.scale import damping_ratio
from gyroctl.hydrodynamics.table import DOFS, Hydrodynamics

FIT = "accurate"
"""Fit that is judged: the one that a device uses."""

RMS, DAMPING, BROKEN, DOUBTFUL, COUPLED = 0.10, 0.10, 0.20, 0.05, 0.05
"""Largest rms of the fit and departure of its damping; departure from Kramers-Kronig that no table has, and one that is
told; coupling that is told. Each relative."""

LEAST_DAMPING = 0.05
"""Departure of the damping that does no harm beside that of the hinge, for the shipped float. [Nms/rad]"""

REACH = 5.0
"""Frequencies in units of the slow mode that waves and motion of a device reach."""


@dataclass(frozen=True)
class Rotation:
    """One rotation of a database and its radiation fit."""

    name: str
    added_mass_inf: float
    """[kg m^2]"""
    added_mass_inf_from: str
    kramers_kronig: float
    """Departure of the stored added mass at infinite frequency from that by Kramers-Kronig, relative. [-]"""
    added_mass_zero: float | None
    """[kg m^2]"""
    waves: bool
    """Whether it makes any."""
    order: tuple[int, int]
    """Degrees of numerator and denominator of the fit."""
    passive: bool
    relative_rms: float
    """[-]"""
    damping: float
    """Of the fit at the slow mode. [Nms/rad]"""
    damping_table: float
    """[Nms/rad]"""


@dataclass(frozen=True)
class ImportReport:
    """What a database holds and whether it can be used.

    Parameters
    ----------
    source : str
        Where it comes from.
    frequencies : int
        Their number.
    band : tuple of float
        Lowest and highest. [rad/s]
    headings : tuple of float
        [deg]
    stiffness : float
        k3; 0 where unknown. [Nm/rad]
    depth, rho, g : float
        [m], [kg/m^3], [m/s^2]
    coupling : float
        Radiation coupling of the two rotations that was dropped, relative. [-]
    slow_mode : float
        [rad/s]
    rotations : tuple of Rotation
        phi1 and phi3.
    told : mapping of str to str
        How units, point, symmetry and single numbers were read.
    notes : tuple of str
        Rows that were left out, limits that were found.
    faults, cares : tuple of str
        Why it cannot be used, and what to look at.
    """

    source: str
    frequencies: int
    band: tuple[float, float]
    headings: tuple[float, ...]
    stiffness: float
    depth: float
    rho: float
    g: float
    coupling: float
    slow_mode: float
    rotations: tuple[Rotation, Rotation]
    told: Mapping[str, str]
    notes: tuple[str, ...]
    faults: tuple[str, ...]
    cares: tuple[str, ...]

    @property
    def ok(self) -> bool:
        """Whether nothing speaks against its use."""
        return not self.faults

    @property
    def verdict(self) -> str:
        """The whole in words."""
        if self.faults:
            return "not usable as it is: " + "; ".join((*self.faults, *self.cares))
        return "usable with care: " + "; ".join(self.cares) if self.cares else "usable"

    def __str__(self) -> str:
        """Lines of name and value."""
        low, high = self.band
        rows = [
            ("source", self.source),
            ("band", f"{low:.4g} to {high:.4g} rad/s, {self.frequencies} frequencies{self._how('frequency')}"),
            ("headings", f"{_listed(self.headings)} deg{self._how('headings')}"),
            ("water", f"depth {self.depth:.4g} m, {self.rho:.6g} kg/m^3, g {self.g:.6g} m/s^2"),
            ("k3", f"{self.stiffness:.4g} Nm/rad{self._how('stiffness')}" if self.stiffness else self._unknown()),
        ]
        for one in self.rotations:
            off = f"{100.0 * one.kramers_kronig:.2g} % off Kramers-Kronig" if one.waves else "makes no waves"
            rows.append((f"A_inf {one.name}", f"{one.added_mass_inf:.4g} kg m^2, {one.added_mass_inf_from}; {off}"))
            if one.added_mass_zero is not None:
                rows.append((f"A_0 {one.name}", f"{one.added_mass_zero:.4g} kg m^2"))
        rows.append(("dropped", self.told.get("coupling", f"coupling {_small(self.coupling)} of the own values")))
        rows += [(name, self.told[name]) for name in ("phases", "point") if name in self.told]
        for one in self.rotations:
            fit = f"{one.order}, {'passive' if one.passive else 'NOT passive'}, rms {100.0 * one.relative_rms:.2f} %"
            slow = f"damping at {self.slow_mode:.4g} rad/s {one.damping:.4g}, table {one.damping_table:.4g} Nms/rad"
            rows.append((f"fit {one.name}", f"{fit}, {slow}"))
        rows += [("note", note) for note in self.notes]
        rows.append(("verdict", self.verdict))
        return "\n".join(f"{name:12} {value}" for name, value in rows)

    def _how(self, name: str) -> str:
        return f" ({self.told[name]})" if name in self.told else ""

    def _unknown(self) -> str:
        return self.told.get("stiffness", "unknown: give --stiffness, or k3 of the device")


def import_report(source: Hydrodynamics | Path | str | None = None) -> ImportReport:
    """Report on a database.

    Parameters
    ----------
    source : Hydrodynamics, Path or str, optional
        A database or its file; without it, the shipped one. One without a kept fit is fitted.

    Returns
    -------
    ImportReport

    Raises
    ------
    InputError
        When the file is missing or of another layout.
    """
    hydro = shipped() if source is None else source if isinstance(source, Hydrodynamics) else load(source)
    told, notes = _kept(hydro)
    fits = [_fit(hydro, j) for j in range(2)]
    first, second = (_rotation(hydro, j, fits[j], told) for j in range(2))
    faults, cares = _judged(hydro, (first, second))
    return ImportReport(
        source=str(hydro.provenance.get("source", hydro.provenance.get("title", "a database"))),
        frequencies=len(hydro.omega),
        band=(float(hydro.omega[0]), float(hydro.omega[-1])),
        headings=tuple(map(float, hydro.headings)),
        stiffness=float(hydro.stiffness),
        depth=float(hydro.depth),
        rho=float(hydro.rho),
        g=float(hydro.g),
        coupling=float(hydro.coupling),
        slow_mode=slow_mode(hydro),
        rotations=(first, second),
        told=told,
        notes=notes,
        faults=faults,
        cares=cares,
    )


def _kept(hydro: Hydrodynamics) -> tuple[dict[str, str], tuple[str, ...]]:
    """What the import has kept with the database."""
    content: Any = hydro.provenance.get("import", {})
    if isinstance(content, str):
        try:
            content = json.loads(content)
        except (ValueError, RecursionError):
            content = {}
    content = content if isinstance(content, Mapping) else {}
    notes = content.get("notes", ())
    told = {str(name): str(value) for name, value in content.items() if name != "notes"}
    return told, tuple(map(str, notes)) if isinstance(notes, list | tuple) else ()


def _fit(hydro: Hydrodynamics, j: int) -> RadiationFit:
    return assess(hydro, j, *hydro.fits[FIT][j]) if FIT in hydro.fits else fit_radiation(hydro, j)


def _rotation(hydro: Hydrodynamics, j: int, fit: RadiationFit, told: Mapping[str, str]) -> Rotation:
    stored, waves = float(hydro.added_mass_inf[j]), not makes_none(hydro, j)
    estimate = added_mass_inf(hydro.omega, hydro.added_mass[j], hydro.damping[j])[0] if waves else stored
    zero = None if hydro.added_mass_zero is None else float(hydro.added_mass_zero[j])
    return Rotation(
        name=DOFS[j],
        added_mass_inf=stored,
        added_mass_inf_from=told.get(f"added_mass_inf of {DOFS[j]}", "kept with the database"),
        kramers_kronig=abs(estimate - stored) / abs(stored) if stored else float(estimate != stored),
        added_mass_zero=None if zero is None or np.isnan(zero) else zero,
        waves=waves,
        order=(len(fit.p) - 1, len(fit.q)),
        passive=fit.passivity.passive,
        relative_rms=fit.relative_rms,
        damping=fit.damping_low,
        damping_table=fit.damping_low_table,
    )


def _judged(hydro: Hydrodynamics, rotations: tuple[Rotation, Rotation]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """What speaks against the use of a database, and what to look at."""
    faults, cares = [], []
    least, slow = LEAST_DAMPING * damping_ratio(hydro), slow_mode(hydro)
    for one in rotations:
        if not one.passive:
            faults.append(f"the fit of {one.name} is not passive")
        if not one.waves:
            cares.append(f"{one.name} makes no waves")
        if one.kramers_kronig > DOUBTFUL:
            words = f"A_inf of {one.name} and the damping do not belong together (Kramers-Kronig, "
            words += f"{100.0 * one.kramers_kronig:.2g} %): the unit of frequency, or a short band"
            (faults if one.kramers_kronig > BROKEN else cares).append(words)
        if one.relative_rms > RMS:
            cares.append(f"the fit of {one.name} misses {100.0 * one.relative_rms:.2g} %")
        if abs(one.damping - one.damping_table) > max(DAMPING * one.damping_table, least):
            ratio = one.damping / one.damping_table if one.damping_table > 0.0 else float("inf")
            cares.append(f"the fit damps {one.name} {ratio:.3g} times as the table at {slow:.3g} rad/s")
    if hydro.omega[0] > slow:
        cares.append(f"the table begins above the slow mode, {slow:.3g} rad/s")
    if hydro.omega[-1] < REACH * slow:
        cares.append(f"the table ends below {REACH * slow:.3g} rad/s: waves beyond do not act")
    if hydro.coupling > COUPLED:
        cares.append(f"coupling of {100.0 * hydro.coupling:.2g} % between phi1 and phi3 is dropped")
    if not hydro.stiffness > 0.0:
        cares.append("k3 is unknown")
    if len(hydro.headings) == 1:
        cares.append(f"waves of heading {hydro.headings[0]:g} deg alone")
    return tuple(faults), tuple(cares)


def _small(value: float) -> str:
    return f"{value:.2g}" if value > 1e-4 else "below 1e-4"


def _listed(values: tuple[float, ...]) -> str:
    """Headings in few words."""
    if len(values) < 7:
        return ", ".join(f"{v:g}" for v in values)
    gaps = np.diff(values)
    steps = f"{np.min(gaps):g}" if np.ptp(gaps) < 1e-6 else f"{np.min(gaps):g} to {np.max(gaps):g}"
    return f"{len(values)} from {values[0]:g} to {values[-1]:g}, {steps} apart"
