"""The reference of the built site: every public name has its page, with its arguments and a link to its source."""

from __future__ import annotations

import inspect
import re
from pathlib import Path

from documented import parameters
from public_names import Name, all_names
from reference_pages import page_of


def lacking(name: Name, html: str) -> list[str]:
    """What the page of a name does not show."""
    shown = set(re.findall(r"\w+", " ".join(re.findall(r"<strong>(.*?)</strong>", html))))
    shown |= set(re.findall(rf'id="{re.escape(name.path)}\.(\w+)"', html))  # members with a text of their own
    what = [] if f'id="{name.path}"' in html or f'id="{name.home}.{name.name}"' in html else ["itself"]
    if not name.constant:
        what += [entry.name for entry in parameters(name.thing) if entry.name not in shown]
        if (inspect.isclass(name.thing) or inspect.isfunction(name.thing)) and "viewcode-link" not in html:
            what.append("its source")
    return what


def faults(site: Path) -> list[str]:
    """Public names that the site in this folder does not show, or not whole."""
    found = []
    for name in all_names():
        page = site / "docs" / "reference" / page_of(name)
        if not page.is_file():
            found.append(f"{name.path}: has no page {page.name}")
        elif what := lacking(name, page.read_text(encoding="utf-8")):
            found.append(f"{name.path}: its page lacks {', '.join(what)}")
    return found
