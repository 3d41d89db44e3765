"""Choices of the plant beyond the linear model, as parameters of an orbit and in another unit of time."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.plant import Plant
from gyroctl.plant.beyond import Beyond
from gyroctl.plant.equations import Coefficients

TERMS: dict[str, tuple[str, tuple[str, ...]]] = {
    "drag": ("drag", ("factor1", "factor3")),
    "bearing": ("losses", ("bearing",)),
    "windage": ("losses", ("windage",)),
    "rolling_resistance": ("losses", ("rolling",)),
    "coupling_slip": ("curve", ("slip",)),
    "coupling_cap": ("cap", ("torque",)),
}
"""Each choice that is a number: its term among those of `Beyond`, and what of the term is in proportion to it."""

NEVER_OFF = ("coupling_slip", "coupling_cap")
"""Choices whose zero stands for none, which is an infinite value: no orbit can be followed there."""


def switched_on(plant: Plant, names: tuple[str, ...]) -> Plant:
    """Return the plant with the terms of the choices `names` there, if only with a value that is to be replaced.

    Raises
    ------
    InputError
        For a choice that cannot be zero and is off.
    """
    off = [name for name in names if name in TERMS and getattr(plant.parameters, name) == 0.0]
    for name in off:
        if name in NEVER_OFF:
            problem = f"{name} is off, which stands for an infinite one"
            mend = f"Start from an orbit of plant.replace({name}=...)"
            raise InputError("parameter", name, problem, mend)
    return plant.replace(**dict.fromkeys(off, 1.0)) if off else plant


def unit_term(plant: Plant, name: str) -> Any:
    """Term of the choice `name` where it is 1: what the choice is to be multiplied by."""
    return getattr(plant.replace(**{name: 1.0}).coefficients.beyond, TERMS[name][0])


def with_choice(k: Coefficients, unit: Any, name: str, value: Any) -> Coefficients:
    """Constants of the equations with a choice at another value, complex for derivatives.

    Parameters
    ----------
    k : Coefficients
        With the choice's term on.
    unit : tuple
        See `unit_term`.
    name : str
        One of `TERMS`.
    value : scalar
        In the unit of the choice.
    """
    return _changed(k, name, {part: value * getattr(unit, part) for part in TERMS[name][1]})


def raised(k: Coefficients, unit: Any, name: str, change: Any) -> Coefficients:
    """Constants of the equations with a choice raised from where it is, see `with_choice`."""
    own = getattr(k.beyond, TERMS[name][0])
    return _changed(k, name, {part: getattr(own, part) + change * getattr(unit, part) for part in TERMS[name][1]})


def _changed(k: Coefficients, name: str, parts: dict[str, Any]) -> Coefficients:
    term = TERMS[name][0]
    return k._replace(beyond=k.beyond._replace(**{term: getattr(k.beyond, term)._replace(**parts)}))


def beyond_in_other_time(beyond: Beyond | None, alpha: Any) -> Beyond | None:
    """Terms with the unit of time changed, tau = alpha t: each constant by its power of time."""
    if beyond is None:
        return None
    changed: dict[str, Any] = {}
    for term, own in POWERS_OF_TIME.items():
        if getattr(beyond, term) is not None:
            old = getattr(beyond, term)
            changed[term] = old._replace(**{part: getattr(old, part) / alpha**power for part, power in own.items()})
    return beyond._replace(**changed)


POWERS_OF_TIME: dict[str, dict[str, int]] = {
    "position": {},
    "drag": {"still": 2},
    "curve": {"slip": 1},
    "cap": {"torque": 2},
    "losses": {"bearing": 2, "slow": 1, "soft": 4},
    "reduced": {"stiffness": 2},
}
"""Of the constants of each term that has an orbit; those that are not named do not know of time."""


def signals_in_other_time(channels: tuple[str, ...], alpha: Any) -> NDArray[Any]:
    """Factor (channels,) of each signal in the time tau = alpha t: velocities of the water, and moments."""
    return np.array([1.0 / alpha if name in ("u", "w") else 1.0 / alpha**2 for name in channels])


def of_moment(channels: tuple[str, ...], moment: str) -> list[int]:
    """Rows of the signals that hold a moment: at rest, and at all positions."""
    return [row for row, name in enumerate(channels) if name.partition("@")[0] == moment]
