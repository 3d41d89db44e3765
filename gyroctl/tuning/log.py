"""What a tuning has run, one line of JSON per step, so that a tuning that was stopped is gone through again from it.

A line is written when its step has ended. A line that was cut short by a kill is dropped and its step run again.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from gyroctl.errors import InputError
from gyroctl.reading import parse_json, read_text
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
        For a file that cannot be read, or a line of which nobody knows what it was.
    """

    def __init__(self, path: Path | None) -> None:
        self.path = path
        self.steps: dict[str, Any] = {}
        if path is None or not path.exists():
            return
        text = read_text("out", path, MEND)
        whole = text[: text.rfind("\n") + 1]
        for number, line in enumerate(whole.split("\n")[:-1], 1):
            name = f"{path}, line {number}"
            step = parse_json("out", name, line, MEND)
            if not isinstance(step, dict) or set(step) != {"key", "value"} or not isinstance(step["key"], str):
                raise InputError("out", name, "is no step of a tuning", MEND)
            self.steps[step["key"]] = step["value"]
        if whole != text:
            write_text(path, whole)

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
            file.write(json.dumps({"key": key, "value": value}) + "\n")
