"""What every page of the project has: one template, its words, a list of contents, and nothing from a network."""

from __future__ import annotations

import base64
import re
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyroctl.palette import GRID, INK, MUTED
from gyroctl.plots.style import AXIS
from gyroctl.reports import wording
from gyroctl.reports.resting import in_words
from gyroctl.reports.theme import DARK

if TYPE_CHECKING:
    from jinja2 import Environment

CONTENTS = "<!-- contents -->"
"""Where the list of contents goes: after the sections are known."""

PICTURE_MAX = 3_000_000
"""Size of a picture beyond which a page goes without it. [bytes]"""

DRAWN_MAX = 500_000
"""Size beyond which a picture is shown as points: a map of thousands of cells. [bytes]"""

PER_DOT = 72.0 / 160.0 * 1.15
"""Pixels of a page for a dot of a PNG: pictures have 160 dots an inch, and small type is enlarged a little."""

LEAST, MOST = 640, 1600
"""Widths of a picture. [px]"""

CARD = "#FFFFFF"
"""What pictures are drawn on."""

IN_THE_DARK = {INK: DARK.ink, MUTED: DARK.muted, GRID: DARK.grid, AXIS: DARK.axis}
"""Colours of a picture, and what they are on a dark page."""

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
    """Address that holds a picture itself, empty where there is none.

    The drawing (SVG) beside a PNG is taken, unless it is large: it is sharp at every size and follows the page into the
    dark. As an image it can neither run nor load anything, whoever wrote the file.

    Parameters
    ----------
    picture : Path
        PNG file.
    """
    drawn = picture.with_suffix(".svg")
    if drawn.is_file() and drawn.stat().st_size <= DRAWN_MAX:
        text = for_the_dark(drawn.read_text(encoding="utf-8", errors="replace"))
        return f"data:image/svg+xml;base64,{base64.b64encode(text.encode()).decode('ascii')}"
    if not picture.is_file() or picture.stat().st_size > PICTURE_MAX:
        return ""
    return f"data:image/png;base64,{base64.b64encode(picture.read_bytes()).decode('ascii')}"


def width_of(picture: Path) -> int:
    """Width at which the words of a picture have the size that they were drawn in, or a usual one. [px]

    Parameters
    ----------
    picture : Path
        PNG file, with or without a drawing beside it.
    """
    with suppress(OSError):
        with picture.open("rb") as file:
            head = file.read(24)
        if head[12:16] == b"IHDR":
            return min(max(round(int.from_bytes(head[16:20], "big") * PER_DOT), LEAST), MOST)
    return LEAST


def for_the_dark(drawn: str) -> str:
    """SVG of matplotlib that takes the colours of a dark page where the page is dark.

    White is that of the page where it is an area; white numbers on coloured cells stay white.
    """
    rules = [
        f'[style*="{what}: {light.lower()}"]{{{what}:{dark}!important}}'
        for light, dark in IN_THE_DARK.items()
        for what in ("fill", "stroke")
    ]
    rules.append(f'path[style*="fill: {CARD.lower()}"]{{fill:{DARK.card}!important}}')
    style = f"<style>@media screen and (prefers-color-scheme: dark){{{''.join(rules)}}}</style>"
    return re.sub(r"<svg\b[^>]*>", lambda found: found.group() + style, drawn, count=1)


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
