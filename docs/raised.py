"""Which errors a function can raise, read from its code: its own ``raise``, and those of the functions that it calls.

Followed are calls by name of what the package itself holds, as far down as `DEPTH`; what is called through an object,
or is chosen while it runs, is not seen. So it finds errors that a docstring forgets, not all there are.
"""

from __future__ import annotations

import ast
import inspect
import textwrap
from typing import Any

DEPTH = 4
"""Calls that are followed, one below the other."""

ENTRANCES = ("__init__", "__new__", "__post_init__")
"""Methods that run when a class is called."""


def raised(thing: Any, depth: int = DEPTH) -> set[str]:
    """Names of the errors that calling a function or a class of the package can raise."""
    return set().union(*(_of(part, depth, set()) for part in _parts(thing)), set())


def _parts(thing: Any) -> list[Any]:
    """Functions that run when it is called."""
    if inspect.isclass(thing):
        return [vars(thing)[name] for name in ENTRANCES if inspect.isfunction(vars(thing).get(name))]
    return [inspect.unwrap(getattr(thing, "py_func", thing))]


def _of(function: Any, depth: int, seen: set[int]) -> set[str]:
    if id(function) in seen or not str(getattr(function, "__module__", "")).startswith("gyroctl"):
        return set()
    seen.add(id(function))
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    except (OSError, TypeError, SyntaxError):
        return set()
    known = {**getattr(function, "__globals__", {}), **_imported(tree)}
    found = {name for node in ast.walk(tree) if isinstance(node, ast.Raise) for name in _named(node)}
    caught = {name for node in ast.walk(tree) if isinstance(node, ast.ExceptHandler) for name in _caught(node)}
    if depth:
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in known:
                for part in _parts(known[node.func.id]):
                    found |= _of(part, depth - 1, seen) - caught
    return found


def _named(node: ast.Raise) -> list[str]:
    raised = node.exc.func if isinstance(node.exc, ast.Call) else node.exc
    return [raised.id] if isinstance(raised, ast.Name) and raised.id[:1].isupper() else []


def _caught(node: ast.ExceptHandler) -> list[str]:
    kinds = node.type.elts if isinstance(node.type, ast.Tuple) else [node.type]
    return [kind.id for kind in kinds if isinstance(kind, ast.Name)]


def _imported(tree: ast.Module) -> dict[str, Any]:
    """What a function imports itself, from the package."""
    found: dict[str, Any] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("gyroctl"):
            module = __import__(node.module or "", fromlist=["_"])
            found.update({each.asname or each.name: getattr(module, each.name, None) for each in node.names})
    return found
