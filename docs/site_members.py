"""What the reference shows of a class: its own public methods, and what the comments beside its fields say.

The accessors that named tuples bring are left out.
"""

from __future__ import annotations

import re
from typing import Any

from documented import missing_section
from sphinx.application import Sphinx


def skip(app: Sphinx, what: str, name: str, thing: Any, skipped: bool, options: Any) -> bool | None:
    """Leave out the fields of named tuples, which the class's docstring explains, and what tuples can do."""
    if type(thing).__name__ == "_tuplegetter" or name in ("count", "index"):
        return True
    return None


def fields(app: Sphinx, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    """Add the parameters of a class that are documented beside its fields."""
    if what == "class":
        added = missing_section(thing)
        place = next((i - 1 for i, line in enumerate(lines) if set(line) == {"-"} and i), len(lines))
        lines[place:place] = [*added, ""] if added else []
    lines[:] = [with_bars(line) for line in lines]


def with_bars(line: str) -> str:
    """A line in which the bars of absolute values are bars, not marks of reStructuredText; code stays as it is."""
    parts = re.split(r"(`+[^`]*`+)", line)
    return "".join(part if part.startswith("`") else part.replace("|", r"\|") for part in parts)


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the choice of members."""
    app.connect("autodoc-skip-member", skip)
    app.connect("autodoc-process-docstring", fields, priority=400)  # before numpydoc, which reads what is there then
    return {"parallel_read_safe": True, "parallel_write_safe": True}
