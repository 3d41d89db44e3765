"""Names from outside: refused where they hide something or lead elsewhere, and written so that they stay text.

A name becomes a path in `file_in` alone. It becomes markup in `in_markup` (HTML, SVG, plotly), `in_cell` (CSV) and
`in_table` (markdown).
"""

from __future__ import annotations

import html
import re
import unicodedata
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from gyroctl.errors import InputError

LONGEST, LONGEST_NAME = 400, 100
"""Characters of a text that is typed, and of a name; bytes of a part of a path, which leaves room for what follows."""

HIDDEN = ("Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp")
"""Categories of Unicode: control, format, surrogate, private, not assigned, separators of lines and paragraphs."""

DEVICES = {"CON", "PRN", "AUX", "NUL", "CONIN$", "CONOUT$"}
DEVICES |= {f"{port}{number}" for port in ("COM", "LPT") for number in "0123456789\xb9\xb2\xb3"}
"""What Windows takes for a device in any folder, whatever follows behind a dot."""

TAG = re.compile(r"<(?=[A-Za-z/!?])")
"""What may begin HTML; "< 0.01" does not."""

FORMULA = re.compile(r"[\t\r\n]|\s*[=+\-@＝＋－＠]")
"""What a spreadsheet may take for the beginning of a formula; some leave out blanks, and know the wide signs too."""

ALIKE_LETTERS = str.maketrans(
    "АВЕЅІЈКМНОРСТУХасԁеһіјӏорԛѕуԝхΑΒΕΖΗΙΚΜΝΟΡΤΥΧο", "ABESIJKMHOPCTYXacdehijlopqsywxABEZHIKMNOPTYXo"
)
"""Cyrillic and Greek letters, and the Latin ones that they cannot be told from."""

NEAR, ALIKE = 3, 0.6
"""Most names that are offered for an unknown one, and how alike they must be, from 0 to 1."""

PLAIN = "Give a name of letters, digits, spaces, -, _ and single dots"


def text_of(field: str, value: Any, longest: int = LONGEST) -> str:
    """Return a text of one line in which nothing is hidden.

    Raises
    ------
    InputError
        Field `field`: no text, an empty or overlong one, or one with characters that control, format or are none:
        C0 and C1, directions, zero widths, separators of lines, surrogates.
    """
    if not isinstance(value, str) or not value.strip():
        raise InputError(field, value, "is no name", PLAIN)
    if len(value) > longest:
        raise InputError(field, f"{value[:40]}...", f"is longer than {longest} characters", PLAIN)
    hidden = [sign for sign in value if unicodedata.category(sign) in HIDDEN]
    if hidden:
        problem = f"has a character that cannot be seen, U+{ord(hidden[0]):04X}"
        raise InputError(field, value, problem, PLAIN)
    return value


def name_of(field: str, value: Any) -> str:
    """Return a name that is a part of no path but itself.

    Raises
    ------
    InputError
        Field `field`: what `text_of` refuses, a path, a device of Windows, a dot or a space at an end.
    """
    name = text_of(field, value, LONGEST_NAME)
    if "/" in name or "\\" in name or name[1:2] == ":" or ".." in name:
        raise InputError(field, name, "is a path", PLAIN)
    if name != name.strip() or name.endswith("."):
        raise InputError(field, name, "ends with a dot, or has a space at an end", PLAIN)
    if name.partition(".")[0].rstrip().upper() in DEVICES:
        raise InputError(field, name, "is a device on Windows", PLAIN)
    return name


def check_apart(field: str, names: Iterable[str], known: Iterable[str] = ()) -> None:
    """Refuse a name whose words mix letters of two scripts that look alike, or that looks like another name.

    Parameters
    ----------
    field : str
        Named by an error.
    names : iterable of str
        Names that are given; each may be one of the `known` ones.
    known : iterable of str
        Names that there are.

    Raises
    ------
    InputError
        Field `field`.
    """
    seen = {looks(name): name for name in known}
    for name in names:
        foreign = _mixed(name)
        if foreign:
            problem = f"has {foreign!r}, {unicodedata.name(foreign)}, in a word of Latin letters, and looks like them"
            raise InputError(field, name, problem, "Write each word in one alphabet")
        like = seen.setdefault(looks(name), name)
        if like != name:
            codes = " ".join(f"U+{ord(sign):04X}" for sign in name if not sign.isascii()) or "ASCII"
            problem = f"looks like the name {like!r}, and has other letters ({codes})"
            raise InputError(field, name, problem, "Give it a name that can be told from the other")


def looks(name: str) -> str:
    """Latin letters that a name looks like: of wide and mathematical forms, of Cyrillic and Greek ones alike."""
    return unicodedata.normalize("NFKC", name).translate(ALIKE_LETTERS)


def _mixed(name: str) -> str:
    """Return the first letter of a word of Latin ones that is none and looks like one; empty where there is none."""
    words: list[str] = re.findall(r"[^\W\d_]+", unicodedata.normalize("NFKC", name))
    for word in words:
        latin = any("LATIN" in unicodedata.name(sign, "") for sign in word)
        foreign: list[str] = [
            sign for sign in word if ord(sign) in ALIKE_LETTERS or "CYRILLIC" in unicodedata.name(sign, "")
        ]
        if latin and foreign:
            return foreign[0]
    return ""


def part_of_path(field: str, value: Any) -> str:
    """Return a name that can be that of a file on every system.

    Raises
    ------
    InputError
        Field `field`: what `name_of` refuses, a sign that names of files cannot have, or too many bytes.
    """
    name = name_of(field, value)
    wrong = [sign for sign in name if sign in '<>:"|?*']
    if wrong:
        raise InputError(field, name, f"has {wrong[0]}, which the name of a file cannot have", PLAIN)
    if len(name.encode()) > LONGEST_NAME:
        raise InputError(field, name, f"is longer than {LONGEST_NAME} bytes", PLAIN)
    return name


def file_in(folder: Path, *parts: str, ending: str) -> Path:
    """Path of a file in a folder, named by parts with dots between: the one way from a name to a path."""
    return folder / (".".join(part_of_path("name", part) for part in parts) + ending)


def in_markup(text: str) -> str:
    """Text as HTML and SVG write it, of which plotly's templates take nothing for their own either."""
    return html.escape(text).replace("%{", "%&#123;")


def in_cell(value: Any) -> Any:
    """Value of a cell of CSV that no spreadsheet takes for a formula: such a text begins with an apostrophe."""
    if isinstance(value, str) and FORMULA.match(value) and not _is_number(value):
        return f"'{value}"
    return value


def in_table(text: str) -> str:
    """Text as a cell of a table in markdown, where it is neither a border nor HTML."""
    return TAG.sub("&lt;", text.replace("|", "\\|"))


def choice_of(name: str, known: Iterable[str]) -> str:
    """Tell what there is to choose from in place of a name that is unknown, the nearest ones before the rest."""
    among = list(known)
    near = nearest(name, among)
    meant = f"Perhaps {' or '.join(near)} is meant. " if near else ""
    return f"{meant}Choose one of {', '.join(among) or 'none'}"


def nearest(name: str, known: Iterable[str]) -> list[str]:
    """Names that are nearest to one that is unknown: of the same letters, or else the most alike; few, or none."""
    from difflib import SequenceMatcher

    folded = {each: each.lower() for each in known}
    turned = [each for each, small in folded.items() if sorted(small) == sorted(name.lower())]
    if turned:
        return turned[:NEAR]
    alike = {each: SequenceMatcher(None, name.lower(), small).ratio() for each, small in folded.items()}
    best = max(alike.values(), default=0.0)
    return [each for each, ratio in alike.items() if ratio == best >= ALIKE][:NEAR]


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
