"""What the text of a law does not tell: values that its functions find at their module's head, and the environment.

A number may come from the environment, a database or another program while a file is loaded: the text stays the same,
and the law is another one. So plain values that the functions of a law name, in its file and in local modules, count as
they stand; and of variables of the environment that a text names, what they are. Folders of the law do not count.
"""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from types import CodeType, ModuleType, SimpleNamespace
from typing import Any

import numpy as np

from gyroctl.fingerprint.imports import imports_of
from gyroctl.fingerprint.local import is_local

ENVIRONMENT = re.compile(r"""(?:environ(?:\.get)?\s*[\[(]|getenv\s*\()\s*(?:b|r)?["']([^"'\n]+)["']""")

CHANCE = re.compile(r"\b(?:np|numpy)\.random\b")

OUTSIDE = ("random", "secrets", "socket", "sqlite3", "subprocess", "urllib", "requests", "http")
"""Modules by which a text fetches what is not seen as a change of it."""

DEEPEST = 20
"""Values within values."""


class _NotPlain(Exception):
    """A value that is no number, text or group of them."""


def as_loaded(those: Iterable[Any]) -> list[str]:
    """Lines that tell the values which local classes and functions find as they stand, one for each, sorted."""
    walk = _Walk()
    for one in those:
        walk.value("", one, frozenset(), Path())
    return sorted(walk.lines)


def environment(files: Iterable[Path]) -> list[str]:
    """Lines that tell the variables of the environment which texts name, sorted."""
    names = {name for text in _texts(files) for name in ENVIRONMENT.findall(text)}
    return sorted(f"environment {name} {_hash([repr(os.environ.get(name)).encode()])}" for name in names)


def fetches(files: Iterable[Path]) -> list[str]:
    """Modules by which texts fetch, while they run, what is not seen as a change: by name, sorted."""
    found: set[str] = set()
    for text in _texts(files):
        found |= {module.partition(".")[0] for module, _ in imports_of(text)} & set(OUTSIDE)
        found |= {"numpy.random"} if CHANCE.search(text) else set()
    return sorted(found)


def _texts(files: Iterable[Path]) -> Iterator[str]:
    for path in files:
        if path.suffix == ".py" and path.is_file():
            yield path.read_text(encoding="utf-8", errors="replace")


class _Walk:
    """From function to function, as far as local files go."""

    def __init__(self) -> None:
        self.lines: set[str] = set()
        self.met: set[int] = set()

    def kind(self, kind: type) -> None:
        """Walk the functions and the plain values of a class, and of those that it inherits from."""
        for one in kind.__mro__:
            members = [_function(member) for member in vars(one).values()]
            home = next((f.__code__.co_filename for f in members if f is not None and _is_here(f)), None)
            if home is None or id(one) in self.met:
                continue
            self.met.add(id(one))
            for name, member in vars(one).items():
                self.value(f"{one.__qualname__}.{name}", member, frozenset(), Path(home))

    def value(self, name: str, value: Any, names: frozenset[str], home: Path) -> None:
        """Walk what a name stands for; `names` are those that the code around it asks for."""
        if name.rpartition(".")[2].startswith("__"):
            return
        if isinstance(value, ModuleType):
            file = Path(getattr(value, "__file__", None) or "")
            if file.is_file() and is_local(file):
                for part in names & set(vars(value)):
                    self.value(part, vars(value)[part], names, file)
        elif isinstance(value, type):
            self.kind(value)
        elif (function := _function(value)) is not None:
            self.function(function)
        else:
            try:
                told = _hash(_plain(value, home.parent, 0))
            except (_NotPlain, RecursionError):
                return  # what it rests on may be seen as a file
            self.lines.add(f"{home.name} {name} {told}")

    def function(self, function: Any) -> None:
        """Walk what a local function names, its defaults, and what it closes over."""
        code = function.__code__
        if id(code) in self.met or not _is_here(function):
            return
        self.met.add(id(code))
        home, names = Path(code.co_filename), frozenset(_names(code))
        around = function.__globals__
        for name in names & set(around):
            self.value(name, around[name], names, home)
        kept = [*(function.__defaults__ or ()), *(function.__kwdefaults__ or {}).values()]
        for cell in function.__closure__ or ():
            try:
                kept.append(cell.cell_contents)
            except ValueError:  # a name that has no value yet
                continue
        for number, value in enumerate(kept):
            self.value(f"{function.__qualname__} {number}", value, names, home)


def _function(member: Any) -> Any:
    """Function of Python behind a member of a class or a module; None where there is none."""
    for _ in range(DEEPEST):
        if hasattr(member, "__code__"):
            return member
        inner = [getattr(member, name, None) for name in ("__wrapped__", "__func__", "fget", "py_func", "func")]
        member = next((one for one in inner if callable(one)), None)
        if member is None:
            break
    return None


def _is_here(function: Callable[..., Any]) -> bool:
    file = Path(function.__code__.co_filename)
    return file.is_file() and is_local(file)


def _names(code: CodeType) -> Iterator[str]:
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _names(constant)


def _hash(parts: Iterable[bytes]) -> str:
    return hashlib.sha256(b"".join(parts)).hexdigest()


def _plain(value: Any, folder: Path, depth: int) -> Iterator[bytes]:
    """Bytes that tell a plain value from any other.

    Raises
    ------
    _NotPlain
        For any other value.
    """
    if depth > DEEPEST:
        raise _NotPlain
    if value is None or isinstance(value, bool | int | float | complex | np.generic):
        yield f"{type(value).__name__} {value!r};".encode()
    elif isinstance(value, str | Path):
        text = str(value).replace(str(folder.resolve()), ".").replace(str(folder), ".").replace(str(Path.cwd()), ".")
        yield f"text {len(text)} {text};".encode("utf-8", "surrogatepass")
    elif isinstance(value, bytes | bytearray):
        yield b"bytes %d " % len(value) + bytes(value)
    elif isinstance(value, np.ndarray) and not value.dtype.hasobject:
        yield f"array {value.dtype.str} {value.shape} ".encode() + np.ascontiguousarray(value).tobytes()
    elif isinstance(value, tuple | list):
        yield f"list {len(value)}(".encode()
        for part in value:
            yield from _plain(part, folder, depth + 1)
        yield b")"
    elif isinstance(value, set | frozenset):
        yield b"set(" + b"".join(sorted(b"".join(_plain(part, folder, depth + 1)) for part in value)) + b")"
    elif (parts := _parts(value)) is not None:
        yield f"group {len(parts)}(".encode()
        for key, part in parts.items():
            yield b"".join([*_plain(key, folder, depth + 1), b"=", *_plain(part, folder, depth + 1)])
        yield b")"
    else:
        raise _NotPlain


def _parts(value: Any) -> Mapping[Any, Any] | None:
    if isinstance(value, Mapping):
        return value
    if is_dataclass(value) and not isinstance(value, type):
        return {field.name: getattr(value, field.name) for field in fields(value)}
    return vars(value) if isinstance(value, SimpleNamespace) else None
