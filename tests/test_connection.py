"""Does the coupling help: both devices on identical waves, and the search for controls of a rigidly geared device."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.harness.yardstick import Yardstick
from gyroctl.statistics import holm, paired_difference
from gyroctl.studies.connection import Answer, answer_of, compare_connections, connection_report, draw, runs, table
from gyroctl.studies.connection.report import flat
from gyroctl.studies.style import styled
from gyroctl.tuning.bench import scanning
from gyroctl.tuning.best_pair import Lengths, best_pair, distinct, first_grid
from gyroctl.writing import plain

SEEDS, DURATION, GAINS = (1, 2, 3, 4), 240.0, (3.5e-4, 1.5e-3, 4e-3)


def known(plant: gy.Plant, sea: gy.SeaState, **_: Any) -> Yardstick:
    """A pair for each device, in the place of a search."""
    return (
        Yardstick(0.0, 2e-4, True, "given")
        if plant.parameters.connection == "rigid"
        else Yardstick(0.06, 4e-4, True, "")
    )


@pytest.fixture(scope="module")
def rigid(device: gy.Plant) -> gy.Plant:
    return device.replace(connection="rigid")


@pytest.fixture(scope="module")
def answer() -> Answer:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(runs, "find_yardstick", known)
        return compare_connections((1.0, 50.0), (0.283,), SEEDS, DURATION, gains=GAINS, workers=1, quiet=True)


# --- the runs ------------------------------------------------------------------------------------------------------


def test_each_device_runs_with_its_own_pair_on_the_same_waves(
    answer: Answer, device: gy.Plant, rigid: gy.Plant
) -> None:
    """Against runs of the two laws, put together here."""
    sea, case = gy.SeaState(gamma=50.0), answer.at_best[1]
    power = {}
    for name, plant in (("magnetic", device), ("rigid", rigid)):
        law = known(plant, sea).law
        waves = [gy.realise(plant, sea, seed, DURATION) for seed in SEEDS]
        power[name] = gy.compare(plant, {"constant": law}, waves, workers=1, quiet=True).mean_power.values[0]
        assert getattr(case, name).power.value == pytest.approx(power[name].mean(), rel=1e-12)
    expected, _ = paired_difference(power["magnetic"], power["rigid"])
    assert case.gain == expected
    assert (case.magnetic.cc, case.rigid.cc, case.rigid.cg) == (0.06, 0.0, 2e-4)


def test_time_in_lock_at_the_same_gain_is_that_of_single_runs(
    answer: Answer, device: gy.Plant, rigid: gy.Plant
) -> None:
    """A gain at which some of the runs are lost, some not: when, by single runs in the loop."""
    (case,) = (one for one in answer.same_gain if one.gamma == 50.0 and one.cg == 1.5e-3)
    times = {}
    for plant in (device, rigid):
        waves = [gy.realise(plant, gy.SeaState(gamma=50.0), seed, DURATION) for seed in SEEDS]
        ds = gy.compare(plant, {"constant": gy.law("constant", cc=runs.CC, cg=1.5e-3)}, waves, workers=1, quiet=True)
        lost = ds.loss_time.values[0]
        times[plant.parameters.connection] = np.where(np.isfinite(lost), lost, DURATION)
    held = [float(np.mean(times[name] == DURATION)) for name in ("magnetic", "rigid")]
    assert [case.magnetic.value, case.rigid.value] == held and held != [0.0, 0.0] and held != [1.0, 1.0]
    expected = np.mean(times["magnetic"] - times["rigid"])
    assert case.longer.value == pytest.approx(expected, abs=0.2)


def test_corrections_are_over_all_cases_of_a_question(answer: Answer) -> None:
    """A p-value that was never corrected would be smaller than what Holm makes of all of them."""
    assert len(answer.same_gain) == 6 and len(answer.at_best) == 2
    for cases in (answer.same_gain, answer.at_best):
        told = [case.p_holm for case in cases]
        assert all(0.0 <= p <= 1.0 for p in told if np.isfinite(p))
        assert all(case.words for case in cases)
    raw = [paired_difference(*_powers(answer, i))[1] for i in range(2)]
    assert [case.p_holm for case in answer.at_best] == pytest.approx(holm(raw), nan_ok=True)


def _powers(answer: Answer, i: int) -> tuple[np.ndarray, np.ndarray]:
    sea, found = gy.SeaState(gamma=answer.at_best[i].gamma), []
    for plant in (gy.zhang2017(), gy.zhang2017(connection="rigid")):
        waves = [gy.realise(plant, sea, seed, DURATION) for seed in SEEDS]
        ds = gy.compare(plant, {"constant": known(plant, sea).law}, waves, workers=1, quiet=True)
        found.append(ds.mean_power.values[0])
    return found[0], found[1]


def test_other_waves_for_one_of_them_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    def other(plant: gy.Plant, sea: gy.SeaState, seed: int, duration: float) -> gy.WaveRealisation:
        return gy.realise(plant, sea, seed + (plant.parameters.connection == "rigid"), duration)

    monkeypatch.setattr(runs, "find_yardstick", known)
    monkeypatch.setattr(runs, "realise", other)
    with pytest.raises(RuntimeError, match="same waves"):
        compare_connections((5.0,), (0.2,), SEEDS, 120.0, gains=(1e-4,), workers=1, quiet=True)


@pytest.mark.parametrize(
    ("given", "field"),
    [
        ({"gammas": ()}, "gammas"),
        ({"heights": ()}, "heights"),
        ({"seeds": (1, 2, 3)}, "seeds"),
        ({"gains": ()}, "gains"),
        ({"plant": gy.zhang2017(connection="rigid")}, "plant"),
        ({"heights": (-0.2,)}, "sea.hs"),
    ],
)
def test_what_cannot_be_asked_is_refused_by_name(given: dict[str, Any], field: str) -> None:
    with pytest.raises(gy.InputError) as caught:
        compare_connections(**given, quiet=True)
    assert caught.value.field == field


# --- what is written ------------------------------------------------------------------------------------------------


def test_figure_says_what_it_shows_with_units_and_the_same_scale_for_what_is_compared(answer: Answer) -> None:
    with styled():
        figure = draw(answer)
    above, below = figure.axes[:2], figure.axes[2:]
    assert len({axes.get_ylim() for axes in above}) == len({axes.get_ylim() for axes in below}) == 1
    shown = [one.power.value for case in answer.at_best for one in (case.magnetic, case.rigid)]
    assert below[0].get_ylim()[0] <= min(shown) and max(shown) <= below[0].get_ylim()[1], (
        "no point outside of the panel"
    )
    assert "[W]" in below[0].get_ylabel() and "[m]" in below[0].get_xlabel() and "Nms]" in above[0].get_xlabel()
    (legend,) = figure.legends
    assert {text.get_text() for text in legend.get_texts()} == {"with the coupling", "rigidly geared"}
    figure.canvas.draw()
    assert all(not legend.get_window_extent().overlaps(axes.get_window_extent()) for axes in figure.axes)


def test_table_and_sentences_count_what_the_cases_say(answer: Answer) -> None:
    text = table(answer)
    assert len([line for line in text.splitlines() if line.startswith("| ")]) == 1 + len(answer.at_best)
    for cases, sentence, words in zip(
        (answer.same_gain, answer.at_best), answer.sentences, (runs.LONGER, runs.POWER), strict=True
    ):
        said = [case.words for case in cases]
        assert f"{words[0]} in {said.count(words[0])}, {words[1]} in {said.count(words[1])} " in sentence
        assert f"of {len(cases)}" in sentence and sentence in text


def test_an_answer_is_read_back_from_its_record(answer: Answer) -> None:
    record = {
        "same_gain": [flat(case) for case in answer.same_gain],
        "at_best": [flat(case) for case in answer.at_best],
    }
    kept = json.loads(json.dumps(plain({**record, "seeds": list(answer.seeds), "duration_s": answer.duration})))
    again = answer_of(kept)
    assert (again.gammas, again.heights, again.seeds, again.duration) == (
        answer.gammas,
        answer.heights,
        SEEDS,
        DURATION,
    )
    np.testing.assert_equal(again.same_gain, answer.same_gain)
    np.testing.assert_equal(again.at_best, answer.at_best)


@pytest.mark.slow
def test_report_searches_and_keeps_all_figures_of_the_answer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GYROCTL_CACHE", str(tmp_path / "cache"))
    connection_report(tmp_path / "out", range(1, 9), (5.0,), (0.283,), 600.0, budget=1e6, workers=2, quiet=True)
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        f"connection.{e}" for e in ("json", "md", "png", "svg", "pdf")
    }
    content = json.loads((tmp_path / "out" / "connection.json").read_text(encoding="utf-8"))
    (best,) = content["at_best"]
    assert best["rigid"]["cc"] == 0.0 < best["magnetic"]["cc"] and "100000" in best["rigid"]["found"]
    assert best["gain"]["low"] <= best["gain"]["value"] <= best["gain"]["high"]
    greedy = [case for case in content["same_gain"] if case["cg"] == 1e-3]
    assert greedy[0]["longer"]["value"] > 0.0, "the paper's claim: the coupling widens the margin of lock"


# --- the search on a rigidly geared device ----------------------------------------------------------------------------


def test_search_for_the_best_pair_of_a_rigid_device_asks_for_its_gain_alone(rigid: gy.Plant) -> None:
    lengths = Lengths(0.025, 200.0, 120.0)
    found = best_pair(
        rigid, gy.SeaState(), 12 * 4 * 200.0 / 0.1 + 1.0, range(100128, 100132), None, lengths=lengths, quiet=True
    )
    assert found.cc == 0.0 and all(cc == 0.0 for (cc, _), _, _ in found.seen)
    each = [(pair, stage, row["mean_power"]) for pair, row, stage in found.seen]
    first = [pair for pair, stage, _ in each if stage == "search"][:12]
    assert len(set(first)) == 12, "no gain twice because of a coupling that is not there"


def test_only_a_rigid_device_forgets_the_coupling(device: gy.Plant, rigid: gy.Plant) -> None:
    pairs = first_grid(gy.Settings())
    assert distinct(device, pairs) == pairs
    assert distinct(rigid, pairs) == [(0.0, cg) for cg in sorted({cg for _, cg in pairs})]


def test_steps_of_a_search_on_a_rigid_device_have_no_slip_to_follow(rigid: gy.Plant) -> None:
    assert scanning(rigid, gy.law("load_angle"), gy.Settings(), 0.025).dt == 0.025
