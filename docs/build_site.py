"""Build the documentation as a site, ``build/site``: open ``index.html`` there, no server is needed.

    python docs/build_site.py

Writes the pages of the reference, draws the figures, builds with warnings as errors, and checks every link and every
public name of what came out. Fails where any of them does.
"""

from __future__ import annotations

import argparse
import re
import shutil
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import reference_pages
import site_links
import site_reference

ROOT = Path(__file__).resolve().parents[1]
OUT = ROOT / "build" / "site"

LINK_BACK = re.compile(r"names/([\w.]+)\.html#([\w.]+)")
"""A link from a source to the reference: page and place."""

ENTRANCE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="refresh" content="0; url=docs/index.html">
<title>gyroctl</title>
</head>
<body><a href="docs/index.html">gyroctl</a></body>
</html>
"""


def mend_sources(out: Path) -> None:
    """Lead the pages of sources back to the reference.

    Sphinx takes one room for all names of a file; where two rooms export names of one, half of its links are to places
    that are not there. The page is right, and says the place. Its list of files also names modules without a page.
    """
    for page in (out / "_modules").rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        new = LINK_BACK.sub(_back, text)
        if page == out / "_modules" / "index.html":
            for address in re.findall(r'<li><a href="([^"]+)">', new):
                if not (page.parent / address).is_file():
                    new = re.sub(rf'<li><a href="{re.escape(address)}">.*?</a>', "<li>", new)
        if new != text:
            page.write_text(new, encoding="utf-8", newline="\n")


def _back(found: re.Match[str]) -> str:
    """The link to a page of the reference with the place that is there: the name by its path, or a member of it."""
    path, place = found[1], found[2]
    if place == path or place.startswith(f"{path}."):
        return found[0]
    _, here, member = place.partition(f".{path.rpartition('.')[2]}")
    return f"names/{path}.html#{path}{member}" if here else found[0]


def build(out: Path = OUT, figures: bool = True) -> int:
    """Build the site in the folder `out`; return 0 where nothing is wrong.

    Parameters
    ----------
    out : Path
        Folder, which is written anew.
    figures : bool
        Whether figures are drawn; without them pages show their scripts alone.
    """
    from sphinx.cmd.build import main as sphinx

    shutil.rmtree(out, ignore_errors=True)
    shutil.rmtree(ROOT / "docs" / "figures", ignore_errors=True)  # no figure of an older state
    reference_pages.write()
    options = ["-b", "html", "-W", "--keep-going", "-E", "-q", "-c", str(ROOT / "docs"), "-d", str(out) + "-read"]
    options += [] if figures else ["-D", "sphinx_gallery_conf.plot_gallery=0"]
    failed = sphinx([*options, str(ROOT), str(out)])
    if failed:
        return int(failed)
    mend_sources(out)
    (out / "index.html").write_text(ENTRANCE, encoding="utf-8", newline="\n")
    lacking = site_reference.faults(out)
    print("\n".join(lacking) or "every public name is in the reference")
    return 1 if site_links.main(out) or lacking else 0


def main(arguments: Sequence[str] | None = None) -> int:
    """Read the arguments and build."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=OUT, help="folder, build/site without it")
    parser.add_argument("--without-figures", action="store_true", help="quick: scripts of figures are shown, not run")
    asked = parser.parse_args(arguments)
    begun = time.monotonic()
    failed = build(asked.out, not asked.without_figures)
    words = "failed" if failed else f"built: {asked.out / 'index.html'}"
    print(f"{words}, {time.monotonic() - begun:.0f} s")
    return failed


if __name__ == "__main__":
    sys.exit(main())
