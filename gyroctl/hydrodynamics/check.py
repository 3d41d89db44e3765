"""Checks of a database against the paper and against itself; `gyroctl hydro check` prints them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gyroctl.hydrodynamics.database import load, shipped
from gyroctl.hydrodynamics.haskind import haskind_error
from gyroctl.hydrodynamics.kramers_kronig import added_mass_inf
from gyroctl.hydrodynamics.radiation import assess
from gyroctl.hydrodynamics.scale import damping_ratio, frequency_ratio
from gyroctl.hydrodynamics.table import DOFS, Hydrodynamics
from gyroctl.hydrodynamics.undisturbed import froude_krylov, panel_stiffness

#: k3, Jh1 and Jh3 of Table 1 of the paper. [Nm/rad], [kg m^2], [kg m^2]
TABLE_1 = {"k3": 2945.0, "Jh1": 14.39, "Jh3": 32.16}

#: The hull's panels are compared up to here. [rad/s], shipped float
FOLLOWED = 8.0


@dataclass(frozen=True)
class Row:
    """One check: it holds when value and reference differ by no more than the tolerance."""

    name: str
    value: float
    reference: float
    tolerance: float
    """Largest permitted |value - reference|, in the unit of the value."""
    unit: str
    note: str

    @property
    def ok(self) -> bool:
        """Whether the check holds."""
        return bool(abs(self.value - self.reference) <= self.tolerance)

    def __str__(self) -> str:
        """Line of the table."""
        numbers = f"{self.value:12.5g} {self.reference:12.5g} {self.tolerance:10.3g}"
        return f"{self.name:34} {numbers}  {'ok ' if self.ok else 'NO '} {self.unit:8} {self.note}"


@dataclass(frozen=True)
class Report:
    """All checks of one database."""

    rows: tuple[Row, ...]

    @property
    def ok(self) -> bool:
        """Whether every check holds."""
        return all(row.ok for row in self.rows)

    def __str__(self) -> str:
        """Plain table."""
        head = f"{'check':34} {'value':>12} {'reference':>12} {'tolerance':>10}      {'unit':8} note"
        return "\n".join([head, *map(str, self.rows)])


def check(source: Hydrodynamics | Path | str | None = None) -> Report:
    """Check a database.

    Parameters
    ----------
    source : Hydrodynamics, Path or str, optional
        A database or its file; without it, the shipped one.

    Returns
    -------
    Report
        Rows on Table 1 (1 %), Haskind's relation (2 %), Kramers-Kronig (1 %), symmetry, the parts of the excitation
        (their sum to rounding; 2 % against the panels of the hull), the panels' stiffness (0.5 %), and the passivity
        and low-frequency damping of each radiation fit kept with the database.

    Raises
    ------
    InputError
        When the file is missing or of another layout.
    """
    hydro = shipped() if source is None else source if isinstance(source, Hydrodynamics) else load(source)
    return Report((*_table_1(hydro), *_consistency(hydro), *_parts(hydro), *_fits(hydro)))


def _table_1(hydro: Hydrodynamics) -> Iterator[Row]:
    values = {"k3": hydro.stiffness, "Jh1": hydro.added_mass_inf[0], "Jh3": hydro.added_mass_inf[1]}
    for name, target in TABLE_1.items():
        unit = "Nm/rad" if name == "k3" else "kg m^2"
        yield Row(name, float(values[name]), target, 0.01 * target, unit, "Table 1 of the paper, within 1 %")


def _consistency(hydro: Hydrodynamics) -> Iterator[Row]:
    error = haskind_error(hydro)
    if error is not None:
        for name, value in zip(DOFS, error, strict=True):
            note = "damping against excitation, largest departure"
            yield Row(f"Haskind {name}", float(value), 0.0, 0.02, "1", note)
    for j, name in enumerate(DOFS):
        estimate, spread = added_mass_inf(hydro.omega, hydro.added_mass[j], hydro.damping[j])
        stored = float(hydro.added_mass_inf[j])
        note = "A_inf from the damping against the stored one"
        yield Row(f"Kramers-Kronig {name}", estimate, stored, 0.01 * stored, "kg m^2", note)
        note = "departure of A_inf(w) over the band"
        yield Row(f"Kramers-Kronig constancy {name}", spread, 0.0, 0.01, "1", note)
    yield Row("coupling of phi1 and phi3", hydro.coupling, 0.0, 1e-3, "1", "zero by symmetry")
    mirror = _mirror(hydro)
    if mirror is not None:
        note = "He1 odd and He3 even under heading -> 180 - heading"
        yield Row("mirrored headings", mirror, 0.0, 1e-3, "1", note)


def _mirror(hydro: Hydrodynamics) -> float | None:
    """Largest departure from the mirror symmetry of the excitation, where the mirrored headings are tabulated."""
    worst, size = None, np.max(np.abs(hydro.excitation), axis=(1, 2))
    for k, heading in enumerate(hydro.headings):
        other = np.flatnonzero(np.isclose((180.0 - heading - hydro.headings + 180.0) % 360.0, 180.0, atol=1e-6))
        if len(other) and other[0] != k:
            odd = np.array([[-1.0], [1.0]])
            gap = np.abs(hydro.excitation[:, k] - odd * hydro.excitation[:, other[0]])
            worst = max(worst or 0.0, float(np.max(gap / size[:, None])))
    return worst


def _parts(hydro: Hydrodynamics) -> Iterator[Row]:
    """Froude-Krylov and diffraction against the whole, and against the surface of the float."""
    if hydro.froude_krylov is None or hydro.diffraction is None:
        return
    size = np.max(np.abs(hydro.excitation), axis=(1, 2))
    gap = np.max(np.abs(hydro.froude_krylov + hydro.diffraction - hydro.excitation), axis=(1, 2)) / size
    for name, value in zip(DOFS, gap, strict=True):
        note = "Froude-Krylov and diffraction against the excitation"
        yield Row(f"FK + diffraction {name}", float(value), 0.0, 1e-6, "1", note)
    if hydro.hull is None:
        return
    end = FOLLOWED * frequency_ratio(hydro)
    followed = hydro.omega <= end * (1.0 + 1e-9)
    panels = froude_krylov(hydro.hull, hydro.omega[followed], hydro.headings, hydro.depth, hydro.rho, hydro.g)
    apart = hydro.excitation[..., followed] - hydro.diffraction[..., followed]
    off = np.max(np.abs(panels - apart), axis=(1, 2)) / np.max(np.abs(apart), axis=(1, 2))
    for name, value in zip(DOFS, off, strict=True):
        note = f"panels of the hull against excitation - diffraction, to {end:.4g} rad/s"
        yield Row(f"Froude-Krylov {name}", float(value), 0.0, 0.02, "1", note)
    if hydro.stiffness > 0.0:
        note = "waterplane and buoyancy of the hull's panels"
        stiffness = panel_stiffness(hydro.hull, hydro.rho, hydro.g)
        yield Row("k3 of the hull", stiffness, hydro.stiffness, 0.005 * hydro.stiffness, "Nm/rad", note)


def _fits(hydro: Hydrodynamics) -> Iterator[Row]:
    for name, pair in hydro.fits.items():
        for j, rotation in enumerate(DOFS):
            fit = assess(hydro, j, *pair[j])
            found = fit.passivity
            faults = float(found.crossings + (not found.stable) + (not found.passive))
            note = f"({len(fit.p) - 1},{len(fit.q)}), Sturm and Routh in exact arithmetic; smallest Re H "
            note += f"{found.smallest:.3g} Nms, rms {100.0 * fit.relative_rms:.2f} %"
            yield Row(f"fit {name} {rotation} passive", faults, 0.0, 0.0, "1", note)
            if name == "accurate":
                value, table = fit.damping_low, fit.damping_low_table
                title = f"fit {name} {rotation} at {fit.low_frequency:.4g} rad/s"
                limit = max(0.1 * table, 0.05 * damping_ratio(hydro))
                yield Row(title, value, table, limit, "Nms/rad", "damping against the table")
