"""The one folder in which this package keeps what it has worked out once for a user: machine code, constant pairs.

What lies there is believed, and machine code is run: so it belongs to this user alone, in no place that others share,
and each file of code carries a seal by a key of this folder. Where there is no such folder nothing is kept.
"""

from __future__ import annotations

import hashlib
import hmac
import os
import re
import secrets
import stat
import sys
import tempfile
from functools import lru_cache
from pathlib import Path

import platformdirs

KEY, KEY_BYTES, SEAL_BYTES = "seal.key", 32, 32

CODE = re.compile(r".*\.(nbi|nbc)|.*_[0-9a-f]{16}\.py|" + re.escape(KEY))
"""Names of what would be run, and of the key that vouches for it."""

SAID = "GYROCTL_CACHE_SAID"
"""In the environment once it is said that nothing is kept: the processes that work for this one do not say it again."""

USER = getattr(os, "getuid", None)
"""Tells the user's number; None on Windows, which keeps the folders of users apart by lists of its own."""

OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH


def cache_folder() -> Path | None:
    """Return $GYROCTL_CACHE/gyroctl, or that of the user's cache folder; None where it cannot be kept private."""
    named = os.environ.get("GYROCTL_CACHE")
    if named:
        return private_folder(Path(named) / "gyroctl")
    return _usual(platformdirs.user_cache_dir(), bool(os.environ.get("XDG_CACHE_HOME")))


@lru_cache(maxsize=16)
def private_folder(place: Path) -> Path | None:
    """Make a folder that only this user can read and write, or see that one is so.

    Parameters
    ----------
    place : Path
        The folder. One of this user's that others could write to is closed to them, and code in it is removed.

    Returns
    -------
    Path or None
        None where the folder cannot be written to, or belongs to somebody else; that is said once on stderr.
    """
    try:
        place.mkdir(parents=True, exist_ok=True, mode=0o700)
        found, above = place.stat(), place.parent.stat().st_mode
        if USER is not None:
            if found.st_uid != USER():
                return _nothing(f"{place} belongs to another user")
            if above & stat.S_IWOTH and not above & stat.S_ISVTX:
                return _nothing(f"everybody may put another folder in the place of {place}")
            if found.st_mode & 0o077:
                place.chmod(0o700)
            if found.st_mode & OTHERS_WRITE:
                removed = _remove_code(place)
                _say(
                    f"Others could write to {place}: it is closed to them now, and {removed} files of code are removed"
                )
        tempfile.TemporaryFile(dir=place).close()
    except OSError as error:
        return _nothing(f"{place} cannot be written to ({error.strerror or error})")
    return place


@lru_cache(maxsize=16)
def _usual(base: str, named: bool) -> Path | None:
    """Take the cache folder of this system's users, unless there is no home, or the home is a place of everybody."""
    if not named:
        if not Path.home().is_dir():
            return _nothing(f"there is no home folder {Path.home()}")
        for place in (Path(base), Path(base).parent):
            if USER is not None and place.is_dir() and place.stat().st_mode & stat.S_IWOTH:
                return _nothing(f"{place} is shared with everybody")
    return private_folder(Path(base) / "gyroctl")


def sealed(folder: Path, name: str, content: bytes) -> bytes:
    """Put a seal before the content of a file of that name.

    Raises
    ------
    OSError
        Where the folder's key can be neither read nor made.
    """
    return _seal(folder, name, content) + content


def unsealed(folder: Path, name: str, content: bytes) -> bytes:
    """Return what is behind a seal.

    Raises
    ------
    ValueError
        Where the seal is that of other content, of another name or of another folder.
    OSError
        Where the folder's key can be neither read nor made.
    """
    seal, inside = content[:SEAL_BYTES], content[SEAL_BYTES:]
    if not hmac.compare_digest(seal, _seal(folder, name, inside)):
        raise ValueError(f"{name} is not as it was written")
    return inside


def _seal(folder: Path, name: str, content: bytes) -> bytes:
    return hmac.digest(_key(folder), name.encode() + b"\0" + content, hashlib.sha256)


@lru_cache(maxsize=16)
def _key(folder: Path) -> bytes:
    """Key of a folder, made by the process that needs it first."""
    path = folder / KEY
    if not path.exists():
        handle, part = tempfile.mkstemp(dir=folder)  # that only the owner can read
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(secrets.token_bytes(KEY_BYTES))
            os.link(part, path)  # not where another process was quicker
        except FileExistsError:
            pass
        finally:
            os.unlink(part)
    key = path.read_bytes()
    if len(key) != KEY_BYTES:
        path.unlink()
        raise OSError(f"{path} is no key")
    return key


def _remove_code(place: Path) -> int:
    """Remove what others may have written to be run; returns how many files."""
    files = [path for path in place.rglob("*") if CODE.fullmatch(path.name) and not path.is_dir()]
    for path in files:
        path.unlink()
    return len(files)


def _nothing(why: str) -> Path | None:
    """Say once, in this process and those that it starts, that nothing is kept; the answer is always None."""
    mend = "set GYROCTL_CACHE to a folder of your own"
    if not os.environ.get(SAID):
        os.environ[SAID] = "1"
        _say(f"Nothing is kept between runs, each compiles anew: {why}; {mend}")
    return None


def _say(words: str) -> None:
    print(words, file=sys.stderr)
