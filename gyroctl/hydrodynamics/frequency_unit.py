"""What a column of frequencies holds, where a file says it or its numbers do."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

import numpy as np

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.kramers_kronig import dispersion
from gyroctl.hydrodynamics.table import Floats

CLEAR = 1.3
"""Factor between the departures from Kramers-Kronig that decides between periods and frequencies."""

MANY = 300
"""Frequencies that decide; more are thinned out."""

MEND = "Say what it holds: --frequency rad/s, Hz or period"


def omega_of(values: Floats, unit: str) -> Floats:
    """Return frequencies [rad/s] of positive numbers in a unit: "rad/s", "Hz" or "period" [s]."""
    with np.errstate(divide="ignore", over="ignore"):
        return {
            "rad/s": lambda: np.asarray(values, dtype=np.float64),
            "Hz": lambda: np.asarray(2.0 * np.pi * np.asarray(values), dtype=np.float64),
            "period": lambda: np.asarray(2.0 * np.pi / np.asarray(values), dtype=np.float64),
        }[unit]()


def departure(omega: Floats, added: Floats, damping: Floats) -> float:
    """Return how far a table departs from Kramers-Kronig, relative to the spread of its added mass; nan without any.

    0 where added mass and damping belong together, about 2 where the axis of frequencies runs backwards.
    """
    order = np.argsort(omega)
    omega, added, damping = omega[order], added[order], damping[order]
    carried = (omega >= 0.05 * omega[-1]) & (omega <= 0.75 * omega[-1])
    carried = carried if np.count_nonzero(carried) > 2 else np.ones(len(omega), dtype=bool)
    spread = float(np.std(added[carried]))
    if (
        len(omega) < 4
        or not np.isfinite(omega).all()
        or not spread > 0.0
        or not np.any(damping)
        or np.any(np.diff(omega) <= 0.0)
    ):
        return float("nan")
    try:
        estimates = (added - dispersion(omega, damping))[carried]
    except np.linalg.LinAlgError:
        return float("nan")
    return float(np.sqrt(np.mean((estimates - np.median(estimates)) ** 2)) / spread)


def runs_as_period(values: Floats, tables: Iterable[tuple[Floats, Floats]]) -> Literal["yes", "no", "open", "torn"]:
    """Decide whether a column of positive numbers holds periods or frequencies, from what stands beside it.

    Parameters
    ----------
    values : ndarray (n,)
        The column.
    tables : iterable of pair of ndarray (n,)
        Added mass, and damping over frequency, of each rotation; nan where there is none.

    Returns
    -------
    {"yes", "no", "open", "torn"}
        "open" where the numbers cannot tell, "torn" where they contradict each other. Causality decides: added mass
        follows from the damping by Kramers-Kronig on the right axis, and has the opposite sign on the reversed one.
        Whether frequencies are rad/s or Hz, it cannot tell, since damping over frequency knows no unit of time.
    """
    score, known = 0.0, False
    thin = slice(None, None, len(values) // MANY + 1)
    values = values[thin]
    for added, ratio in ((one[thin], other[thin]) for one, other in tables):
        sound = np.isfinite(added) & np.isfinite(ratio)
        if np.count_nonzero(sound) < 4:
            continue
        with np.errstate(all="ignore"):
            ends = []
            for unit in ("period", "rad/s"):
                omega = omega_of(values[sound], unit)
                ends.append(departure(omega, added[sound], ratio[sound] * omega))
        if all(np.isfinite(end) for end in ends):
            known = True
            score += float(np.log(max(ends[0], 1e-6) / max(ends[1], 1e-6)))
    if not known:
        return "open"
    if abs(score) < np.log(CLEAR):
        return "torn"
    return "yes" if score < 0.0 else "no"


def settled(given: str | None, told: dict[str, str], name: str) -> tuple[str, str]:
    """Return the unit of a file's frequencies and who says so.

    Parameters
    ----------
    given : str or None
        The option.
    told : mapping of str to str
        Units by the places that tell them.
    name : str
        The file, for errors.

    Raises
    ------
    InputError
        Where nobody tells, or two places tell different units and no option decides.
    """
    places = " and ".join(f"{unit} by {place}" for place, unit in told.items())
    if given is not None:
        other = f", against {places}" if set(told.values()) - {given} else ""
        return given, f"--frequency{other}"
    if len(set(told.values())) > 1:
        raise InputError(f"{name}: frequency", places, "can be read in two ways", MEND)
    if not told:
        raise InputError(f"{name}: frequency", "unit", "is told nowhere", MEND)
    return next(iter(told.values())), ", ".join(told)
