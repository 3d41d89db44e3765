"""What a tuning has run, one line of JSON per step, so that a tuning that was stopped is gone through again from it.

A line is written and synced when its step has ended, and carries the checksum of the step. A line that was cut short by
a kill, damaged or edited is not believed: it is dropped, and its step run again.
"""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import Any

from gyroctl.engine.store import aloud
from gyroctl.errors import InputError
from gyroctl.reading import TEXT_MAX, existing, parse_json
from gyroctl.writing import write_text

MEND = "Take the file away, and its steps are run again; or give another folder"


class TuningLog:
    """Steps that have been run, by key, in a file that only grows.

    Parameters
    ----------
    path : Path or None
        The file; made with its folder when the first step is added. None keeps the steps in memory only.

    Raises
    ------
    InputError
        For a file that cannot be read.
    """

    def __init__(self, path: Path | None) -> None:
        self.path = path
        self.steps: dict[str, Any] = {}
        if path is None or not path.exists():
            return
        lines, good = _lines(path), list[str]()
        for line in lines:
            step = _step(line)
            if step is not None:
                self.steps[step[0]] = step[1]
                good.append(line)
        if lines != [*good, ""]:
            dropped = len([line for line in lines if line]) - len(good)
            aloud(f"{path}: {dropped} lines are not what was written: not believed, their steps are run again")
            write_text(path, "".join(f"{line}\n" for line in good))

    def get(self, key: str) -> Any:
        """Value of a step, or None where it has not been run."""
        return self.steps.get(key)

    def add(self, key: str, value: Any) -> None:
        """Keep the value of a step. Floats come back from the file to the last bit."""
        self.steps[key] = value
        if self.path is None:
            return
        self.path.parent.mkdir(parents=True, exist_ok=True)
        with self.path.open("a", encoding="utf-8") as file:
            file.write(json.dumps({"key": key, "value": value, "sha256": _digest(key, value)}) + "\n")
            file.flush()
            os.fsync(file.fileno())


def _lines(path: Path) -> list[str]:
    """Lines of a log; bytes that are no text stand in none that was written."""
    try:
        with existing("out", path, MEND).open("rb") as file:
            content = file.read(TEXT_MAX + 1)
    except OSError as error:
        raise InputError("out", str(path), f"cannot be read: {error}", MEND) from None
    if len(content) > TEXT_MAX:
        raise InputError("out", str(path), f"is larger than {TEXT_MAX >> 20} MB", MEND)
    return content.decode("utf-8", "replace").split("\n")


def _step(line: str) -> tuple[str, Any] | None:
    """Step of a line, None where it is not what was written."""
    try:
        step = parse_json("out", "a line", line, MEND, finite=False)
        key, value = step["key"], step["value"]
        return (key, value) if isinstance(key, str) and step["sha256"] == _digest(key, value) else None
    except (InputError, KeyError, TypeError):
        return None


def _digest(key: str, value: Any) -> str:
    return hashlib.sha256(json.dumps([key, value]).encode()).hexdigest()
