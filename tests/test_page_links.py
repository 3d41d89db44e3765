"""Links of the pages: files and headings that they lead to exist; those to other hosts are of an allowed form."""

from __future__ import annotations

import ast
import os
import re
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest
import site_links
from markdown_it import MarkdownIt
from markdown_it.token import Token
from public_names import Name

ROOT = Path(__file__).parents[1]
FOLDERS = ("docs", "docs/results")
TOP = ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")
MADE = ("docs/reference/", "docs/figures/")
"""Pages that the build of the site makes."""


def pages() -> list[Path]:
    return [
        *(ROOT / name for name in TOP),
        *(page for folder in FOLDERS for page in sorted((ROOT / folder).glob("*.md"))),
    ]


def tokens(text: str) -> Iterator[Token]:
    for token in MarkdownIt("commonmark").enable("table").parse(text):
        yield token
        yield from token.children or ()


def links(text: str) -> list[str]:
    """Addresses of links and pictures of a page."""
    found = [str(token.attrs.get("href") or token.attrs.get("src") or "") for token in tokens(text)]
    return [address for address in found if address]


def slug(heading: str) -> str:
    """Name of a heading in a link, as GitHub and the site make it."""
    plain = re.sub(r"[`*_]{1,2}(?=\S)|(?<=\S)[`*]{1,2}", "", heading)
    return re.sub(r"[^\w\- ]", "", plain.lower()).replace(" ", "-")


def places(text: str) -> set[str]:
    """Headings of a page that can be linked to."""
    found, heading = set(), False
    for token in tokens(text):
        if heading and token.type == "inline":
            words = "".join(part.content for part in token.children or () if part.type in ("text", "code_inline"))
            name, n = slug(words), 0
            while (name if not n else f"{name}-{n}") in found:
                n += 1
            found.add(name if not n else f"{name}-{n}")
        heading = token.type == "heading_open"
    return found


def dead(page: Path, address: str, root: Path = ROOT) -> str:
    """Why a link leads nowhere, or an empty text."""
    parts = urlsplit(address)
    if parts.scheme or parts.netloc:
        return "" if parts.scheme == "https" and parts.netloc else "no address of the form https://"
    target = (page.parent / unquote(parts.path)).resolve() if parts.path else page
    if any(target.is_relative_to(root / made) for made in MADE):
        return ""  # checked on the site itself
    if not target.exists():
        return "there is no such file"
    if parts.fragment and parts.fragment not in places(target.read_text(encoding="utf-8")):
        return "there is no such heading"
    return ""


@pytest.mark.parametrize("page", pages(), ids=lambda page: page.relative_to(ROOT).as_posix())
def test_links_of_a_page_lead_somewhere(page: Path) -> None:
    found = {address: dead(page, address) for address in links(page.read_text(encoding="utf-8"))}
    assert {address: why for address, why in found.items() if why} == {}


def test_every_page_is_in_the_site() -> None:
    """In one list of contents, or it would be found by nobody."""
    listed: set[Path] = set()
    for page in (ROOT / "docs").glob("*.md"):
        text = page.read_text(encoding="utf-8")
        for block in re.findall(r"^```\{toctree\}\n(.*?)^```", text, re.MULTILINE | re.DOTALL):
            for line in block.splitlines():
                entry = re.sub(r".*<(.*)>$", r"\1", line.strip())
                if entry and not entry.startswith(":"):
                    target = Path(os.path.normpath(page.parent / entry))
                    listed |= set(target.parent.glob(f"{target.name}.md"))
    assert set(pages()) - listed == {ROOT / "docs" / "index.md"}


def test_dead_links_are_found(tmp_path: Path) -> None:
    (tmp_path / "other.md").write_text("# Other page\n\n## It's `here`, in 2 parts\n\n## Twice\n\n## Twice\n")
    page = tmp_path / "page.md"
    page.write_text(
        "[a](other.md#its-here-in-2-parts) [b](other.md#twice-1) [c](none.md) ![d](none.png) `[e](code.md)`\n"
    )
    assert links(page.read_text()) == ["other.md#its-here-in-2-parts", "other.md#twice-1", "none.md", "none.png"]
    assert dead(page, "other.md#its-here-in-2-parts", tmp_path) == dead(page, "other.md#twice-1", tmp_path) == ""
    assert dead(page, "other.md#nowhere", tmp_path) == "there is no such heading"
    assert dead(page, "none.md", tmp_path) == "there is no such file"
    assert dead(page, "http://example.org", tmp_path) == "no address of the form https://"


# --- the check of the built site ---------------------------------------------------------------------------------

SOUND = {
    "index.html": '<a href="a/b.html#here">x</a><img src="p.png"><a href="https://example.org">out</a>'
    '<a href="#top">t</a><h1 id="top"></h1><link rel="canonical" href="https://example.org/">',
    "a/b.html": '<p id="here"></p><a href="../index.html?v=1">back</a><link rel="stylesheet" href="../s.css">',
    "p.png": "",
    "s.css": "body { background: url(p.png) }",
}


def site(folder: Path, changes: dict[str, str]) -> tuple[list[str], list[str], int]:
    for name, text in {**SOUND, **changes}.items():
        path = folder / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
    return site_links.faults(folder)


def test_sound_site_has_no_fault(tmp_path: Path) -> None:
    assert site(tmp_path, {}) == ([], ["https://example.org"], 5)


@pytest.mark.parametrize(
    ("name", "text", "fault"),
    [
        ("a/b.html", '<a href="../none.html">x</a><p id="here">', "a/b.html: ../none.html: there is no such file"),
        ("a/b.html", "<p>", "index.html: a/b.html#here: there is no such place on that page"),
        (
            "c.html",
            '<script src="https://cdn.example/x.js"></script>',
            "c.html: fetches https://cdn.example/x.js from another host",
        ),
        ("c.html", '<link rel="preload" href="//cdn.example/f">', "c.html: fetches //cdn.example/f from another host"),
        (
            "c.html",
            '<img srcset="https://cdn.example/i 2x">',
            "c.html: fetches https://cdn.example/i from another host",
        ),
        (
            "c.html",
            "<style>@import 'https://cdn.example/c';</style>",
            "c.html: fetches https://cdn.example/c from another host",
        ),
        (
            "s.css",
            "@font-face { src: url('https://f.example/f') }",
            "s.css: fetches https://f.example/f from another host",
        ),
    ],
)
def test_fault_of_a_site_is_found(tmp_path: Path, name: str, text: str, fault: str) -> None:
    assert site(tmp_path, {name: text})[0] == [fault]


PAGE = (
    '<dt id="gyroctl.Regular"><a href="../m.html"><span class="viewcode-link">[source]</span></a></dt>'
    "<dt><strong>height</strong></dt><dt><strong>wp, heading</strong></dt>"
)


def test_name_that_the_reference_does_not_show_whole_is_found() -> None:
    site_reference, name = pytest.importorskip("site_reference"), Name("gyroctl", "Regular", "gyroctl.waves.regular")
    assert site_reference.lacking(name, PAGE) == []
    assert site_reference.lacking(name, PAGE.replace("height", "width")) == ["height"]
    assert site_reference.lacking(name, PAGE.replace("viewcode", "no")) == ["its source"]
    assert site_reference.lacking(name, PAGE.replace("Regular", "Other")) == ["itself"]


@pytest.mark.parametrize(
    ("link", "mended"),
    [
        ("names/gyroctl.a.b.It.html#gyroctl.a.It.do", "names/gyroctl.a.b.It.html#gyroctl.a.b.It.do"),
        ("names/gyroctl.a.It.html#gyroctl.a.It.do", "names/gyroctl.a.It.html#gyroctl.a.It.do"),
        ("names/gyroctl.it.it.html#gyroctl.it.it", "names/gyroctl.it.it.html#gyroctl.it.it"),
    ],
)
def test_sources_lead_back_to_the_place_that_is_there(link: str, mended: str) -> None:
    build_site = pytest.importorskip("build_site")
    assert build_site.LINK_BACK.sub(build_site._back, link) == mended


def test_messages_name_pages_by_their_titles() -> None:
    """A reader of the site has no file of that name."""
    titles = {page.read_text(encoding="utf-8").partition("\n")[0].removeprefix("# ") for page in pages()}
    named = set()
    for folder in ("gyroctl", "studies", "controllers"):
        for file in sorted((ROOT / folder).rglob("*.py")):
            tree = ast.parse(file.read_text(encoding="utf-8"))
            told = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}  # docstrings
            for node in ast.walk(tree):
                if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in told:
                    assert not re.search(r"docs/\w+\.md", node.value), (file, node.value)
                    named |= set(re.findall(r'the page "([^"]+)"', node.value))
    assert named and named <= titles
