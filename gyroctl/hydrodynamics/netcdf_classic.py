"""Reader of the NetCDF classic format, so that the shipped data open without xarray, h5py or scipy.

The classic format (CDF-1 and CDF-2, big-endian) is short enough to read here in a millisecond; importing xarray or
scipy.io for it would cost hundreds. Files are written by xarray (`database.save`); a test holds this reader against it.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError

_TYPES = {1: ">i1", 2: "S1", 3: ">i2", 4: ">i4", 5: ">f4", 6: ">f8"}
_DIMENSIONS, _VARIABLES, _ATTRIBUTES = 10, 11, 12


@dataclass(frozen=True)
class Variable:
    """One variable of a file: its dimensions and its values in native byte order."""

    dimensions: tuple[str, ...]
    values: NDArray[Any]


@dataclass(frozen=True)
class Contents:
    """Everything a reader of databases needs: variables (coordinates too) and global attributes."""

    variables: dict[str, Variable]
    attributes: dict[str, Any]


class _Header:
    """Cursor over the header bytes."""

    def __init__(self, data: bytes, wide: bool) -> None:
        self.data, self.at, self.wide = data, 4, wide

    def integer(self) -> int:
        (value,) = struct.unpack_from(">i", self.data, self.at)
        self.at += 4
        return int(value)

    def offset(self) -> int:
        (value,) = struct.unpack_from(">q" if self.wide else ">i", self.data, self.at)
        self.at += 8 if self.wide else 4
        return int(value)

    def raw(self, length: int) -> bytes:
        value = self.data[self.at : self.at + length]
        self.at += length + (-length) % 4  # padded to four bytes
        return value

    def name(self) -> str:
        return self.raw(self.integer()).decode("utf-8")

    def count(self, tag: int) -> int:
        found, number = self.integer(), self.integer()
        if found not in (0, tag):
            raise ValueError("unexpected tag in the header")
        return number

    def attributes(self) -> dict[str, Any]:
        out: dict[str, Any] = {}
        for _ in range(self.count(_ATTRIBUTES)):
            name, kind, number = self.name(), self.integer(), self.integer()
            code = np.dtype(_TYPES[kind])
            data = self.raw(number * code.itemsize)
            if kind == 2:
                out[name] = data.decode("utf-8")
            else:
                values = np.frombuffer(data, code)
                out[name] = values[0].item() if number == 1 else values.astype(code.newbyteorder("="))
        return out


def _strings(values: NDArray[Any]) -> NDArray[Any]:
    """Character arrays (..., length) as arrays of str (...)."""
    width = values.shape[-1]
    joined = np.ascontiguousarray(values).view(f"S{width}")[..., 0]
    return np.char.decode(joined, "utf-8")


def read(path: Path) -> Contents:
    """Read a whole NetCDF classic file.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    Contents
        Variables by name and global attributes; character arrays become arrays of str.

    Raises
    ------
    InputError
        When the file is damaged or uses records (an unlimited dimension), which this project never writes.
    """
    data = path.read_bytes()
    try:
        header = _Header(data, wide=data[3] == 2)
        if header.integer() != 0:
            raise ValueError("it has an unlimited dimension")
        dimensions = [(header.name(), header.integer()) for _ in range(header.count(_DIMENSIONS))]
        attributes = header.attributes()
        variables: dict[str, Variable] = {}
        for _ in range(header.count(_VARIABLES)):
            name = header.name()
            own = [dimensions[header.integer()] for _ in range(header.integer())]
            header.attributes()
            code = np.dtype(_TYPES[header.integer()])
            header.integer()  # size in bytes, implied by the shape
            start, shape = header.offset(), tuple(length for _, length in own)
            flat = np.frombuffer(data, code, count=int(np.prod(shape)), offset=start)
            values = flat.reshape(shape)
            names = tuple(label for label, _ in own)
            if code.char == "S" and values.ndim > 0:
                variables[name] = Variable(names[:-1], _strings(values))
            else:
                variables[name] = Variable(names, values.astype(code.newbyteorder("=")))
    except (ValueError, KeyError, IndexError, struct.error) as error:
        raise InputError(
            "path",
            str(path),
            f"is not a readable NetCDF classic file ({error})",
            "Write it again with xarray or Capytaine",
        ) from error
    return Contents(variables, attributes)
