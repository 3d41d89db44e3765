"""Files that appear whole or not at all, and what JSON can hold."""

from __future__ import annotations

import csv
import hashlib
import io
import json
import math
import os
import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, redirect_stderr, suppress
from dataclasses import asdict, is_dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from gyroctl.disk import DISK, Disk
from gyroctl.errors import in_words
from gyroctl.names import in_cell


@contextmanager
def written_whole(path: Path, disk: Disk = DISK) -> Iterator[Path]:
    """Give a path beside `path` to write to; what was written replaces `path` at the end, or leaves no trace.

    The name cannot be guessed and is made by this process alone, so that two writers do not meet and no link that
    waits under the name is followed. What is written is on the disk before the name is, and the name before the return.
    """
    with _told_of(path), _written(path, disk) as part:
        yield part


@contextmanager
def _written(path: Path, disk: Disk) -> Iterator[Path]:
    make_folders(path.parent, disk)
    _clear_once(path.parent, disk)
    me = disk.owner()
    part = disk.new_file(path.parent, f".{path.stem}.{me.process}-{me.host}.{me.start}", f".part{path.suffix}")
    try:
        yield part
        disk.sync(part)
        disk.rename(part, path)
        disk.sync_folder(path.parent)
    finally:
        disk.remove(part)


@contextmanager
def _told_of(path: Path) -> Iterator[None]:
    """Name the file that was to be written in an error of the system, instead of the one that is no more."""
    try:
        yield
    except OSError as error:
        named = isinstance(error.filename, str | Path) and not PART.fullmatch(Path(error.filename).name)
        if error.errno is not None and not named:
            error.filename, error.filename2 = str(path), None
        raise


@contextmanager
def written_as_hdf5(path: Path) -> Iterator[Path]:
    """As `written_whole`, for the library of HDF5: what the system refuses it ends in an error of the system too.

    The library tells such a refusal as any error, and prints one more for each part of the file that it cannot close.
    """
    said = io.StringIO()
    with written_whole(path) as part:
        try:
            with redirect_stderr(said):
                yield part
        except (OSError, RuntimeError) as error:
            number = next((int(n) for one in (error, error.__context__) for n in ERRNO.findall(str(one))), None)
            if number is None:
                raise
            said = io.StringIO()
            raise OSError(number, os.strerror(number), str(path)) from error
        finally:
            print(said.getvalue(), end="", file=sys.stderr)


def make_folders(folder: Path, disk: Disk = DISK) -> None:
    """Make a folder with those above it, and bring their names to the disk."""
    missing, place = list[Path](), folder
    while not disk.has(place):
        missing.append(place)
        place = place.parent
    for place in reversed(missing):
        disk.make_folder(place)
        _synced(place.parent, disk)


def settle(folder: Path, disk: Disk = DISK) -> None:
    """Bring the name of a folder, and of those above it, to the disk: who made them may have been killed before."""
    for above in folder.absolute().parents:
        _synced(above, disk)


def _synced(folder: Path, disk: Disk) -> None:
    with suppress(PermissionError):  # it may be written to, or gone through, and not read
        disk.sync_folder(folder)


ERRNO = re.compile(r"errno = (\d+)")
"""Where HDF5 says what the system answered."""

PART = re.compile(r"\..+\.(\d+)-([0-9a-f]{8})\.([^.]+)\.part(\..*)?")
"""Name of a file that is being written: process, machine, and a word that begins with that of its start."""

OLD = 86400.0
"""Age from which such a file of another machine is left over. [s]"""


def left_over(folder: Path, disk: Disk = DISK) -> list[Path]:
    """Files that a process which is no more left half-written in a folder: it was killed, or the power failed."""
    return [
        path
        for path in disk.names(folder)
        if (found := PART.fullmatch(path.name)) and _dead(disk, path, *found.groups())
    ]


def clear(folder: Path, disk: Disk = DISK) -> None:
    """Remove what killed processes left half-written; where that must not be, it stays."""
    with suppress(OSError):  # a folder that may be written to and not be read
        for path in left_over(folder, disk):
            with suppress(OSError):
                disk.remove(path)


@lru_cache(maxsize=64)
def _clear_once(folder: Path, disk: Disk) -> None:
    """Clear a folder that this process first writes to."""
    clear(folder, disk)


def _dead(disk: Disk, path: Path, process: str, host: str, word: str, *_: str) -> bool:
    me = disk.owner()
    if host == me.host and int(process) == me.process:  # in a container the number is often that of the one before
        return not word.startswith(me.start)
    try:
        old = disk.age(path) > OLD
    except OSError:
        return False
    alive = disk.alive(int(process)) if host == me.host else None
    return old or alive is False


SEAL = b"\ngyroctl sha256 "
"""Before the checksum of all that stands above it, at the end of a file."""

SEALED = "sealed"
"""Attribute of a dataset whose file ends with its checksum: where that is missing, something was cut off or changed."""


def seal(path: Path) -> None:
    """Write the checksum of a file behind it: HDF5 does not look behind its end, and every reader reads on."""
    digest = _sha256(path, path.stat().st_size)
    with path.open("ab") as stream:
        stream.write(SEAL + digest + b"\n")


def seal_of(path: Path) -> bool | None:
    """Whether a file is what was sealed, None where it bears no seal."""
    length = len(SEAL) + 65
    size = path.stat().st_size
    with path.open("rb") as stream:
        stream.seek(max(0, size - length))
        last = stream.read()
    if not last.startswith(SEAL):
        return None
    return last == SEAL + _sha256(path, size - length) + b"\n"


def _sha256(path: Path, size: int) -> bytes:
    """Checksum of the first bytes of a file, in hexadecimal."""
    digest = hashlib.sha256()
    with path.open("rb") as stream:
        while size > 0 and (piece := stream.read(min(size, 1 << 20))):
            digest.update(piece)
            size -= len(piece)
    return digest.hexdigest().encode()


def write_text(path: Path, text: str, disk: Disk = DISK) -> Path:
    """Write a text file whole or not at all."""
    with written_whole(path, disk) as part:
        disk.write(part, text.encode("utf-8"))
    return path


def write_json(path: Path, content: Any, disk: Disk = DISK) -> Path:
    """Write a JSON file whole or not at all, see `plain`."""
    return write_text(path, json.dumps(plain(content), indent=1, allow_nan=False, ensure_ascii=False) + "\n", disk)


class Kept:
    """A report in JSON that is made in stages: what is finished is on the disk, whatever happens to the rest.

    Parameters
    ----------
    content : dict
        What is written; the stages add to it.
    path : Path, optional
        JSON file, written after each stage; without it nothing is written.
    """

    def __init__(self, content: dict[str, Any], path: Path | None = None) -> None:
        self.content, self.path = content, path
        self.failed: dict[str, str] = {}
        self.errors: list[Exception] = []

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Do a part of the work: where it fails, its name and the reason are kept, and the others go on."""
        try:
            yield
        except Exception as error:  # also what a user's law can raise: the other stages do not depend on it
            self.failed[name] = in_words(error)
            self.errors.append(error)
        self.write()

    def write(self) -> None:
        """Write what there is, what failed beside it."""
        self.content["failed"] = dict(self.failed)
        if self.path is not None:
            write_json(self.path, self.content)


def write_rows(path: Path, rows: Iterable[Iterable[Any]], bom: bool = False) -> Path:
    """Write a CSV file whole or not at all, with a mark of byte order where asked; no text in it is a formula."""
    with written_whole(path) as part, part.open("w", newline="", encoding="utf-8-sig" if bom else "utf-8") as stream:
        csv.writer(stream).writerows([in_cell(value) for value in row] for row in rows)
    return path


def plain(value: Any) -> Any:
    """Return what JSON can hold.

    NumPy's numbers and arrays become Python's, records tables, complex numbers pairs; what is not finite becomes null.
    """
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, complex):
        return [plain(value.real), plain(value.imag)]
    if is_dataclass(value) and not isinstance(value, type):
        value = asdict(value)
    elif isinstance(value, tuple) and hasattr(value, "_asdict"):
        value = value._asdict()
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [plain(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
