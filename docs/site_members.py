"""What of a class the reference shows: its own public methods, not the accessors that named tuples bring."""

from __future__ import annotations

from typing import Any

from sphinx.application import Sphinx


def skip(app: Sphinx, what: str, name: str, thing: Any, skipped: bool, options: Any) -> bool | None:
    """Leave out the fields of named tuples, which the class's docstring explains, and what tuples can do."""
    if type(thing).__name__ == "_tuplegetter" or name in ("count", "index"):
        return True
    return None


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the choice of members."""
    app.connect("autodoc-skip-member", skip)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
