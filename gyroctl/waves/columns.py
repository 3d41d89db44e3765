"""Two columns of numbers from a user's text file: a spectrum or an elevation record."""

from __future__ import annotations

import hashlib
import os
import re
from os import PathLike

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.reading import read_text, real

FIELD = "sea.file"
FILE_MAX = 32 << 20
"""Largest file: a day at ten samples a second. [bytes]"""

_SEPARATOR = re.compile(r"\s*[,;\t]\s*|\s+")


def read_columns(path: str | PathLike[str], columns: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Read two columns of numbers.

    Separators are comma, semicolon, tab or blanks; lines starting with ``#`` and empty lines are skipped; one header
    line is allowed; further columns are refused, because picking two of them would be a guess.

    Parameters
    ----------
    path : str or path
        Text file in UTF-8.
    columns : str
        What the two columns are, for the messages, e.g. ``"time [s], elevation [m]"``.

    Returns
    -------
    tuple of ndarray, shape (n,) each
        The columns, n >= 2.

    Raises
    ------
    InputError
        Field ``sea.file``: missing or unreadable file, a line that is not two finite numbers, fewer than two lines.
    """
    mend = f"Give a text file with two columns of numbers: {columns}"
    rows: list[tuple[float, float]] = []
    header_allowed = True
    for number, line in enumerate(read_text(FIELD, os.fspath(path), mend, FILE_MAX).split("\n"), start=1):
        text = line.strip()
        if not text or text.startswith("#"):
            continue
        row = _row(text)
        if row is None and not header_allowed:
            raise InputError(FIELD, str(path), f"line {number} is not two finite numbers: {text[:60]!r}", mend)
        if row is not None:
            rows.append(row)
        header_allowed = False
    if len(rows) < 2:
        raise InputError(FIELD, str(path), f"has {len(rows)} lines of numbers, at least 2 are needed", mend)
    table = np.array(rows, dtype=np.float64)
    return table[:, 0].copy(), table[:, 1].copy()


def digest(*arrays: NDArray[np.float64]) -> str:
    """SHA-256 of the numbers themselves, the same on every machine."""
    content = hashlib.sha256()
    for array in arrays:
        content.update(str(array.shape).encode())
        content.update(np.ascontiguousarray(array, dtype="<f8").tobytes())
    return content.hexdigest()


def _row(text: str) -> tuple[float, float] | None:
    parts = _SEPARATOR.split(text)
    if len(parts) != 2:
        return None
    try:
        first, second = real(parts[0]), real(parts[1])
    except ValueError:
        return None
    return (first, second) if np.isfinite(first) and np.isfinite(second) else None
