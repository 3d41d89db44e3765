"""What the store asks of a file system: few operations; each may fail, and after each a kill may come.

The store and what writes for it know no other: whatever a disk does to them can be played through, see
`benchmarks/faults.py`.
"""

from __future__ import annotations

import errno
import hashlib
import os
import platform
import secrets
import stat
import time
import uuid
from collections.abc import Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import BinaryIO, Protocol

NOTHING_TO_SYNC = (errno.EINVAL, errno.ENOTSUP, errno.ENOSYS, errno.EROFS)
"""Answers of a file system that knows no names to be synced, or has none that could have changed."""


class Owner(Protocol):
    """Who writes: by it is told what a process which is no more left behind."""

    process: int
    host: str  # hash that tells nobody which machine it is
    start: str  # of this process alone: its number may have been another one's


class Disk(Protocol):
    """Operations on files; an `OSError` says what the system refused."""

    def __hash__(self) -> int:
        """As of any value that is known by itself."""

    def owner(self) -> Owner:
        """Who writes."""

    def alive(self, process: int) -> bool | None:
        """Whether a process of this machine runs, None where that cannot be told."""

    def age(self, path: Path) -> float:
        """Time since a file was written. [s]"""

    def has(self, path: Path) -> bool:
        """Whether there is a file or folder."""

    def names(self, folder: Path) -> list[Path]:
        """All that is in a folder; nothing where there is none."""

    def size(self, path: Path) -> int:
        """Length of a file. [B]"""

    def read(self, path: Path) -> bytes:
        """Whole file."""

    def lines(self, path: Path, *most: int) -> list[bytes]:
        """First lines of a file, each of so many bytes at most."""

    def make_folder(self, folder: Path) -> None:
        """Make a folder in one that is there; another process may have done so."""

    def new_file(self, folder: Path, prefix: str, suffix: str) -> Path:
        """Make an empty file of a name that cannot be guessed and was not there."""

    def write(self, path: Path, content: bytes) -> None:
        """Write a file of this process."""

    def append(self, path: Path, content: bytes) -> None:
        """Write behind a file, or a new one, and bring it to the disk."""

    def sync(self, path: Path) -> None:
        """Bring the content of a file to the disk."""

    def rename(self, path: Path, target: Path) -> None:
        """Give a file another name in its folder, instead of what had it."""

    def sync_folder(self, folder: Path) -> None:
        """Bring the names in a folder to the disk."""

    def remove(self, path: Path) -> None:
        """Take a file away, if it is there."""

    def remove_folder(self, folder: Path) -> None:
        """Take an empty folder away."""

    def writers(self, count: int) -> Executor:
        """Threads that wait for this disk."""


class _Process:
    """Number, machine and start of this process."""

    def __init__(self) -> None:
        self.process, self.host, self.start = os.getpid(), _host(), uuid.uuid4().hex[:8]


class LocalDisk:
    """The file system of this machine."""

    def owner(self) -> Owner:
        """Who runs this."""
        return _process(os.getpid())  # another one after a fork

    def alive(self, process: int) -> bool | None:
        """Whether a process runs, as far as that can be told without ending it."""
        if os.name == "nt":
            return None
        try:
            os.kill(process, 0)
        except (ProcessLookupError, OverflowError):
            return False
        except OSError:  # of another user
            return None
        return True

    def age(self, path: Path) -> float:
        """By the clock of this machine; a link is as old as itself."""
        return time.time() - path.lstat().st_mtime

    def has(self, path: Path) -> bool:
        """Whether there is something that can be reached."""
        return path.exists()

    def names(self, folder: Path) -> list[Path]:
        """In no order."""
        return list(folder.iterdir()) if folder.is_dir() else []

    def size(self, path: Path) -> int:
        """Of what a link leads to."""
        return path.stat().st_size

    def read(self, path: Path) -> bytes:
        """All of it."""
        with _opened(path) as stream:
            return stream.read()

    def lines(self, path: Path, *most: int) -> list[bytes]:
        """With their ends, where these are within the limit."""
        with _opened(path) as stream:
            return [stream.readline(length) for length in most]

    def make_folder(self, folder: Path) -> None:
        """With the rights that folders of this process have."""
        folder.mkdir(exist_ok=True)

    def new_file(self, folder: Path, prefix: str, suffix: str) -> Path:
        """With the rights that files of this process have; a link that waits under the name is not followed."""
        path = folder / f"{prefix}{secrets.token_hex(8)}{suffix}"
        os.close(os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        return path

    def write(self, path: Path, content: bytes) -> None:
        """Whole, or an error."""
        with _named(path):
            path.write_bytes(content)

    def append(self, path: Path, content: bytes) -> None:
        """Where it fails a part of it may stand there.

        By one handle: where several write to a file, and the system could not bring it to the disk, it tells each who
        has it open, once, and nobody who opens it behind that.
        """
        with _named(path), path.open("ab") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())

    def sync(self, path: Path) -> None:
        """`fsync`."""
        with _named(path), path.open("rb+") as file:
            os.fsync(file.fileno())

    def rename(self, path: Path, target: Path) -> None:
        """In one step for whoever looks."""
        path.replace(target)

    def sync_folder(self, folder: Path) -> None:
        """Where the system can: Windows does it by itself."""
        if os.name == "nt":
            return
        handle = os.open(folder, os.O_RDONLY)
        try:
            with _named(folder):
                os.fsync(handle)
        except OSError as error:
            if error.errno not in NOTHING_TO_SYNC:
                raise
        finally:
            os.close(handle)

    def remove(self, path: Path) -> None:
        """A link, not what it leads to."""
        path.unlink(missing_ok=True)

    def remove_folder(self, folder: Path) -> None:
        """Where it is empty."""
        folder.rmdir()

    def writers(self, count: int) -> Executor:
        """Threads of Python."""
        return ThreadPoolExecutor(count)


DISK: Disk = LocalDisk()
"""That of this machine, which holds no state."""


@contextmanager
def _named(path: Path) -> Iterator[None]:
    """Name the file in an error of the system, which names none where a file that is open cannot be written."""
    try:
        yield
    except OSError as error:
        error.filename = error.filename or str(path)
        raise


def _opened(path: Path) -> BinaryIO:
    """Open a file to be read; a pipe has no writer to wait for, a device no end."""
    handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    try:
        if not stat.S_ISREG(os.fstat(handle).st_mode):
            raise OSError(errno.EINVAL, "is no file with an end", str(path))
        return os.fdopen(handle, "rb")
    except BaseException:
        os.close(handle)
        raise


@cache
def _host() -> str:
    """Short name of this machine that tells nobody which one it is."""
    return hashlib.sha256(f"{platform.node()} {uuid.getnode()}".encode()).hexdigest()[:8]


@cache
def _process(_: int) -> Owner:
    return _Process()
