"""What a folder of results holds: done, failed, left, by law and case; damaged, stale and half-written files."""

from __future__ import annotations

import os
import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from gyroctl.engine.plan import SUFFIX as PLAN
from gyroctl.engine.plan import Noted, in_force, plans, read_plan
from gyroctl.engine.record import Damaged, Record
from gyroctl.engine.store import EARLIER, SUFFIX, differences, heads, is_whole, read, stored
from gyroctl.errors import InputError
from gyroctl.fingerprint import made_with, text_of
from gyroctl.writing import left_over

RUNS = "runs"
"""Folder of the stored results within that of a study."""

ALL = 1_000_000
"""Results of a folder that are counted."""

CHECKED = 20_000
"""Results of a folder whose checksum is looked at where its state is told."""

MODULES = re.compile(r"\w+(\.\w+)*( \w+(\.\w+)*)*")
"""Names of modules that made a result."""


@dataclass
class Line:
    """Counts of a law in a case, as a command wanted it."""

    case: str
    law: str
    done: int = 0
    failed: int = 0
    left: int = 0
    why: str = ""  # the first failure
    damaged: int = 0  # stored, and not what was written: they will be computed again
    command: str = ""  # that wanted it; empty within another program


@dataclass
class State:
    """What there is."""

    lines: list[Line] = field(default_factory=list)
    left_s: float | None = None  # time left [s]; None where it is not known
    running: bool = False
    here: int = 0  # stored results that the libraries and the processor of this process made
    apart: dict[str, int] = field(default_factory=dict)  # those of others, by what differs: they are not used
    earlier: int = 0  # stored results that only earlier runs of the same commands wanted, see `plan.in_force`
    unchecked: int = 0  # stored results beyond `CHECKED`

    @property
    def left(self) -> int:
        """Pieces of work that are left."""
        return sum(line.left for line in self.lines)

    @property
    def damaged(self) -> int:
        """Pieces of work whose results are damaged."""
        return sum(line.damaged for line in self.lines)

    @property
    def failed(self) -> int:
        """Pieces of work that failed."""
        return sum(line.failed for line in self.lines)


def results_folder(folder: Path) -> Path:
    """Folder of the stored results of a study, or this one.

    Raises
    ------
    InputError
        Where there are none.
    """
    return results_folders(folder)[0]


def results_folders(folder: Path) -> list[Path]:
    """Folders of stored results and of plans: this one, as of a tuning, and the one within it, as of other studies.

    Raises
    ------
    InputError
        Where there are none.
    """
    mend = "Give the folder that --out named"
    if not folder.is_dir():
        raise InputError("dir", str(folder), "there is no such folder", mend)
    places = [place for place in (folder, folder / RUNS) if place.is_dir()]
    found = [place for place in places if any(_ours(path) for path in place.iterdir())]
    if not found:
        raise InputError("dir", str(folder), "holds no stored results", mend)
    return found


def _ours(path: Path) -> bool:
    return path.name.endswith((SUFFIX, PLAN)) or path.match(EARLIER)


def state(folder: Path, kept: Collection[str] = ()) -> State:
    """What is done, failed and left of all that was wanted of a folder; `kept` are keys that are done without files."""
    found = State()
    lines: dict[tuple[str, str, str], Line] = {}
    times: list[float | None] = []
    noted = plans(folder)
    last, files = in_force(noted), stored(folder)
    wanted, asked = ({item.key for plan in some for item in plan.items} for some in (noted, last))
    places = {path.stem: path for path in files}
    broken = {path.stem for path in files[:CHECKED] if not is_whole(path)}
    found.unchecked = max(0, len(files) - CHECKED)
    found.earlier = sum(path.stem in wanted and path.stem not in asked for path in files)
    counted = set[tuple[str, str, str, str]]()
    for plan in last:
        finished = []
        for item in plan.items:
            of = (plan.command, plan.case, item.law)
            line = lines.setdefault(of, Line(plan.case, item.law, command=plan.command))
            name = item.key or f"{item.law} {item.seed}"
            place, why = places.get(item.key), plan.failures.get(name, "")
            there = place is not None and item.key not in broken and place.is_file()
            if place is not None and there:
                finished.append(place.stat().st_mtime)
            if (*of, name) in counted:
                continue  # of another plan of the same command, with more laws or seeds
            counted.add((*of, name))
            if there or item.key in kept:
                line.done += 1
            elif why:
                line.failed += 1
                line.why = line.why or why
            elif place is not None:
                line.damaged += 1
                line.why = line.why or (f"{place} is a folder: remove it" if place.is_dir() else "")
            elif plan.ended and not item.key:
                line.done += 1  # of a law that cannot be told from another one: run, and not stored
            else:
                line.left += 1
        running = not plan.ended and _alive(plan.process)
        found.running = found.running or running
        times.append(_left(plan, finished) if running else None)
    for head in heads(folder, ALL):
        if other := differences(head):
            found.apart[other] = found.apart.get(other, 0) + 1
        else:
            found.here += 1
        if "step" in head and head["key"] not in wanted:  # of a report whose plan has been thrown away
            line = lines.setdefault(("", str(head.get("case", "")), str(head["step"])), _step(head))
            line.damaged += head["key"] in broken
            line.done += head["key"] not in broken
    found.lines = sorted(lines.values(), key=lambda line: (line.command, line.case, line.law))
    known = [time for time in times if time is not None]
    found.left_s = sum(known) if known else None
    return found


def _step(head: Mapping[str, Any]) -> Line:
    return Line(str(head.get("case", "")), str(head["step"]))


def _left(plan: Noted, finished: list[float]) -> float | None:
    """Time left at the pace since the plan began."""
    begin = datetime.fromisoformat(plan.begun).timestamp()
    since = [time for time in finished if time >= begin]
    left = len(plan.items) - len(finished) - len(plan.failures)
    if not since or left < 0:
        return None
    return left * (datetime.now(UTC).timestamp() - begin) / len(since)


def _alive(process: int) -> bool:
    """Whether a process runs on this machine, as far as that can be told without ending it."""
    if os.name == "nt" or process < 1:
        return False
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except OSError:
        return True
    return True


@dataclass
class Litter:
    """Files that serve nobody, by kind."""

    damaged: list[Path] = field(default_factory=list)  # not what was written, or of an earlier format
    stale: list[Path] = field(default_factory=list)  # of code that has changed, or wanted by nobody; plans of these
    earlier: list[Path] = field(default_factory=list)  # wanted by earlier runs of commands alone; their plans
    temporary: list[Path] = field(default_factory=list)  # left by a process that is no more
    other_versions: list[Path] = field(default_factory=list)  # made with other libraries or another processor
    in_the_way: list[Path] = field(default_factory=list)  # folders under the name of a result; they stay

    def of(self, kinds: Iterable[str]) -> list[Path]:
        """Files of some kinds."""
        return [path for kind in kinds for path in getattr(self, kind)]


def litter(folder: Path) -> Litter:
    """Find what can be thrown away."""
    found = Litter(temporary=[path for place in {folder, folder.parent} for path in left_over(place)])
    noted = {path: plan for path in sorted(folder.glob(f"*{PLAN}")) if (plan := read_plan(path)) is not None}
    last = in_force(noted.values())
    wanted, asked = ({item.key for plan in some for item in plan.items} for some in (noted.values(), last))
    here = made_with()
    for path in sorted(path for path in folder.iterdir() if not path.name.startswith(".")):  # that is being written
        if path.is_dir() and not path.is_symlink():
            if path.name.endswith((SUFFIX, PLAN)):
                found.in_the_way.append(path)  # nobody of us made it: who knows what it holds
            continue
        if path.match(EARLIER) or (path.name.endswith(PLAN) and read_plan(path) is None):
            found.damaged.append(path)
        elif path.suffix == SUFFIX:
            try:
                record = read(path)
            except (Damaged, OSError):
                found.damaged.append(path)
                continue
            if record.about.get("made_with") != here:
                found.other_versions.append(path)
            elif changed(record) or not (record.key in wanted or "step" in record.about):
                found.stale.append(path)
            elif record.key in wanted and record.key not in asked:
                found.earlier.append(path)
    there, stale = {path.stem for path in stored(folder)}, {path.stem for path in found.stale}
    for path, plan in noted.items():
        keys = {item.key for item in plan.items} & there
        if plan.ended or not _alive(plan.process):
            if keys and keys <= stale:
                found.stale.append(path)
            elif plan not in last:
                found.earlier.append(path)
    return found


def changed(record: Record) -> bool:
    """Whether the code that made a record is not that of this installation any more."""
    code = record.about.get("code", {})
    if not isinstance(code, Mapping) or not all(MODULES.fullmatch(names) for names in code):
        return True  # of no code that there could be
    return any(text_of(*names.split()) != text for names, text in code.items())
