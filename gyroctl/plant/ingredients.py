"""All that a function is compiled from, as one hash: its bytecode, what it calls, the constants that it reads.

numba's own cache looks at the file of the function alone. Here the names that the bytecode reads are followed: into
functions and classes, through modules of this package or of a user, down to numbers. Of a module of this package that
is met on the way the whole text counts, since what stands in for a function when it is compiled (`overload`) is beside
it. Other libraries count by their versions.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Iterator
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np
from numba import types
from numba.core.dispatcher import Dispatcher
from numba.core.extending import _Intrinsic

LIBRARIES = ("numba", "llvmlite", "numpy")
FOREIGN = frozenset({*LIBRARIES, "scipy", *sys.stdlib_module_names})
"""Packages that are told by their version."""

HOME = __name__.partition(".")[0]
PLAIN = (type(None), bool, int, float, complex, str, bytes, type(...), np.generic, np.dtype, types.Type)


class Untold(TypeError):
    """Something that a hash cannot tell from another of its kind."""


def ingredients(*roots: Any, names: tuple[str, ...] = ()) -> str:
    """SHA-256 of functions, classes and constants, and of all that they lead to.

    Parameters
    ----------
    *roots
        Functions, classes or constants.
    names : tuple of str
        Methods of the classes that are called from outside.

    Raises
    ------
    Untold
        Where something is read that is no constant, function, class or module.
    """
    listing = _Listing(names)
    for root in roots:
        listing.add(root)
    listing.close()
    return hashlib.sha256("\n".join([*_versions(), *sorted(listing.lines)]).encode()).hexdigest()


class _Listing:
    """What was met, a line each."""

    def __init__(self, names: tuple[str, ...]) -> None:
        self.lines: set[str] = set()
        self.names = set(names)  # read anywhere: methods of these names may be called
        self.classes: list[type[Any]] = []
        self.seen: dict[int, Any] = {}

    def close(self) -> None:
        """Follow the methods that are called, until no new name comes up."""
        done: set[tuple[type[Any], str]] = set()
        while True:
            found = {(kind, name) for kind in self.classes for name in self.names if name in vars(kind)} - done
            if not found:
                return
            for kind, name in found:
                self.lines.add(f"method {kind.__qualname__}.{name}")
                self.add(vars(kind)[name])
            done |= found

    def add(self, value: Any) -> None:
        if isinstance(value, PLAIN):
            self.lines.add(_word(value))
        elif id(value) not in self.seen:
            self.seen[id(value)] = value  # kept, or another object might get its address
            self._add(value)

    def _add(self, value: Any) -> None:
        if _foreign(value):
            self.lines.add(f"{getattr(value, '__module__', '')}.{_name_of(value)}")
        elif isinstance(value, FunctionType):
            self._function(value)
        elif isinstance(value, Dispatcher):
            if str(value.py_func.__module__).partition(".")[0] != HOME:
                raise Untold("machine code of others, whose names in it may be those of other code")
            self.lines.add(f"options {sorted(value.targetoptions.items())}")
            self.add(value.py_func)
        elif isinstance(value, _Intrinsic):
            self.add(value._defn)
        elif isinstance(value, type):
            self._class(value)
        elif isinstance(value, property | staticmethod | classmethod):
            self.add(value.fget if isinstance(value, property) else value.__func__)
        elif isinstance(value, ModuleType):
            self._module(value, self.names)
        elif isinstance(value, np.ndarray) and value.dtype != object:
            self.lines.add(_word(value))
        elif isinstance(value, tuple | frozenset):
            self.lines.add(_word(value) if isinstance(value, tuple) else f"set {sorted(map(_word, value))}")
            for part in value:
                self.add(part)
        elif type(value).__name__ in ("_tuplegetter", "member_descriptor"):
            pass  # a field: its place is told by the fields of the class
        else:
            raise Untold(f"{type(value).__module__}.{type(value).__qualname__}")

    def _function(self, function: FunctionType) -> None:
        self._text(function.__module__)
        self.lines.add(f"function {_word(function)}")
        for value in (*(function.__defaults__ or ()), *(function.__kwdefaults__ or {}).values()):
            self.add(value)
        for cell in function.__closure__ or ():
            self.add(cell.cell_contents)
        names = {name for code in _codes(function.__code__) for name in code.co_names}
        self.names |= names
        for name in sorted(names & function.__globals__.keys()):
            value = function.__globals__[name]
            self.lines.add(f"{function.__qualname__} reads {name} {_word(value)}")
            if isinstance(value, ModuleType):
                self._module(value, names)
            else:
                self.add(value)

    def _class(self, kind: type[Any]) -> None:
        self._text(kind.__module__)
        fields = getattr(kind, "_fields", ())
        self.lines.add(f"class {kind.__module__}.{kind.__qualname__} {fields}")
        self.classes += [base for base in kind.__mro__ if not _foreign(base)]

    def _module(self, module: ModuleType, names: set[str]) -> None:
        """Of another module, what the function reads there."""
        self.lines.add(f"module {module.__name__}")
        if module.__name__.partition(".")[0] not in FOREIGN:
            for name in sorted(names & vars(module).keys()):
                self.add(vars(module)[name])

    def _text(self, module: str | None) -> None:
        if module is not None and module.partition(".")[0] == HOME:
            file = getattr(sys.modules.get(module), "__file__", None)
            if file is not None:
                self.lines.add(f"{module} {_hashed(file)}")


def _foreign(value: Any) -> bool:
    if isinstance(value, BuiltinFunctionType | np.ufunc):
        return True
    named = isinstance(value, FunctionType | type) or (hasattr(value, "__name__") and callable(value))
    return named and str(getattr(value, "__module__", "")).partition(".")[0] in FOREIGN | {"builtins"}


def _name_of(value: Any) -> str:
    return str(getattr(value, "__qualname__", getattr(value, "__name__", repr(value))))


def _word(value: Any, around: tuple[int, ...] = ()) -> str:
    """What stands in one place: of two that change places, each must be told at its own."""
    if isinstance(value, PLAIN):
        return f"{type(value).__name__} {value!r}"
    if id(value) in around or _foreign(value):
        return _name_of(value)
    around = (*around, id(value))
    if isinstance(value, tuple):
        return f"{type(value).__qualname__} {[_word(part, around) for part in value]}"
    if isinstance(value, np.ndarray) and value.dtype != object:
        content = hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()
        return f"array {value.dtype} {value.shape} {content}"
    if isinstance(value, Dispatcher):
        return _word(value.py_func, around)
    if isinstance(value, FunctionType):
        kept = [*(cell.cell_contents for cell in value.__closure__ or ()), *(value.__defaults__ or ())]
        named = sorted((value.__kwdefaults__ or {}).items())
        words = [_word(part, around) for part in (*kept, *(part for item in named for part in item))]
        return f"{value.__module__}.{value.__qualname__} {_bytes(value.__code__)} {words}"
    if isinstance(value, type | ModuleType):
        return f"{getattr(value, '__module__', '')}.{_name_of(value)}"
    return type(value).__name__


def _codes(code: CodeType) -> Iterator[CodeType]:
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _codes(constant)


def _bytes(code: CodeType) -> str:
    digest = hashlib.sha256()
    for part in _codes(code):
        plain = [_steady(constant) for constant in part.co_consts if not isinstance(constant, CodeType)]
        digest.update(part.co_code + repr((part.co_names, part.co_varnames, part.co_freevars, plain)).encode())
    return digest.hexdigest()


def _steady(constant: Any) -> Any:
    """A constant set in one order: its own differs from process to process."""
    return sorted(map(repr, constant)) if isinstance(constant, frozenset) else constant


@lru_cache(maxsize=1024)
def _hashed(file: str) -> str:
    return hashlib.sha256(Path(file).read_bytes()).hexdigest()


@lru_cache(maxsize=1)
def _versions() -> tuple[str, ...]:
    return (sys.version, *(f"{name} {version(name)}" for name in LIBRARIES))
