"""Tables as read from TOML: a file that is none, an unknown entry, what is no number are refused by their names."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from gyroctl.errors import InputError
from gyroctl.names import choice_of
from gyroctl.reading import is_finite, read_toml


def read_tables(path: Path, field: str) -> dict[str, Any]:
    """Read a TOML file; an error names `field`."""
    return read_toml(field, path)


def table_of(tables: Mapping[str, Any], name: str) -> dict[str, Any]:
    """Return a table by its name, empty where it is left out."""
    return checked_table(name, tables.get(name, {}))


def checked_table(path: str, value: Any) -> dict[str, Any]:
    """Return what stands at `path`, which must be a table."""
    if not isinstance(value, Mapping):
        raise InputError(path, value, "must be a table", f"Write [{path}] and its entries below")
    return dict(value)


def check_known(path: str, entries: Mapping[str, Any], names: Collection[str]) -> None:
    """Refuse entries of the table `path` ("" for the whole file) that are not among `names`."""
    for key, value in entries.items():
        if key not in names:
            problem = "unknown table" if isinstance(value, Mapping) else "unknown key"
            raise InputError(f"{path}.{key}" if path else key, value, problem, choice_of(key, names))


def number(path: str, value: Any) -> float:
    """Return a number that stands at `path`."""
    if not is_finite(value):
        raise InputError(path, value, "must be a finite number", "Write it without quotes")
    return float(value)


def names_of(kind: Any) -> list[str]:
    """Names of the fields of a dataclass: the keys of a table that is one."""
    return [field.name for field in fields(kind)]
