"""Stored results of finished work items, one file each, written whole or not at all."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gyroctl.writing import written_whole

MOST = 1 << 29
"""Most bytes of a stored result. A damaged one may tell any size."""

Stored = tuple[str, dict[str, float], dict[str, NDArray[np.float64]]]


def save(
    folder: Path | None, key: str, sha256: str, values: dict[str, float], series: dict[str, NDArray[np.float64]]
) -> None:
    """Store a result under its key; without a folder or a key there is nothing to do."""
    if folder is None or not key:
        return
    with written_whole(folder / f"{key}.npz") as part:
        np.savez(part, head=np.array(json.dumps({"sha256": sha256, "values": values})), **series)  # type: ignore[arg-type]


def load(folder: Path | None, key: str) -> Stored | None:
    """Return a stored result, or None where there is none that can be read."""
    if folder is None or not key or not (folder / f"{key}.npz").is_file():
        return None
    try:
        with zipfile.ZipFile(folder / f"{key}.npz") as packed:
            if sum(part.file_size for part in packed.infolist()) > MOST:
                return None
        with np.load(folder / f"{key}.npz") as file:
            head = json.loads(str(file["head"]))
            sha256, values = head["sha256"], head["values"]
            series = {name: file[name] for name in file.files if name != "head"}
    except Exception:  # whatever a damaged archive makes of its readers: it is computed again and replaced
        return None
    sound = (
        isinstance(sha256, str) and isinstance(values, dict) and all(s.dtype.kind in "fiub" for s in series.values())
    )
    return (sha256, values, series) if sound and all(isinstance(v, float) for v in values.values()) else None
