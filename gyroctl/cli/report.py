"""`gyroctl report`: the page of a comparison, a margin study, an evaluation or a site again, from its files."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from importlib import import_module
from pathlib import Path
from typing import Annotated

import typer

MEND = "Give the folder that gyroctl compare, margins, evaluate or site wrote, or a results.nc"

WANTED = ("scipy.stats", "matplotlib.figure", "matplotlib.backends.backend_svg")
"""What a page is drawn and reckoned with; they take two seconds to load."""

EMPTY = (
    f"{MEND}. If gyroctl compare wrote it, it is damaged: run that again with the same --out, finished runs are kept"
)

WANTED = ("scipy.stats", "matplotlib.figure", "matplotlib.backends.backend_svg")
"""What a page is drawn and reckoned with; they take two seconds to load."""

FILES = ("xarray", "h5py", "h5netcdf.legacyapi")
WRITING = (*WANTED, *FILES, "scipy.signal", "plotly.offline", "rich.table", "gyroctl.reports")
"""What a comparison is written with."""


def report(
    folder: Annotated[Path, typer.Argument(help="Folder of results, or a results.nc.")],
    out: Annotated[Path | None, typer.Option(help="Where to write; by default beside the results.")] = None,
) -> None:
    """Write the pages of a folder again from its files: comparison, margins, evaluation, site."""
    from gyroctl.cli.compare import check_folder

    if out is not None:
        check_folder(out)
    beside = folder if folder.is_dir() else folder.parent
    home = out or beside
    pages = _studies(folder, home) if folder.is_dir() else []
    if not pages or (folder / "results.nc").exists():
        _comparison(folder, home, beside)
    for page in pages:
        typer.echo(f"Page: {page}")


def _comparison(folder: Path, home: Path, beside: Path) -> None:
    """Page and summary of a comparison; refuses a folder in which there is nothing at all, before it loads anything."""
    from gyroctl.netcdf import kind_of

    kind_of("results", folder / "results.nc" if folder.is_dir() else folder, MEND)

    from gyroctl.cli.compare import write
    from gyroctl.reports import open_results

    beside_it = ThreadPoolExecutor(1)  # results are read in a process of their own, which takes a second
    for library in WANTED:
        beside_it.submit(import_module, library)
    try:
        results = open_results(folder)
    finally:
        beside_it.shutdown(wait=False, cancel_futures=True)  # a file that is none is refused without the rest of them
    write(results, home, results=home != beside, source=beside)


def _studies(folder: Path, home: Path) -> list[Path]:
    """Write the pages of the studies whose files lie in a folder."""
    # the studies bring the plant and all that computes with them, which takes longer to load than the page to draw
    pages = []
    if (folder / "margins.json").is_file():
        from gyroctl.studies.margins.page import page_again as margins_page

        pages.append(margins_page(folder, home))
    if (folder / "site.json").is_file():
        from gyroctl.studies.site.page import page_again as site_page

        pages.append(site_page(folder, home))
    if any(page.with_suffix(".json").is_file() for page in folder.glob("*.md")):
        from gyroctl.studies.evaluation.page import tables_in, write_page
        from gyroctl.studies.evaluation.titles import TITLES

        if tables_in(folder, tuple(TITLES)):
            pages.append(write_page(folder, tuple(TITLES), home))
    return pages
