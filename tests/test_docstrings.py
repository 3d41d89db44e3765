"""Every public name is documented: arguments, units, results, errors, and what was written is true of the code.

A test in the way of python-control's: it walks the names, reads the sections of their docstrings, and holds them to the
signatures and to the code. Each rule is shown to fail on a function made up for it.
"""

from __future__ import annotations

import ast
import builtins
import importlib
import inspect
import re
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import pytest
from documented import docstring, missing_section, parameters, section
from numpy.typing import NDArray
from public_names import FLOW, ROOMS, Name, all_names, groups, home_of, names_of, rooms
from raised import raised

import gyroctl as gy

NAMES = {name.path: name for name in all_names()}
CALLED = {path: name.thing for path, name in NAMES.items() if not name.constant}
OWN_ERRORS = {"InputError", "LawError"}

NUMBER = re.compile(r"\b(?:float|floats|array|arrays|ndarray|NDArray|array_like|scalar|complex)\b", re.IGNORECASE)
NO_NUMBER = re.compile(r"^\{|\bbool|\bDataset\b|\bDataArray\b")
"""Choices between words, flags, and labelled results, whose variables carry their units themselves."""

UNIT = re.compile(r"\[[^\]]+\]|\bunits?\b")


def arguments(thing: Any) -> list[str]:
    """Names of what a call takes; a protocol is not called."""
    if getattr(thing, "_is_protocol", False):
        return []
    return [name for name in inspect.signature(thing).parameters if name not in ("self", "cls")]


def undocumented(thing: Any) -> list[str]:
    """Arguments that no section and no comment explains."""
    known = {entry.name for entry in parameters(thing)}
    return [name for name in arguments(thing) if name not in known]


def invented(thing: Any) -> list[str]:
    """Arguments of the section "Parameters" that the call does not take."""
    taken = set(arguments(thing))
    if isinstance(thing, partial):
        taken |= set(inspect.signature(thing.func).parameters)
    return [entry.name for entry in section(thing, "Parameters") if entry.name not in taken and taken]


def without_unit(thing: Any) -> list[str]:
    """Numbers among arguments, fields and results that do not say their unit."""
    entries = [*parameters(thing), *section(thing, "Returns"), *section(thing, "Yields")]
    told = [(entry, entry.type or entry.name) for entry in entries]
    numbers = [entry for entry, kind in told if NUMBER.search(kind) and not NO_NUMBER.search(kind)]
    return [entry.name for entry in numbers if not UNIT.search(entry.about)]


def untold_errors(thing: Any) -> list[str]:
    """Errors that the code raises and the docstring does not name: its own, and the package's from further down."""
    told = {entry.name for entry in section(thing, "Raises")}
    return sorted(((raised(thing) & OWN_ERRORS) | raised(thing, 0)) - told)


def unknown_errors(thing: Any) -> list[str]:
    """Errors that the docstring names and that are none."""
    told = [entry.name for entry in section(thing, "Raises")]
    return [name for name in told if not _is_error(getattr(builtins, name, None) or getattr(gy, name, None))]


def _is_error(kind: Any) -> bool:
    return inspect.isclass(kind) and issubclass(kind, Exception)


def told_constants(module: str) -> set[str]:
    """Names of a module with a text below their value, or with comments that begin with #: above it."""
    source = inspect.getsource(importlib.import_module(module))
    rows, body = source.splitlines(), ast.parse(source).body
    found = set()
    for node, after in zip(body, [*body[1:], None], strict=True):
        if isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            below = isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant)
            if below or rows[node.lineno - 2].startswith("#:"):
                found |= {name.id for name in ast.walk(ast.Tuple(targets)) if isinstance(name, ast.Name)}
    return found


def without_result(thing: Any) -> bool:
    """Whether a function gives something and says neither in its first line nor in a section what."""
    if inspect.isclass(thing) or docstring(thing)["Returns"] or docstring(thing)["Yields"]:
        return False
    function = thing.func if isinstance(thing, partial) else inspect.unwrap(getattr(thing, "py_func", thing))
    given = inspect.signature(function).return_annotation
    return given not in (None, "None") and not (inspect.getdoc(thing) or "").strip()


# --- the names ---------------------------------------------------------------------------------------------------


def test_names_are_all_there_is() -> None:
    assert {path.removeprefix("gyroctl.") for path in NAMES if path.count(".") == 1} == set(gy.__all__)
    assert set(rooms()) == set(ROOMS), "a new room: put it where it stands in the flow"
    assert set().union(*FLOW.values()) == set(gy.__all__), "a new name: put it where it stands in the flow"
    assert [title for title in groups() if title not in FLOW] == []
    assert len(CALLED) > 190


def test_homes_are_where_things_are_written() -> None:
    assert home_of("gyroctl", "SeaState") == "gyroctl.waves.spectrum"
    assert home_of("gyroctl.waves", "OMEGA_MAX") == "gyroctl.waves.grid"
    for room in ("", *rooms()):
        for name in names_of(room):
            module = getattr(name.thing, "__module__", None)
            if inspect.isclass(name.thing) or inspect.isfunction(name.thing):
                assert name.home == module, name.path


@pytest.mark.parametrize("path", sorted(CALLED))
def test_public_name_is_documented(path: str) -> None:
    thing = CALLED[path]
    text = inspect.getdoc(thing.func if isinstance(thing, partial) else thing) or ""
    assert text and text.splitlines()[0].rstrip().endswith((".", "]")), "a first line that is a sentence"
    assert undocumented(thing) == [], "arguments"
    assert invented(thing) == [], "arguments that there are not"
    assert without_unit(thing) == [], "units"
    assert untold_errors(thing) == [], "errors"
    assert unknown_errors(thing) == [], "errors that there are not"
    assert not without_result(thing), "result"


@pytest.mark.parametrize("path", sorted(path for path, name in NAMES.items() if name.constant))
def test_constant_is_documented_where_it_is_written(path: str) -> None:
    name: Name = NAMES[path]
    assert name.name in told_constants(name.home), f"{name.home}.{name.name}: a text below it, or #: above"


@pytest.mark.parametrize("path", sorted(path for path, thing in CALLED.items() if inspect.isclass(thing)))
def test_public_methods_say_what_they_do(path: str) -> None:
    for method, function in inspect.getmembers(CALLED[path], inspect.isfunction):
        own = str(function.__module__).startswith("gyroctl") and not method.startswith("_")
        if own and function.__name__ == method and function.__qualname__.partition(".")[0] == CALLED[path].__name__:
            assert inspect.getdoc(function), method
            assert invented(function) == [] or arguments(function) == [], method
            assert unknown_errors(function) == [], method


# --- the rules fail where they should ----------------------------------------------------------------------------


def planted(height: float, wp: float) -> float:
    """Make something of a wave.

    Parameters
    ----------
    height : float
        How high it is.
    colour : str
        Which colour.

    Raises
    ------
    WrongWave
        Always.
    """
    raise KeyError(height + wp)


def test_rules_see_what_is_missing_and_what_is_made_up() -> None:
    assert undocumented(planted) == ["wp"]
    assert invented(planted) == ["colour"]
    assert without_unit(planted) == ["height"]
    assert unknown_errors(planted) == ["WrongWave"]


def test_errors_are_seen_in_what_is_called() -> None:
    assert raised(gy.SeaState) == {"InputError"}, "of __post_init__, in a check further down"
    assert "InputError" in raised(gy.lock_orbit) and "InputError" not in raised(gy.WaveRealisation, 0)
    assert untold_errors(gy.lock_orbit) == []


class Beside(NamedTuple):
    """A class whose fields are explained beside them."""

    speed: float = 1.0  # of the ring [rad/s]
    # where it begins
    # [rad]
    angle: float = 0.0
    bare: float = 0.0
    rows: NDArray[np.float64] | None = None  # (n,) [Nm]


def test_comments_beside_fields_become_parameters() -> None:
    assert undocumented(Beside) == ["bare"]
    lines = missing_section(Beside)
    assert lines[:4] == ["", "Parameters", "----------", "speed : float"]
    assert "    of the ring [rad/s]" in lines and "    where it begins [rad]" in lines
    assert missing_section(gy.SeaState) == [], "has a section of its own"
