"""A file system in memory that fails as real ones do, and processes that are killed: all of it from one generator.

What a process has written is seen by all others at once and is on the medium only once it is synced, content and names
apart. A power cut leaves of the rest whatever a file system may leave: nothing, all, a part, blocks of the old content
or of zeros, names in their order or not.
"""

from __future__ import annotations

import errno
import os
import random
import threading
from collections.abc import Callable
from concurrent.futures import Executor, Future
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

ROOT = Path("/medium")

BLOCK = 64
"""Bytes that reach the medium together, or not. [B]"""

HOST = "0123abcd"


class Killed(BaseException):
    """The process is no more: nothing of it runs any longer, no handler and no cleaning up."""


@dataclass(eq=False)
class Inode:
    """A file."""

    data: bytes = b""
    safe: bytes | None = None  # on the medium; None before the first sync
    holes: list[tuple[int, int]] = field(default_factory=list)  # parts whose sync failed: they are not tried again
    born: float = 0.0
    whole: bytes | None = None  # all that was to be in it
    appended: bool = False
    errors: int = 0  # how often a sync failed


@dataclass(eq=False)
class Process:
    """Who writes, and what is to happen to it at which of its operations."""

    process: int
    start: str
    faults: dict[int, str] = field(default_factory=dict)
    host: str = HOST
    count: int = 0
    dead: bool = False
    full: bool = False


Change = tuple[str, Path, Path, Inode | None]


class Medium:
    """Files as processes see them, and as they are found after a power cut."""

    def __init__(self, rng: random.Random) -> None:
        self.rng, self.now = rng, 0.0
        self.files: dict[Path, Inode] = {}
        self.folders = {ROOT}
        self.stable: dict[Path, Inode] = {}
        self.stable_folders = {ROOT}
        self.pending: dict[Path, list[Change]] = {}
        self.processes: list[Process] = []

    def note(self, kind: str, path: Path, target: Path, inode: Inode | None) -> None:
        """Remember a change of names until it is synced."""
        self.pending.setdefault(target.parent, []).append((kind, path, target, inode))

    def settle(self, changes: list[Change]) -> None:
        """Bring changes of names to the medium."""
        for kind, path, target, inode in changes:
            if kind == "folder":
                self.stable_folders.add(target)
            elif kind == "no folder":
                self.stable_folders.discard(target)
            else:
                self.stable.pop(path, None)
                if inode is not None:
                    self.stable[target] = inode

    def cut(self) -> None:
        """The power fails."""
        for process in self.processes:
            process.dead = True
        rng, ordered = self.rng, self.rng.random() < 0.5
        for changes in self.pending.values():
            first = rng.randint(0, len(changes))
            self.settle(changes[:first] if ordered else [each for each in changes if rng.random() < 0.5])
        self.pending.clear()
        self.folders = {place for place in self.stable_folders if self._there(place)}
        self.files = {path: self._left(inode) for path, inode in self.stable.items() if path.parent in self.folders}
        self.stable, self.stable_folders = dict(self.files), set(self.folders)

    def _there(self, folder: Path) -> bool:
        return folder == ROOT or (folder in self.stable_folders and self._there(folder.parent))

    def _left(self, inode: Inode) -> Inode:
        old, rng = inode.safe or b"", self.rng
        before = old if inode.appended else b""  # what stands there already is not written once more
        data, old = inode.data[len(before) :], old[len(before) :]
        if data != old:
            kind = rng.choice(("old", "new", "cut", "blocks", "zeros"))
            if kind in ("old", "zeros"):
                data = old if kind == "old" else bytes(len(data))
            elif kind == "cut":
                data = data[: int(rng.random() * len(data))]
            elif kind == "blocks":
                blocks = range(0, len(data), BLOCK)
                data = b"".join((data, old, bytes(len(data)))[rng.randrange(3)][i : i + BLOCK] for i in blocks)
        return Inode(before + data, before + data, [], inode.born, inode.whole, inode.appended)


class World:
    """Takes turns among threads, one of which runs at a time, as the generator has it."""

    def __init__(self, rng: random.Random) -> None:
        self.rng = rng
        self.ready: list[threading.Semaphore] = []
        self.idle = threading.Semaphore(0)
        self.mine = threading.local()

    def start(self, work: Callable[[], None]) -> None:
        """Let work run in a thread whose turn comes sometime."""
        go = threading.Semaphore(0)

        def run() -> None:
            go.acquire()
            self.mine.go = go
            try:
                work()
            finally:
                self.ready.remove(go)
                (self.rng.choice(self.ready) if self.ready else self.idle).release()

        self.ready.append(go)
        threading.Thread(target=run, daemon=True).start()

    def turn(self) -> None:
        """Let another thread run, or this one go on."""
        me = getattr(self.mine, "go", None)
        if me is None or len(self.ready) < 2:
            return
        other = self.rng.choice(self.ready)
        if other is not me:
            other.release()
            me.acquire()

    def run(self, *works: Callable[[], None]) -> None:
        """Run works side by side to their ends."""
        for work in works:
            self.start(work)
        self.rng.choice(self.ready).release()
        self.idle.acquire()


class Later(Future[Any]):
    """Work that is done when it is waited for, or before."""

    def __init__(self, pool: Pool) -> None:
        super().__init__()
        self.pool = pool

    def result(self, timeout: float | None = None) -> Any:
        """Run the work of the pool, in any order, until this is done."""
        self.pool.until(self.done)
        return super().result(timeout)


class Pool(Executor):
    """Writers of a process: side by side in threads of the world, or one after the other in any order."""

    def __init__(self, world: World, told: Callable[[str], None], threads: bool) -> None:
        self.world, self.told, self.threads = world, told, threads
        self.todo: list[Callable[[], None]] = []
        self.left = 0

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Take work, whose first argument is a key."""
        future = Later(self)

        def work() -> None:
            try:
                future.set_result(fn(*args, **kwargs))
                self.told(args[0])
            except BaseException as error:
                future.set_exception(error)
            self.left -= 1

        self.left += 1
        if self.threads:
            self.world.start(work)
        else:
            self.todo.append(work)
            if self.world.rng.random() < 0.3:
                self._one()
        return future

    def _one(self) -> None:
        self.todo.pop(self.world.rng.randrange(len(self.todo)))()

    def until(self, done: Callable[[], bool]) -> None:
        """Run until something is done."""
        while not done():
            if self.threads:
                self.world.turn()
            else:
                self._one()

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Wait for all."""
        self.until(lambda: self.left == 0)


class SimulatedDisk:
    """The medium as a process sees it."""

    def __init__(self, medium: Medium, process: Process, pool: Callable[[], Pool], turn: Callable[[], None]) -> None:
        self.medium, self.process, self.pool, self.turn = medium, process, pool, turn

    def _begin(self) -> str:
        """One more operation: what is to happen to it."""
        me = self.process
        self.turn()
        if me.dead:
            raise Killed
        me.count += 1
        fault = me.faults.get(me.count, "")
        if fault in ("kill", "cut"):
            self._end(f"{fault} after")
        if fault == "full":
            me.full = True
        if fault == "room":
            me.full = False
        return fault

    def _end(self, fault: str) -> None:
        if fault == "cut after":
            self.medium.cut()
        if fault in ("kill after", "cut after"):
            self.process.dead = True
            raise Killed

    def _fails(self, fault: str, path: Path) -> None:
        if fault == "error":
            raise OSError(errno.EIO, os.strerror(errno.EIO), str(path))

    def _no_room(self, path: Path) -> None:
        if self.process.full:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))

    def _inode(self, path: Path) -> Inode:
        if path not in self.medium.files:
            raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(path))
        return self.medium.files[path]

    def owner(self) -> Process:
        return self.process

    def alive(self, process: int) -> bool:
        return any(each.process == process and not each.dead for each in self.medium.processes)

    def age(self, path: Path) -> float:
        return self.medium.now - self._inode(path).born

    def has(self, path: Path) -> bool:
        self._begin()
        return path in self.medium.files or path in self.medium.folders

    def names(self, folder: Path) -> list[Path]:
        fault = self._begin()
        self._fails(fault, folder)
        inside = [path for path in (*self.medium.files, *self.medium.folders) if path.parent == folder]
        self.medium.rng.shuffle(inside)
        return inside

    def size(self, path: Path) -> int:
        return len(self._inode(path).data)

    def read(self, path: Path) -> bytes:
        fault = self._begin()
        data = self._inode(path).data
        self._fails(fault, path)
        return data

    def lines(self, path: Path, *most: int) -> list[bytes]:
        found = self.read(path).split(b"\n")[: len(most)]
        return [line[:length] for line, length in zip([*found, b"", b""], most, strict=False)]

    def make_folder(self, folder: Path) -> None:
        fault = self._begin()
        self._fails(fault, folder)
        self._no_room(folder)
        if folder.parent not in self.medium.folders:
            raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(folder))
        if folder not in self.medium.folders:
            self.medium.folders.add(folder)
            self.medium.note("folder", folder, folder, None)
        self._end(fault)

    def new_file(self, folder: Path, prefix: str, suffix: str) -> Path:
        fault = self._begin()
        self._fails(fault, folder)
        self._no_room(folder)
        if folder not in self.medium.folders:
            raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(folder))
        path = folder / f"{prefix}{self.medium.rng.randrange(1 << 60):x}{suffix}"
        inode = self.medium.files[path] = Inode(born=self.medium.now)
        self.medium.note("file", path, path, inode)
        self._end(fault)
        return path

    def write(self, path: Path, content: bytes) -> None:
        self._written(path, content, appended=False)

    def append(self, path: Path, content: bytes) -> None:
        if path not in self.medium.files:
            self._begin()
            self._no_room(path)
            if path not in self.medium.files:  # another process may have made it meanwhile
                inode = self.medium.files[path] = Inode(born=self.medium.now, appended=True)
                self.medium.note("file", path, path, inode)
        seen = self._inode(path).errors
        self._written(path, content, appended=True)
        self.sync(path, seen)

    def _written(self, path: Path, content: bytes, appended: bool) -> None:
        fault = self._begin()
        inode = self._inode(path)
        before = inode.data if appended else b""  # as it is now: the end is looked for and written to at once
        part = before + content[: int(self.medium.rng.random() * len(content))]
        inode.whole = before + content
        if fault.startswith("short") or self.process.full or fault == "error":
            inode.data = part
            self._end({"short, kill": "kill after", "short, cut": "cut after"}.get(fault, ""))
            self._fails(fault, path)
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))
        inode.data = before + content
        self._end(fault)

    def sync(self, path: Path, seen: int | None = None) -> None:
        """As Linux does: an error is told once to each who has the file open, `seen` when it had told so many."""
        fault = self._begin()
        inode = self._inode(path)
        if fault == "error" and inode.data != inode.safe:
            start = len(inode.safe or b"") if inode.appended else 0
            inode.holes.append((start, len(inode.data)))
            inode.errors += 1
        self._fails("error" if seen not in (None, inode.errors) else fault, path)
        safe = bytearray(inode.data)
        for start, end in inode.holes:
            safe[start:end] = bytes(len(safe[start:end]))
        inode.safe = bytes(safe)
        self._end(fault)

    def rename(self, path: Path, target: Path) -> None:
        fault = self._begin()
        self._fails(fault, path)
        inode = self._inode(path)
        del self.medium.files[path]
        self.medium.files[target] = inode
        self.medium.note("rename", path, target, inode)
        self._end(fault)

    def sync_folder(self, folder: Path) -> None:
        fault = self._begin()
        self._fails(fault, folder)
        self.medium.settle(self.medium.pending.pop(folder, []))
        self._end(fault)

    def remove(self, path: Path) -> None:
        fault = self._begin()
        if self.medium.files.pop(path, None) is not None:
            self.medium.note("gone", path, path, None)
        self._end(fault)

    def remove_folder(self, folder: Path) -> None:
        self._begin()
        if any(path.parent == folder for path in (*self.medium.files, *self.medium.folders)):
            raise OSError(errno.ENOTEMPTY, os.strerror(errno.ENOTEMPTY), str(folder))
        self.medium.folders.discard(folder)
        self.medium.note("no folder", folder, folder, None)

    def writers(self, count: int) -> Pool:
        return self.pool()
