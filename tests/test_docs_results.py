"""Every figure of the pages is written from committed results, and stands nowhere else."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import pytest
from kept_results import kept, write_kept
from result_blocks.source import result
from run_results import RUNS, typed
from write_results import BLOCK, BLOCKS, ROOT, block, blocks_of, differing, filled, pages, whole_pages, write

RESULT = re.compile(
    r"""(?<![\w.^-]) (?:
    (?P<power>   [+−-]?\d+(?:\.\d+)?\ W\b (?!/) )
  | (?P<ratio>   \d+(?:\.\d+)?\ ?x\b | \d+(?:\.\d+)?\ times\ (?:the|that|as\ much)\b )
  | (?P<count>   \d+\ of\ (?:the\ )?\d+\b | \d+/\d+\b (?=\ (?:runs|lock|held|stay)|,|\)|\ \|) )
  | (?P<part>    [+−-]?\d+(?:\.\d+)?\ % )
  | (?P<motion>  \d+\.\d+\ rad\b (?!/) )
  | (?P<decibel> [+−-]?\d+(?:\.\d+)?\ dB\b )
  | (?P<factor>  (?:factors?\ (?:of\ )?|\balpha\ |α\ =\ )\d+(?:\.\d+)? )
  | (?P<cv>      CV\ (?:of\ |below\ )?\d+(?:\.\d+)? )
  | (?P<time>    \d+(?:\.\d+)?\ (?:ms|µs)\b )
    )""",
    re.VERBOSE,
)
"""What looks like a figure of a result: power, ratio, count of runs, part, motion, margin, coefficient of variation."""

DEFINED: dict[str, dict[str, str]] = {
    "docs/bound.md": {
        r"98 %": "name of a measure",
        r"0\.35 rad|0\.25 rad": "limits of motion",
        r"20 ms": "setting of the actuators",
    },
    "docs/connection.md": {r"95 %": "name of an interval"},
    "docs/conventions.md": {
        r"= 1\.76 W": "the paper's own figures, held by the test that is named",
        r"0\.3 rad": "range of the model",
        r"98 %|95 %": "names of measures",
    },
    "docs/estimation.md": {},
    "docs/evaluation.md": {
        r"0\.35 rad": "limit of motion",
        r"98 %|95 %|99 % of the time": "names of measures",
        r"99 % of the realisations": "limit of lock",
        r"85 % of each": "share that one set for all seas is to reach",
        r"(?:5\.5|4\.5|10|13|11|9|3\.5) W|(?:1\.8|3) times(?: the)?|CV ≤|0\.25 rad": "bars",
        r"± ?20 %|5 %|0\.091 rad|20, 50, 100 ms": "the perturbed devices",
        r"4 of 4 locked|200 of 200|51 %": "arithmetic of Wilson's interval, on made-up counts",
        r"0\.1 rad/s": "step of the drifting sea",
        r"20 ms|200 ms|10, 50, 100 ms": "cases of real water",
    },
    "docs/seas.md": {r"0\.5 % of their|1 % on": "limits from which on drift and waves that are cut are told"},
    "docs/experiment.md": {r"2 %|99 %": "tolerance of the check of a law, and the name of a measure"},
    "docs/laws.md": {r"within 15 %": "rule of the supervisor", r"30 W": "setting of the supervisor"},
    "docs/margins.md": {
        r"95 %": "name of an interval",
        r"0\.35 rad": "size of the disturbances",
        r"in the nonlinear loop, 1 %": "held by the test that is named beside it",
    },
    "docs/nmpc.md": {r"14 W": "setting of the power command"},
    "docs/wetted.md": {
        r"(?:0\.2|0\.5|2) % of": "bars, held by the tests that are named beside them",
        r"10 ms": "setting of the plant",
    },
    "docs/nomenclature.md": {r"98 %|95 %|99 %|99\.9 %|0\.3 rad|10 %|5 %": "names of measures, and definitions"},
}
"""What looks like one and is a definition, a setting, a limit, or held by a test that is named: with the reason."""


def outside_blocks(page: str) -> str:
    """A page without its blocks, its code and its links."""
    text = BLOCK.sub("", page)
    text = re.sub(r"^ *```.*?^ *```", "", text, flags=re.MULTILINE | re.DOTALL)
    text = re.sub(r"^    .*$", "", text, flags=re.MULTILINE)
    return re.sub(r"`[^`\n]*`|\]\([^)]*\)", "", text)


def strays(name: str, page: str) -> list[str]:
    """Figures of results outside the blocks, with the words before and after them."""
    text = outside_blocks(page)
    defined = [m.span() for pattern in DEFINED.get(name, {}) for m in re.finditer(rf"(?<![\d.])(?:{pattern})", text)]
    found = []
    for match in RESULT.finditer(text):
        start, end = match.span()
        if not any(first <= start and end <= last for first, last in defined):
            found.append(text[max(0, start - 40) : end + 20].replace("\n", " "))
    return found


def page_of(path: Path) -> str:
    return path.read_text(encoding="utf-8")


# --- the blocks ------------------------------------------------------------------------------------------------------


def test_pages_say_what_the_results_say() -> None:
    assert differing() == [], "python docs/write_results.py writes them"


def test_every_block_stands_on_a_page_and_says_its_command() -> None:
    shown = {name for path in pages() for name in blocks_of(page_of(path))}
    assert shown == set(BLOCKS)
    for name in BLOCKS:
        told = block(name).strip().splitlines()[-1]
        assert re.search(r"`(gyroctl |python )", told), f"{name}: {told}"


def test_marks_of_blocks_come_in_pairs() -> None:
    for path in pages():
        text = page_of(path)
        assert len(re.findall("<!-- results: ", text)) == len(re.findall("<!-- end -->", text)) == len(blocks_of(text))


@pytest.mark.parametrize("name", ["README.md", "docs/evaluation.md", "docs/margins.md"])
def test_a_figure_that_was_changed_by_hand_is_found_and_written_anew(name: str) -> None:
    """In a copy of the page, which is never written to its place."""
    folder = str(Path(name).parent)
    page = page_of(ROOT / name)
    which, text = next((one, text) for one, text in blocks_of(page).items() if re.search(r"\d\.\d", text))
    changed = re.sub(r"(\d\.)(\d)", lambda m: f"{m[1]}{(int(m[2]) + 1) % 10}", text, count=1)
    mutated = page.replace(text, changed)
    assert mutated != page and blocks_of(mutated)[which] != block(which, folder)
    assert filled(mutated, folder) == page


def test_check_names_the_block_that_differs_and_write_mends_it(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "docs", tmp_path / "docs", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "README.md", tmp_path / "README.md")
    page = tmp_path / "docs" / "margins.md"
    text = page_of(page)
    page.write_text(text.replace("| cg headroom | ", "| cg headroom | 9"), encoding="utf-8")
    found = differing(tmp_path)
    assert len(found) == 1 and found[0].startswith(str(Path("docs/margins.md, margins-sizes: "))) and "9" in found[0]
    assert write(tmp_path) == ["margins.md"]
    assert page_of(page) == text and differing(tmp_path) == []


# --- everywhere else -------------------------------------------------------------------------------------------------


def test_no_figure_of_a_result_stands_outside_the_blocks() -> None:
    found = {name: strays(name, page_of(path)) for path in pages() for name in [path.relative_to(ROOT).as_posix()]}
    assert {name: figures for name, figures in found.items() if figures} == {}


@pytest.mark.parametrize(
    "planted",
    [
        "It gives 17.1 W.",
        "That is 7.5x the pair.",
        "That is 7.5 times that of the pair.",
        "Lock was kept in 189 of 200 runs.",
        "It holds (64/64).",
        "Its CV 0.17 is small.",
        "The float moves up to 0.42 rad.",
        "cg stands a factor of 33.",
        "A disk margin α = 1.08 is safe.",
        "The load may rise by 23.4 dB.",
        "The best found takes 68 % of the cap.",
        "A plan takes 0.4 ms.",
    ],
)
def test_a_planted_figure_is_found(planted: str) -> None:
    for path in pages():
        name = path.relative_to(ROOT).as_posix()
        assert len(strays(name, f"{page_of(path)}\n{planted}\n")) == 1, name


def test_every_exception_is_needed_and_has_a_reason() -> None:
    for name, patterns in DEFINED.items():
        text = outside_blocks(page_of(ROOT / name))
        for pattern, reason in patterns.items():
            assert reason and re.search(pattern, text), f"{name}: {pattern}"


def test_no_page_says_locked_without_in_step_beside_it() -> None:
    """Counts of runs that held lock stand in blocks alone, each beside those in step, or what stands in their place."""
    for name in BLOCKS:
        text = block(name)
        if re.search(r"\blocked\b", text):
            assert re.search(r"[Ii]n step", text), name


# --- the results -----------------------------------------------------------------------------------------------------


def test_each_result_says_how_it_was_made() -> None:
    paths = sorted((ROOT / "docs" / "results").glob("*.json"))
    assert len(paths) > 5
    for path in paths:
        name, found = path.stem, json.loads(path.read_text(encoding="utf-8"))
        assert found["command"].startswith(("gyroctl ", "python -m gyroctl.")) and found["gyroctl_version"], name
        assert re.fullmatch(r"\d{4}-\d\d-\d\d", found["date"]), name
        assert name.startswith(("margins", "hydro")) or found["seed_states"], name


def test_results_that_nothing_makes_are_not_kept() -> None:
    assert {path.stem for path in (ROOT / "docs" / "results").glob("*.json")} <= set(RUNS)
    assert {path.name for path in (ROOT / "docs" / "results").glob("*.md")} == {Path(p).name for p in whole_pages()}


def test_block_of_a_result_that_is_not_kept_says_what_makes_it(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing() -> str:
        return str(result("nothing"))

    monkeypatch.setitem(BLOCKS, "hydro", missing)  # type: ignore[misc]
    assert block("hydro").strip() == "*Not run yet: `python docs/run_results.py nothing`.*"


def test_report_without_a_command_is_not_kept(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="command"):
        kept("hydro", {"command": "", "rows": []})
    found = kept("hydro", {"command": "gyroctl hydro check", "rows": [{"value": 1.23456789}], "extra": [1, 2]})
    assert found == {"command": "gyroctl hydro check", "rows": [{"value": 1.23457}], "extra": [1, 2]}
    assert json.loads(write_kept("hydro", found, tmp_path).read_text(encoding="utf-8")) == found


def test_commands_of_the_results_are_commands() -> None:
    """Of this package, with options that it knows: what a page promises can be typed."""
    from typer.main import get_command

    from gyroctl.cli.app import app

    commands = get_command(app)
    for name in RUNS:
        for short in (False, True):
            words, report = typed(name, short)
            assert report.suffix == ".json"
            if words[0] == "gyroctl":
                context = commands.make_context("gyroctl", words[1:], resilient_parsing=False)
                sub = commands.commands[words[1]]  # type: ignore[attr-defined]
                rest = words[2:]
                if hasattr(sub, "commands"):
                    sub, rest = sub.commands[words[2]], words[3:]
                sub.make_context(name, rest, parent=context)
