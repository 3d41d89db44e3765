"""Headings of a file in degrees, once around at most."""

from __future__ import annotations

import numpy as np

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.table import Floats

MEND = "Say what they are: --headings deg or rad"


def degrees(values: Floats, given: str | None, told: str | None, usual: str | None, name: str) -> Floats:
    """Return headings in degrees.

    Parameters
    ----------
    values : ndarray (n,)
        As the file has them.
    given, told : {"deg", "rad"} or None
        Unit by the option, and by the file.
    usual : {"deg", "rad"} or None
        Unit of the format, where numbers do not speak against it.
    name : str
        The file, for errors.

    Raises
    ------
    InputError
        Where they can be read in two ways, or go beyond a turn.
    """
    values = np.asarray(values, dtype=np.float64)
    if not np.all(np.isfinite(values)):
        raise InputError(f"{name}: headings", "nan", "must be finite numbers", "Give headings in degrees")
    largest = float(np.max(np.abs(values), initial=0.0))
    if given is not None and told is not None and given != told:
        raise InputError("hydro.headings", given, f"differs from {told}, which {name} tells", "Leave the option out")
    unit = given or told
    turn = 2.0 * np.pi + 1e-4
    if unit is None:
        whole = bool(np.all(values == np.round(values)))
        if usual == "rad" and largest > turn:
            raise InputError(f"{name}: headings", largest, "lies beyond 2 pi rad: degrees, perhaps", MEND)
        if usual != "rad" and 0.0 < largest <= turn and not whole:
            raise InputError(f"{name}: headings", largest, "could be radians or degrees", MEND)
        unit = usual or "deg"
    if unit == "rad" and largest > turn:
        raise InputError(f"{name}: headings", largest, "lies beyond 2 pi rad", MEND)
    found = np.asarray(np.round(np.rad2deg(values), 9) if unit == "rad" else values, dtype=np.float64)
    if largest > 720.0:
        raise InputError(f"{name}: headings", largest, "must lie within a turn or two", "Give degrees")
    if np.ptp(found) > 360.0 + 1e-6 or np.max(np.abs(found), initial=0.0) > 360.0 + 1e-6:
        found = np.asarray(found % 360.0, dtype=np.float64)
    return found


def repeated(headings: Floats) -> list[tuple[int, int]]:
    """Return pairs (kept, repeated) of positions of headings that are the same direction, (n,) [deg]."""
    first: dict[int, int] = {}
    pairs = []
    for k, micro in enumerate(np.round(np.asarray(headings) * 1e6).astype(np.int64) % 360_000_000):
        kept = first.setdefault(int(micro), k)
        if kept != k:
            pairs.append((kept, k))
    return pairs
