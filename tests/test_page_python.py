"""The Python of every page runs as it stands, or reduced as the table here says, in the order of its page.

The blocks of python.md have tests of their own beside this, see tests/test_python_page.py.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from foreign_files import write_wamit
from test_page_commands import device, scatter
from test_page_links import ROOT, pages

import gyroctl as gy
from gyroctl.studies.site import SiteRequest

ELSEWHERE = ("docs/python.md",)
"""Pages with a test file of their own."""


def short(scope: dict[str, Any]) -> None:
    """What a reader has by then: a plant, laws, short waves."""
    plant = gy.zhang2017()
    waves = gy.realise(plant, gy.SeaState(), 1, 150.0)
    scope |= {"plant": plant, "waves": waves, "laws": {"mine": gy.law("constant")}, "my_law": gy.law("constant")}


def one_realisation(scope: dict[str, Any]) -> None:
    short(scope)
    scope["waves"] = [scope["waves"]]


def run_of_wamit(folder: Path) -> None:
    (folder / "run").mkdir()
    stem = write_wamit(folder / "run")
    for ending in (".1", ".3", ".hst"):
        if (file := stem.with_suffix(ending)).is_file():
            file.rename(folder / "run" / f"float{ending}")


def planned(ask: SiteRequest) -> dict[str, Any]:
    """In place of the runs of a site: hours of work."""
    assert set(ask.laws) == {"mine"}
    return {"annual": {"mine": {"energy": {"value": 1.0}}}}


def stored_answer(**asked: Any) -> Any:
    """In place of the comparison of two devices: what it gave."""
    import inspect

    from gyroctl.studies.connection import compare_connections
    from gyroctl.studies.connection.report import answer_of

    inspect.signature(compare_connections).bind(**asked)
    return answer_of(json.loads((ROOT / "docs" / "results" / "connection.json").read_text(encoding="utf-8")))


@dataclass(frozen=True)
class Reduced:
    """How the Python of a page runs here.

    Parameters
    ----------
    why : str
        Why it does not run as it stands, or what it takes for given.
    text : tuple of pairs of str
        What stands on the page, and what runs in its place.
    scope : callable, optional
        Names that the page takes for given.
    given : mapping of str to object
        Others.
    files : tuple of callable
        What makes the files that it names.
    slow : bool
        Whether it is one of the long tests all the same.
    """

    why: str
    text: tuple[tuple[str, str], ...] = ()
    scope: Callable[[dict[str, Any]], None] = lambda _: None
    given: tuple[tuple[str, Any], ...] = ()
    files: tuple[Callable[[Path], None], ...] = ()
    slow: bool = False


REDUCED: dict[str, Reduced] = {
    "README.md": Reduced(
        "eight runs of 2000 s",
        (("range(1, 9)", "range(1, 3)"), ("sea, seed)", "sea, seed, 150.0)"), ("yardstick=best)", "quiet=True)")),
    ),
    "docs/cluster.md": Reduced(
        "runs on other machines; tests/test_cluster.py does so on this one",
        (("from dask.distributed import Client", ""), (', scheduler=Client("tcp://HOST:8786")', "")),
        scope=one_realisation,
    ),
    "docs/connection.md": Reduced(
        "a search for each device",
        (("= compare_connections(", "= stored_answer("),),
        given=(("stored_answer", stored_answer),),
    ),
    "docs/device.md": Reduced("reads the device of the page", files=(device,)),
    "docs/import.md": Reduced("reads results of another solver", files=(run_of_wamit,), slow=True),
    "docs/laws.md": Reduced("goes on from a plant, waves and a law of one's own", scope=short),
    "docs/margins.md": Reduced(
        "many disturbances", (('"load_angle")', '"load_angle", samples=4, quiet=True)'),), slow=True
    ),
    "docs/site.md": Reduced(
        "hours of work", (("= site_report(", "= planned("),), given=(("planned", planned),), files=(scatter,)
    ),
}
"""By page."""


def blocks(page: Path) -> list[str]:
    return re.findall(r"^```python\n(.*?)^```$", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)


PAGES = {
    name: page
    for page in (pages() if (ROOT / "docs").is_dir() else [])
    if (name := page.relative_to(ROOT).as_posix()) not in ELSEWHERE and blocks(page)
}


MARKS = {name: [pytest.mark.slow] if how.slow else [] for name, how in REDUCED.items()}


@pytest.mark.parametrize("name", [pytest.param(name, marks=MARKS.get(name, [])) for name in PAGES])
def test_python_of_a_page_runs(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    how, scope = REDUCED.get(name, Reduced("")), dict[str, Any]()
    how.scope(scope)
    scope |= dict(how.given)
    for make in how.files:
        make(tmp_path)
    whole = blocks(PAGES[name])
    for stands, runs in how.text:
        assert any(stands in block for block in whole), f"{stands} does not stand on {name}"
        whole = [block.replace(stands, runs) for block in whole]
    for block in whole:
        exec(compile(block, name, "exec"), scope)


def test_what_is_reduced_is_on_a_page() -> None:
    assert not PAGES or set(REDUCED) <= set(PAGES)
