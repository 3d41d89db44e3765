"""The folder of stored results: one file each, written whole and synced, believed only where its checksum matches."""

from __future__ import annotations

import json
import sys
from collections import Counter, deque
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future
from contextlib import contextmanager
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from gyroctl.disk import DISK, Disk
from gyroctl.engine.record import LARGEST, Damaged, Record, from_bytes, is_as_written, to_bytes
from gyroctl.errors import visible
from gyroctl.fingerprint import made_with
from gyroctl.provenance import commit
from gyroctl.version import VERSION
from gyroctl.writing import clear, settle, written_whole

SUFFIX = ".run"
EARLIER = "*.npz"
"""Results of a format that carried no checksum."""

WRITERS, PENDING = 4, 64
"""Threads that write, and how many results may wait for them: no more is in memory than these."""


def aloud(line: str) -> None:
    """Say a line where messages go."""
    print(visible(line), file=sys.stderr, flush=True)


class Store:
    """Results of finished work, by key.

    Parameters
    ----------
    folder : Path or None
        Made when the first result is stored. None stores nothing.
    say : callable
        Told in one line what is not believed.
    disk : Disk
        The file system.
    """

    def __init__(self, folder: Path | None, say: Callable[[str], None] = aloud, disk: Disk = DISK) -> None:
        self.folder, self.say, self.disk = folder, say, disk
        self.refused: Counter[str] = Counter()
        self._settled = False  # whether the folder's own name is on the disk
        if folder is not None:
            clear(folder, disk)

    def path(self, key: str) -> Path:
        """File of a result."""
        assert self.folder is not None
        return self.folder / f"{key}{SUFFIX}"

    def load(self, key: str) -> Record | None:
        """Return a result, or None where there is none that can be believed; what is refused is counted."""
        if self.folder is None or not key:
            return None
        try:
            return read(self.path(key), self.disk)
        except FileNotFoundError:
            return None
        except (Damaged, OSError) as error:
            self.refused[str(error) if isinstance(error, Damaged) else f"not readable ({error.strerror})"] += 1
            return None

    def save(
        self,
        key: str,
        content: dict[str, Any],
        arrays: Mapping[str, NDArray[Any]] | None = None,
        about: Mapping[str, Any] | None = None,
    ) -> None:
        """Store a result under its key; without a folder or a key there is nothing to do.

        Raises
        ------
        OSError
            Where it cannot be written; nothing of it is left then.
        """
        if self.folder is None or not key:
            return
        told = {**(about or {}), **made_by(), "finished": datetime.now(UTC).isoformat(timespec="milliseconds")}
        with written_whole(self.path(key), self.disk) as part:
            self.disk.write(part, to_bytes(Record(key, content, arrays or {}, told)))
        if not self._settled:
            settle(self.folder, self.disk)
            self._settled = True

    @contextmanager
    def beside(self) -> Iterator[Callable[..., None]]:
        """Give a `save` that does not wait for the disk; at the end of the context all of it is stored.

        A disk takes ten milliseconds to sync a file and its name, which other work need not wait for.

        Raises
        ------
        OSError
            As `save`, at one of the next calls or at the end.
        """
        pending: deque[Future[None]] = deque()
        with self.disk.writers(WRITERS) as pool:

            def save(*given: Any) -> None:
                while pending and (pending[0].done() or len(pending) > PENDING):
                    pending.popleft().result()
                pending.append(pool.submit(self.save, *given))

            yield save
            while pending:
                pending.popleft().result()

    def tell(self) -> None:
        """Say once what was refused, and why it is computed again."""
        for why, count in self.refused.items():
            some = "a stored result is" if count == 1 else f"{count} stored results are"
            self.say(f"{self.folder}: {some} {why}: not believed, computed again")
        self.refused.clear()
        if self.folder is not None and not stored(self.folder, self.disk) and _earlier(self.folder, self.disk):
            self.say(f"{self.folder}: results of an earlier format carry no checksum: not believed, computed again")

    def tell_apart(self, wanted: set[str], laws: set[tuple[str, str]]) -> None:
        """Say which results of the same laws, by case and name, are there and were made with other libraries."""
        if self.folder is None:
            return
        apart = Counter(
            differences(head)
            for head in heads(self.folder, disk=self.disk)
            if head["key"] not in wanted and (str(head.get("case", "")), str(head.get("law"))) in laws
        )
        for what, count in apart.items():
            if what:
                self.say(f"{self.folder}: {count} stored results were made with {what}: kept apart, not used")

    def files(self) -> Iterator[Path]:
        """Files of all results, sorted."""
        if self.folder is not None:
            yield from stored(self.folder, self.disk)


def stored(folder: Path, disk: Disk = DISK) -> list[Path]:
    """Files of all results in a folder, sorted; what is being written is none yet."""
    return sorted(path for path in disk.names(folder) if path.suffix == SUFFIX and not path.name.startswith("."))


def _earlier(folder: Path, disk: Disk) -> bool:
    return any(path.match(EARLIER) for path in disk.names(folder))


def read(path: Path, disk: Disk = DISK) -> Record:
    """Read the file of a result.

    Raises
    ------
    Damaged
        Where it is not what was written.
    OSError
        Where it cannot be read.
    """
    if disk.size(path) > LARGEST:
        raise Damaged("too large")
    return from_bytes(disk.read(path), path.stem)


def is_whole(path: Path, disk: Disk = DISK) -> bool:
    """Whether the file of a result can be read and is what was written under its name: checksum and key alone."""
    try:
        raw = disk.read(path) if disk.size(path) <= LARGEST else b""
    except OSError:
        return False
    return is_as_written(raw, path.stem)


@cache
def made_by() -> dict[str, Any]:
    """What makes results in this process: version, commit, libraries, processor, machine."""
    return {"gyroctl": VERSION, "commit": commit(), "made_with": made_with()}


def differences(about: Mapping[str, Any]) -> str:
    """What made a result and is not what there is here, in words; empty where all is the same."""
    here, there = made_with(), about.get("made_with", {})
    if not isinstance(there, Mapping):
        return "unknown versions"
    names = [name for name in {**here, **there} if here.get(name) != there.get(name)]
    return ", ".join(f"{name} {there.get(name, 'unknown')} (here {here.get(name, 'none')})" for name in names)


def heads(folder: Path, most: int = 2000, disk: Disk = DISK) -> Iterator[Mapping[str, Any]]:
    """Yield what results are of and what made them, without reading their numbers: to be told, not to be believed."""
    for path in stored(folder, disk)[:most]:
        try:
            head = json.loads(disk.lines(path, 200, 1 << 24)[1])
            yield {"key": str(head["key"]), **head["about"]}
        except (OSError, ValueError, KeyError, TypeError, RecursionError):
            continue
