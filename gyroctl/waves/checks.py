"""Checks of the numbers a user gives for a sea or a run; each refusal names field, value and mend."""

from __future__ import annotations

import math
from numbers import Integral, Real

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError

SEED_MAX = 2**63 - 1
"""Largest seed: results keep them as 64-bit numbers."""


HEIGHT_MAX, FREQUENCY_MAX = 100.0, 100.0
"""Heights [m] and frequencies [rad/s] beyond which no wave is meant; what a device can ride is far less."""

DURATION_MAX = 1e5
"""Longest run: a day. [s]"""


def finite(field: str, value: object, mend: str) -> float:
    """Return `value` as a float.

    Raises
    ------
    InputError
        `value` is not a real number, or is infinite or NaN.
    """
    if isinstance(value, bool) or not isinstance(value, Real):
        raise InputError(field, value, "must be a number", mend)
    try:
        known = math.isfinite(value)
    except OverflowError:  # a whole number beyond any float
        known = False
    if not known:
        raise InputError(field, value, "must be finite", mend)
    return float(value) + 0.0  # -0.0 becomes 0.0: both must have one content hash


def positive(field: str, value: object, mend: str) -> float:
    """Return `value` as a float above zero.

    Raises
    ------
    InputError
        `value` is not a finite number above zero.
    """
    number = finite(field, value, mend)
    if number <= 0.0:
        raise InputError(field, value, "must be positive", mend)
    return number


def at_most(field: str, value: float, high: float, unit: str) -> float:
    """Return a number that is no slip of the unit.

    Raises
    ------
    InputError
        `value` is above `high`.
    """
    if value > high:
        raise InputError(field, value, f"must be at most {high:g}", f"Give it in {unit}" if unit else "Give less")
    return value


def within(field: str, value: object, low: float, high: float, mend: str) -> float:
    """Return `value` as a float from `low` to `high`, both included.

    Raises
    ------
    InputError
        `value` is not a finite number between the two.
    """
    number = finite(field, value, mend)
    if not low <= number <= high:
        raise InputError(field, value, f"must be between {low:g} and {high:g}", mend)
    return number


def whole(field: str, value: object, low: int, high: int, mend: str) -> int:
    """Return `value` as an int from `low` to `high`, both included.

    Raises
    ------
    InputError
        `value` is not a whole number between the two.
    """
    if within(field, value, low, high, mend) != int(value):  # type: ignore[call-overload]
        raise InputError(field, value, "must be a whole number", mend)
    return int(value)  # type: ignore[call-overload, no-any-return]


def heading_angle(value: object) -> float:
    """Return a wave heading in [-180, 180] [deg].

    Raises
    ------
    InputError
        Field ``sea.heading``: not a finite number within a full turn.
    """
    mend = "Give the heading in degrees, 0 for waves along +x3, for example 30"
    number = finite("sea.heading", value, mend)
    if abs(number) > 180.0:
        raise InputError("sea.heading", value, "must lie between -180 and 180 degrees", mend)
    return number


def seed_number(value: object) -> int:
    """Return a seed as an int.

    Raises
    ------
    InputError
        Field ``run.seeds``: not a whole number, or negative.
    """
    mend = "Give a whole number from 0 upwards, for example 1001"
    if isinstance(value, bool) or not isinstance(value, Integral):
        raise InputError("run.seeds", value, "a seed must be a whole number", mend)
    if value < 0:
        raise InputError("run.seeds", value, "a seed must not be negative", mend)
    if int(value) > SEED_MAX:
        raise InputError("run.seeds", value, f"a seed must not be above {SEED_MAX}", mend)
    return int(value)


def check_text(field: str, value: object) -> str:
    """Return a text.

    Raises
    ------
    InputError
        `value` is none.
    """
    if not isinstance(value, str):
        raise InputError(field, value, "must be a text", "Give it in quotes")
    return value


def store(value: object, **fields: object) -> None:
    """Set fields of a frozen dataclass that is being made."""
    for name, entry in fields.items():
        object.__setattr__(value, name, entry)


def series(field: str, value: object, mend: str) -> NDArray[np.float64]:
    """Return `value` as a read-only copy, shape (n,), of finite float64.

    Raises
    ------
    InputError
        `value` is not a one-dimensional array of finite numbers.
    """
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(field, value, "must be a list of numbers", mend) from None
    if array.ndim != 1:
        raise InputError(field, f"array of shape {array.shape}", "must have one dimension", mend)
    bad = np.flatnonzero(~np.isfinite(array))
    if bad.size:
        raise InputError(field, float(array[bad[0]]), f"entry {bad[0] + 1} is not finite", mend)
    array.setflags(write=False)
    return array
