"""Nested tuples of floats as flat numbers and back: how laws and their states cross into arrays and compiled code.

A law groups its parameters, and its state, in NamedTuples within NamedTuples; arrays, hashes and machine code want one
row of numbers. The order is that of the fields, depth first.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

FIRST = "first"
"""Field of a law around a law with the other one's first state: a plain tuple there is a state, and no table."""

Shape = None | int | tuple[type[Any], tuple[Any, ...]]
"""Of a number, of a table with its length, of a group with its type and the shapes of its parts: hashable."""


class NotFlat(TypeError):
    """A value that is no nest of numbers and tables; the message says where."""


def leaves(value: Any) -> list[Any]:
    """What stands in nested tuples, depth first."""
    return [leaf for part in value for leaf in leaves(part)] if isinstance(value, tuple) else [value]


def like(example: Any, values: Sequence[Any]) -> Any:
    """Nest `values` as `example` is nested; the inverse of `leaves`."""
    return _filled(example, iter(values))


def _filled(example: Any, values: Iterator[Any]) -> Any:
    if not isinstance(example, tuple):
        return next(values)
    parts = [_filled(part, values) for part in example]
    return group(type(example), parts)


def group(kind: type[Any], parts: Sequence[Any]) -> Any:
    """Make a tuple of a kind, plain or named, of its parts."""
    return tuple(parts) if kind is tuple else kind(*parts)


def named(value: Any) -> dict[str, Any]:
    """Fields of a NamedTuple by name, those of groups within it among them."""
    found: dict[str, Any] = {}
    for name, part in value._asdict().items():
        found |= named(part) if hasattr(part, "_asdict") else {name: part}
    return found


def regrouped(groups: Mapping[str, Any], values: Mapping[str, Any]) -> dict[str, Any]:
    """Give `values`, by names of fields within `groups`, their places: the groups that change, by name."""
    changed: dict[str, Any] = {}
    for name, value in values.items():
        for home, part in groups.items():
            if name in part._fields:
                changed[home] = changed.get(home, part)._replace(**{name: value})
    return changed


def shape(value: Any, tables: bool = True, where: str = "law") -> Shape:
    """Shape of a nest of numbers, and where `tables` may be, of tables: tuples or arrays of floats.

    Raises
    ------
    NotFlat
        For anything else in it.
    """
    if _is_number(value):
        return None
    if tables and isinstance(value, np.ndarray) and value.ndim == 1 and value.dtype == np.float64:
        return int(value.size)
    if not isinstance(value, tuple):
        raise NotFlat(f"{where} is neither a number nor a table of numbers")
    names = getattr(value, "_fields", None)
    if tables and names is None and all(_is_number(entry) for entry in value):
        return len(value)
    parts = zip(names or range(len(value)), value, strict=True)
    return type(value), tuple(shape(part, tables and name != FIRST, f"its field {name}") for name, part in parts)


def expression(of: Shape, array: str, types: dict[str, Any]) -> str:
    """Python text that builds a value of a shape from the flat `array`; the types that it names come into `types`."""
    text, _ = _expression(of, array, types, 0)
    return text


def places(of: Shape, value: str) -> list[str]:
    """Python texts of the numbers in a `value` of a shape, in their order."""
    if not isinstance(of, tuple):
        return [value]
    return [place for i, part in enumerate(of[1]) for place in places(part, f"{value}[{i}]")]


def _expression(of: Shape, array: str, types: dict[str, Any], at: int) -> tuple[str, int]:
    if of is None:
        return f"{array}[{at}]", at + 1
    if isinstance(of, int):
        return f"{array}[{at}:{at + of}]", at + of
    parts = []
    for part in of[1]:
        text, at = _expression(part, array, types, at)
        parts.append(text)
    kind = of[0]
    if kind is tuple:
        return f"({', '.join(parts)}{',' if parts else ''})", at
    name = next((key for key, known in types.items() if known is kind), f"Type{len(types)}")
    types[name] = kind
    return f"{name}({', '.join(parts)})", at


def _is_number(value: Any) -> bool:
    return isinstance(value, float | int) and not isinstance(value, bool)
