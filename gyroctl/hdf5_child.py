"""Reads an HDF5 file in a process of its own with limits on memory and time: python -P hdf5_child.py FILE BYTES.

HDF5 is read by a large library in C, which a file made for it can make write where it should not. What the file says
goes to the standard output as numbers and text, never as objects. Only `gyroctl.netcdf` starts this script.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from importlib import import_module
from typing import Any

MEMORY, SECONDS = 1 << 30, 4
"""What the process may take. [bytes, s of its processor]"""

NO_LIMITS = 3
"""Exit code where the platform cannot limit a process."""


def limit() -> None:
    """Take away what reading a file of bounded size never needs.

    Raises
    ------
    ImportError
        Where the system limits no process.
    """
    resource = import_module("resource")  # by name: not every system has it, and this one function alone asks for it

    for kind, most in (
        (resource.RLIMIT_AS, MEMORY),
        (resource.RLIMIT_CPU, SECONDS),
        (resource.RLIMIT_FSIZE, 0),
        (resource.RLIMIT_CORE, 0),
    ):
        resource.setrlimit(kind, (most, most))


def framed(path: str, most: int) -> Iterator[bytes]:
    """Contents of a file: a line of JSON that names variables and attributes, then their numbers in its order.

    Raises
    ------
    ValueError
        For more than `most` bytes of numbers, or values that are neither numbers nor text.
    """
    import h5netcdf

    variables, numbers, left = {}, [], most
    with h5netcdf.File(path, "r", decode_vlen_strings=True) as file:
        for name, variable in file.variables.items():
            size = variable.dtype.itemsize if variable.dtype is not str else 8
            for length in variable.shape:
                size *= int(length)
            left -= size
            if left < 0:
                raise ValueError(f"it holds more than {most >> 20} MB")
            told, values = _told(variable[...])
            dimensions = [str(dimension) for dimension in variable.dimensions]
            variables[str(name)] = {**told, "dimensions": dimensions, "attributes": _attributes(variable.attrs)}
            numbers.append(values)
        yield json.dumps({"variables": variables, "attributes": _attributes(file.attrs)}).encode() + b"\n"
    for values in numbers:
        yield values


def _told(values: Any) -> tuple[dict[str, Any], bytes]:
    """What an array is, and its numbers; a text tells its letters at once."""
    import numpy as np

    array = np.asarray(values)
    if array.dtype.kind in "biufc":
        array = array.astype(array.dtype.newbyteorder("<"))
        return {"dtype": array.dtype.str, "shape": list(array.shape)}, array.tobytes()
    texts = [one.decode("utf-8") if isinstance(one, bytes) else one for one in array.ravel().tolist()]
    if not all(isinstance(one, str) for one in texts):
        raise ValueError("it holds what is neither a number nor a text")
    return {"texts": texts, "shape": list(array.shape)}, b""


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
    try:
        limit()
    except (ImportError, OSError, ValueError):
        return NO_LIMITS
    path, most = sys.argv[1:]
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
