"""A tuple with one number exchanged: how one text writes a state of any length, in Python and in machine code."""

from __future__ import annotations

from typing import Any

from numba.cpython.unsafe.tuple import tuple_setitem
from numba.extending import overload


def with_entry(values: Any, at: int, value: Any) -> Any:
    """Return the tuple with `value` in the place `at`."""
    return (*values[:at], value, *values[at + 1 :])


@overload(with_entry, strict=False)  # type: ignore[untyped-decorator]
def _with_entry(values: Any, at: Any, value: Any) -> Any:
    return lambda values, at, value: tuple_setitem(values, at, value)
