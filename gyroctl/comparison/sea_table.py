"""The table [sea] of an experiment: kinds of sea and what builds them."""

from __future__ import annotations

import datetime
import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Any

from gyroctl.errors import NOT_GIVEN, InputError
from gyroctl.froude import growth
from gyroctl.tables import check_known, number
from gyroctl.waves import (
    Bichromatic,
    DriftingSea,
    Regular,
    Sea,
    SeaState,
    SpreadSea,
    TurningSea,
    TwoPeaks,
    read_record,
    read_spectrum,
)
from gyroctl.waves.peak_periods import in_frequencies, with_periods

SEAS: dict[str, Callable[..., Sea]] = {
    "jonswap": SeaState,
    "regular": Regular,
    "bichromatic": Bichromatic,
    "drifting": DriftingSea,
    "turning": TurningSea,
    "two peaks": TwoPeaks,
    "spectrum": read_spectrum,
    "record": read_record,
}
"""Kinds of sea: the value of `sea.kind` and what builds it from the other entries of the table."""

SPREADABLE, SPREAD = ("jonswap", "two peaks", "spectrum"), ("spreading", "width")
"""Kinds that can be spread over directions, and the entries that do it."""

WIDTH = "Give width = the exponent s of cos2s, or the standard deviation of normal in degrees"


def build_sea(table: dict[str, Any], folder: Path, length: float = 1.0) -> Sea:
    """Build a sea from its table; a file is relative to `folder`, the usual sea is that of a device of this length.

    Raises
    ------
    InputError
        For an unknown kind or entry, a missing one, and what the sea itself refuses.
    """
    table = dict(table)
    kind = table.pop("kind", "spectrum" if "format" in table else "jonswap")
    if not isinstance(kind, str) or kind not in SEAS:
        raise InputError("sea.kind", kind, "unknown kind of sea", f"Choose one of {', '.join(SEAS)}")
    spread = {name: table.pop(name) for name in SPREAD if name in table} if kind in SPREADABLE else {}
    sea = _of_file(kind, table, folder) if kind in ("spectrum", "record") else _of_numbers(kind, table, length)
    return _spread(sea, **spread) if spread else sea


def _spread(sea: Any, spreading: Any = None, width: Any = None) -> Sea:
    for name, value, mend in (("spreading", spreading, 'Give spreading = "cos2s"'), ("width", width, WIDTH)):
        if value is None:
            raise InputError(f"sea.{name}", NOT_GIVEN, "a sea with spreading needs it", mend)
    return SpreadSea(sea, spreading, number("sea.width", width))


def _of_numbers(kind: str, table: dict[str, Any], length: float) -> Sea:
    parameters = inspect.signature(SEAS[kind]).parameters
    check_known("sea", table, with_periods(parameters))
    table = in_frequencies("sea", table)
    if length != 1.0 and SEAS[kind] is SeaState:
        table = {"hs": SeaState.hs * length, "wp": SeaState.wp * growth("rad/s", length), **table}
    for name, value in table.items():
        several = isinstance(value, list)
        table[name] = tuple(number(f"sea.{name}", v) for v in value) if several else number(f"sea.{name}", value)
    for name, parameter in parameters.items():
        if parameter.default is parameter.empty and name not in table:
            raise InputError(f"sea.{name}", NOT_GIVEN, f"a sea of kind {kind!r} needs it", f"Give {name}")
    return SEAS[kind](**table)


def _of_file(kind: str, table: dict[str, Any], folder: Path) -> Sea:
    if "file" not in table:
        raise InputError("sea.file", NOT_GIVEN, f"a sea of kind {kind!r} needs a file", "Give the path of a CSV file")
    path, read = folder / str(table.pop("file")), SEAS[kind]
    parameters = inspect.signature(read).parameters
    check_known("sea", table, ["file", *list(parameters)[1:]])
    for name, value in table.items():
        if isinstance(value, datetime.datetime):
            table[name] = value.isoformat()
        elif "bool" in str(parameters[name].annotation):
            if not isinstance(value, bool):
                raise InputError(f"sea.{name}", value, "must be true or false", "Write it without quotes")
        elif "str" in str(parameters[name].annotation):
            if not isinstance(value, str):
                raise InputError(f"sea.{name}", value, "must be a text", "Write it in quotes")
        else:
            table[name] = number(f"sea.{name}", value)
    return read(path, **table)
