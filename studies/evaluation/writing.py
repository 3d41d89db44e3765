"""Tables as markdown and as JSON."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gyroctl.reports.statistics import Estimate
from gyroctl.reports.wording import interval, number


def markdown_table(headings: Sequence[str], lines: Sequence[Sequence[str]], text: int = 1) -> str:
    """Write a table; the first `text` columns and the last one are aligned to the left."""
    marks = ["---" if i < text or i == len(headings) - 1 else "---:" for i in range(len(headings))]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in (headings, marks, *lines))


def with_interval(estimate: Estimate, digits: int = 3) -> str:
    """Write a number with its interval in brackets."""
    bounds = interval(estimate, digits)
    return f"{number(estimate.value, digits)} ({bounds})" if bounds else number(estimate.value, digits)


def plain(value: Any) -> Any:
    """For JSON: records become tables, what is not finite becomes null."""
    if is_dataclass(value) and not isinstance(value, type):
        return plain(asdict(value))
    if isinstance(value, tuple) and hasattr(value, "_asdict"):
        return plain(value._asdict())
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [plain(entry) for entry in value]
    if isinstance(value, bool | np.bool_):
        return bool(value)
    if isinstance(value, int | np.integer):
        return int(value)
    if isinstance(value, float | np.floating):
        return float(value) if math.isfinite(value) else None
    return value


def write_text(path: Path, text: str) -> None:
    """Write a file whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(path.suffix + ".part")
    part.write_text(text, encoding="utf-8")
    os.replace(part, path)


def write_json(path: Path, content: Any) -> None:
    """Write a JSON file whole or not at all."""
    write_text(path, json.dumps(plain(content), indent=1, allow_nan=False, ensure_ascii=False) + "\n")
