"""The shipped tuning of the laws of this folder, as tune.py wrote it."""

from __future__ import annotations

import json
from functools import lru_cache
from pathlib import Path
from typing import Any

FILE = Path(__file__).with_name("tuning.json")


@lru_cache(maxsize=1)
def shipped() -> dict[str, Any]:
    """Content of tuning.json: for each law its parameters, budget and result on the tuning seeds."""
    content: dict[str, Any] = json.loads(FILE.read_text())
    return content


def tuning_seeds() -> list[int]:
    """Seeds that served for tuning and so may not judge the laws."""
    seeds = shipped()["tuning_seeds"]
    return list(range(seeds["first"], seeds["last"] + 1))
