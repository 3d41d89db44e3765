"""What a law computes, as a text to hash: the code of its methods and of all that they call, and the numbers they name.

Not the text of its file: a comment, or another default, makes no other law.
"""

from __future__ import annotations

import inspect
from types import CodeType, FunctionType, ModuleType
from typing import Any

METHODS = ("init", "step", "informed", "information", "period", "__init__", "__post_init__")


def content(built: Any) -> str:
    """Return what the methods of a law compute; its parameters are apart."""
    known: dict[str, str] = {}
    kind = type(built)
    for name in METHODS:
        member = inspect.getattr_static(kind, name, None)
        member = member.fget if isinstance(member, property) else member
        if isinstance(member, FunctionType):
            _follow(f"{kind.__qualname__}.{name}", member, known, kind.__module__.rpartition(".")[0])
    return "\n".join(f"{name}: {known[name]}" for name in sorted(known))


def _follow(name: str, function: FunctionType, known: dict[str, str], package: str) -> None:
    """Add a function and, in turn, what it names: functions of its package and numbers of its module."""
    if name in known:
        return
    known[name] = _code(function.__code__)
    for used in _names(function.__code__):
        value = function.__globals__.get(used)
        value = getattr(value, "py_func", value)  # of a compiled function
        if isinstance(value, type | FunctionType) and not _own(value, function, package):
            continue
        if isinstance(value, FunctionType):
            _follow(f"{value.__module__}.{value.__qualname__}", value, known, package)
        elif isinstance(value, type):
            for method, member in vars(value).items():
                if isinstance(member, FunctionType) and not method.startswith("_"):
                    _follow(f"{value.__module__}.{value.__qualname__}.{method}", member, known, package)
        elif value is not None and not isinstance(value, ModuleType) and isinstance(value, int | float | str | tuple):
            known[f"{function.__module__}.{used}"] = repr(value)


def _own(value: Any, function: FunctionType, package: str) -> bool:
    return value.__module__ == function.__module__ or bool(package and value.__module__.startswith(f"{package}."))


def _names(code: CodeType) -> set[str]:
    inner = (part for part in code.co_consts if isinstance(part, CodeType))
    return set(code.co_names).union(*(_names(part) for part in inner))


def _code(code: CodeType) -> str:
    constants = [_code(part) if isinstance(part, CodeType) else repr(part) for part in code.co_consts]
    return repr((code.co_code.hex(), constants, code.co_names, code.co_varnames))
