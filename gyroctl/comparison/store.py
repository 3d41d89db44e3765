"""Stored results of finished work items, one file each, written whole or not at all."""

from __future__ import annotations

import json
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gyroctl.writing import written_whole

Stored = tuple[str, dict[str, float], dict[str, NDArray[np.float64]]]


def save(
    folder: Path | None, key: str, sha256: str, values: Mapping[str, float], series: dict[str, NDArray[np.float64]]
) -> None:
    """Store a result under its key; without a folder or a key there is nothing to do."""
    if folder is None or not key:
        return
    with written_whole(folder / f"{key}.npz") as part:
        np.savez(part, head=np.array(json.dumps({"sha256": sha256, "values": dict(values)})), **series)  # type: ignore[arg-type]


def load(folder: Path | None, key: str) -> Stored | None:
    """Return a stored result, or None where there is none that can be read."""
    if folder is None or not key or not (folder / f"{key}.npz").is_file():
        return None
    try:
        with np.load(folder / f"{key}.npz") as file:
            head = json.loads(str(file["head"]))
            return head["sha256"], head["values"], {name: file[name] for name in file.files if name != "head"}
    except (OSError, EOFError, ValueError, KeyError, zipfile.BadZipFile, zlib.error):
        return None  # computed again and replaced
