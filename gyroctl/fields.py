"""What stands beside the fields of a class: in settings and states the meaning of a field is the comment behind it."""

from __future__ import annotations

import ast
import inspect
import io
import textwrap
import tokenize
from typing import NamedTuple


class Field(NamedTuple):
    """A field of a class as its text tells it."""

    name: str
    annotation: str
    about: str  # the comment beside or right above it, or the text below; empty where there is none


def fields_of(thing: object) -> list[Field]:
    """Fields that a class declares, in their order; none of what is no class, or has no text."""
    if not inspect.isclass(thing):
        return []
    try:
        source = textwrap.dedent(inspect.getsource(thing))
    except (OSError, TypeError):
        return []
    beside = {
        token.start[0]: token.string.lstrip("#: ").strip()
        for token in tokenize.generate_tokens(io.StringIO(source).readline)
        if token.type == tokenize.COMMENT
    }
    rows = source.splitlines()
    found, body = [], ast.parse(source).body[0].body  # type: ignore[attr-defined]
    for node, after in zip(body, [*body[1:], None], strict=True):
        if not (isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name)):
            continue
        below = after.value.value if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant) else ""
        lines = range(node.lineno, (node.end_lineno or node.lineno) + 1)
        above = _above(rows, node.lineno) if not any(line in beside for line in lines) else ""
        about = " ".join([str(below), *(beside[line] for line in lines if line in beside), above]).strip()
        found.append(Field(node.target.id, ast.unparse(node.annotation), about))
    return found


def _above(rows: list[str], line: int) -> str:
    """The comment that stands alone right above a line."""
    found: list[str] = []
    while line >= 2 and rows[line - 2].strip().startswith("#"):
        line -= 1
        found.insert(0, rows[line - 1].strip().lstrip("# "))
    return " ".join(found)
