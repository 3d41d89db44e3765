"""Checks of a database against the paper and against itself; `gyroctl hydro check` prints them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gyroctl.hydrodynamics.database import load, shipped
from gyroctl.hydrodynamics.haskind import haskind_error
from gyroctl.hydrodynamics.kramers_kronig import added_mass_inf
from gyroctl.hydrodynamics.radiation import assess
from gyroctl.hydrodynamics.table import Hydrodynamics

#: k3, Jh1 and Jh3 of Table 1 of the paper. [Nm/rad], [kg m^2], [kg m^2]
TABLE_1 = {"k3": 2945.0, "Jh1": 14.39, "Jh3": 32.16}
_ROTATIONS = ("phi1", "phi3")


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
        lines = [f"{'check':34} {'value':>12} {'reference':>12} {'tolerance':>10}      {'unit':8} note"]
        lines += [
            f"{r.name:34} {r.value:12.5g} {r.reference:12.5g} {r.tolerance:10.3g}  {'ok ' if r.ok else 'NO '} "
            f"{r.unit:8} {r.note}"
            for r in self.rows
        ]
        return "\n".join(lines)


def check(source: Hydrodynamics | Path | str | None = None) -> Report:
    """Check a database.

    Parameters
    ----------
    source : Hydrodynamics, Path or str, optional
        A database or its file; without it, the shipped one.

    Returns
    -------
    Report
        Rows on Table 1 (1 %), Haskind's relation (2 %), Kramers-Kronig (1 %), symmetry, and the passivity and
        low-frequency damping of each radiation fit kept with the database.

    Raises
    ------
    InputError
        When the file is missing or of another layout.
    """
    hydro = shipped() if source is None else source if isinstance(source, Hydrodynamics) else load(source)
    return Report((*_table_1(hydro), *_consistency(hydro), *_fits(hydro)))


def _table_1(hydro: Hydrodynamics) -> list[Row]:
    values = {"k3": hydro.stiffness, "Jh1": hydro.added_mass_inf[0], "Jh3": hydro.added_mass_inf[1]}
    units = {"k3": "Nm/rad", "Jh1": "kg m^2", "Jh3": "kg m^2"}
    return [
        Row(name, float(values[name]), target, 0.01 * target, units[name], "Table 1 of the paper, within 1 %")
        for name, target in TABLE_1.items()
    ]


def _consistency(hydro: Hydrodynamics) -> list[Row]:
    rows = []
    error = haskind_error(hydro)
    for j, name in enumerate(_ROTATIONS):
        if error is not None:
            rows.append(
                Row(f"Haskind {name}", float(error[j]), 0.0, 0.02, "1", "damping against excitation, largest departure")
            )
    for j, name in enumerate(_ROTATIONS):
        estimate, spread = added_mass_inf(hydro.omega, hydro.added_mass[j], hydro.damping[j])
        stored = float(hydro.added_mass_inf[j])
        rows.append(
            Row(
                f"Kramers-Kronig {name}",
                estimate,
                stored,
                0.01 * stored,
                "kg m^2",
                "A_inf from the damping against the stored one",
            )
        )
        rows.append(
            Row(f"Kramers-Kronig constancy {name}", spread, 0.0, 0.01, "1", "departure of A_inf(w) over the band")
        )
    rows.append(Row("coupling of phi1 and phi3", hydro.coupling, 0.0, 1e-3, "1", "zero by symmetry"))
    mirror = _mirror(hydro)
    if mirror is not None:
        rows.append(
            Row("mirrored headings", mirror, 0.0, 1e-3, "1", "He1 odd and He3 even under heading -> 180 - heading")
        )
    return rows


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


def _fits(hydro: Hydrodynamics) -> list[Row]:
    rows = []
    for name, pair in hydro.fits.items():
        for j, rotation in enumerate(_ROTATIONS):
            fit = assess(hydro, j, *pair[j])
            order = f"({len(fit.p) - 1},{len(fit.q)})"
            faults = float(fit.passivity.crossings + (not fit.passivity.stable) + (not fit.passivity.passive))
            rows.append(
                Row(
                    f"fit {name} {rotation} passive",
                    faults,
                    0.0,
                    0.0,
                    "1",
                    f"{order}, Sturm and Routh in exact arithmetic; smallest Re H {fit.passivity.smallest:.3g} Nms, "
                    f"rms {100.0 * fit.relative_rms:.2f} %",
                )
            )
            if name == "accurate":
                limit = max(0.1 * fit.damping_low_table, 0.05)
                rows.append(
                    Row(
                        f"fit {name} {rotation} at 1.2 rad/s",
                        fit.damping_low,
                        fit.damping_low_table,
                        limit,
                        "Nms/rad",
                        "damping against the table",
                    )
                )
    return rows
