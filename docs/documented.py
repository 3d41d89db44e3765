"""What a public name's documentation says, section by section: of its docstring, or of the comments beside its fields.

In settings and states the meaning of a field stands beside it (``period: float = 0.1  # [s]``). Where the docstring of
such a class has no section of parameters, one is made of these comments, for the site and for the tests alike.
"""

from __future__ import annotations

import ast
import inspect
import io
import textwrap
import tokenize
from dataclasses import dataclass
from functools import partial
from typing import Any, get_type_hints

from numpydoc.docscrape import NumpyDocString


@dataclass(frozen=True)
class Entry:
    """An argument or a field, as it is documented.

    Parameters
    ----------
    name : str
        Name, without stars.
    type : str
        What it may be.
    about : str
        What it means, with its unit.
    """

    name: str
    type: str
    about: str


def docstring(thing: Any) -> NumpyDocString:
    """Sections of the docstring; of a function with some arguments filled in, those of the function."""
    return NumpyDocString(inspect.getdoc(thing.func if isinstance(thing, partial) else thing) or "")


def section(thing: Any, title: str) -> list[Entry]:
    """Entries of a section of the docstring, one for each name: ``hs, wp : float`` are two."""
    found = []
    for parameter in docstring(thing)[title]:
        about = " ".join(line.strip() for line in parameter.desc)
        for name in (parameter.name or parameter.type).split(","):
            found.append(Entry(name.strip().lstrip("*"), parameter.type, about))
    return found


def parameters(thing: Any) -> list[Entry]:
    """Arguments or fields as documented: of the section, of ``Attributes``, and of comments beside fields."""
    said = [*section(thing, "Parameters"), *section(thing, "Other Parameters"), *section(thing, "Attributes")]
    names = {entry.name for entry in said}
    return said + [entry for entry in field_comments(thing) if entry.name not in names]


def field_comments(thing: Any) -> list[Entry]:
    """Fields of a class with the comment beside each, or the text below it; those without are left out."""
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
        about = about or _of_class(_annotated(thing, node.target.id))
        if about:
            found.append(Entry(node.target.id, ast.unparse(node.annotation), about))
    return found


def _above(rows: list[str], line: int) -> str:
    """The comment that stands alone right above a line."""
    found: list[str] = []
    while line >= 2 and rows[line - 2].strip().startswith("#"):
        line -= 1
        found.insert(0, rows[line - 1].strip().lstrip("# "))
    return " ".join(found)


def _annotated(thing: Any, name: str) -> Any:
    """The type of a field, None where it cannot be told."""
    try:
        return get_type_hints(thing)[name]
    except (NameError, KeyError, TypeError):
        return None


def _of_class(kind: Any) -> str:
    """What a group of settings is, with the meaning of each: for a field whose class says it."""
    if not (inspect.isclass(kind) and str(kind.__module__).startswith("gyroctl")):
        return ""
    summary = " ".join(docstring(kind)["Summary"])
    fields = "; ".join(f"{entry.name}: {entry.about}" for entry in parameters(kind))
    return f"{summary} {fields}".strip()


def missing_section(thing: Any) -> list[str]:
    """Lines of a section of parameters made of the comments beside fields, where the docstring has none."""
    if not inspect.isclass(thing) or docstring(thing)["Parameters"] or docstring(thing)["Attributes"]:
        return []
    entries = field_comments(thing)
    lines = ["", "Parameters", "----------"] if entries else []
    for entry in entries:
        lines += [f"{entry.name} : {entry.type}", f"    {entry.about}"]
    return lines
