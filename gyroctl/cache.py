"""The one folder in which this package keeps what it has worked out once for a user: compiled text, constant pairs."""

from __future__ import annotations

import atexit
import os
import tempfile
from functools import lru_cache
from pathlib import Path

import platformdirs


def cache_folder() -> Path:
    """Return $GYROCTL_CACHE/gyroctl, or that of the user's cache folder, or else a temporary one."""
    wanted = os.environ.get("GYROCTL_CACHE") or platformdirs.user_cache_dir()
    try:
        place = Path(wanted) / "gyroctl"
        place.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=place).close()
    except OSError:
        return _aside()
    return place


@lru_cache(maxsize=1)
def _aside() -> Path:
    """Folder of this process alone, where the user's cache cannot be written to."""
    place = tempfile.TemporaryDirectory(prefix="gyroctl-")
    atexit.register(place.cleanup)
    return Path(place.name)
