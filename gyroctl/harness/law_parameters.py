"""Parameters of a law for a reader: name, value without a tuning that is asked for, meaning with its unit."""

from __future__ import annotations

import inspect
import math
import re
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any, NamedTuple

from gyroctl import nested
from gyroctl.fields import fields_of
from gyroctl.harness.protocol import Law
from gyroctl.harness.registry import defaults_of, factory_of

GIVEN = ("seen", "clock", "law", nested.FIRST)
"""What the harness hands to a law."""


class Parameter(NamedTuple):
    """One of them."""

    name: str
    value: str
    about: str


def parameters_of(name: str, built: Law) -> list[Parameter]:
    """Parameters that ``gyroctl.law(name, ...)`` takes, those of groups by their own names, in their order.

    Parameters
    ----------
    name : str
        Registered name or "file.py:Name".
    built : Law
        That law.

    Raises
    ------
    InputError
        As `gyroctl.law`.
    """
    factory = factory_of(name)
    about = _told(factory)
    found = []
    for key, default in defaults_of(factory).items():
        value = getattr(built, key, default)
        if hasattr(default, "_fields"):
            found += [Parameter(*entry) for entry in _within(value)]
        elif key not in GIVEN:
            found.append(Parameter(key, _short(value), about.get(key, "")))
    return found


def _within(group: Any) -> Iterator[tuple[str, str, str]]:
    """Fields of a group of settings, and of the groups within it."""
    about = {field.name: field.about for field in fields_of(type(group))}
    for key, value in group._asdict().items():
        if hasattr(value, "_fields"):
            yield from _within(value)
        else:
            yield key, _short(value), about.get(key, "")


def _told(factory: Callable[..., Any]) -> Mapping[str, str]:
    """What is said of each parameter: beside the fields of a class, in the docstring of a function."""
    if inspect.isclass(factory):
        return {field.name: field.about for field in fields_of(factory)}
    text = inspect.getdoc(factory.func if isinstance(factory, partial) else factory) or ""
    section = re.search(r"^Parameters\n-+\n(.*?)(?=^\w[^\n]*\n-+$|\Z)", text, re.DOTALL | re.MULTILINE)
    found: dict[str, str] = {}
    for names, about in re.findall(r"^(\S[^:\n]*) :.*\n((?:[ \t]+\S.*\n?)+)", section[1] if section else "", re.M):
        found |= dict.fromkeys(re.split(r",\s*", names), " ".join(about.split()))
    return found


def _short(value: Any) -> str:
    if value is None or value is inspect.Parameter.empty:
        return ""
    if isinstance(value, bool | str):
        return str(value)
    if isinstance(value, int | float):
        return f"{value:.4g}" if math.isfinite(value) else "none"
    if isinstance(value, tuple):
        return f"{len(value)} numbers"
    return str(getattr(value, "name", type(value).__name__))
