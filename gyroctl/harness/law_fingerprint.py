"""Which law it is: a hash of the texts that define it, of what they rest on, and of its parameters."""

from __future__ import annotations

import hashlib
import pickle
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gyroctl.fingerprint import code_of, fingerprint
from gyroctl.fingerprint.as_loaded import as_loaded, environment, fetches
from gyroctl.fingerprint.local import sources
from gyroctl.harness.code_files import is_file, parted

UNKNOWN = ""
"""Instead of a hash, where a law cannot be told from another one."""


class Unknown(Exception):
    """A value that cannot be told from another one."""


def law_fingerprint(law: Any) -> str:
    """SHA-256 of a law: its source and every field, for a law around a law those of both.

    `UNKNOWN` for a law with hidden state, that is neither a NamedTuple nor a dataclass or holds what cannot be
    pickled, for one that was typed in by hand and has no file, and for one that says so by a true member ``untold``.
    """
    met: set[Path] = set()
    digest = hashlib.sha256()
    try:
        for one in _layers(law):
            if not (hasattr(one, "_fields") or is_dataclass(one)) or getattr(one, "untold", False):
                return UNKNOWN
            for part in _told(one, met):
                digest.update(part)
    except (AttributeError, TypeError, pickle.PicklingError, Unknown):
        return UNKNOWN
    source = law_source(law, met)
    return hashlib.sha256(digest.digest() + source.encode()).hexdigest() if source else UNKNOWN


def value_fingerprint(*values: Any) -> str:
    """SHA-256 of values: numbers, texts, arrays, groups of them, a plant, waves; `UNKNOWN` for what cannot be told."""
    met: set[Path] = set()
    try:
        digest = hashlib.sha256(b"".join(part for value in values for part in _told(value, met)))
    except (AttributeError, TypeError, pickle.PicklingError, Unknown):
        return UNKNOWN
    digest.update(sources(met).lines().encode())
    return digest.hexdigest()


def law_source(law: Any, further: set[Path] | None = None) -> str:
    """SHA-256 of the text of a law and of the law within it, with all that it rests on.

    Its file, and in a package every file of that; of a law from elsewhere also the local modules that it imports and
    the tables that it names or reads, see `fingerprint.local`, and values that it finds when it is loaded, see
    `fingerprint.as_loaded`; of this package all that its modules reach. `UNKNOWN`
    where there is no such file. It tells a law that is built from nothing but its name and numbers.

    Parameters
    ----------
    law : Law
        The law.
    further : set of Path, optional
        Files of functions and tables that it holds.
    """
    files: set[Path] = set(further or ())
    ours: set[str] = set()
    elsewhere: list[type] = []
    try:
        for one in _layers(law):
            for kind in _kinds(type(one)):
                if kind.__module__.startswith("gyroctl."):
                    ours.add(kind.__module__)
                    continue
                elsewhere.append(kind)
                for file in _files(kind):
                    packed = (file.parent / "__init__.py").is_file()
                    files |= set(file.parent.rglob("*.py")) if packed else {file}
        if not all(file.is_file() for file in files) or not (files or ours):
            return UNKNOWN
        found = sources(files)
        ours |= set(found.ours)
        values = [*as_loaded(elsewhere), *environment(found.files)]
    except (AttributeError, OSError):
        return UNKNOWN
    whole = [fingerprint()] if "gyroctl" in ours else []  # import gyroctl as gy: whatever it then asks for
    text = "\n".join([*whole, code_of(*ours), found.lines(), *values])
    return hashlib.sha256(text.encode()).hexdigest()


def fetches_of(law: Any) -> list[str]:
    """Modules by which a law from elsewhere fetches, while it runs, what no fingerprint sees; by name."""
    kinds = [kind for one in _layers(law) for kind in _kinds(type(one)) if not kind.__module__.startswith("gyroctl.")]
    try:
        return fetches(sources({file for kind in kinds for file in _files(kind) if file.is_file()}).files)
    except (AttributeError, OSError):
        return []


def _kinds(kind: type) -> list[type]:
    """Return a class and those that it inherits from, without those of Python."""
    apart = ("typing", "abc", "collections")
    return [one for one in kind.__mro__ if one not in (object, tuple) and one.__module__ not in apart]


def _files(kind: type) -> set[Path]:
    """Files of the functions of a class.

    Raises
    ------
    AttributeError
        For a class whose `step` is no function of Python.
    """
    found = set()
    for member in vars(kind).values():
        function: Any = getattr(member, "fget", None) or getattr(member, "__func__", None) or member
        code = getattr(function, "__code__", None)
        if code is not None and getattr(function, "__module__", None) == kind.__module__:
            found.add(Path(code.co_filename))
    if "step" in vars(kind):
        found.add(Path(vars(kind)["step"].__code__.co_filename))
    # what Python writes for a NamedTuple or a dataclass has no file
    return {file for file in found if not str(file).startswith("<") or file.name == "<stdin>"}


def _told(value: Any, met: set[Path]) -> Iterator[bytes]:
    """Bytes that tell a value from any other, whatever memory it lies in; files that are met on the way are noted."""
    if value is None or isinstance(value, bool | int | float | complex | np.generic):
        yield f"{type(value).__name__} {value!r};".encode()
    elif isinstance(value, str | Path):
        yield from _text(value, met)
    elif isinstance(value, bytes):
        yield b"bytes %d " % len(value) + value
    elif isinstance(value, np.ndarray) and not value.dtype.hasobject:
        yield f"array {value.dtype.str} {value.shape} ".encode() + np.ascontiguousarray(value).tobytes()
    elif is_dataclass(value) and not isinstance(value, type):
        parts = {f.name: getattr(value, f.name) for f in fields(value)}
        yield from _group(type(value).__qualname__, parts, met)
    elif isinstance(value, tuple) and hasattr(value, "_asdict"):
        yield from _group(type(value).__qualname__, value._asdict(), met)
    elif isinstance(value, tuple | list):
        yield from _group(type(value).__name__, dict(enumerate(value)), met)
    elif isinstance(value, Mapping):
        yield from _group("mapping", dict(value), met)
    else:
        yield from _object(value, met)


def _group(name: str, parts: Mapping[Any, Any], met: set[Path]) -> Iterator[bytes]:
    yield f"{name} {len(parts)}(".encode()
    for key, part in parts.items():
        yield repr(key).encode() + b"="
        yield from _told(part, met)
    yield b")"


def _text(value: str | Path, met: set[Path]) -> Iterator[bytes]:
    """A text; where it is the path of a file, or names a law in one, that file's last name, and its content counts."""
    path, name = parted(value) if isinstance(value, str) and is_file(value) else (value, "")
    file = Path(path)
    try:
        there = len(str(value)) < 4096 and "." in file.name and file.is_file()
    except (OSError, ValueError):
        there = False
    if there:
        met.add(file.resolve())
    text = f"{file.name}:{name}".removesuffix(":") if there else str(value)
    yield f"text {len(text)} {text};".encode()


def _object(value: Any, met: set[Path]) -> Iterator[bytes]:
    """Anything else: a function by its name and file, the rest as it is pickled."""
    if isinstance(value, type) or hasattr(value, "__code__"):
        module = sys.modules.get(value.__module__)
        pickle.dumps(value)  # what has no name of its own cannot be told
        file = getattr(module, "__file__", None) or _code_file(value)
        if file is None:
            raise Unknown
        if not value.__module__.startswith("gyroctl."):
            met.add(Path(file).resolve())
            yield "\n".join(as_loaded([value])).encode()
        yield f"function {value.__module__}.{value.__qualname__};".encode()
        return
    yield type(value).__qualname__.encode() + pickle.dumps(value)


def _code_file(value: Callable[..., Any] | type) -> str | None:
    return getattr(getattr(value, "__code__", None), "co_filename", None)


def _layers(law: Any) -> Iterator[Any]:
    """Yield a law and what it is around, from the outside in."""
    while law is not None:
        yield law
        law = getattr(law, "law", None)
