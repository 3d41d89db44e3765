"""NetCDF files from outside: numbers and text by name, whatever the file is.

NetCDF classic is read here, by SciPy's reader in Python. NetCDF 4 is HDF5, read by a library in C that damaged files
can bring down: it runs in a process of its own with 1 GB of memory and 4 s (`hdf5_child`), and hands over numbers. A
large file, as of whole time series, may hold more than that and take longer, in proportion to its size.
"""

from __future__ import annotations

import io
import json
import math
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import IO, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl import hdf5_child
from gyroctl.errors import InputError
from gyroctl.reading import existing

MOST = 256 << 20
"""Bytes of numbers that any file may hold; a comparison of ten laws on a hundred realisations has half a million."""

SWELL = 16
"""How often its own size a larger file may hold: whole time series compress to about a half, constant ones more."""

SECONDS, PER_SECOND = 4, 10 << 20
"""Time of the processor for reading HDF5, and for what size of the file one second more. [s, bytes]"""

READS_MAX = 1_000_000
"""Most numbers and names in the head of a NetCDF classic file."""

PATIENCE = 30.0
"""How long to wait for each second that the process may use. [1]"""

TRUSTED = "GYROCTL_TRUST_HDF5"
"""Variable of the environment: 1 where HDF5 files are the user's own, on a platform that cannot limit a process."""


class Variable(NamedTuple):
    """One variable of a file: its dimensions, its values in native byte order, and its attributes."""

    dimensions: tuple[str, ...]
    values: NDArray[Any]
    attributes: Mapping[str, Any] = {}


Variables = Mapping[str, Variable]


class Contents(NamedTuple):
    """All variables and the global attributes of a file."""

    variables: Variables
    attributes: Mapping[str, Any]


KINDS = {b"CDF\x01": "classic", b"CDF\x02": "classic", b"\x89HDF": "4"}
"""What a file begins with."""


def read_netcdf(field: str, path: Path | str, mend: str) -> Contents:
    """Read a NetCDF file, classic or 4.

    Parameters
    ----------
    field : str
        Named by an error.
    path : Path or str
        The file.
    mend : str
        What to do about a file that is none.

    Returns
    -------
    Contents
        Numbers, or texts for arrays of characters and of strings.

    Raises
    ------
    InputError
        For a file that is missing, damaged, no NetCDF file or too large, and for NetCDF 4 where the platform cannot
        limit the process that reads it.
    """
    reader: Callable[[str, Path, str], Contents] = {"classic": read_classic, "4": read_hdf5}[kind_of(field, path, mend)]
    contents = reader(field, Path(path), mend)
    names = [*contents.variables, *contents.attributes]
    if not all(name.isprintable() for name in names):
        raise InputError(field, str(path), "has a name with a control character", mend)
    return contents


def kind_of(field: str, path: Path | str, mend: str) -> str:
    """Kind of a NetCDF file by its first bytes, ``classic`` or ``4``; says at once of a file that it is none.

    Raises
    ------
    InputError
        As `read_netcdf`, for a file that is missing or no NetCDF file.
    """
    file = existing(field, path, mend)
    try:
        with file.open("rb") as stream:
            magic = stream.read(4)
    except OSError as error:
        raise InputError(field, str(path), f"cannot be read: {error.strerror}", mend) from None
    if magic not in KINDS:
        raise InputError(field, str(path), "this is not a NetCDF file", mend)
    return KINDS[magic]


def read_classic(field: str, path: Path, mend: str) -> Contents:
    """Read a NetCDF classic file; character arrays become arrays of str.

    SciPy is what xarray would read it with, and comes without the second that importing xarray takes.

    Raises
    ------
    InputError
        When the file is damaged or has an unlimited dimension, which none of ours has.
    """
    from scipy.io import netcdf_file

    try:
        if path.stat().st_size > MOST:
            raise ValueError(f"it is larger than {MOST >> 20} MB")
        with netcdf_file(_Once(path.read_bytes()), mmap=False) as file:
            if None in file.dimensions.values():
                raise ValueError("it has an unlimited dimension")
            variables = {
                str(name): _variable(v.dimensions, v.data, _attributes(v._attributes))
                for name, v in file.variables.items()
            }
            attributes = _attributes(file._attributes)
    except (ArithmeticError, AttributeError, LookupError, MemoryError, OSError, TypeError, ValueError) as error:
        problem = f"is not a readable NetCDF classic file ({error})"
        raise InputError(field, str(path), problem, mend) from error
    return Contents(variables, attributes)


class _Once(io.BytesIO):
    """A file that is read once: variables that say they lie in the same place would fill the memory."""

    def __init__(self, content: bytes) -> None:
        super().__init__(content)
        self.left, self.steps = len(content), READS_MAX

    def read(self, size: int | None = -1, /) -> bytes:
        """Read as any file, up to what it holds in all."""
        found = super().read(size)
        self.left, self.steps = self.left - len(found), self.steps - 1
        if self.left < 0 or self.steps < 0:
            raise ValueError("its variables overlap, or are too many")
        return found


def _attributes(found: Mapping[Any, Any]) -> dict[str, Any]:
    plain = {
        str(name): value.decode() if isinstance(value, bytes) else np.asarray(value).tolist()
        for name, value in found.items()
    }
    return {name: value[0] if isinstance(value, list) and len(value) == 1 else value for name, value in plain.items()}


def _variable(dimensions: tuple[str, ...], values: NDArray[Any], attributes: Mapping[str, Any]) -> Variable:
    if values.dtype.char != "c" or values.ndim == 0:
        return Variable(dimensions, values.astype(values.dtype.newbyteorder("=")), attributes)
    text = np.ascontiguousarray(values).view(f"S{values.shape[-1]}")[..., 0]
    return Variable(dimensions[:-1], np.char.decode(text, "utf-8"), attributes)


def read_hdf5(field: str, path: Path, mend: str) -> Contents:
    """Read a NetCDF 4 file through a process of limited memory and time.

    Raises
    ------
    InputError
        As `read_netcdf`.
    """
    most, seconds = room(path)
    try:
        if os.environ.get(TRUSTED) == "1":
            return _own(path, most)
        return _handed_over(field, path, mend, most, seconds)
    except InputError:
        raise
    except (KeyError, MemoryError, TypeError, ValueError) as error:
        raise InputError(field, str(path), f"cannot be read as NetCDF 4 ({error})", mend) from error


def room(path: Path) -> tuple[int, int]:
    """Bytes of numbers that a file may hold, and the time that its reading may take of the processor [s]."""
    size = path.stat().st_size
    return max(MOST, SWELL * size), SECONDS + size // PER_SECOND


def _own(path: Path, most: int) -> Contents:
    try:
        return _contents(io.BytesIO(b"".join(hdf5_child.framed(str(path), most))), most)
    except Exception as error:  # whatever the library makes of a damaged file
        raise ValueError(str(error)) from error


def _handed_over(field: str, path: Path, mend: str, most: int, seconds: int) -> Contents:
    command = [sys.executable, "-P", hdf5_child.__file__, str(path.resolve()), str(most), str(seconds)]
    # one thread, since each has memory of its own; no filters that the file names and the disk holds
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "HDF5_PLUGIN_PRELOAD": "::"}
    pipe, nothing = subprocess.PIPE, subprocess.DEVNULL
    try:
        child = subprocess.Popen(command, stdin=nothing, stdout=pipe, stderr=pipe, env=environment)
    except OSError as error:
        problem = f"no process could be started to read it: {error.strerror}"
        raise InputError(field, str(path), problem, "Try again when the machine has room") from None
    late, wrong = threading.Event(), None

    def give_up() -> None:
        late.set()
        child.kill()

    end = threading.Timer(PATIENCE * seconds, give_up)
    end.daemon = True
    end.start()
    with child:
        assert child.stdout is not None and child.stderr is not None
        try:
            found = _contents(child.stdout, most)
        except (KeyError, MemoryError, TypeError, ValueError) as error:  # perhaps since the process came to an end
            wrong = error
        while child.stdout.read(1 << 20):
            pass
        said = " ".join(child.stderr.read().decode("utf-8", "replace").split())[:300]
    end.cancel()
    if late.is_set():
        raise InputError(field, str(path), f"took more than {PATIENCE * seconds:g} s to read", mend)
    if child.returncode == hdf5_child.NO_LIMITS:
        problem = "is HDF5, and this platform cannot limit the memory of what reads it"
        raise InputError(field, str(path), problem, f"If it is your own, set {TRUSTED}=1; or save it as NetCDF classic")
    if child.returncode != 0:
        problem = f"cannot be read as NetCDF 4 ({said or f'its reader came to an end in 1 GB and {seconds} s'})"
        raise InputError(field, str(path), problem, mend)
    if wrong is not None:
        raise wrong
    return found


def _contents(stream: IO[bytes], most: int) -> Contents:
    """What `hdf5_child.framed` wrote, with the sizes that it tells checked."""
    told, variables = json.loads(stream.readline(most)), {}
    for name, one in told["variables"].items():
        shape, dimensions = tuple(map(int, one["shape"])), tuple(map(str, one["dimensions"]))
        if len(shape) != len(dimensions):
            raise ValueError(f"{name} has {len(shape)} dimensions and names {len(dimensions)}")
        if "texts" in one:
            values = np.array([str(text) for text in one["texts"]], dtype=np.str_).reshape(shape)
        else:
            kind = np.dtype(one["dtype"])
            if kind.kind not in "biufc":
                raise ValueError(f"{name} is no array of numbers")
            size = math.prod(shape) * kind.itemsize
            most -= size
            if most < 0:
                raise ValueError("it hands over more than it may")
            values = _filled(stream, size).view(kind).reshape(shape).astype(kind.newbyteorder("="), copy=False)
        variables[name] = Variable(dimensions, values, one["attributes"])
    return Contents(variables, told["attributes"])


def _filled(stream: IO[bytes], size: int) -> NDArray[np.uint8]:
    """Read so many bytes.

    Raises
    ------
    ValueError
        Where there are fewer.
    """
    values = np.empty(size, np.uint8)
    if stream.readinto(values.data) < size:  # type: ignore[attr-defined]
        raise ValueError("its numbers are cut short")
    return values
