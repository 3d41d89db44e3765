"""What a public name's documentation says, section by section: of its docstring, or of the comments beside its fields.

In settings and states the meaning of a field stands beside it (``period: float = 0.1  # [s]``). Where the docstring of
such a class has no section of parameters, one is made of these comments, for the site and for the tests alike.
"""

from __future__ import annotations

import inspect
from dataclasses import dataclass
from functools import partial
from typing import Any, get_type_hints

from numpydoc.docscrape import NumpyDocString

from gyroctl.fields import fields_of


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
    said = [(field, field.about or _of_class(_annotated(thing, field.name))) for field in fields_of(thing)]
    return [Entry(field.name, field.annotation, about) for field, about in said if about]


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
