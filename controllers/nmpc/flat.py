"""Nested constants and states as one row of numbers, and back: within Python as views, compiled by a written-out text.

A row begins with the number of its whole numbers; these follow, then the others. Both begin with what stands alone, and
with the places and shapes of the arrays, so that one compiled function serves rows of any size. What is built from a
row shares its memory.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

Row = NDArray[np.float64]
Whole = NDArray[np.int64]


class NotFlat(TypeError):
    """A value that a row of numbers cannot hold."""


def row_of(value: Any) -> Row:
    """Write a nest of tuples, numbers, None, and arrays of floats or whole numbers as one row.

    Raises
    ------
    NotFlat
        For anything else in it.
    """
    leaves = list(_leaves(value))
    arrays = [leaf for leaf in leaves if isinstance(leaf, np.ndarray)]
    table = sum(1 + leaf.ndim for leaf in arrays) + sum(isinstance(leaf, int) for leaf in leaves)
    alone = [leaf for leaf in leaves if isinstance(leaf, float)]
    ends = {np.int64: table, np.float64: len(alone)}  # where the data of the next array begins
    whole: list[int] = []
    for leaf in leaves:
        if isinstance(leaf, np.ndarray):
            whole += [ends[leaf.dtype.type], *leaf.shape]
            ends[leaf.dtype.type] += leaf.size
        elif isinstance(leaf, int):
            whole.append(leaf)
    data = {kind: [leaf.ravel() for leaf in arrays if leaf.dtype == kind] for kind in ends}
    integers = np.concatenate([np.array(whole, np.int64), *data[np.int64]]).view(np.float64)
    return np.concatenate([np.array([float(integers.size)]), integers, np.array(alone), *data[np.float64]])


def parts_of(row: Row) -> tuple[Whole, Row]:
    """Whole numbers and the others, as views."""
    count = int(row[0])
    return row[1 : 1 + count].view(np.int64), row[1 + count :]


def built(like: Any, row: Row) -> Any:
    """Build what was written to a row, with views for its arrays; `like` is nested as it is."""
    whole, numbers = parts_of(row)

    def array(at: int, like: Any) -> Any:
        source = numbers if like.dtype == np.float64 else whole
        shape = whole[at + 1 : at + 1 + like.ndim]
        return source[whole[at] : whole[at] + int(np.prod(shape))].reshape(shape)

    return _walked(like, lambda i: int(whole[i]), lambda i: float(numbers[i]), array, _group)


def text_of(like: Any, whole: str, numbers: str, types: dict[str, Any]) -> Any:
    """Python text that builds a value nested as `like` from arrays of these names; its types come into `types`.

    Returned is a nest of texts: those of the leaves, in tuples as `like` has them; `joined` makes one text of it. It
    names the function `views.view`.
    """

    def array(at: int, like: Any) -> str:
        source = numbers if like.dtype == np.float64 else whole
        shape = "".join(f"{whole}[{at + 1 + i}], " for i in range(like.ndim))
        return f"view({source}, {whole}[{at}], ({shape}))"

    def group(kind: Any, parts: list[Any]) -> Any:
        if kind is not tuple:
            types[kind.__name__] = kind
        return _group(kind, parts)

    return _walked(like, lambda i: f"{whole}[{i}]", lambda i: f"{numbers}[{i}]", array, group)


def joined(texts: Any) -> str:
    """One text of a nest of texts."""
    if not isinstance(texts, tuple):
        return str(texts)
    name = type(texts).__name__ if hasattr(texts, "_fields") else ""
    return f"{name}({''.join(joined(part) + ', ' for part in texts)})"


def _leaves(value: Any) -> Iterator[Any]:
    if isinstance(value, tuple):
        for part in value:
            yield from _leaves(part)
    elif isinstance(value, np.ndarray) and value.dtype in (np.float64, np.int64):
        yield value
    elif isinstance(value, bool) or not (value is None or isinstance(value, int | float)):
        raise NotFlat(f"{type(value).__name__} is no number")
    elif value is not None:
        yield int(value) if isinstance(value, int) else float(value)


def _group(kind: Any, parts: list[Any]) -> Any:
    return tuple(parts) if kind is tuple else kind(*parts)


def _walked(
    like: Any,
    integer: Callable[[int], Any],
    number: Callable[[int], Any],
    array: Callable[[int, Any], Any],
    group: Callable[[Any, list[Any]], Any],
) -> Any:
    """Make a nest as `like` is, leaf by leaf, in the order of the row."""
    at = {int: 0, float: 0}

    def made(value: Any) -> Any:
        if value is None:
            return None
        if isinstance(value, tuple):
            return group(type(value), [made(part) for part in value])
        if isinstance(value, np.ndarray):
            at[int] += 1 + value.ndim
            return array(at[int] - 1 - value.ndim, value)
        kind: Any = int if isinstance(value, int) else float
        at[kind] += 1
        return integer(at[int] - 1) if kind is int else number(at[float] - 1)

    return made(like)
