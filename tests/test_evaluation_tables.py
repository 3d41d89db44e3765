"""The fair tables, run in the small: seas, robustness, information, off the design; resuming and refusing."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import gyroctl as gy
from gyroctl.cli.app import app
from gyroctl.comparison import execution
from gyroctl.harness.registry import describe
from gyroctl.harness.run import Settings, lead_in, run_law
from gyroctl.palette import law_styles
from gyroctl.studies.evaluation import Request, information, offdesign, request, seas
from gyroctl.studies.evaluation.cases import Case, run_case
from gyroctl.studies.evaluation.entrants import Entrant, pair, reference
from gyroctl.studies.evaluation.information import REALISTIC, information_table, levels
from gyroctl.studies.evaluation.offdesign import OffSea, found_pair, off_seas, offdesign_table
from gyroctl.studies.evaluation.perturbed_devices import NOMINAL, truths
from gyroctl.studies.evaluation.real_water import Water
from gyroctl.studies.evaluation.report import evaluate_tables
from gyroctl.studies.evaluation.robustness import robustness_table
from gyroctl.tuning.best_pair import searching
from gyroctl.waves import DriftingSea, realise

SHORT = 130.0
"""Runs that are scored for 30 s. [s]"""

TRIED = ("100000:100001",)


def asked(out: Path, laws: str = "load_angle", seeds: Any = TRIED, **more: Any) -> Request:
    return request(out, laws, seeds, SHORT, 1, allow_tuning_seeds=True, quiet=True, **more)


def forbidden(items: Any) -> None:
    raise AssertionError(f"{[(item.name, item.seed) for item in items]} were run again")


def test_seas_table_and_how_it_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ask = asked(tmp_path, "load_angle,constant")
    monkeypatch.setattr("gyroctl.studies.evaluation.report.TABLES", {"seas": lambda a: seas.seas_table(a, (5.0,))})
    first = evaluate_tables(["seas"], ask)["seas"]
    assert {"seas.md", "seas.json", "seas.png"} <= {path.name for path in tmp_path.iterdir()}
    assert json.loads((tmp_path / "seas.json").read_text())["seas"]["gamma5"]
    powers = {entry["law"]: entry["power"].value for entry in first["seas"]["gamma5"]}
    assert set(powers) >= {"best_constant", "load_angle", "constant"}

    ran: list[tuple[str, int]] = []
    perform = execution.perform

    def counted(items: Any) -> Any:
        ran.extend((item.name, item.seed) for item in items)
        return perform(items)

    monkeypatch.setattr(execution, "perform", forbidden)
    again, _, _ = seas.seas_table(asked(tmp_path, "load_angle,constant"), (5.0,))
    assert {r["law"]: r["power"].value for r in again["seas"]["gamma5"]} == powers
    monkeypatch.setattr(execution, "perform", counted)
    larger = asked(tmp_path, "load_angle", ("100000:100002", "load_angle=100000:100001"))
    seas.seas_table(larger, (5.0,))
    assert ran == [("best_constant", 100002)]


@pytest.mark.slow
def test_law_that_breaks_does_not_stop_the_others(tmp_path: Path) -> None:
    text = (
        "from typing import NamedTuple\n"
        "class Bad(NamedTuple):\n"
        "    period: float = 0.1\n"
        "    information = 'sensors'\n"
        "    def init(self):\n        return ()\n"
        "    def step(self, t, y, state):\n        return (0.05, float('nan') if t > 5.0 else 3e-4), state\n"
    )
    (tmp_path / "bad.py").write_text(text)
    ask = asked(tmp_path / "out", f"load_angle,{tmp_path}/bad.py:Bad")
    case = Case("one", gy.zhang2017(), gy.SeaState(), ask.settings)
    outcome = run_case(case, [reference(), *ask.entrants], ask)
    assert set(outcome.runs) == {"best_constant", "load_angle"}
    assert [("not finite" in why) for why in outcome.failed.values()] == [True]


def test_robustness_runs_the_truth_and_not_the_design(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The excitation that is a fifth higher brings more wave input, by the square where motion stays linear."""
    chosen = [truth for truth in truths() if truth.name in (NOMINAL, "He +20 %", "one sample late")]
    monkeypatch.setattr("gyroctl.studies.evaluation.robustness.truths", lambda settings: tuple(chosen))
    content, text, _ = robustness_table(asked(tmp_path))
    inputs = {name: {r["law"]: r["wave_input_w"] for r in table} for name, table in content["cases"].items()}
    assert inputs["He +20 %"]["best_constant"] > 1.1 * inputs[NOMINAL]["best_constant"]
    by_case = {name: {r["law"]: r for r in table} for name, table in content["cases"].items()}
    assert by_case[NOMINAL]["load_angle"]["of_nominal"].value == 1.0
    late = by_case["one sample late"]
    kept, nominal = (case["best_constant"]["power"].value for case in (late, by_case[NOMINAL]))
    assert kept == pytest.approx(nominal, rel=1e-5), "a constant command comes late but once"
    assert late["load_angle"]["of_nominal"].value != 1.0
    assert "## load_angle" in text


@pytest.mark.slow
def test_price_of_information_on_a_stand_in(tmp_path: Path) -> None:
    """A planner whose load grows with its lead: the difference of two levels is that of their runs, seed by seed."""
    text = (
        "from typing import NamedTuple\n"
        "class Planner(NamedTuple):\n"
        "    information: str = 'sensors'\n    lead: float = 0.0\n    period: float = 0.1\n"
        "    def init(self):\n        return ()\n"
        "    def step(self, t, y, state):\n"
        "        more = {'oracle': 5.0, 'forecast': self.lead, 'sensors': -0.5}[self.information]\n"
        "        return (0.05, 2e-4 + 4e-5 * more), state\n"
    )
    (tmp_path / "planner.py").write_text(text)
    name = f"{tmp_path}/planner.py:Planner"
    ask = asked(tmp_path / "out", seeds=("100000:100002", f"{name}=100000:100001"), planner=name)
    content, text, _ = information_table(ask)
    assert list(content["levels"]) == ["oracle", *(f"forecast {s} s" for s in (4, 2, 1, 0)), "sensors", "none"]
    powers = [level["power"].value for level in content["levels"].values()]
    assert powers[:6] == sorted(powers[:6], reverse=True)
    step = content["differences"][1]
    assert (step["more"], step["less"], step["pairs"]) == ("forecast 4 s", "forecast 2 s", 2)
    assert step["difference"].value == pytest.approx(powers[1] - powers[2])
    assert {(s["more"], s["less"]) for s in content["differences"]} >= {("oracle", "none"), ("sensors", "none")}
    assert "no interval from 2 realisations" in text


def test_levels_in_real_water_differ_in_what_is_seen_alone() -> None:
    """One law, which plans with that water and is told of its lag; the linear levels are as they ship."""
    built: dict[str, Any] = {name: one.build() for name, one in levels("nmpc", REALISTIC).items() if name != "none"}
    leads = [f"forecast {lead} s" for lead in (4, 2, 1, 0)]
    assert list(built) == ["oracle", *leads, "gauge at 10 m", "sensors"]
    assert [built[name].preview for name in leads] == [4.0, 2.0, 1.0, 0.0]
    assert built["gauge at 10 m"].gauge.distance == 10.0
    final = describe(gy.law("nmpc", plant="realistic", lag=REALISTIC.lag))
    for law in built.values():
        differing = {key for key, value in describe(law).items() if value != final[key]}
        assert differing <= {"information", "lead"}
    linear: dict[str, Any] = {name: one.build() for name, one in levels("nmpc").items() if name != "none"}
    assert list(linear) == ["oracle", *leads, "sensors"]
    assert describe(linear["sensors"]) == describe(gy.law("nmpc"))


def test_information_in_real_water_is_run_in_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With its lag, beside the pair of the linear device; the stand-in knows no more with its design model."""
    met: list[Case] = []
    kept = information.run_case

    def noted(case: Case, entrants: Any, ask: Request) -> Any:
        met.append(case)
        return kept(case, entrants, ask)

    monkeypatch.setattr(information, "run_case", noted)
    monkeypatch.setattr(information, "levels", lambda *_: {"sensors": Entrant("a", "constant"), "none": reference()})
    water = Water("drag, lagging", {"drag": 1.0}, 0.05)
    content, text, _ = information_table(asked(tmp_path), water=water)
    assert met[0].truth.parameters == gy.zhang2017(drag=1.0).parameters and met[0].settings.actuators.cc_lag == 0.05
    assert content["water"] == {"choices": {"drag": 1.0}, "lag_s": 0.05}
    assert information.IN_WATER in text
    linear, _, _ = information_table(asked(tmp_path))
    assert linear["water"] == {"choices": {}, "lag_s": 0.0}
    one, other = (each["levels"]["sensors"]["power"].value for each in (content, linear))
    assert one != other


def test_offdesign_stands_beside_the_pair_of_that_sea(tmp_path: Path) -> None:
    low, high = gy.SeaState(hs=0.2), gy.SeaState(hs=0.45)

    def search(plant: gy.Plant, sea: Any, ask: Request) -> dict[str, Any]:
        if sea == high:
            raise gy.InputError("sea.hs", sea.hs, "no lock begins here", "Lower it")
        return {"cc": 0.07, "cg": 1e-4, "met": False}

    chosen = [OffSea("height", "0.2 m", low), OffSea("height", "0.45 m", high)]
    content, text, _ = offdesign_table(asked(tmp_path), chosen, search)
    assert [case["name"] for case in content["cases"]] == ["0.2 m"]
    assert "no lock begins" in content["failed"]["height 0.45 m"]
    assert "cc 0.07, cg 0.0001" in text
    assert "comes nearest" in text
    device = gy.zhang2017()
    waves = lead_in(realise(device, low, 100000, SHORT), Settings())
    record, _ = run_law(device, gy.law("constant", cc=0.07, cg=1e-4), waves, Settings())
    by_hand = np.mean(1e-4 * record.states[1000:, 7] ** 2)
    constant = next(entry for entry in content["cases"][0]["laws"] if entry["law"] == "best_constant")
    outcome = run_case(Case("x", device, low, Settings()), [pair(0.07, 1e-4)], asked(tmp_path, seeds=("100000",)))
    assert outcome.reference.values["generated_w"][0] == pytest.approx(by_hand, rel=2e-3)
    assert constant["generated_w"] > 0.0


def test_pair_of_a_sea_is_searched_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from gyroctl.tuning.best_pair import BestPair

    calls: list[tuple[Any, float]] = []

    def best_pair(plant: Any, sea: Any, budget: float, seeds: Any, goal: Any, *_: Any, **__: Any) -> BestPair:
        calls.append((sea, goal.motion))
        motion = 0.8 * sea.hs
        met = motion <= goal.motion
        return BestPair(0.05, 2e-4 if met else 1e-5, {"phi1_p98": 0.1, "phi3_p98": motion}, met, 1.0, ())

    monkeypatch.setattr(offdesign, "best_pair", best_pair)
    device, ask = gy.zhang2017(), asked(tmp_path)
    for sea in (gy.SeaState(hs=0.2), gy.SeaState(hs=0.2), gy.SeaState(hs=0.3), DriftingSea(), DriftingSea()):
        found = found_pair(device, sea, ask)
        assert (found["cg"], found["motion_waived"]) == (2e-4, False)
    assert len(calls) == 3
    high = found_pair(device, gy.SeaState(hs=0.6), ask)  # no pair keeps the motion limit: none is held back by it
    assert (high["cg"], high["motion_waived"]) == (2e-4, True)
    assert [motion for sea, motion in calls if sea.hs == 0.6] == [0.34, float("inf")]
    assert searching(device, Settings()).actuators.cc_max < 0.3


def test_seas_off_the_design_are_those_that_are_asked_for() -> None:
    found = off_seas(2000.0)
    assert [s.sea.hs for s in found if s.group == "significant height"] == [0.15, 0.2, 0.283, 0.45, 0.6]
    assert [s.sea.wp for s in found if s.group == "peak frequency"] == [2.7, 2.9, 3.4, 3.6]
    assert sum(isinstance(s.sea, DriftingSea) for s in found) == 2


def test_command_refuses_before_the_first_run(tmp_path: Path) -> None:
    for arguments in (
        ["seas", "--seeds", "100000"],
        ["nothing"],
        ["--laws", "unknown"],
        ["--duration", "50"],
        ["--seeds", "unknown=1:4"],
    ):
        result = CliRunner().invoke(app, ["evaluate", *arguments, "--out", str(tmp_path / "out")])
        assert isinstance(result.exception, gy.InputError), arguments
    assert not (tmp_path / "out").exists()


def test_no_two_laws_look_alike_in_a_figure() -> None:
    styles = law_styles([*(f"law {i}" for i in range(24)), "best_constant"])
    assert len({(style.colour, style.marker) for style in styles.values()}) == 25
