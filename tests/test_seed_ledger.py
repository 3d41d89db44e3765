"""The ledger of seeds, and that tune, compare and evaluate keep to it, for a user's law with a tuned set as well."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import gyroctl as gy
from gyroctl.cli.app import app
from gyroctl.comparison.compare import Realisations, compare
from gyroctl.comparison.experiment import RunTable, build_experiment
from gyroctl.fingerprint import listing
from gyroctl.harness.registry import registered, tuned_seeds
from gyroctl.harness.seed_ledger import LEDGER, all_tuning_seeds, ledger, read_ledger, refused_for, seeds_beside
from gyroctl.reports import evaluate, judge
from gyroctl.studies.evaluation.report import _page
from gyroctl.studies.evaluation.request import request
from gyroctl.studies.evaluation.seeds import seed_plan, states_in_words
from gyroctl.tuning.task import build_task
from gyroctl.tuning.tune import check_seeds
from gyroctl.tuning.waters import Circumstances

ROOT = Path(gy.__file__).resolve().parents[1]
LAW = (ROOT / "docs" / "examples" / "my_law.py").read_text(encoding="utf-8")
OWN = range(20000, 20008)
"""Seeds on which the user's law is tuned: in no entry of the ledger."""

HEAD = "[judging]\nfirst = 0\nlast = 99\n"
ENTRY = '[[seeds]]\nfirst = {}\nlast = {}\nstate = "{}"\nsince = 2026-01-01\nuse = "x"\n'


def tuned(folder: Path, stem: str, first: int = OWN[0], last: int = OWN[-1]) -> Path:
    """The example law in a file of its own, with a tuned set beside it."""
    (folder / "my_law.py").write_text(LAW + "\n\ndef make(cg: float = 4e-4) -> MyLaw:\n    return MyLaw(cg=cg)\n")
    entry = {"parameters": {"cg": 4e-4}, "found": {"seeds": {"first": first, "last": last}}}
    (folder / "tuned").mkdir(exist_ok=True)
    (folder / "tuned" / f"{stem}.json").write_text(json.dumps({"law": stem, "sets": {"all": entry}}))
    return folder / "my_law.py"


# --- the ledger itself ----------------------------------------------------------------------------------------------


def test_ledger_says_what_each_seed_was_used_for() -> None:
    book = ledger()
    assert {book.state(seed) for seed in range(1, 201)} == {"spent"}
    for first, last in ((1001, 1400), (2001, 2064), (3001, 9999)):
        states = {book.state(seed) for seed in range(first, last + 1)}
        assert states <= {"reserve", "spent"}, "a reserve is never anything but spent later"
    assert all(
        seed in book.judging for entry in book.entries if entry.state in ("spent", "reserve") for seed in entry.span
    )
    assert not any(seed in book.judging for seed in book.tried())
    assert book.states([1, 500, 100000, 2]) == {"spent": [1, 2], "unlisted": [500], "tuning": [100000]}


def test_every_seed_that_a_shipped_law_was_tuned_on_is_in_it() -> None:
    for name in registered():
        assert all(ledger().state(seed) == "tuning" for seed in tuned_seeds(name)), name
    assert set(all_tuning_seeds()) <= ledger().tried()
    assert ledger().tried() >= set(range(100000, 100256))
    assert {ledger().state(seed) for seed in RunTable().seeds} == {"spent"}, "and the default report says so"


@pytest.mark.parametrize(
    "text",
    [
        "",
        HEAD,
        HEAD + ENTRY.format(1, 9, "fresh"),
        HEAD + ENTRY.format(9, 1, "spent"),
        HEAD + ENTRY.format(1, 9, "spent") + ENTRY.format(9, 12, "reserve"),
        HEAD + ENTRY.format(1, 9, "spent").replace("2026-01-01", '"once"'),
        HEAD + ENTRY.format(1, 9, "spent") + "who = 1\n",
    ],
)
def test_ledger_that_is_none_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "seeds.toml").write_text(text)
    with pytest.raises(gy.InputError) as error:
        read_ledger(tmp_path / "seeds.toml")
    assert error.value.field == "ledger"


def test_marking_seeds_spent_makes_no_stored_run_stale(tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    for name in ("table.nc", LEDGER.name):
        (tmp_path / "data" / name).write_text("1")
    before = listing({"data": tmp_path / "data"})
    (tmp_path / "data" / LEDGER.name).write_text("2")
    assert listing({"data": tmp_path / "data"}) == before
    (tmp_path / "data" / "table.nc").write_text("2")
    assert listing({"data": tmp_path / "data"}) != before


# --- tune -----------------------------------------------------------------------------------------------------------

KNOBS = {"law": "coupling", "knobs": {"cg": {"start": 4e-4, "width": 0.5}}}


@pytest.mark.parametrize(("first", "count"), [(1, 8), (200, 4), (1390, 4), (2064, 1), (9990, 20), (500, 4)])
def test_no_law_is_tuned_on_seeds_that_judge(device: gy.Plant, first: int, count: int) -> None:
    task = build_task({**KNOBS, "seeds": {"first": first, "count": count}})
    with pytest.raises(gy.InputError, match="judge laws"):
        check_seeds(task, Circumstances(device))


def test_seeds_for_tuning_and_unlisted_ones_above_are_accepted(device: gy.Plant) -> None:
    for first in (100000, 100200, 20000):
        check_seeds(build_task({**KNOBS, "seeds": {"first": first, "count": 8}}), Circumstances(device))


# --- compare --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", [100000, 100143, 100144, 100255])
def test_comparison_refuses_what_the_ledger_keeps_for_tuning(device: gy.Plant, seed: int) -> None:
    waves = Realisations(gy.SeaState(), (1, seed), duration=120.0)
    with pytest.raises(gy.InputError, match="used for tuning") as error:
        compare(device, {"a": gy.law("constant")}, waves, gy.Settings(blend=40.0), quiet=True)
    assert error.value.value == [seed]


@pytest.mark.parametrize("built", ["class", "factory", "wrapped"])
def test_comparison_refuses_the_seeds_of_a_user_s_own_tuning(device: gy.Plant, tmp_path: Path, built: str) -> None:
    file = tuned(tmp_path, "make" if built == "factory" else "MyLaw")
    law: Any = gy.law(f"{file}:{'make' if built == 'factory' else 'MyLaw'}")
    if built == "wrapped":
        law = gy.law("supervisor", wraps=law)
    assert seeds_beside(law) == set(OWN)
    waves = Realisations(gy.SeaState(), (1, OWN[3]), duration=120.0)
    with pytest.raises(gy.InputError, match="used for tuning") as error:
        compare(device, {"mine": law}, waves, gy.Settings(blend=40.0), quiet=True)
    assert error.value.value == [OWN[3]]
    other = tuned(tmp_path, "SomeoneElse")
    assert set(OWN) <= set(refused_for([law]))
    (tmp_path / "tuned" / ("make.json" if built == "factory" else "MyLaw.json")).unlink()
    assert other.is_file() and seeds_beside(law) == set(), "sets of a law of another name are not its own"


@pytest.mark.parametrize("name", ["MyLaw", "make"])
def test_command_refuses_the_seeds_of_a_user_s_own_tuning(tmp_path: Path, name: str) -> None:
    tuned(tmp_path, name)
    toml = tmp_path / "e.toml"
    toml.write_text(
        f'[run]\nduration = 120\nblend = 40\nseeds = [1, {OWN[0]}]\n[laws.mine]\nlaw = "my_law.py:{name}"\n'
    )
    done = CliRunner().invoke(app, ["compare", str(toml), "--out", str(tmp_path / "out")])
    assert isinstance(done.exception, gy.InputError)
    assert (done.exception.field, done.exception.value) == ("run.seeds", [OWN[0]])
    assert not (tmp_path / "out").exists()
    assert OWN[0] in build_experiment({"laws": {"mine": {"law": f"my_law.py:{name}"}}}, folder=tmp_path).tuning_seeds


def test_report_says_which_seeds_are_spent_or_in_reserve(device: gy.Plant) -> None:
    waves = Realisations(gy.SeaState(), (3, 1), duration=120.0)
    ds = compare(device, {"a": gy.law("constant")}, waves, gy.Settings(blend=40.0), workers=1, quiet=True)
    assert json.loads(ds.attrs["seed_states"]) == {"spent": [1, 3]}
    assert any("Seeds 1, 3 are spent" in caveat for caveat in judge(evaluate(ds)).caveats)
    fresh = ds.assign_attrs(seed_states=json.dumps({"reserve": [3001, 3002], "unlisted": [500]}))
    caveats = " ".join(judge(evaluate(fresh)).caveats)
    assert "3001, 3002 were in reserve" in caveats and "spent: laws" not in caveats and "500" not in caveats


# --- evaluate -------------------------------------------------------------------------------------------------------


def test_evaluation_refuses_the_seeds_of_a_user_s_own_tuning(tmp_path: Path) -> None:
    file = tuned(tmp_path, "MyLaw")
    with pytest.raises(gy.InputError, match="tuning") as error:
        request(tmp_path / "out", f"{file}:MyLaw", [f"{OWN[0]}:{OWN[-1]}"])
    assert error.value.field == "seeds"
    assert request(tmp_path / "out", f"{file}:MyLaw", ["1:4"]).plan.common == (1, 2, 3, 4)
    assert request(tmp_path / "out", "coupling", [f"{OWN[0]}"]).plan.common == (OWN[0],)


@pytest.mark.parametrize("seeds", ["100000", "100255", "1:4,100144"])
def test_evaluation_refuses_what_the_ledger_keeps_for_tuning(seeds: str) -> None:
    with pytest.raises(gy.InputError, match="tuning"):
        seed_plan([seeds])


def test_page_of_an_evaluation_says_what_was_known_of_its_seeds(tmp_path: Path) -> None:
    ask = request(tmp_path / "out", "coupling", ["1:64"])
    page = _page("seas", ask, "", {})
    assert "1 to 64: spent, laws were changed after results on them were known" in page
    assert ask.record()["seed_states"] == {"spent": list(range(1, 65))}
    words = states_in_words([1, 2, 9000, 500])
    assert "1, 2: spent" in words and "9000: reserve" in words and "500: unlisted" in words


def test_law_under_the_name_of_the_reference_does_not_stand_in_for_it(tmp_path: Path) -> None:
    assert [e.label for e in request(tmp_path / "out", "best_constant,coupling").entrants] == ["coupling"]


# --- words ----------------------------------------------------------------------------------------------------------

CLAIMS = re.compile(r"unseen|never (?:met|seen)|not tuned on|no law was tuned on|nothing was tuned", re.IGNORECASE)


def claims(text: str) -> list[str]:
    """Paragraphs that call realisations unseen and say neither that they are spent nor of which reserve they are."""
    return [part for part in re.split(r"\n\s*\n", text) if CLAIMS.search(part) and not re.search("spent|reserve", part)]


def test_words_about_seeds_follow_the_ledger() -> None:
    files = [*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md"), *(ROOT / "gyroctl").rglob("*.py")]
    files += [*(ROOT / "studies").rglob("*.py"), *(ROOT / "controllers").rglob("*.py")]
    found = {str(path): claims(path.read_text(encoding="utf-8")) for path in files}
    assert {path: parts for path, parts in found.items() if parts} == {}
    assert claims("On 64 unseen\nruns.") and not claims("On 64 runs that no law was tuned on, spent since.")
