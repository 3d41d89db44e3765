"""What every page of the project has: one template, its words, a list of contents, and nothing from a network."""

from __future__ import annotations

import base64
import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyroctl.reports import wording
from gyroctl.reports.resting import in_words

if TYPE_CHECKING:
    from jinja2 import Environment

CONTENTS = "<!-- contents -->"
"""Where the list of contents goes: after the sections are known."""

PICTURE_MAX = 3_000_000
"""Size of a picture beyond which a page goes without it. [bytes]"""

HEADING = re.compile(r'<h(?P<level>[23]) id="(?P<anchor>[^"]+)"[^>]*>(?P<words>.*?)</h(?P=level)>', re.S)


def environment(filters: Mapping[str, Any] | None = None) -> Environment:
    """Environment of the templates.

    What words the text words the page too: each function of `wording` is a filter.

    Parameters
    ----------
    filters : mapping, optional
        Filters of one page alone.
    """
    from jinja2 import Environment, PackageLoader, StrictUndefined

    made = Environment(
        loader=PackageLoader("gyroctl.reports"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters |= {name: words for name, words in vars(wording).items() if callable(words)}
    made.filters |= {"in_words": in_words, **(filters or {})}
    return made


def render(template: str, values: Mapping[str, Any], filters: Mapping[str, Any] | None = None) -> str:
    """HTML of a page, with its list of contents; equal values give equal text."""
    return with_contents(environment(filters).get_template(template).render(**values))


def with_contents(page: str) -> str:
    """Page with a list of the headings that have an anchor, those of the third level below those of the second."""
    found = [(match["level"], match["anchor"], _bare(match["words"])) for match in HEADING.finditer(page)]
    lines = list[str]()
    deep = False
    for level, anchor, words in found:
        if level == "2" and deep:
            lines.append("</ol>")
        if level == "3" and not deep:
            lines.append("<ol>")
        deep = level == "3"
        lines.append(f'<li><a href="#{anchor}">{words}</a>')
    lines += ["</ol>"] if deep else []
    return page.replace(CONTENTS, "\n".join(lines), 1)


def _bare(words: str) -> str:
    return " ".join(re.sub(r"<[^>]*>", "", words).split())


def as_source(picture: Path) -> str:
    """Address of a PNG file that holds the picture itself, empty where there is no such file."""
    if not picture.is_file() or picture.stat().st_size > PICTURE_MAX:
        return ""
    return f"data:image/png;base64,{base64.b64encode(picture.read_bytes()).decode('ascii')}"


def provenance(content: Mapping[str, Any]) -> list[tuple[str, str]]:
    """What made a result, from what its JSON file says of it."""
    versions = content.get("versions")
    libraries = versions.items() if isinstance(versions, dict) else ()
    known = {
        "gyroctl": content.get("gyroctl_version"),
        "Date": content.get("date"),
        "Command": content.get("command"),
        "Libraries": ", ".join(f"{name} {version}" for name, version in libraries),
        "Platform": content.get("platform"),
        "Commit": content.get("commit"),
    }
    return [(name, str(value)) for name, value in known.items() if value]
