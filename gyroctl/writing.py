"""Files that appear whole or not at all, and what JSON can hold."""

from __future__ import annotations

import csv
import errno
import hashlib
import json
import math
import os
import platform
import re
import tempfile
import time
import uuid
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, is_dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from gyroctl.errors import in_words
from gyroctl.names import in_cell


@contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """Give a path beside `path` to write to; what was written replaces `path` at the end, or leaves no trace.

    The name cannot be guessed and is made by this process alone, so that two writers do not meet and no link that
    waits under the name is followed. What is written is on the disk before the name is, and the name before the return.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    owner = f"{os.getpid()}-{_host()}"
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.stem}.{owner}.", suffix=f".part{path.suffix}")
    os.close(handle)
    part = Path(name)
    try:
        part.chmod(0o666 & ~_umask())
        yield part
        with part.open("rb+") as file:
            os.fsync(file.fileno())
        part.replace(path)
        sync_folder(path.parent)
    finally:
        part.unlink(missing_ok=True)


def sync_folder(folder: Path) -> None:
    """Bring the names in a folder to the disk, where the system can: Windows does it by itself."""
    if os.name == "nt":
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    except OSError as error:
        if error.errno not in (errno.EINVAL, errno.ENOTSUP):  # a file system that knows no such thing
            raise
    finally:
        os.close(handle)


PART = re.compile(r"\..+\.(\d+)-([0-9a-f]{8})\.[^.]+\.part(\..*)?")
"""Name of a file that is being written: process and machine."""

OLD = 86400.0
"""Age from which such a file of another machine is left over. [s]"""


def left_over(folder: Path) -> list[Path]:
    """Files that a process which is no more left half-written in a folder: it was killed, or the power failed."""
    if not folder.is_dir():
        return []
    return [path for path in folder.iterdir() if (found := PART.fullmatch(path.name)) and _dead(path, *found.groups())]


def _dead(path: Path, process: str, host: str, *_: str) -> bool:
    try:
        old = time.time() - path.lstat().st_mtime > OLD
    except OSError:
        return False
    if host != _host() or os.name == "nt":  # there a process cannot be asked for without ending it
        return old
    try:
        os.kill(int(process), 0)
    except (ProcessLookupError, OverflowError):
        return True
    except OSError:  # of another user
        return old
    return old and int(process) != os.getpid()


@cache
def _host() -> str:
    """Short name of this machine that tells nobody which one it is."""
    return hashlib.sha256(f"{platform.node()} {uuid.getnode()}".encode()).hexdigest()[:8]


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


def write_text(path: Path, text: str) -> Path:
    """Write a text file whole or not at all."""
    with written_whole(path) as part:
        part.write_text(text, encoding="utf-8", newline="\n")
    return path


def write_json(path: Path, content: Any) -> Path:
    """Write a JSON file whole or not at all, see `plain`."""
    return write_text(path, json.dumps(plain(content), indent=1, allow_nan=False, ensure_ascii=False) + "\n")


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


def _umask() -> int:
    """Permissions that this process withholds from new files; mkstemp withholds all but the owner's."""
    mask = os.umask(0)
    os.umask(mask)
    return mask
