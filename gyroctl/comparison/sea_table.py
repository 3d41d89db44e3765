"""The table [sea] of an experiment: kinds of sea and what builds them."""

from __future__ import annotations

import datetime
import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Any

from gyroctl.errors import InputError
from gyroctl.tables import check_known, number
from gyroctl.waves import (
    Bichromatic,
    DriftingSea,
    Regular,
    Sea,
    SeaState,
    TurningSea,
    TwoPeaks,
    read_record,
    read_spectrum,
)

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


def build_sea(table: dict[str, Any], folder: Path) -> Sea:
    """Build a sea from its table; a file is relative to `folder`.

    Raises
    ------
    InputError
        For an unknown kind or entry, a missing one, and what the sea itself refuses.
    """
    table = dict(table)
    kind = table.pop("kind", "jonswap")
    if not isinstance(kind, str) or kind not in SEAS:
        raise InputError("sea.kind", kind, "unknown kind of sea", f"Choose one of {', '.join(SEAS)}")
    if kind in ("spectrum", "record"):
        return _of_file(kind, SEAS[kind], table, folder)
    parameters = inspect.signature(SEAS[kind]).parameters
    check_known("sea", table, parameters)
    for name, value in table.items():
        several = isinstance(value, list)
        table[name] = tuple(number(f"sea.{name}", v) for v in value) if several else number(f"sea.{name}", value)
    for name, parameter in parameters.items():
        if parameter.default is parameter.empty and name not in table:
            raise InputError(f"sea.{name}", None, f"a sea of kind {kind!r} needs it", f"Give {name}")
    return SEAS[kind](**table)


def _of_file(kind: str, read: Callable[..., Sea], table: dict[str, Any], folder: Path) -> Sea:
    if "file" not in table:
        raise InputError("sea.file", None, f"a sea of kind {kind!r} needs a file", "Give the path of a CSV file")
    path = folder / str(table.pop("file"))
    parameters = inspect.signature(read).parameters
    check_known("sea", table, ["file", *list(parameters)[1:]])
    for name, value in table.items():
        if isinstance(value, datetime.datetime):
            table[name] = value.isoformat()
        elif "str" in str(parameters[name].annotation):
            if not isinstance(value, str):
                raise InputError(f"sea.{name}", value, "must be a text", "Write it in quotes")
        else:
            table[name] = number(f"sea.{name}", value)
    return read(path, **table)
