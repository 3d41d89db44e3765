"""Reads an HDF5 file in a process with limits on memory and time: python -P hdf5_child.py FILE BYTES SECONDS.

HDF5 is read by a large library in C, which a file made for it can make write where it should not. What the file says
goes to the standard output as numbers and text, never as objects. Only `gyroctl.netcdf` starts this script.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Iterator, Sequence
from importlib import import_module
from typing import Any

MEMORY = 1 << 30
"""What the process may take. [bytes]"""

PIECE = 16 << 20
"""Most numbers that are read at once. [bytes]"""

NO_LIMITS = 3
"""Exit code where the platform cannot limit a process."""


def limit(seconds: int) -> None:
    """Take away what reading a file of bounded size never needs; `seconds` of the processor it may use.

    Raises
    ------
    ImportError
        Where the system limits no process.
    """
    resource = import_module("resource")  # by name: not every system has it, and this one function alone asks for it

    for kind, most in (
        (resource.RLIMIT_AS, MEMORY),
        (resource.RLIMIT_CPU, seconds),
        (resource.RLIMIT_FSIZE, 0),
        (resource.RLIMIT_CORE, 0),
    ):
        resource.setrlimit(kind, (most, most))


def framed(path: str, most: int) -> Iterator[bytes]:
    """Contents of a file: a line of JSON that names variables and attributes, then their numbers in its order.

    No more than a `PIECE` of numbers is held at a time, so that a file may hold more than the process may take.

    Raises
    ------
    ValueError
        For more than `most` bytes of numbers, or values that are neither numbers nor text.
    """
    import h5netcdf

    variables, left = {}, most
    with h5netcdf.File(path, "r", decode_vlen_strings=True) as file:
        sizes = {name: int(dimension.size) for name, dimension in file.dimensions.items()}
        for name, variable in file.variables.items():  # the library looks up in the file whatever it is asked for
            dtype, dimensions = variable.dtype, variable.dimensions
            shape = [sizes[dimension] for dimension in dimensions]
            left -= math.prod(shape) * (8 if dtype is str else dtype.itemsize)
            if left < 0:
                raise ValueError(f"it holds more than {most >> 20} MB")
            number = dtype is not str and dtype.kind in "biufc"
            told = {"dtype": dtype.newbyteorder("<").str} if number else _texts(variable)
            last = len(shape) - characters(dtype, shape)
            own = {"shape": shape[:last], "dimensions": list(map(str, dimensions[:last]))}
            variables[str(name)] = {**told, **own, "attributes": _attributes(variable.attrs)}
        yield json.dumps({"variables": variables, "attributes": _attributes(file.attrs)}).encode() + b"\n"
        for name, variable in file.variables.items():
            one = variables[str(name)]
            for piece in pieces(one["shape"], int(one["dtype"][2:])) if "dtype" in one else ():
                yield _part(variable, one["shape"], piece).astype(one["dtype"]).tobytes()


def _part(variable: Any, shape: list[int], piece: tuple[Any, ...]) -> Any:
    """A piece of the numbers; all of them by the way that asks for no padding, where they fill the `shape` told."""
    if piece == (Ellipsis,) and shape:
        whole = variable.__array__()
        if list(whole.shape) == shape:
            return whole
    return variable[piece]


def pieces(shape: Sequence[int], size: int) -> Iterator[tuple[Any, ...]]:
    """Indices of parts of an array of at most `PIECE` bytes, in the order of its numbers of `size` bytes."""
    row = size * math.prod(shape[1:])
    if not shape or row * shape[0] <= PIECE:
        yield (Ellipsis,)
    elif row <= PIECE:
        step = PIECE // row
        yield from ((slice(first, first + step),) for first in range(0, shape[0], step))
    else:
        for number in range(shape[0]):
            yield from ((number, *rest) for rest in pieces(shape[1:], size))


def characters(dtype: Any, shape: Sequence[int]) -> bool:
    """Whether an array is one of characters, as in NetCDF classic, whose last dimension runs along each text."""
    return dtype is not str and dtype.kind == "S" and dtype.itemsize == 1 and bool(shape)


def _texts(variable: Any) -> dict[str, list[str]]:
    """All texts of an array."""
    import numpy as np

    values = np.asarray(variable[...])
    if characters(values.dtype, values.shape):  # joined before they are decoded: a letter may be of several bytes
        values = np.ascontiguousarray(values).view(f"S{values.shape[-1]}")[..., 0]
    texts = [one.decode("utf-8") if isinstance(one, bytes) else one for one in values.ravel().tolist()]
    if not all(isinstance(one, str) for one in texts):
        raise ValueError("it holds what is neither a number nor a text")
    return {"texts": texts}


def _attributes(attrs: Any) -> dict[str, Any]:
    """Attributes that are texts or numbers; others belong to the layout of the file."""
    import numpy as np

    found: dict[str, Any] = {}
    for name in attrs:
        value = attrs[name]
        value = value.decode("utf-8") if isinstance(value, bytes) else value
        if isinstance(value, np.ndarray | np.generic):
            value = value.tolist()
        value = value[0] if isinstance(value, list) and len(value) == 1 else value
        if isinstance(value, str | int | float | bool) or (
            isinstance(value, list) and all(isinstance(one, str | int | float) for one in value)
        ):
            found[str(name)] = value
    return found


def main() -> int:
    """Write the contents of the file, or why there are none and exit code 1."""
    path, most, seconds = sys.argv[1:]
    try:
        limit(int(seconds))
    except (ImportError, OSError, ValueError):
        return NO_LIMITS
    try:
        for part in framed(path, int(most)):
            sys.stdout.buffer.write(part)
        sys.stdout.buffer.flush()
    except Exception as error:  # whatever the library makes of a damaged file
        sys.stderr.write((str(error) or type(error).__name__)[:300])
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
