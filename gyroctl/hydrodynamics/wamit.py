"""WAMIT's numeric output: NAME.1 (added mass, damping), NAME.3 (excitation), NAME.3fk (Froude-Krylov), NAME.hst."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.directions import degrees
from gyroctl.hydrodynamics.foreign import Forces, Reading, Site, assembled, existing, mode_of, unlike
from gyroctl.hydrodynamics.fortran_numbers import Row, rows_of
from gyroctl.hydrodynamics.frequency_unit import MANY, omega_of, runs_as_period, settled
from gyroctl.hydrodynamics.kramers_kronig import added_mass_inf
from gyroctl.hydrodynamics.moving import framed
from gyroctl.hydrodynamics.table import Floats, Hydrodynamics
from gyroctl.hydrodynamics.wamit_control import control

MEND = "Use WAMIT's numeric output files"


def read_wamit(path: Path | str, site: Site | None = None) -> Hydrodynamics:
    """Read WAMIT's NAME.1 and NAME.3 (or NAME.2), and NAME.3fk, NAME.hst and XBODY of the run where they are there.

    Parameters
    ----------
    path : Path or str
        Either file, or NAME without suffix.
    site : Site, optional
        Density, gravity, depth, length, modes, units and place of the run.

    Returns
    -------
    Hydrodynamics
        WAMIT's time factor is exp(+i w t) as here. Rows of period 0 (infinite frequency) give the added mass at
        infinite frequency; without them Kramers-Kronig does.

    Raises
    ------
    InputError
        When a file is missing or of another layout, and where its first column can be read in two ways.
    """
    site = site or Site()
    if site.phases is not None:
        problem = "does not matter: real and imaginary parts are taken"
        raise InputError("hydro.phases", site.phases, problem, "Leave it out")
    base = Path(path)
    base = base.with_suffix("") if base.suffix in (".1", ".2", ".3", ".3fk", ".hst") else base
    first = existing(base.with_name(base.name + ".1"))
    third, second = (base.with_name(base.name + suffix) for suffix in (".3", ".2"))
    third = existing(second if second.is_file() and not third.is_file() else third)
    said = control(base)
    frame = framed(site, said.places)
    reading = Reading(site, frame, f"WAMIT files {first.name} and {third.name}")
    reading.rho, reading.g, reading.depth = (site.settled(name, said.numbers.get(name), said.where) for name in WATER)
    length = site.settled("length", said.numbers.get("length"), said.where)
    with np.errstate(all="ignore"):  # what overflows is refused as what it gives
        unit = _radiation(reading, first, length, said.frequency)
        reading.forces = _forces(reading, third, length, unit)
        apart = base.with_name(base.name + ".3fk")
        if apart.is_file():
            reading.undisturbed = _forces(reading, apart, length, unit)
        _restoring(reading, base.with_name(base.name + ".hst"), length)
        return assembled(reading)


WATER = ("rho", "g", "depth")


def _power(mode: int) -> int:
    """1 for a rotation, which brings one more length."""
    return int(mode > 3)


def _radiation(reading: Reading, path: Path, length: float, told: dict[str, str]) -> str:
    """Read NAME.1 and return the unit of its first column."""
    wanted = reading.frame.wanted
    rows = []
    for row in rows_of(path, (4, 5), MEND):
        value, i, j = row.values[0], *(mode_of(v) if math.isfinite(v) else 0 for v in row.values[1:3])
        if not math.isfinite(value) or not all(map(math.isfinite, row.values[1:3])):
            _refused(path, row, "names no frequency and modes")
        if i in wanted and j in wanted:
            if value > 0.0 and len(row.values) == 4:
                _refused(path, row, "has no damping")
            rows.append((row, value, wanted.index(i), wanted.index(j)))
    unit = _unit(reading, path, rows, told)
    scale = reading.rho * np.array([[length ** (3 + _power(i) + _power(j)) for j in wanted] for i in wanted])
    limits: dict[float, Floats] = {}
    for row, value, i, j in rows:
        if value <= 0.0:
            table = limits.setdefault(math.copysign(1.0, value) if value else 0.0, np.full(scale.shape, np.nan))
            if not math.isfinite(row.values[3]):
                reading.notes.append(f"{path.name}, line {row.line}: no number for the limit of this mode")
            _place(path, row, table, (i, j), scale[i, j] * row.values[3])
            continue
        omega = float(omega_of(np.array(value), unit))
        entry = reading.matrices.setdefault(omega, np.full((2, *scale.shape), np.nan))
        if i == j or reading.frame.moved:
            if not all(map(math.isfinite, row.values[3:])):
                reading.spoiled.setdefault(omega, []).append(f"{path.name}, line {row.line}")
                np.nan_to_num(entry[:, i, j], copy=False)
                continue
        elif not all(map(math.isfinite, row.values[3:])):
            reading.note(f"{path.name}, line {row.line}: coupling that cannot be read, dropped like all of it")
            continue
        _place(path, row, entry[0], (i, j), scale[i, j] * row.values[3])
        _place(path, row, entry[1], (i, j), scale[i, j] * row.values[4] * omega)
    _limits(reading, limits, unit)
    return unit


def _unit(reading: Reading, path: Path, rows: list[tuple[Row, float, int, int]], told: dict[str, str]) -> str:
    """Unit of the first column: the option, IPEROUT, or periods where the numbers agree with that alone."""
    told = dict(told)
    if reading.site.frequency is None and not told:
        axis = sorted({value for _, value, _, _ in rows if value > 0.0})
        at = {value: n for n, value in enumerate(axis)}
        tables = np.full((len(reading.frame.wanted), 2, len(axis)), np.nan)
        for row, value, i, j in rows:
            if i == j and value > 0.0:
                tables[i, :, at[value]] = row.values[3:5]
        period = runs_as_period(np.array(axis), [(one[0], one[1]) for one in tables])
        if period == "torn":
            problem = "could be periods or frequencies"
            raise InputError(f"{path.name}: frequency", f"{axis[0]:g} to {axis[-1]:g}", problem, ASK)
        if period == "no":
            problem = "are no periods, by added mass and damping (Kramers-Kronig)"
            raise InputError(f"{path.name}: frequency", f"{axis[0]:g} to {axis[-1]:g}", problem, ASK)
        alone = "the format alone" if period == "open" else "the format, with which added mass and damping agree"
        told[alone] = "period"
    unit, source = settled(reading.site.frequency, told, path.name)
    reading.told["frequency"] = f"{unit}, by {source}"
    return unit


ASK = "Say what it holds: --frequency rad/s, Hz or period"


def _limits(reading: Reading, limits: dict[float, Floats], unit: str) -> None:
    """Rows of zero and of infinite frequency.

    A period of 0 is an infinite frequency, a negative one stands for zero. In a column of frequencies 0 is zero and a
    negative one infinite, as WAMIT and HAMS have it; files made from such of periods keep the 0 of an infinite one. The
    added mass itself decides: that at infinite frequency follows from the table.
    """
    names = {0.0: "infinite", -1.0: "zero"} if unit == "period" else {0.0: "zero", -1.0: "infinite"}
    if unit != "period" and limits and len(reading.matrices) > 3:
        scores = {sign: _nearer_infinite(reading, values) for sign, values in limits.items()}
        if len(limits) == 1:
            ((sign, score),) = scores.items()
            if score is not None:
                names[sign] = "infinite" if score else "zero"
        elif scores.get(0.0) is True and scores.get(-1.0) is False:
            names = {0.0: "infinite", -1.0: "zero"}
    for sign, values in limits.items():
        if names[sign] == "infinite":
            reading.infinite = values
        else:
            reading.zero = values
        column = "0" if sign == 0.0 else "negative"
        reading.notes.append(f"rows of {names[sign]} frequency ({column} in column 1) read")


def _nearer_infinite(reading: Reading, values: Floats) -> bool | None:
    """Whether a limit is nearer to the added mass at infinite frequency than to that at the lowest one; None: open."""
    omega = np.array(sorted(reading.matrices))
    omega = omega[:: len(omega) // MANY + 1]
    table = np.array([reading.matrices[w] for w in omega])
    gaps = np.zeros(2)
    for i in range(len(values)):
        added, damping = table[:, 0, i, i], table[:, 1, i, i]
        if np.isfinite(values[i, i]) and np.isfinite(added).all() and np.isfinite(damping).all() and np.any(damping):
            infinite = added_mass_inf(omega, added, damping)[0]
            gaps += np.abs(values[i, i] - np.array([infinite, added[0]])) / max(abs(infinite), abs(added[0]), 1e-300)
    low, high = np.sort(gaps)
    return None if high <= 2.0 * low else bool(gaps[0] < gaps[1])


def _forces(reading: Reading, path: Path, length: float, unit: str) -> Forces:
    """Forces and moments of a file in the layout of NAME.3."""
    wanted = reading.frame.wanted
    rows = []
    for row in rows_of(path, (7,), MEND):
        if not all(map(math.isfinite, row.values[:3])):
            _refused(path, row, "names no frequency, heading and mode")
        i = mode_of(row.values[2])
        if i in wanted and row.values[0] > 0.0:
            rows.append((row, wanted.index(i)))
    if not rows:
        return {}
    raw = np.array([row.values[1] for row, _ in rows])
    different = np.unique(raw)
    turned = degrees(different, reading.site.headings, None, None, path.name)
    reading.told["headings"] = reading.site.headings or "deg, by the format"
    heading = dict(zip(different.tolist(), turned.tolist(), strict=True))
    forces: Forces = {}
    for row, i in rows:
        omega = float(omega_of(np.array(row.values[0]), unit))
        key = (omega, heading[row.values[1]])
        entry = forces.setdefault(key, np.full(len(wanted), np.nan + 0j))
        real, imaginary = row.values[5:7]
        if not (math.isfinite(real) and math.isfinite(imaginary)):
            reading.spoiled.setdefault(omega, []).append(f"{path.name}, line {row.line}")
            continue
        value = reading.rho * reading.g * length ** (2 + _power(wanted[i])) * (real + 1j * imaginary)
        _place(path, row, entry, i, value)
    return forces


def _restoring(reading: Reading, path: Path, length: float) -> None:
    """Read NAME.hst, where it is there: restoring coefficients over rho g and lengths."""
    if not path.is_file():
        return
    matrix = np.zeros((6, 6))
    for row in rows_of(path, (3,), MEND):
        i, j = (mode_of(v) if math.isfinite(v) else 0 for v in row.values[:2])
        if not 1 <= i <= 6 or not 1 <= j <= 6:
            continue
        if not math.isfinite(row.values[2]):
            reading.notes.append(f"{path.name}, line {row.line}: no number, so k3 is not taken from there")
            return
        power = 2 + _power(i) + _power(j)
        matrix[i - 1, j - 1] = reading.rho * reading.g * length**power * row.values[2]
    reading.restoring, reading.told["restoring"] = matrix, path.name


def _place(path: Path, row: Row, table: np.ndarray, at: int | tuple[int, ...], value: complex) -> None:
    """Set a value that stands nowhere else with another one."""
    if np.isfinite(table[at]) and unlike(complex(table[at]), value):
        _refused(path, row, "gives a value once more, another one")
    table[at] = value


def _refused(path: Path, row: Row, problem: str) -> None:
    raise InputError(f"{path.name}, line {row.line}", " ".join(f"{v:g}" for v in row.values), problem, MEND)
