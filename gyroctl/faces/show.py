"""The face of an object as text and as HTML: title, facts, and a picture that is drawn only where it is seen."""

from __future__ import annotations

import html
import textwrap
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, TypeVar

from gyroctl.errors import visible

T = TypeVar("T", bound=type[Any])

WIDTH, LINES = 100, 5
"""Most characters of a line of a repr, and most lines."""

LONGEST = 160
"""Most characters of a title, and of a fact."""

STYLE = (
    "display:flex;flex-wrap:wrap;gap:0 1.5em;align-items:center;border:1px solid;border-color:rgba(127,127,127,.4);"
    "border-radius:6px;padding:.5em .9em;margin:.2em 0;font-size:.9em;line-height:1.35;width:fit-content"
)


class Face(NamedTuple):
    """What is shown of an object."""

    title: str
    facts: Sequence[tuple[str, str]]  # name and value with its unit
    picture: Callable[[], str] = str  # inline SVG


def shown(face: Callable[[Any], Face]) -> Callable[[T], T]:
    """Give a class the repr and the HTML repr that a function tells of its objects."""

    def give(kind: T) -> T:
        def text(self: Any) -> str:
            return as_text(_face(self))

        def markup(self: Any) -> str:
            return as_html(_face(self))

        def _face(self: Any) -> Face:
            try:
                return face(self)
            except Exception as error:  # a repr that raises hides what one wanted to see
                return Face(type(self).__name__, [("cannot be shown", f"{type(error).__name__}: {error}")])

        own: Any = kind
        own.__repr__, own._repr_html_ = text, markup
        return kind

    return give


def pictured(face: Callable[[Any], Face]) -> Callable[[T], T]:
    """Give a class the HTML repr alone: its repr is short, and builds it again."""

    def give(kind: T) -> T:
        own: Any = kind
        plain = own.__repr__
        shown(face)(own)
        own.__repr__ = plain
        return kind

    return give


def as_text(face: Face) -> str:
    """At most `LINES` lines: title, then the facts."""
    facts = "; ".join(f"{_plain(name)} {_plain(value)}" for name, value in face.facts)
    lines = textwrap.wrap(facts, WIDTH - 2, break_on_hyphens=False)
    if len(lines) > LINES - 1:
        lines = [*lines[: LINES - 2], f"{lines[LINES - 2][: WIDTH - 4]} …"]
    return "\n".join([f"<{_plain(face.title)}", *(f"  {line}" for line in lines)])[: WIDTH * LINES] + ">"


def as_html(face: Face) -> str:
    """Return a card: title, table of the facts, picture; all text escaped, nothing fetched."""
    rows = "".join(
        f'<tr><th scope="row" style="text-align:left;font-weight:400;opacity:.75;padding:0 1em 0 0">{_safe(name)}</th>'
        f'<td style="text-align:left;padding:0">{_safe(value)}</td></tr>'
        for name, value in face.facts
    )
    table = f'<table style="border:0;margin:.2em 0"><tbody>{rows}</tbody></table>' if rows else ""
    try:
        picture = face.picture()
    except Exception:  # a card without its picture still tells the facts
        picture = ""
    return f'<div class="gyroctl" style="{STYLE}"><div><strong>{_safe(face.title)}</strong>{table}</div>{picture}</div>'


def number(value: Any, unit: str = "", digits: int = 4) -> str:
    """A number to some digits with its unit."""
    try:
        return f"{float(value):.{digits}g} {unit}".rstrip()
    except (TypeError, ValueError, OverflowError):
        return f"{value} {unit}".rstrip()


def _plain(text: Any) -> str:
    line = visible(" ".join(str(text).split()))
    return line if len(line) <= LONGEST else f"{line[: LONGEST - 2]} …"


def _safe(text: Any) -> str:
    return html.escape(_plain(text))
