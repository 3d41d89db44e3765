"""The tuned sets of the laws of this folder, as `gyroctl tune --ship` wrote them into ``tuned/``."""

from __future__ import annotations

import json
from functools import lru_cache
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).with_name("tuned")


@lru_cache(maxsize=32)
def shipped(law: str) -> dict[str, Any]:
    """Tuned sets of a law by name, each with ``parameters``, ``goal``, ``result`` and ``found``.

    Parameters
    ----------
    law : str
        Name of the law.

    Returns
    -------
    dict
        By the names of the sets; empty where none ships.
    """
    sets: dict[str, Any] = json.loads((FOLDER / f"{law}.json").read_text(encoding="utf-8"))["sets"]
    return sets
