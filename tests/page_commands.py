"""What the pages tell to type: commands of blocks, of the README's table and within sentences, found by a parser.

A block is fenced or indented by four columns. In a block that is in no other language every line that begins with a
program that we know is a command; a page that is added is read like the others.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]

FENCE = re.compile(r"^(?P<indent> *)(?P<mark>`{3,}|~{3,}) *(?P<language>[\w{}-]*)")
LANGUAGES = {"", "sh", "bash", "shell", "console", "text"}
"""Of blocks that may hold commands; the others hold programs and tables."""

PROGRAMS = re.compile(r"^(?:\$ )?(?:\S*/)?(?:gyroctl|python3?|pip|pytest|make|dask|kubectl|git|ruff|mypy)\b")
SPAN = re.compile(r"`(gyroctl(?: [^`]*)?)`")


@dataclass(frozen=True)
class Typed:
    """A command and where it stands.

    Parameters
    ----------
    page : str
        Path of the page from the top of the checkout.
    line : int
        Its line there.
    words : tuple of str
        The command, without what is behind a # or beside it in the line.
    """

    page: str
    line: int
    words: tuple[str, ...]

    @property
    def text(self) -> str:
        """The command as one would type it."""
        return shlex.join(self.words)


def pages() -> list[Path]:
    """Every page for readers; what is written from results alone tells commands of the past."""
    return [*(ROOT / name for name in ("README.md", "CONTRIBUTING.md")), *sorted((ROOT / "docs").glob("*.md"))]


def block_lines(text: str) -> Iterator[tuple[int, str]]:
    """Lines of blocks that may hold commands, with their numbers from 1."""
    fence, language, before = "", "", ""
    for number, line in enumerate(text.splitlines(), 1):
        found = FENCE.match(line)
        if fence:
            if found and line.strip().startswith(fence) and not found["language"]:
                fence = ""
            elif language in LANGUAGES:
                yield number, line.strip()
        elif found:
            fence, language = found["mark"], found["language"]
        elif line.startswith("    ") and not _continues(before):
            yield number, line.strip()
        if line.strip():
            before = line if not line.startswith("    ") else before


def _continues(before: str) -> bool:
    """Whether an indented line belongs to an item of a list rather than to a block of its own."""
    return bool(re.match(r"\s*(?:[-*+]|\d+\.)\s", before))


def commands(text: str, page: str = "") -> list[Typed]:
    """Commands of the blocks of a page."""
    found, begun, first = [], "", 0
    for number, line in block_lines(text):
        first = first if begun else number
        begun += line.removeprefix("$ ") if not begun else f" {line}"
        if begun.endswith("\\"):
            begun = begun[:-1].rstrip()
            continue
        if PROGRAMS.match(begun):
            found += [Typed(page, first, words) for words in _split(begun)]
        begun = ""
    return found


def _split(line: str) -> list[tuple[str, ...]]:
    """Commands of a line, which may be joined by &&, ; or &."""
    lexer = shlex.shlex(line, posix=True, punctuation_chars="&;|")
    lexer.whitespace_split = True
    parts: list[list[str]] = [[]]
    for word in lexer:
        if set(word) <= set("&;|"):
            parts.append([])
        else:
            parts[-1].append(word)
    return [tuple(part) for part in parts if part]


def rows(text: str, page: str = "") -> list[Typed]:
    """Commands in the first column of tables."""
    found = []
    for number, line in enumerate(text.splitlines(), 1):
        if line.startswith("| `"):
            told = [span for span in SPAN.findall(line.split(" | ")[0]) if " " in span]
            found += [Typed(page, number, tuple(shlex.split(span))) for span in told]
    return found


def spans(text: str, page: str = "") -> list[Typed]:
    """Commands within sentences; several may stand in one, with commas between."""
    found = []
    for number, line in enumerate(text.splitlines(), 1):
        for span in SPAN.findall(line):
            for part in re.split(r", (?=gyroctl )", span):
                found.append(Typed(page, number, tuple(shlex.split(part))))
    return found


def is_ours(typed: Typed) -> bool:
    """Whether it is a command of gyroctl."""
    return typed.words[0].rpartition("/")[2] == "gyroctl"


def all_commands() -> list[Typed]:
    """Commands of the blocks of all pages, and of the README's and the pages' tables of commands."""
    found = []
    for path in pages():
        name, text = path.relative_to(ROOT).as_posix(), path.read_text(encoding="utf-8")
        found += [*commands(text, name), *rows(text, name)]
    return found


def all_spans() -> list[Typed]:
    """Commands within the sentences of all pages, the changelog and the results as well."""
    found = []
    for path in [*pages(), ROOT / "CHANGELOG.md", *sorted((ROOT / "docs" / "results").glob("*.md"))]:
        found += spans(path.read_text(encoding="utf-8"), path.relative_to(ROOT).as_posix())
    return found
