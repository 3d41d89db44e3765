"""Values as JSON and arrays, and back: named groups, tables, numbers, and nothing that could be code.

A group comes back as the class that the reader names for it, and as no other one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.engine.record import Damaged

Arrays = dict[str, NDArray[Any]]


def packed(value: Any) -> tuple[Any, Arrays]:
    """Return what JSON can hold, and the arrays that it refers to by name.

    Raises
    ------
    TypeError
        For a value that is none of these.
    """
    arrays: Arrays = {}
    return _packed(value, arrays), arrays


def _packed(value: Any, arrays: Arrays) -> Any:
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, np.generic):
        return _packed(value.item(), arrays)
    if isinstance(value, np.ndarray) and not value.dtype.hasobject:
        name = f"a{len(arrays)}"
        arrays[name] = value
        return {"array": name}
    if is_dataclass(value) and not isinstance(value, type):
        return _group(value, {f.name: getattr(value, f.name) for f in fields(value) if f.init}, arrays)
    if isinstance(value, tuple) and hasattr(value, "_asdict"):
        return _group(value, value._asdict(), arrays)
    if isinstance(value, Mapping):
        return {"table": [[_packed(key, arrays), _packed(part, arrays)] for key, part in value.items()]}
    if isinstance(value, list | tuple):
        return {type(value).__name__: [_packed(part, arrays) for part in value]}
    raise TypeError(f"{type(value).__name__} cannot be stored")


def _group(value: Any, parts: Mapping[str, Any], arrays: Arrays) -> dict[str, Any]:
    return {"group": type(value).__name__, "parts": {name: _packed(part, arrays) for name, part in parts.items()}}


def unpacked(content: Any, arrays: Mapping[str, NDArray[Any]], kinds: Sequence[type]) -> Any:
    """Return the value that was packed; its groups are of `kinds`.

    Raises
    ------
    Damaged
        For anything else.
    """
    try:
        return _unpacked(content, arrays, {kind.__name__: kind for kind in kinds})
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise Damaged("of another shape") from error


def _unpacked(content: Any, arrays: Mapping[str, NDArray[Any]], kinds: Mapping[str, type]) -> Any:
    def each(parts: Any) -> list[Any]:
        return [_unpacked(part, arrays, kinds) for part in parts]

    if not isinstance(content, dict):
        return content
    if "group" in content:
        return kinds[content["group"]](**dict(zip(content["parts"], each(content["parts"].values()), strict=True)))
    if "array" in content:
        return arrays[content["array"]]
    if "table" in content:
        return {key: part for key, part in (each(pair) for pair in content["table"])}
    return tuple(each(content["tuple"])) if "tuple" in content else each(content["list"])
