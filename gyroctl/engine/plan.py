"""What was wanted of a folder of results: by it `gyroctl status` tells what is done, what failed and what is left.

A plan is a note and no result: without it, or with another one, the same runs come out. It is known by the whole
request, so that several experiments in one folder keep theirs.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterable, Sequence
from contextlib import AbstractContextManager, suppress
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple

from gyroctl.disk import DISK, Disk
from gyroctl.errors import InputError
from gyroctl.provenance import typed
from gyroctl.reading import TEXT_MAX, read_json
from gyroctl.writing import settle, write_json

SUFFIX = ".plan.json"

KEPT = 64
"""Plans of the same case, laws and seeds that a folder keeps: with one more the oldest is forgotten."""

ANYWHERE = re.compile(r" --(workers|scheduler|out)[ =]\S+")
"""Options of a command by which it asks for nothing else."""


class Wanted(NamedTuple):
    """A piece of work: key of its result, law and seed."""

    key: str  # "" for what is not stored
    law: str
    seed: int


@dataclass(frozen=True)
class Noted:
    """What a plan's file holds."""

    case: str
    items: tuple[Wanted, ...]
    failures: dict[str, str]  # by key, why
    begun: str  # ISO time
    ended: str  # "" while it runs, or where it was stopped
    process: int
    command: str = ""  # that wanted it; empty within another program


class Plan(AbstractContextManager["Plan"]):
    """Notes a piece of a study while it runs.

    Parameters
    ----------
    folder : Path or None
        Of the results; None notes nothing.
    case : str
        What the runs are of.
    items : sequence of Wanted
        All that is wanted, finished or not.
    disk : Disk
        The file system.
    """

    def __init__(self, folder: Path | None, case: str, items: Sequence[Wanted], disk: Disk = DISK) -> None:
        self.like = _hash([case, sorted({item.law for item in items}), sorted({item.seed for item in items})])
        name = f"{self.like}-{_hash(sorted(items))}{SUFFIX}"
        self.path = folder / name if folder is not None else None
        self.disk = disk
        self.there = False  # whether the same was wanted before
        self.made: list[Path] = []  # folders that were not there before
        self._settled = False  # whether the folder's own name is on the disk
        self.noted = Noted(case, tuple(items), {}, _now(), "", disk.owner().process, typed())

    def __enter__(self) -> Plan:
        """Note what is wanted."""
        places = (self.path.parent, self.path.parent.parent) if self.path is not None else ()
        self.made = [place for place in places if not self.disk.has(place)]
        self.there = self.path is not None and self.disk.has(self.path)
        self._write()
        self._forget()
        return self

    def __exit__(self, kind: type[BaseException] | None, *error: object) -> None:
        """Note what failed, and that it ended; what was stopped stays open, and what was refused leaves no trace."""
        if kind is not None and issubclass(kind, InputError) and self.path is not None:
            with suppress(OSError):  # it holds results
                if not self.there:
                    self.disk.remove(self.path)
                for folder in self.made:
                    self.disk.remove_folder(folder)
        elif kind is not None and issubclass(kind, Exception) and self.noted.failures:
            with suppress(OSError):  # it may be the disk that ended the work
                self._write()
        if kind is None:
            self.noted = replace(self.noted, ended=_now())
            self._write()

    def failed(self, key: str, why: str) -> None:
        """Note a failure."""
        self.noted.failures[key] = why

    def _forget(self) -> None:
        """Keep the last `KEPT` plans of the same case, laws and seeds."""
        if self.path is None or self.there:
            return
        with suppress(OSError):  # another process may have done so
            names = self.disk.names(self.path.parent)
            same = [path for path in names if path.name.startswith(self.like) and path.name.endswith(SUFFIX)]
            for path in sorted(same, key=self.disk.age)[KEPT:] if len(same) > KEPT else ():
                self.disk.remove(path)

    def _write(self) -> None:
        if self.path is None:
            return
        write_json(self.path, asdict(self.noted), self.disk)
        if not self._settled:  # a study that finds all of its results there tells them stored, and stores none
            settle(self.path.parent, self.disk)
            self._settled = True


def plans(folder: Path) -> list[Noted]:
    """Plans of a folder; a file that is none tells nothing."""
    found = [read_plan(path) for path in sorted(folder.glob(f"*{SUFFIX}"))] if folder.is_dir() else []
    return [plan for plan in found if plan is not None]


def read_plan(path: Path) -> Noted | None:
    """Read a plan, None for what is none."""
    try:
        table: dict[str, Any] = read_json("plan", path, "It is no result", TEXT_MAX)
        items = tuple(Wanted(str(i["key"]), str(i["law"]), int(i["seed"])) for i in table["items"])
        failures = {str(key): str(why) for key, why in table["failures"].items()}
        begun = datetime.fromisoformat(table["begun"]).astimezone(UTC).isoformat(timespec="milliseconds")
        told = (str(table["case"]), items, failures, begun, str(table["ended"]), int(table["process"]))
        return Noted(*told, str(table.get("command", "")))
    except (ArithmeticError, AttributeError, KeyError, OSError, TypeError, ValueError):
        return None


def in_force(noted: Iterable[Noted]) -> list[Noted]:
    """Of plans that the same command made for the same case, laws and seeds the last: laws or experiment were edited.

    The options of a command that say where it computes, and where to, count for nothing.
    """
    last: dict[Any, Noted] = {}
    for plan in sorted(noted, key=lambda plan: plan.begun):
        laws, seeds = frozenset(item.law for item in plan.items), frozenset(item.seed for item in plan.items)
        last[ANYWHERE.sub("", plan.command), plan.case, laws, seeds] = plan
    return list(last.values())


def _hash(of: Any) -> str:
    return hashlib.sha256(json.dumps(of).encode()).hexdigest()[:16]


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")
