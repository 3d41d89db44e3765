"""Write the figures of the pages from the committed results: the blocks between ``results: NAME`` and ``end``.

``python docs/write_results.py`` writes the pages and draws the pictures anew where their results have changed;
``--check`` writes nothing and names what differs. What makes the results: ``docs/run_results.py``.
"""

from __future__ import annotations

import argparse
import difflib
import hashlib
import os
import re
import shlex
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from result_blocks import benchmarks, bounds, evaluations, margins, physics, pictures, real, scale, seas, speed, studies
from result_blocks.source import HERE, ROOT, Missing, result, table
from run_results import RUNS

BLOCKS: Mapping[str, Callable[[], str]] = {
    **seas.BLOCKS,
    **evaluations.BLOCKS,
    **physics.BLOCKS,
    **real.BLOCKS,
    **bounds.BLOCKS,
    **margins.BLOCKS,
    **studies.BLOCKS,
    **benchmarks.BLOCKS,
    **speed.BLOCKS,
    **scale.BLOCKS,
}
"""What the pages may show, by name."""

BLOCK = re.compile(r"<!-- results: (?P<name>[\w-]+) -->\n(?P<text>.*?)<!-- end -->", re.DOTALL)


def pages(root: Path = ROOT) -> list[Path]:
    """Pages that may hold blocks: the first page and those of docs."""
    return [root / "README.md", *sorted((root / "docs").glob("*.md"))]


def blocks_of(page: str) -> dict[str, str]:
    """Blocks of a page by name, as they stand there."""
    return {match["name"]: match["text"] for match in BLOCK.finditer(page)}


def block(name: str, folder: str = "docs") -> str:
    """Text of a block on a page in that folder, as it stands between its marks.

    Raises
    ------
    KeyError
        For a name that is none.
    """
    way = Path(os.path.relpath(ROOT / "docs" / "results", ROOT / folder)).as_posix()
    return "\n" + _made(BLOCKS[name]).replace(HERE, "" if way == "." else f"{way}/") + "\n\n"


def _made(make: Callable[[], str]) -> str:
    """A text from results, or that one of them is not kept yet and what makes it."""
    try:
        return make()
    except Missing as missing:
        return f"*Not run yet: `python docs/run_results.py {missing.args[0]}`.*"


def filled(page: str, folder: str = "docs") -> str:
    """A page with each of its blocks as it should be."""
    return BLOCK.sub(lambda m: f"<!-- results: {m['name']} -->\n{block(m['name'], folder)}<!-- end -->", page)


def whole_pages() -> dict[str, str]:
    """Pages that hold nothing but results, by path."""
    made = {path: f"{_made(make)}\n" for path, make in {**evaluations.PAGES, **physics.PAGES}.items()}
    found = {path: text if text.startswith("# ") else f"# {_title(path)}\n\n{text}" for path, text in made.items()}
    found = {path: text.replace(HERE, "") for path, text in found.items()}
    return {**found, "docs/results/README.md": index()}


def _title(path: str) -> str:
    """Title of a page whose results are not kept yet."""
    return f"{Path(path).stem.capitalize()} in full"


def index() -> str:
    """Where each figure stands and what makes it: the page of docs/results."""
    blocks = []
    for path in pages():
        for name in blocks_of(path.read_text(encoding="utf-8")):
            sources = re.findall(r"\[([\w.]+\.json)\]|`([\w/]+\.json)`", _made(BLOCKS[name]) if name in BLOCKS else "")
            told = ", ".join(f"`{kept or other}`" for kept, other in dict.fromkeys(sources))
            blocks.append([f"`{path.relative_to(ROOT).as_posix()}`", f"`{name}`", told])
    made = []
    for name, run in RUNS.items():
        made.append([f"`{name}`", f"`{run.command}`", run.takes, _stands(name, run.command)])
    pictures_ = [[f"`{name}`", f"`{Path(one.source).name}`"] for name, one in pictures.PICTURES.items()]
    return "\n\n".join(
        [
            "# Results",
            "What the pages show, and by what it was made. A command of a result writes its report, "
            "`python docs/run_results.py NAME` runs it and keeps here what the pages show, and "
            "`python docs/write_results.py` writes blocks, pages and pictures from that; "
            "`tests/test_docs_results.py` compares them. Seeds that are in reserve are marked spent in the "
            "[ledger](../../gyroctl/data/seeds.toml) by a commit after the run.",
            table(("result", "command", "takes on two cores", "made by"), made, 4),
            table(("page", "block", "from"), blocks, 3),
            table(("picture", "from"), pictures_, 2) + "\n",
        ]
    )


def _stands(name: str, wanted: str) -> str:
    """Whether a result was made by its command, and when; else by which."""
    try:
        found = result(name)
    except Missing:
        return "not run yet"
    now = re.sub(r" --out \S+", "", found["command"])
    return f"this command, {found['date']}" if now == plain_command(wanted) else f"`{now}`, {found['date']}"


def plain_command(command: str) -> str:
    """A command as a report writes it: words with a space in them in quotes, others without."""
    words = shlex.split(command)
    return " ".join(f'"{word}"' if " " in word else word for word in words)


def differing(root: Path = ROOT) -> list[str]:
    """What does not say what the results say: ``docs/nmpc.md, nmpc-time``, with the first line that differs."""
    found = []
    for path in pages(root):
        where = path.relative_to(root)
        for name, text in blocks_of(path.read_text(encoding="utf-8")).items():
            if name not in BLOCKS:
                found.append(f"{where}, {name}: there is no such block")
            elif text != (wanted := block(name, str(where.parent))):
                found.append(f"{where}, {name}: {_first_difference(text, wanted)}")
    for name, wanted in whole_pages().items():
        path = root / name
        text = path.read_text(encoding="utf-8") if path.is_file() else ""
        if text != wanted:
            found.append(f"{name}: {_first_difference(text, wanted)}")
    return [
        *found,
        *(f"{name}: drawn from other results" for name in pictures.PICTURES if not _drawn(root / name, name)),
    ]


def _first_difference(text: str, wanted: str) -> str:
    lines = difflib.ndiff(text.splitlines(), wanted.splitlines())
    return "; ".join([line for line in lines if line[:1] in "+-"][:2]) or "blank lines"


def _key(name: str) -> str:
    """What a picture is drawn from, and the code that draws it: a new colour is a new picture."""
    picture = pictures.PICTURES[name]
    files = (picture.source, picture.code, *pictures.LOOK)
    return hashlib.sha256(b"".join((ROOT / file).read_bytes() for file in files)).hexdigest()


def _drawn(path: Path, name: str) -> bool:
    """Whether a picture shows its results; one whose results are not kept yet has nothing to show."""
    if not (ROOT / pictures.PICTURES[name].source).is_file():
        return True
    return path.is_file() and pictures.key_of(path) == _key(name)


def write(root: Path = ROOT) -> list[str]:
    """Fill the blocks of all pages, write the pages that are nothing but results, draw the pictures."""
    changed = []
    for path in pages(root):
        text = path.read_text(encoding="utf-8")
        new = filled(text, str(path.relative_to(root).parent))
        if new != text:
            path.write_text(new, encoding="utf-8", newline="\n")
            changed.append(path.name)
    for name, text in whole_pages().items():
        path = root / name
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8", newline="\n")
            changed.append(name)
    for name, picture in pictures.PICTURES.items():
        if not _drawn(root / name, name):
            picture.draw(root / name, _key(name))
            changed.append(name)
    return changed


def main(arguments: Sequence[str] | None = None) -> int:
    """Read the arguments; write, or check."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="write nothing, name what differs")
    if not parser.parse_args(arguments).check:
        print("\n".join(write()) or "nothing has changed")
        return 0
    found = differing()
    print("\n".join(found) or "every page says what the results say")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
