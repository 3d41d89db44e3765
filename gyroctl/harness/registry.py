"""Laws by name: registered ones through the entry-point group, a user's own as "file.py:Name"."""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import inspect
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from functools import lru_cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import ModuleType
from typing import Any, cast

from gyroctl import nested
from gyroctl.devices import zhang2017
from gyroctl.devices.identity import is_shipped
from gyroctl.errors import InputError, check_kind
from gyroctl.fingerprint.as_loaded import environment
from gyroctl.fingerprint.local import noted, sources
from gyroctl.harness.code_files import Trust, asked_for, is_file, parted
from gyroctl.harness.for_device import design_in, in_model_scale, numbers_of
from gyroctl.harness.protocol import INFORMATION, Law, Wrapping
from gyroctl.harness.tuned_sets import read_sets, seeds_of, tuned_file
from gyroctl.names import choice_of
from gyroctl.plant import Plant
from gyroctl.plant.given import check_plant
from gyroctl.reading import is_finite

GROUP = "gyroctl.controllers"

REAL = "real"
"""Name of the sets that were tuned in real water, and of what serves all seas there."""

DEFAULT_SEA = "gamma5"
"""Name of the sea of `gyroctl.SeaState()` in the names of sets."""


PLAIN = (int, float, list, Mapping)
"""What a file can hold besides text."""


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
    if is_file(name):
        path, attribute = parted(name)
        return _existing(name, path).parent, attribute
    module = importlib.import_module(_point(name).module)
    package = module if hasattr(module, "__path__") else importlib.import_module(str(module.__package__))
    return Path(str(package.__file__)).parent, name


def tuned_sets(name: str, allow_code: Sequence[str | Path] = ()) -> dict[str, Any]:
    """Tuned sets that ship beside a law, by name; empty where there are none.

    Raises
    ------
    InputError
        For a file that cannot be read, or a set that names code outside the law's folder which was not asked for.
    """
    folder, stem = home(name)
    sets, trust = read_sets(tuned_file(folder, stem)), Trust(folder, asked_for(allow_code))
    named = {key: trust.names(f"tuned.{key}.parameters", entry.get("parameters", {})) for key, entry in sets.items()}
    return {key: {**entry, "parameters": named[key]} for key, entry in sets.items()}


def tuned_seeds(name: str) -> set[int]:
    """Seeds on which a law was tuned, and so may not be judged."""
    return seeds_of(read_sets(tuned_file(*home(name))))


def real_set(name: str, allow_code: Sequence[str | Path] = ()) -> str | None:
    """Name of the set with which a law goes into real water; None where it was tuned for none.

    "real", for all seas. A law that has none there takes that of the default sea, "real-gamma5": better tuned for
    another sea of the same water than for another water.
    """
    sets = tuned_sets(name, allow_code)
    return next((choice for choice in (REAL, f"{REAL}-{DEFAULT_SEA}") if choice in sets), None)


def build(
    name: str,
    given: Mapping[str, Any],
    tuning: str | None = None,
    allow_code: Sequence[str | Path] = (),
    device: Plant | None = None,
) -> Law:
    """Build a law from a table of parameters, as `_build`, for a device of one's own where there is one.

    Raises
    ------
    InputError
        As `gyroctl.law`.
    """
    if device is not None:
        check_plant(device, "device")
    if device is None or is_shipped(device):
        return _build(name, given, tuning, allow_code)
    parameters = dict(given)
    if isinstance(given.get("plant"), str | Mapping):
        parameters["plant"] = design_in(device, given["plant"])
    plain = _build(name, given, tuning, allow_code)
    taken = taken_by(factory_of(name))
    wraps = given.get("wraps", taken.get("wraps"))
    if isinstance(plain, Wrapping) and isinstance(wraps, str | Mapping):  # the law within is given them too
        table = {"law": wraps} if isinstance(wraps, str) else dict(wraps)
        inner, names = _wrapped(name, table, allow_code), taken_by(factory_of(str(table["law"])))
        parameters["wraps"] = {k: v for k, v in numbers_of(inner, device).items() if k in names} | table
    known = numbers_of(plain, device)
    own = {key: value for key, value in known.items() if key in taken and key not in given}
    built = _build(name, {**own, **parameters}, tuning, allow_code)
    return in_model_scale(built, device.parameters.length_scale, name, given)


def _build(
    name: str, given: Mapping[str, Any], tuning: str | None = None, allow_code: Sequence[str | Path] = ()
) -> Law:
    """Build a law from a table of parameters that somebody else has written: none of its names is one of `gyroctl.law`.

    As `gyroctl.law`, but that a set may stand in the table, as ``tuning``.

    Raises
    ------
    InputError
        As `gyroctl.law`.
    """
    check_kind("law", name, str, "the name of a law", 'Give a name, for example gyroctl.law("load_angle")')
    parameters = dict(given)
    tuning = parameters.pop("tuning", tuning)
    if tuning is not None:
        check_kind(f"laws.{name}.tuning", tuning, str, "the name of a set", 'Give for example tuning = "all"')
        parameters = {**_tuned_parameters(name, tuning, allow_code), **parameters}
    if isinstance(parameters.get("wraps"), str | Mapping):
        parameters = {**parameters, "wraps": _wrapped(name, parameters["wraps"], allow_code)}
    if isinstance(parameters.get("plant"), str | Mapping):
        parameters = {**parameters, "plant": _design(name, parameters["plant"])}
    design = parameters.get("plant")
    if tuning is None and isinstance(design, Plant) and design.coefficients.beyond is not None:
        known_set = real_set(name, allow_code)
        parameters = {**(_tuned_parameters(name, known_set, allow_code) if known_set else {}), **parameters}
    factory = factory_of(name)
    own_names, known = defaults_of(factory), taken_by(factory)
    groups = {key: default for key, default in own_names.items() if hasattr(default, "_fields")}
    for key, value in parameters.items():
        _check_parameter(name, key, value, known)
    grouped = {key: value for key, value in parameters.items() if key not in own_names}
    own = {key: value for key, value in parameters.items() if key not in grouped}
    own |= nested.regrouped({key: own.get(key, group) for key, group in groups.items()}, grouped)
    file = Path(parted(name)[0]) if is_file(name) else None
    try:
        with noted(file) if file is not None else nullcontext():
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
def defaults_of(factory: Callable[..., Any]) -> Mapping[str, Any]:
    """Parameters of a law with their defaults; a search builds a law thousands of times."""
    return {key: parameter.default for key, parameter in inspect.signature(factory).parameters.items()}


def factory_of(name: str) -> Callable[..., Any]:
    """What builds a law of that name."""
    factory = _from_file(name) if is_file(name) else _from_name(name)
    if not callable(factory):
        raise InputError("law", name, f"is a {type(factory).__name__}, no law", "Name a class or function of the file")
    return factory


def taken_by(factory: Callable[..., Any]) -> dict[str, Any]:
    """Parameters that a law takes, those of its groups among them, with their defaults."""
    own = dict(defaults_of(factory))
    groups = [default for default in own.values() if hasattr(default, "_fields")]
    return own | {key: value for group in groups for key, value in nested.named(group).items()}


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
        raise InputError(field, value, "unknown parameter", choice_of(key, known))
    if hasattr(known[key], "_fields") and not hasattr(value, "_fields"):
        raise InputError(field, value, "stands for several parameters", f"Give {', '.join(known[key]._fields)} instead")
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if key == "plant" and isinstance(value, PLAIN) and not isinstance(known[key], PLAIN):
        raise InputError(field, value, "is no design model", 'Give a variant, for example plant = "realistic"')
    if isinstance(known[key], str) and isinstance(value, PLAIN):
        raise InputError(field, value, "must be a name", f'The default is "{known[key]}"')
    if number and not is_finite(value):
        raise InputError(field, value, "must be a finite number", f"Give {key} as a number")
    if isinstance(known[key], float) and not number:
        raise InputError(field, value, "must be a number", f"The default is {known[key]}")
    if key in ("cc", "cg") and number and value < 0.0:
        raise InputError(field, value, "must not be negative: both controls only dissipate", f"Give {key} >= 0 in Nms")


def _wrapped(name: str, wraps: str | Mapping[str, Any], allow_code: Sequence[str | Path]) -> Law:
    """Build the law that another one wraps: a name, or a table with `law` and its parameters."""
    table = {"law": wraps} if isinstance(wraps, str) else {**wraps}
    inner = table.pop("law", None)
    if not isinstance(inner, str) or inner == name:
        raise InputError(
            f"laws.{name}.wraps",
            inner,
            "is no law to wrap",
            'Give its name, or a table with law = "load_angle" and its parameters',
        )
    return build(inner, table, None, allow_code)


def _design(name: str, plant: str | Mapping[str, Any]) -> Plant:
    """Design model of a law: a variant, or a table of choices."""
    try:
        return zhang2017(plant) if isinstance(plant, str) else zhang2017(**plant)
    except InputError as error:
        raise InputError(f"laws.{name}.{error.field}", error.value, error.problem, error.mend) from None


def _tuned_parameters(name: str, tuning: str, allow_code: Sequence[str | Path]) -> dict[str, Any]:
    sets = tuned_sets(name, allow_code)
    if tuning == REAL:
        tuning = real_set(name, allow_code) or REAL
    if tuning not in sets:
        mend = f"Choose one of {', '.join(sets)}" if sets else f"Tune it: gyroctl tune {name} --ship"
        raise InputError(f"laws.{name}.tuning", tuning, "there is no such set of tuned parameters", mend)
    return dict(sets[tuning]["parameters"])


def _point(name: str) -> EntryPoint:
    points = registered()
    if name not in points:
        raise InputError("law", name, "unknown law", f'{choice_of(name, points)}, or give "file.py:Name"')
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
    path, attribute = parted(name)
    module = _module(name, _existing(name, path))
    if not hasattr(module, attribute):
        raise InputError("law", name, f"{path} defines no {attribute}", "Name a class or function of the file")
    return cast(Callable[..., Any], getattr(module, attribute))


def _module(name: str, file: Path) -> ModuleType:
    """Import a user's file; again only when its text, or what it rests on, has changed: its laws are compiled once."""
    key = _content(file)
    if key in _loaded:
        return _loaded[key]
    for known, loaded in list(sys.modules.items()):  # local modules that it imports may have changed with it
        if (getattr(loaded, "__file__", None) or "") in key[2] and known != "__main__":
            del sys.modules[known]
    spec = importlib.util.spec_from_file_location(f"gyroctl_user_{file.stem}", file)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    beside = str(file.resolve().parent)
    if added := beside not in sys.path:
        sys.path.append(beside)  # what lies beside it is found however gyroctl was begun, and hides no installed module
    try:
        with noted(file):
            spec.loader.exec_module(module)
    except Exception as error:
        raise InputError(
            "law",
            name,
            f"the file cannot be imported: {type(error).__name__}: {error}",
            "Run the file with Python and correct it",
        ) from error
    finally:
        if added and beside in sys.path:
            sys.path.remove(beside)
    _loaded[_content(file)] = module  # with the tables that it read
    return module


def _content(file: Path) -> tuple[str, str, tuple[str, ...]]:
    """A user's file, a hash of all that it rests on, and the local modules among that."""
    found = sources([file])
    others = tuple(str(path) for path in found.files[1:] if path.suffix == ".py")
    rests_on = "\n".join([found.lines(), *environment(found.files)])
    return str(file.resolve()), hashlib.sha256(rests_on.encode()).hexdigest(), others


_loaded: dict[tuple[str, str, tuple[str, ...]], ModuleType] = {}
"""Users' files by path and content."""
