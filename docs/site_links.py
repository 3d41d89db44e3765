"""Links of the built site: every one within it leads to a file and a place that exist, and no page asks another host.

``python docs/site_links.py build/site`` prints what is broken and how many links of each kind there are. Links that a
reader may follow to other hosts are listed, not requested.
"""

from __future__ import annotations

import posixpath
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

FETCHED = {"link": "href", "script": "src", "img": "src", "source": "src", "iframe": "src", "object": "data"}
"""Elements that make a browser fetch something when the page is opened, and the attribute that says what."""

SILENT = {"canonical", "next", "prev", "author", "alternate"}
"""Relations of a ``link`` that fetch nothing."""

IN_STYLE = re.compile(r"""url\(\s*['"]?(?P<address>[^'")]+)|@import\s+['"](?P<sheet>[^'"]+)""")


@dataclass
class Page:
    """What a page holds: places that can be linked to, links to follow, files that it fetches."""

    places: set[str] = field(default_factory=set)
    links: list[str] = field(default_factory=list)
    fetched: list[str] = field(default_factory=list)


class _Reader(HTMLParser):
    """Collects them."""

    def __init__(self) -> None:
        super().__init__()
        self.page = Page()
        self.styles = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attrs}
        self.page.places |= {given[name] for name in ("id", "name") if name in given}
        self.styles = tag == "style"
        if tag == "a" and "href" in given:
            self.page.links.append(given["href"])
        elif tag in FETCHED and FETCHED[tag] in given and not set(given.get("rel", "").split()) & SILENT:
            self.page.fetched.append(given[FETCHED[tag]])
        self.page.fetched += [part.split()[0] for part in given.get("srcset", "").split(",") if part.strip()]
        self.page.fetched += addresses(given.get("style", ""))

    def handle_data(self, data: str) -> None:
        if self.styles:
            self.page.fetched += addresses(data)

    def handle_endtag(self, tag: str) -> None:
        self.styles = False


def addresses(style: str) -> Iterator[str]:
    """Addresses that a style sheet fetches."""
    return (found["address"] or found["sheet"] for found in IN_STYLE.finditer(style))


def read(html: str) -> Page:
    """Read a page."""
    reader = _Reader()
    reader.feed(html)
    return reader.page


def outside(address: str) -> bool:
    """Whether an address is on another host."""
    parts = urlsplit(address)
    return bool(parts.netloc) or parts.scheme in ("http", "https", "ftp")


def faults(site: Path) -> tuple[list[str], list[str], int]:
    """Check the site in the folder `site`.

    Returns
    -------
    tuple of list of str, list of str and int
        What is broken, each with the page that says it; the links to other hosts; the number of links within the site.
    """
    files = {path.relative_to(site).as_posix() for path in site.rglob("*") if path.is_file()}
    named = [name for name in sorted(files) if name.endswith(".html") and not name.startswith("_static/")]  # templates
    pages = {name: read((site / name).read_text(encoding="utf-8")) for name in named}
    broken, away, inside = [], set(), 0
    for name, page in pages.items():
        for address in page.links + page.fetched:
            if outside(address):
                if address in page.fetched:
                    broken.append(f"{name}: fetches {address} from another host")
                else:
                    away.add(address)
                continue
            if urlsplit(address).scheme:  # data:, mailto:
                continue
            inside += 1
            if why := _dead(name, address, files, pages):
                broken.append(f"{name}: {address}: {why}")
    for sheet in sorted(site.rglob("*.css")):
        broken += [
            f"{sheet.relative_to(site)}: fetches {address} from another host"
            for address in addresses(sheet.read_text(encoding="utf-8"))
            if outside(address)
        ]
    return broken, sorted(away), inside


def _dead(page: str, address: str, files: set[str], pages: dict[str, Page]) -> str:
    """Why a link within the site leads nowhere, or an empty text."""
    parts = urlsplit(address)
    target = posixpath.normpath(posixpath.join(posixpath.dirname(page), unquote(parts.path))) if parts.path else page
    if target not in files:
        return "there is no such file"
    place = unquote(parts.fragment)
    if place and target in pages and place not in pages[target].places:
        return "there is no such place on that page"
    return ""


def main(site: Path) -> int:
    """Print what was found; 1 where something is broken."""
    broken, away, inside = faults(site)
    print("\n".join(broken))
    print(f"{inside} links within the site, {len(broken)} broken; {len(away)} links to other hosts, not requested")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
