"""Names from outside stay names: no path, no markup, no formula, and nothing hidden in them, end to end."""

from __future__ import annotations

import csv
import json
import pickle
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
from command_line import SHORT, Run
from hypothesis import given, settings
from hypothesis import strategies as st
from rich.console import Console
from small_task import SMALL
from test_reports_synthetic import save, synthetic

import gyroctl as gy
from gyroctl.comparison.experiment import build_experiment
from gyroctl.errors import NOT_GIVEN, visible
from gyroctl.harness.arguments import laws_by_name
from gyroctl.names import (
    check_apart,
    choice_of,
    file_in,
    in_cell,
    in_markup,
    in_table,
    name_of,
    nearest,
    part_of_path,
    text_of,
)
from gyroctl.reports import open_results, print_table, write_picture, write_report
from gyroctl.studies.evaluation import request
from gyroctl.studies.evaluation.writing import markdown_table
from gyroctl.tuning.task import build_task
from gyroctl.writing import write_rows

HIDDEN = (
    "a\0b",
    "a\nb",
    "a\x1b[31mb",
    "a\x7fb",
    "a\x85b",
    "a\u202eb",
    "a\u200bb",
    "a\u2066b",
    "a\u2028b",
    "a\ufeffb",
    "a\ud800b",
)
PATHS = (
    "../a",
    "a/../b",
    "/etc/a",
    "a/b",
    "..",
    ".",
    "a\\b",
    "C:a",
    "z:\\a",
    "a.",
    "a ",
    " a",
    "con",
    "NUL.txt",
    "Com1",
)
LONG = ("a" * 101, "")
MARKUP = "<img src=x onerror=alert(1)>$\\frac{$ %{x} & [red]x[/] |"
"""All that HTML, plotly, matplotlib, rich and markdown take for their own."""


@pytest.mark.parametrize("name", [*HIDDEN, *PATHS, *LONG, "COM\xb9"])
def test_name_that_leads_elsewhere_or_hides_something_is_refused(name: str) -> None:
    for refuse in (name_of, part_of_path):
        with pytest.raises(gy.InputError, match="laws"):
            refuse("laws", name)


@pytest.mark.parametrize("name", ["load_angle", "nmpc[horizon=8]", "ωλ (γ 5)", "a.b", "console", "naïve", "-x", "v2.0"])
def test_name_that_is_one_stays_as_it_is(name: str) -> None:
    assert name_of("laws", name) == part_of_path("laws", name) == name


@pytest.mark.parametrize(
    ("names", "problem"),
    [
        (("\u0441onstant",), "CYRILLIC SMALL LETTER ES"),
        (("load_\u0430ngle",), "CYRILLIC SMALL LETTER A"),
        (("M\u03a1C",), "GREEK CAPITAL LETTER RHO"),
        (("mine", "\uff4dine"), "looks like the name 'mine'"),
        (("pac", "\u0440\u0430\u0441"), "looks like the name 'pac'"),
        (("\uff43oupling",), "looks like the name 'coupling'"),
    ],
)
def test_name_that_looks_like_another_is_refused(names: tuple[str, ...], problem: str) -> None:
    with pytest.raises(gy.InputError, match=problem) as caught:
        check_apart("laws", names, ("constant", "coupling", "load_angle"))
    assert caught.value.field == "laws" and caught.value.value == names[-1]
    with pytest.raises(gy.InputError, match=problem):
        build_experiment({"laws": {name: {"law": "constant"} for name in names}})
    with pytest.raises(gy.InputError, match=problem):
        laws_by_name({name: "constant" for name in names})


@pytest.mark.parametrize(
    "name",
    ["закон", "мой закон 2", "νόμος", "制御A", "λ law", "ωλ (γ 5)", "ρLQR", "Δcc", "naïve", "constant", "coupling 2"],
)
def test_name_in_any_one_alphabet_stands_beside_others(name: str) -> None:
    check_apart("laws", [name, "mine"], ("constant", "coupling"))
    assert name in build_experiment({"laws": {name: {"law": "constant"}}}).laws


@settings(deadline=None)
@given(st.text(st.characters(codec=None), max_size=120))
def test_part_of_a_path_stays_in_its_folder(name: str) -> None:
    folder = Path("/out/folder")
    try:
        path = file_in(folder, name, ending=".json")
    except gy.InputError as error:
        str(error).encode()  # can be written, and steers no terminal
        assert str(error).isprintable()
        return
    assert path.parent == folder and path.name == f"{name}.json" and path.resolve().parent == folder.resolve()
    assert len(path.name.encode()) <= 255


@settings(deadline=None)
@given(st.text(st.characters(codec=None)))
def test_any_text_can_be_shown(text: str) -> None:
    shown = visible(text)
    shown.encode()
    assert all(sign.isprintable() or sign in "\n\t" for sign in shown)


def test_message_steers_no_terminal() -> None:
    with pytest.raises(gy.InputError) as caught:
        build_task({"\x1b[2J\u202e": 1})
    assert str(caught.value).isprintable() and r"\x1b[2J\u202e" in str(caught.value)


# --- end to end ----------------------------------------------------------------------------------------------------


def quoted(name: str) -> str:
    """Name as a key of TOML."""
    return json.dumps(name).replace("\\ud800", "\\u2028").replace("\x7f", "\\u007f")  # TOML has no surrogates


@pytest.mark.parametrize("name", [*HIDDEN, *PATHS, *LONG])
def test_comparison_of_such_a_name_is_refused_before_anything_runs(name: str, tmp_path: Path, run: Run) -> None:
    (tmp_path / "in").mkdir()
    file = tmp_path / "in" / "study.toml"
    file.write_text(f'[laws.{quoted(name)}]\nlaw = "coupling"\n')
    code, out, err = run("compare", file, "--out", tmp_path / "in" / "out")
    assert code == 2 and not out and err.startswith("Error: laws = ")
    assert err.rstrip("\n").isprintable()
    assert [path.name for path in tmp_path.rglob("*")] == ["in", "study.toml"]


@pytest.mark.parametrize("where", ["seas", "goals"])
@pytest.mark.parametrize("name", [*HIDDEN, *PATHS, *LONG, "a:b", "a*"])
def test_task_with_such_a_name_is_refused(name: str, where: str) -> None:
    table: dict[str, Any] = {"seas": {"hs": 0.25}, "goals": {"motion": 0.2}}
    with pytest.raises(gy.InputError, match=where):
        build_task({**SMALL, where: {name: table[where]}}, folder=Path(SMALL["law"]).parent)


@pytest.mark.parametrize("law", ["mine.py:../../Mine", "mine.py:a\u202eb", "mine.py:NUL"])
def test_task_of_a_law_whose_name_is_none_is_refused(law: str, tmp_path: Path, run: Run) -> None:
    task = tmp_path / "task.toml"
    task.write_text(f"law = {json.dumps(law)}\n[knobs]\ncc = {{start = 0.05, width = 0.3}}\n")
    code, _, err = run("tune", task, "--out", tmp_path / "out")
    assert code == 2 and "law = " in err and err.rstrip("\n").isprintable()
    assert [path.name for path in tmp_path.iterdir()] == ["task.toml"]


@pytest.mark.parametrize("name", HIDDEN)
def test_evaluation_of_such_a_law_is_refused(name: str, tmp_path: Path) -> None:
    for given_names in ({"laws": f"constant[cc=0.05,x={name}]"}, {"planner": name}):
        with pytest.raises(gy.InputError, match=r"laws|planner"):
            request(tmp_path / "out", **given_names)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", [name for name in HIDDEN if "\0" not in name and "\ud800" not in name])
def test_results_from_elsewhere_with_such_a_name_are_refused(name: str, tmp_path: Path, run: Run) -> None:
    save(synthetic().assign_coords(law=["best_constant", name, "b", "c"]), tmp_path / "results.nc")
    code, out, err = run("report", tmp_path)
    assert code == 2 and not out and "results.law" in err
    assert [file.name for file in tmp_path.iterdir()] == ["results.nc"]


class Elements(HTMLParser):
    """Elements of a page, and the attributes that would run something."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.found: list[str] = []
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found += [tag, *(name for name, _ in attrs if name.startswith("on"))]


@pytest.mark.slow
def test_report_of_a_name_that_is_markup_holds_it_as_text(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """In the page, in its figures, in the picture and in the table of the terminal."""
    ds = synthetic().assign_coords(law=["best_constant", MARKUP, "b", "c"])
    ds.attrs["plant"] = "[red]title[/]<b>"
    save(ds, tmp_path / "results.nc")
    page = write_report(tmp_path, tmp_path / "report.html").read_text(encoding="utf-8")
    plain = write_report(synthetic(), tmp_path / "plain.html").read_text(encoding="utf-8")
    assert set(Elements(page).found) == set(Elements(plain).found)
    assert "<img src=x" not in page
    assert "\\u003cimg src=x" in page and "&lt;img src=x" in page  # for the closer look, which writes names as text
    assert write_picture(ds, tmp_path / "picture.svg").read_text().count("<img") == 0
    console = Console(width=200, file=(tmp_path / "table.txt").open("w"))
    print_table(open_results(ds), console=console)
    console.file.close()
    shown = (tmp_path / "table.txt").read_text()
    assert "[red]x[/]" in shown and "\x1b" not in shown


@pytest.mark.slow
def test_comparison_of_a_name_that_is_markup_runs(tmp_path: Path, run: Run) -> None:
    name = "<img src=x onerror=alert(1)> $x^{"
    file = tmp_path / "study.toml"
    file.write_text(SHORT.replace("[laws.steady]", f'[laws."{name}"]').replace("seeds = [1, 2]", "seeds = [1]"))
    code, _, err = run("compare", file, "--out", tmp_path / "out", "--no-search")
    assert code == 0, err
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "img" not in Elements(page).found
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"results.nc", "summary.json", "report.html", "runs"}
    code, _, err = run("report", tmp_path / "out", "--out", tmp_path / "again")
    assert code == 0, err


@pytest.mark.parametrize(
    "text", ["=1+1", "+cmd", "-2+3", "@sum", "\tx", "\rx", "\nx", "\uff1d1+1", "=cmd|' /C calc'!A0"]
)
def test_cell_of_a_table_is_no_formula(text: str, tmp_path: Path) -> None:
    path = write_rows(tmp_path / "table.csv", [[text, "name"], [-1.5, "-1.5e-3"], ["a,b", '"q"']])
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    assert rows == [[f"'{text}", "name"], ["-1.5", "-1.5e-3"], ["a,b", '"q"']]
    assert in_cell(in_cell(text)) == in_cell(text)


def test_cells_of_markdown_hold_names() -> None:
    (_, _, line) = markdown_table(["law"], [["a|b<script>"]]).splitlines()
    assert line == "| a\\|b&lt;script> |"
    for text in ("nmpc[horizon=8] & more", "< 0.01"):
        assert in_table(text) == text
    assert in_markup("a%{x}<") == "a%&#123;x}&lt;"
    assert text_of("laws", "a/b") == "a/b"


@pytest.mark.parametrize(
    ("name", "known", "near"),
    [
        ("J41", ("J11", "J13", "J14", "Jh1", "d1"), ["J14"]),
        ("shre", ("share", "margin"), ["share"]),
        ("Share", ("share", "margin"), ["share"]),
        ("cx", ("cc", "cg", "gain"), []),
        ("gain", ("gain1", "gain3", "slow"), ["gain1", "gain3"]),
        ("nothing", (), []),
    ],
)
def test_nearest_names_are_offered(name: str, known: tuple[str, ...], near: list[str]) -> None:
    assert nearest(name, known) == near
    assert choice_of(name, known).startswith(f"Perhaps {' or '.join(near)} is meant. " if near else "Choose one of ")
    assert all(each in choice_of(name, known) for each in known)


def test_what_was_not_given_is_no_none() -> None:
    error = gy.InputError("sea.time", NOT_GIVEN, "a.csv holds 3 spectra", "Give one")
    for each in (error, pickle.loads(pickle.dumps(error))):
        assert str(each) == "sea.time is not given: a.csv holds 3 spectra. Give one." and each.value is None
    assert "sea.time = None" in str(gy.InputError("sea.time", None, "is none", "Give one")), "a None that was given"
