"""Laws by name: registered ones through the entry-point group, a user's own as "file.py:Name"."""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import inspect
import os
from collections.abc import Callable, Mapping
from functools import lru_cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import ModuleType
from typing import Any, cast

from gyroctl import nested
from gyroctl.devices import zhang2017
from gyroctl.errors import InputError, check_kind
from gyroctl.harness.protocol import INFORMATION, Law, Wrapping
from gyroctl.harness.tuned_sets import read_sets, seeds_of, tuned_file
from gyroctl.plant import Plant
from gyroctl.reading import is_finite

GROUP = "gyroctl.controllers"

REAL = "real"
"""Name of the sets that were tuned in real water, and of what serves all seas there."""


def registered() -> dict[str, EntryPoint]:
    """Entry points of all registered laws by name, sorted."""
    return dict(_registered())


@lru_cache(maxsize=1)
def _registered() -> tuple[tuple[str, EntryPoint], ...]:
    """Look once: the metadata of every installed package is read for it."""
    return tuple(sorted((point.name, point) for point in entry_points(group=GROUP)))


def home(name: str) -> tuple[Path, str]:
    """Folder of the code of a law, beside which its task and its tuned sets are, and their name.

    Raises
    ------
    InputError
        For an unknown law or a missing file.
    """
    if ".py:" in name:
        path, _, attribute = name.rpartition(":")
        return _existing(name, path).parent, attribute
    module = importlib.import_module(_point(name).module)
    package = module if hasattr(module, "__path__") else importlib.import_module(str(module.__package__))
    return Path(str(package.__file__)).parent, name


def tuned_sets(name: str) -> dict[str, Any]:
    """Tuned sets that ship beside a law, by name; empty where there are none."""
    return read_sets(tuned_file(*home(name)))


def tuned_seeds(name: str) -> set[int]:
    """Seeds on which a law was tuned, and so may not be judged."""
    return seeds_of(tuned_sets(name))


def law(name: str, /, tuning: str | None = None, **parameters: Any) -> Law:
    """Build a law.

    Parameters
    ----------
    name : str
        A registered name, or "file.py:Name" for a law in a user's file.
    tuning : str, optional
        A set of its tuned parameters: "all", or one for a sea alone, as "gamma1", "gamma5", "gamma50"; "real" for all
        seas in real water. A law whose design model goes beyond the linear one takes "real" unless told otherwise.
    **parameters
        Parameters of the law; the defaults are its shipped tuning for all seas. The design model `plant` of a law that
        has one may be a variant, "realistic", or a table of choices as `gyroctl.zhang2017` takes them.

    Returns
    -------
    Law

    Raises
    ------
    InputError
        For an unknown name, set or parameter, a missing file, a value that is not a finite number, or an object that
        is no law.
    """
    check_kind("law", name, str, "the name of a law", 'Give a name, for example gyroctl.law("load_angle")')
    if tuning is not None:
        check_kind(f"laws.{name}.tuning", tuning, str, "the name of a set", 'Give for example tuning = "all"')
        parameters = {**_tuned_parameters(name, tuning), **parameters}
    if isinstance(parameters.get("wraps"), str | Mapping):
        parameters = {**parameters, "wraps": _wrapped(name, parameters["wraps"])}
    if isinstance(parameters.get("plant"), str | Mapping):
        parameters = {**parameters, "plant": _design(name, parameters["plant"])}
    design = parameters.get("plant")
    if tuning is None and isinstance(design, Plant) and design.coefficients.beyond is not None:
        parameters = {**tuned_sets(name).get(REAL, {}).get("parameters", {}), **parameters}
    factory = _from_file(name) if ".py:" in name else _from_name(name)
    if not callable(factory):
        raise InputError("law", name, f"is a {type(factory).__name__}, no law", "Name a class or function of the file")
    own_names = _defaults(factory)
    known = dict(own_names)
    groups = {key: default for key, default in known.items() if hasattr(default, "_fields")}
    known |= {key: value for group in groups.values() for key, value in nested.named(group).items()}
    for key, value in parameters.items():
        _check_parameter(name, key, value, known)
    grouped = {key: value for key, value in parameters.items() if key not in own_names}
    own = {key: value for key, value in parameters.items() if key not in grouped}
    own |= nested.regrouped({key: own.get(key, group) for key, group in groups.items()}, grouped)
    try:
        built = factory(**own)
    except InputError:
        raise
    except (TypeError, ValueError, ArithmeticError, AttributeError, LookupError) as error:
        raise InputError(f"laws.{name}", parameters, f"could not be built: {error}", "Check its parameters") from error
    for member in ("period", "information", "init", "step"):
        if not hasattr(built, member):
            raise InputError(
                "law", name, f"has no `{member}`", "A law has period, information, init() and step(t, y, state)"
            )
    if built.information not in INFORMATION:
        raise InputError(
            f"laws.{name}.information", built.information, "unknown level", f"Choose one of {', '.join(INFORMATION)}"
        )
    return cast(Law, built)


@lru_cache(maxsize=64)
def _defaults(factory: Callable[..., Any]) -> Mapping[str, Any]:
    """Parameters of a law with their defaults; a search builds a law thousands of times."""
    return {key: parameter.default for key, parameter in inspect.signature(factory).parameters.items()}


def describe(built: Law) -> dict[str, Any]:
    """Parameters of a law for the record, those of its groups among them, those of a law within it as ``law_...``."""
    within = built.law if isinstance(built, Wrapping) else None
    if isinstance(built, tuple):
        fields: dict[str, Any] = built._asdict()  # type: ignore[attr-defined]
    else:
        fields = {key: getattr(built, key) for key in getattr(built, "__dataclass_fields__", {})}
        fields |= {key: value.name for key, value in fields.items() if isinstance(value, Plant)}
        fields = {key: value for key, value in fields.items() if isinstance(value, int | float | str | tuple)}
    fields = {key: value for key, value in fields.items() if within is None or key not in ("law", nested.FIRST)}
    found: dict[str, Any] = {}
    for key, value in fields.items():
        found |= nested.named(value) if hasattr(value, "_fields") else {key: value}
    return found | ({f"law_{key}": value for key, value in describe(within).items()} if within is not None else {})


def _check_parameter(name: str, key: str, value: Any, known: Mapping[str, Any]) -> None:
    """Refuse a parameter that the law does not know, or a value that none of its kind can be."""
    field = f"laws.{name}.{key}"
    if key not in known:
        raise InputError(field, value, "unknown parameter", f"Choose one of: {', '.join(known) or 'none'}")
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if number and not is_finite(value):
        raise InputError(field, value, "must be a finite number", f"Give {key} as a number")
    if isinstance(known[key], float) and not number:
        raise InputError(field, value, "must be a number", f"The default is {known[key]}")
    if key in ("cc", "cg") and number and value < 0.0:
        raise InputError(field, value, "must not be negative: both controls only dissipate", f"Give {key} >= 0 in Nms")


def _wrapped(name: str, wraps: str | Mapping[str, Any]) -> Law:
    """Build the law that another one wraps: a name, or a table with `law` and its parameters."""
    table = {"law": wraps} if isinstance(wraps, str) else dict(wraps)
    inner = table.pop("law", None)
    if not isinstance(inner, str) or inner == name:
        raise InputError(
            f"laws.{name}.wraps",
            inner,
            "is no law to wrap",
            'Give its name, or a table with law = "load_angle" and its parameters',
        )
    return law(inner, **table)


def _design(name: str, plant: str | Mapping[str, Any]) -> Plant:
    """Design model of a law: a variant, or a table of choices."""
    try:
        return zhang2017(plant) if isinstance(plant, str) else zhang2017(**plant)
    except InputError as error:
        raise InputError(f"laws.{name}.{error.field}", error.value, error.problem, error.mend) from None


def _tuned_parameters(name: str, tuning: str) -> dict[str, Any]:
    sets = tuned_sets(name)
    if tuning not in sets:
        mend = f"Choose one of {', '.join(sets)}" if sets else f"Tune it: gyroctl tune {name} --ship"
        raise InputError(f"laws.{name}.tuning", tuning, "there is no such set of tuned parameters", mend)
    return dict(sets[tuning]["parameters"])


def _point(name: str) -> EntryPoint:
    points = registered()
    if name not in points:
        raise InputError("law", name, "unknown law", f'Choose one of {", ".join(points)}, or give "file.py:Name"')
    return points[name]


def _from_name(name: str) -> Callable[..., Any]:
    return cast(Callable[..., Any], _point(name).load())


def defined(file: Path) -> dict[str, Any]:
    """What a user's file defines itself, by name.

    Raises
    ------
    InputError
        For a file that is missing or cannot be imported.
    """
    module = _module(str(file), _existing(str(file), str(file)))
    return {name: value for name, value in vars(module).items() if getattr(value, "__module__", "") == module.__name__}


def _existing(name: str, path: str) -> Path:
    if not os.path.isfile(path):  # unlike a Path it takes every text for a name
        raise InputError("law", name, f"there is no file {path}", "Give the path of a Python file, as file.py:Name")
    return Path(path)


def _from_file(name: str) -> Callable[..., Any]:
    path, _, attribute = name.rpartition(":")
    module = _module(name, _existing(name, path))
    if not hasattr(module, attribute):
        raise InputError("law", name, f"{path} defines no {attribute}", "Name a class or function of the file")
    return cast(Callable[..., Any], getattr(module, attribute))


def _module(name: str, file: Path) -> ModuleType:
    """Import a user's file; again only when its text has changed, so that its laws are compiled once."""
    key = (str(file.resolve()), hashlib.sha256(file.read_bytes()).hexdigest())
    if key in _loaded:
        return _loaded[key]
    spec = importlib.util.spec_from_file_location(f"gyroctl_user_{file.stem}", file)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise InputError(
            "law",
            name,
            f"the file cannot be imported: {type(error).__name__}: {error}",
            "Run the file with Python and correct it",
        ) from error
    _loaded[key] = module
    return module


_loaded: dict[tuple[str, str], ModuleType] = {}
"""Users' files by path and text."""
