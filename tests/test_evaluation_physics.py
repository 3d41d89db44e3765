"""The table of the laws in real water: what is run, what is said of the order and of lock, and how it goes on."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import gyroctl as gy
from gyroctl.cli.app import app
from gyroctl.comparison import execution
from gyroctl.harness.run import Settings, lead_in, run_law
from gyroctl.plant import Parameters
from gyroctl.simulation.metrics import evaluate
from gyroctl.simulation.validity import validity
from gyroctl.studies.evaluation import Request, request
from gyroctl.studies.evaluation.cases import Case, Outcome, Runs
from gyroctl.studies.evaluation.entrants import Entrant, pair
from gyroctl.studies.evaluation.order import changes, holding, lost_lock, order, told
from gyroctl.studies.evaluation.physics import _left, judge, physics_table
from gyroctl.studies.evaluation.physics_answer import answer, in_sentences
from gyroctl.studies.evaluation.physics_cells import table_of
from gyroctl.studies.evaluation.real_water import LINEAR, WATERS, Water
from gyroctl.waves import realise

SHORT = 130.0
"""Runs that are scored for 30 s. [s]"""

SEEDS = np.arange(1, 17)

WATER: Any = Water("choice", {"drag": 0.5})


def asked(out: Path, laws: str = "load_angle", seeds: Any = ("100000:100001",)) -> Request:
    return request(out, laws, seeds, SHORT, 1, allow_tuning_seeds=True, quiet=True)


def runs(label: str, power: float, locked: int = 16, scatter: float = 0.3, phase: float = 0.0, n: int = 16) -> Runs:
    """Planted runs: power about a mean, lock held in so many of them."""
    wave = np.sin(2.4 * SEEDS[:n] + phase)
    names: tuple[str, ...] = (
        "power_cv",
        "power_cv_1s",
        "phi1_p98",
        "phi3_p98",
        "phi1_max",
        "phi3_max",
        "outside_share",
        "cycle_slips",
    )
    names += ("generated_w", "stored_w", "slip_loss_w", "wave_input_w", "saturations", "ledger_residual")
    names += ("outside_model", "step_ms_median", "step_ms_p99", "fallbacks", "deadline_misses", "failed")
    names += ("reversals", "traction_p99", "beyond_validity")
    values = {name: np.zeros(n) for name in names}
    values |= {"mean_power": power + scatter * (wave - wave.mean()), "locked": (np.arange(n) < locked).astype(float)}
    values |= {"turns_kept": np.ones(n), "waves_counted": np.full(n, 950.0)}
    hashes = tuple(map(str, SEEDS[:n]))
    return Runs(Entrant(label, label), "simple", "sensors", SEEDS[:n].astype(np.int64), hashes, values)


def outcome(**laws: Runs) -> Outcome:
    case: Any = None
    return Outcome(case, {name: laws[name] for name in laws}, {})


def judged(linear: Mapping[str, Runs], **cases: Mapping[str, Runs]) -> dict[str, Any]:
    """Answer on planted cases, each one a choice of its own."""
    base = Outcome(None, linear, {})  # type: ignore[arg-type]
    waters = {LINEAR: (Water(LINEAR, {}), base)}
    waters |= {name: (Water(name, {"drag": 1.0}), Outcome(None, laws, {})) for name, laws in cases.items()}  # type: ignore[arg-type]
    return answer({name: judge(water, found, base) for name, (water, found) in waters.items()})


# --- what is run -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("lag", [0.0, pytest.param(0.05, marks=pytest.mark.slow)])
def test_a_case_is_that_device_run_by_the_law_bit_for_bit(tmp_path: Path, lag: float) -> None:
    """By hand, with the device built from the choices alone, and its lag among the actuators."""
    water = Water("drag, lagging", {"drag": 1.0}, lag, single=False)
    ask = asked(tmp_path)
    content, _, _ = physics_table(ask, (Water(LINEAR, {}), water))
    plant = gy.zhang2017(drag=1.0)
    settings = Settings()
    settings = replace(settings, actuators=replace(settings.actuators, cc_lag=lag))
    sea = gy.SeaState(gamma=5.0)
    powers, reversals, beyond = [], [], []
    for seed in (100000, 100001):
        waves = lead_in(realise(plant, sea, seed, SHORT), settings)
        record, _ = run_law(plant, gy.law("load_angle"), waves, settings)
        powers.append(evaluate(plant, record, waves.moments[1], waves.dt, sea.wp, 100.0, 1.0)["mean_power"])
        card = validity(plant, record, waves, 100.0)
        reversals.append(card["reversals"])
        beyond.append(card["beyond_validity"])
    row = next(row for row in content["cases"][water.name] if row["law"] == "load_angle")
    linear = next(row for row in content["cases"][LINEAR] if row["law"] == "load_angle")
    assert row["power"].value == np.mean(powers)
    assert (row["reversals"], row["beyond_validity"]) == (np.mean(reversals), np.mean(beyond))
    assert row["less_linear"].value == pytest.approx(np.mean(powers) - linear["power"].value, rel=1e-12)
    assert row["of_linear"].value == pytest.approx(np.mean(powers) / linear["power"].value, rel=1e-12)
    assert (linear["of_linear"].value, linear["less_linear"].value) == (1.0, 0.0)
    assert content["waters"][water.name] == {"choices": dict(water.choices), "lag_s": lag, "single": False}


def test_the_pair_is_that_of_the_linear_device_everywhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from gyroctl.studies.evaluation import physics

    met: list[Case] = []

    def searched(case: Case, ask: Request) -> Entrant:
        met.append(case)
        return pair(0.05, 3e-4)

    monkeypatch.setattr(physics, "best_pair_of", searched)
    content, _, _ = physics_table(asked(tmp_path), (Water(LINEAR, {}), Water("drag", {"drag": 1.0})))
    assert [case.truth.parameters for case in met] == [gy.zhang2017().parameters]
    assert content["pair"] == {"cc": 0.05, "cg": 3e-4}


def test_every_choice_stands_alone_in_some_case_and_the_cases_differ() -> None:
    usual = gy.zhang2017().parameters
    built = {water.name: (water.plant().parameters, water.lag) for water in WATERS}
    assert built[LINEAR] == (usual, 0.0)
    assert len(set(map(repr, built.values()))) == len(WATERS) == len(built)
    alone = {name for water in WATERS if water.single for name in water.choices}
    assert alone >= {"position", "drag", "contact", "bearing", "coupling_slip", "coupling_cap"}
    assert {water.lag for water in WATERS if water.single} == {0.0, 0.02, 0.05, 0.1, 0.2}
    both = [built[name][0] for name in ("all, without a cap", "all: realistic")]
    differing = {name for name in Parameters.__dataclass_fields__ if getattr(both[0], name) != getattr(both[1], name)}
    assert differing == {"coupling_cap"}, "the page says so"


def test_table_goes_on_where_it_was_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    waters = (Water(LINEAR, {}), Water("drag", {"drag": 0.5}), Water("lag", {}, lag=0.1))
    perform: Any = execution.perform  # type: ignore[attr-defined]
    ran: list[tuple[str, int]] = []

    def stops(items: Any) -> Any:
        if len(ran) == 7:
            raise KeyboardInterrupt
        ran.extend((item.name, item.seed) for item in items)
        return perform(items)

    monkeypatch.setattr(execution, "perform", stops)
    with pytest.raises(KeyboardInterrupt):
        physics_table(asked(tmp_path), waters)
    assert len(ran) == 7

    def goes_on(items: Any) -> Any:
        ran.extend((item.name, item.seed) for item in items)
        return perform(items)

    monkeypatch.setattr(execution, "perform", goes_on)
    content, _, _ = physics_table(asked(tmp_path), waters)
    assert len(ran) == 3 * 2 * 2, "two laws on two seeds in three cases, none of them twice"
    assert not content["failed"] and list(content["cases"]) == [water.name for water in waters]


def test_command_takes_what_the_table_has_for_itself(tmp_path: Path) -> None:
    from gyroctl.studies.evaluation.physics import DURATION, LAWS
    from gyroctl.studies.evaluation.physics import SEEDS as USUAL

    ask = request(tmp_path).usually(LAWS, USUAL, DURATION)
    assert [entrant.label for entrant in ask.entrants] == ["nmpc", "coupling", "load_angle"]
    assert (ask.plan.of("coupling"), ask.plan.of("nmpc")) == (tuple(range(1, 17)), tuple(range(1, 9)))
    assert ask.duration == 600.0
    own = request(tmp_path, "coupling", ["1:4"], 300.0).usually(LAWS, USUAL, DURATION)
    assert ([entrant.label for entrant in own.entrants], own.plan.all, own.duration) == (
        ["coupling"],
        (1, 2, 3, 4),
        300.0,
    )
    some = request(tmp_path, "coupling").usually(LAWS, USUAL, DURATION)
    assert some.plan.all == tuple(range(1, 17)) and not some.plan.own, "seeds of a law that takes no part"


def test_time_left_goes_by_the_cases_that_are_done() -> None:
    assert _left(0.0, 0, 20) == "" == _left(10.0, 5, 20), "nothing known, or not worth a word"
    assert _left(300.0, 5, 20) == ", about 15 min left"


def test_command_writes_table_picture_and_numbers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "gyroctl.studies.evaluation.report.TABLES", {"physics": lambda ask: physics_table(ask, WATERS[:2])}
    )
    arguments = ["physics", "--laws", "coupling", "--seeds", "1:2", "--duration", "130", "--workers", "1"]
    done = CliRunner().invoke(app, ["evaluate", *arguments, "--out", str(tmp_path)])
    assert done.exit_code == 0, done.output
    page = (tmp_path / "physics.md").read_text(encoding="utf-8")
    assert "Does the order of the laws change, and which choice turns it?" in page and "## coupling" in page
    assert (tmp_path / "physics.png").is_file()
    content = json.loads((tmp_path / "physics.json").read_text(encoding="utf-8"))
    assert list(content["cases"]) == [LINEAR, "drag 0.5"] and content["answer"]["linear"]


# --- what is said ----------------------------------------------------------------------------------------------------

STRONG = {"a": runs("a", 9.0), "b": runs("b", 6.0, phase=1.0), "best_constant": runs("best_constant", 2.0, phase=2.0)}


def test_order_is_by_paired_differences_and_says_what_can_be_told() -> None:
    near = {**STRONG, "c": runs("c", 6.02, phase=2.5)}
    found = order(near)
    assert found.laws == ("a", "c", "b", "best_constant")
    assert found.words == "a > c ≈ b > best_constant"
    assert told(found.pair("b", "a")) and not told(found.pair("b", "c"))


def test_order_of_laws_with_fewer_realisations_is_that_on_the_same_waves() -> None:
    """Half the seeds are the rough ones: on those the short law is the weaker, though its mean is the higher one."""
    long, short = runs("long", 5.0), runs("short", 5.5, n=8)
    values = {**long.values, "mean_power": np.where(SEEDS <= 8, 7.0, 1.0) + 0.01 * SEEDS}
    other = Runs(long.entrant, long.kind, long.information, long.seeds, long.hashes, values)
    assert float(np.mean(values["mean_power"])) < 5.5
    found = order({"short": short, "long": other})
    assert found.laws == ("long", "short") and found.pair("long", "short").estimate.value > 1.0


def test_choice_that_turns_the_order_is_named() -> None:
    turned = {**STRONG, "a": runs("a", 6.0), "b": runs("b", 9.0, phase=1.0)}
    found = judged(STRONG, kept=STRONG, turning=turned)
    assert [(entry["case"], entry["first"], entry["second"]) for entry in found["turned"]] == [("turning", "b", "a")]
    turn = found["turned"][0]
    assert (turn["here"].value, turn["before"].value) == (pytest.approx(3.0), pytest.approx(-3.0))
    told_ = "\n".join(in_sentences(found))
    assert "`b` before `a` in *turning* (3.0 W)" in told_ and "kept" not in told_
    assert "No choice takes the lock" in told_


def test_choice_that_does_not_turn_it_is_not_named() -> None:
    found = judged(
        STRONG,
        weaker={name: runs(name, 0.5 * float(np.mean(one.values["mean_power"]))) for name, one in STRONG.items()},
    )
    assert not any(
        found[name] for name in ("turned", "turned_lost", "parted", "blurred", "exchanged", "takes_lock", "costs_lock")
    )
    told_ = "\n".join(in_sentences(found))
    assert "weaker" not in told_ and "No choice turns the order" in told_


def test_neighbours_that_chance_exchanges_do_not_turn_the_order() -> None:
    near = {**STRONG, "b": runs("b", 8.9, scatter=2.0, phase=1.0)}
    found = judged(near, noisy={**near, "b": runs("b", 9.1, scatter=2.0, phase=1.0)})
    assert not found["turned"] and [entry["case"] for entry in found["exchanged"]] == ["noisy"]
    assert "within what chance explains: `b` before `a` in *noisy*" in "\n".join(in_sentences(found))


def test_turn_with_the_loss_of_lock_is_told_apart_from_one_among_laws_that_lock() -> None:
    fallen = {**STRONG, "a": runs("a", 1.0, locked=0)}
    found = judged(STRONG, falling=fallen)
    assert not found["turned"]
    assert {(entry["first"], entry["second"]) for entry in found["turned_lost"]} == {("b", "a"), ("best_constant", "a")}
    assert [(entry["law"], entry["held"], entry["held_before"]) for entry in found["takes_lock"]] == [("a", 0, 16)]
    told_ = "\n".join(in_sentences(found))
    assert "It turns where lock is lost: `b` before `a` in *falling* (5.0 W, `a` without lock)" in told_
    assert "Lock is taken from `a` in *falling* (0 of 16)." in told_


def test_few_losses_are_not_said_to_take_the_lock() -> None:
    """The exact sign test: six losses of sixteen come by chance in 3 % of cases, and Holm over three laws asks more."""
    for held, sure in ((14, False), (10, False), (8, True)):
        lost = lost_lock(STRONG, {**STRONG, "a": runs("a", 9.0, locked=held)})
        assert [(one.law, one.held, one.sure) for one in lost] == [("a", held, sure)], held
    assert lost_lock(STRONG, STRONG) == []
    assert lost[0].p_holm == pytest.approx(3 * 2 * 0.5**8)


def test_who_holds_lock() -> None:
    laws = {"all": runs("all", 1.0), "most": runs("most", 1.0, locked=15), "few": runs("few", 1.0, locked=14)}
    assert holding(laws) == ["all", "most"]


def test_change_against_the_linear_plant_is_paired() -> None:
    linear, here = (
        outcome(best_constant=runs("best_constant", 4.0)),
        outcome(best_constant=runs("best_constant", 3.0, n=7, phase=1.0)),
    )
    cell = table_of(here, linear)["best_constant"]
    own, before = here.runs["best_constant"].values["mean_power"], linear.runs["best_constant"].values["mean_power"][:7]
    assert cell.less_linear.value == pytest.approx(float(np.mean(own - before)))
    assert cell.less_linear.value != pytest.approx(-1.0, abs=1e-3), "the mean of all sixteen is another"
    assert (
        table_of(here, outcome(other=runs("other", 1.0)))["best_constant"].of_linear.note
        == "not run in the linear plant"
    )


def test_turns_need_both_laws_in_the_linear_plant() -> None:
    base = order({"a": STRONG["a"], "best_constant": STRONG["best_constant"]})
    assert changes(base, order({**STRONG, "b": runs("b", 20.0)}), []) == []


def test_laws_that_are_told_apart_only_there_or_no_longer() -> None:
    near, noisy = runs("b", 8.9, scatter=2.0, phase=1.0), runs("b", 7.5, scatter=4.0, phase=1.0)
    found = judged({**STRONG, "b": near}, clear=STRONG)
    assert [(entry["case"], entry["first"], entry["second"]) for entry in found["parted"]] == [("clear", "a", "b")]
    found = judged(STRONG, rough={**STRONG, "b": noisy})
    assert [(entry["first"], entry["second"]) for entry in found["blurred"]] == [("a", "b")]
    assert "No longer told apart: `a` before `b` in *rough*" in "\n".join(in_sentences(found))


# --- the picture -----------------------------------------------------------------------------------------------------


def test_picture_shows_power_as_length_and_counts_lost_lock() -> None:
    from matplotlib.patches import Rectangle

    from gyroctl.studies.evaluation.draw_physics import draw_physics

    linear = outcome(best_constant=STRONG["best_constant"], b=STRONG["b"], a=STRONG["a"])
    fallen = outcome(best_constant=STRONG["best_constant"], b=runs("b", -1.0, locked=3), a=STRONG["a"])
    tables = {LINEAR: table_of(linear, linear), "choice": table_of(fallen, linear)}
    figure = draw_physics(tables, {"laws": ["a", "b"], "duration_s": 600.0, "seeds": [1], "own_seeds": {}})
    axes = {axis.get_title(loc="left").replace("\n", "_"): axis for axis in figure.axes}
    axes |= {axis.get_title().replace("\n", "_"): axis for axis in figure.axes if axis.get_title()}
    assert [name for name in axes if name] == ["a", "b", "best_constant"], "as asked for, the reference last"
    lengths = {
        name: [round(p.get_width(), 9) for p in axis.patches if isinstance(p, Rectangle)] for name, axis in axes.items()
    }
    assert lengths["b"] == [6.0, -1.0] and lengths["a"] == [9.0, 9.0]
    inches = {name: axis.get_position().width / float(np.ptp(axis.get_xlim())) for name, axis in axes.items()}
    assert max(inches.values()) == pytest.approx(min(inches.values()), rel=0.05), "a watt is as long for every law"
    assert "3/16" in [text.get_text() for text in axes["b"].texts] and not any(
        "/" in t.get_text() for t in axes["a"].texts
    )
