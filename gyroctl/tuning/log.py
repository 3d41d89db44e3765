"""What a tuning has run, one line of JSON per step, so that a tuning that was stopped is gone through again from it.

A line is written and synced when its step has ended, and carries the checksum of the step. A line that was cut short by
a kill, damaged or edited is not believed, and its step run again. It begins with an end of line of its own: of two
processes that write to one file, what the one leaves torn costs the other nothing.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

from gyroctl.disk import DISK, Disk
from gyroctl.engine.store import aloud, made_by
from gyroctl.errors import InputError, in_words
from gyroctl.reading import TEXT_MAX, parse_json
from gyroctl.writing import make_folders, settle

MEND = "Take the file away, and its steps are run again; or give another folder"


class TuningLog:
    """Steps that have been run, by key, in a file that only grows.

    Parameters
    ----------
    path : Path or None
        The file; made with its folder when the first step is added. None keeps the steps in memory only.
    disk : Disk
        The file system.

    Raises
    ------
    InputError
        For a file that cannot be read.
    """

    def __init__(self, path: Path | None, disk: Disk = DISK) -> None:
        self.path, self.disk = path, disk
        self.steps: dict[str, Any] = {}
        self.made: dict[str, dict[str, Any]] = {}  # what made a step, as it is noted beside it
        self._settled = False  # whether the file's name is on the disk
        if path is None or not disk.has(path):
            return
        lines = [line for line in _lines(path, disk) if line]
        steps = [step for line in lines if (step := _step(line)) is not None]
        for key, value, made in steps:
            self.steps[key], self.made[key] = value, made
        if dropped := len(lines) - len(steps):  # they stay: another process may write to the file
            aloud(f"{path}: {dropped} lines are not what was written: not believed, their steps are run again")

    def get(self, key: str) -> Any:
        """Value of a step, or None where it has not been run."""
        return self.steps.get(key)

    def add(self, key: str, value: Any) -> None:
        """Keep the value of a step. Floats come back from the file to the last bit.

        Raises
        ------
        OSError
            Where it cannot be written; what was kept before is whole.
        """
        if self.path is not None:
            line = json.dumps({"key": key, "value": value, "sha256": _digest(key, value), "made": made_by()})
            make_folders(self.path.parent, self.disk)
            self.disk.append(self.path, f"\n{line}\n".encode())  # what stands before it may be torn
            if not self._settled:
                self.disk.sync_folder(self.path.parent)
                settle(self.path.parent, self.disk)
                self._settled = True
        self.steps[key] = value


def _lines(path: Path, disk: Disk) -> list[str]:
    """Lines of a log; bytes that are no text stand in none that was written."""
    try:
        if disk.size(path) > TEXT_MAX:
            raise InputError("out", str(path), f"is larger than {TEXT_MAX >> 20} MB", MEND)
        content = disk.read(path)
    except OSError as error:
        raise InputError("out", str(path), f"cannot be read: {in_words(error)}", MEND) from None
    return content.decode("utf-8", "replace").split("\n")


def _step(line: str) -> tuple[str, Any, dict[str, Any]] | None:
    """Key, value and maker of a step, None where the line is not what was written; its checksum is of key and value."""
    try:
        step = parse_json("out", "a line", line, MEND, finite=False)
        key, value, made = step["key"], step["value"], step.get("made")
        if not isinstance(key, str) or step["sha256"] != _digest(key, value):
            return None
        return key, value, made if isinstance(made, dict) else {}
    except (AttributeError, InputError, KeyError, TypeError):
        return None


def _digest(key: str, value: Any) -> str:
    return hashlib.sha256(json.dumps([key, value]).encode()).hexdigest()
