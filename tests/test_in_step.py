"""In step beside locked: the rule on cases made by hand, and what stands in tables, page, summary and verdict."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console
from test_reports_synthetic import save, synthetic

import gyroctl as gy
from gyroctl.comparison.compare import Realisations, compare
from gyroctl.reports import evaluate, judge, open_results, print_table, summarise, write_report
from gyroctl.reports.verdict import too_few
from gyroctl.simulation.lock import in_step, poisson_limit, turns_kept

WP, DT = 3.14, 0.1
TIME = np.arange(6001) * DT
WAVES = np.full(4, 1000.0)  # so that slips per 1000 waves are counts


# --- turns kept


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("share", [1.0, 0.89, 0.5, 0.0])
def test_turns_kept_of_a_ring_that_misses_some(share: float, sense: int) -> None:
    phasor = 50.0 * np.exp(1j * WP * TIME)
    assert turns_kept(sense * share * WP * TIME + 1.0, phasor, DT, sense) == pytest.approx(share, abs=1e-9)


def test_frequency_of_the_waves_is_weighted_by_their_power() -> None:
    """Half the time at 3 rad/s and twice the height, half at 4: the mean is that of powers 4 to 1."""
    omega = np.where(TIME < 300.0, 3.0, 4.0)
    height = np.where(TIME < 300.0, 2.0, 1.0)
    phase = np.concatenate([[0.0], np.cumsum(omega[:-1] * DT)])
    mean = np.angle(4.0 * np.exp(0.3j) + np.exp(0.4j)) / DT  # the mean of the advance in a sample
    assert turns_kept(mean * TIME, height * np.exp(1j * phase), DT) == pytest.approx(1.0, abs=1e-3)
    assert mean == pytest.approx(3.2, abs=0.01)


def test_run_that_is_not_finite_keeps_no_number_of_turns() -> None:
    psi = WP * TIME
    psi[4000:] = np.nan
    assert np.isnan(turns_kept(psi, np.exp(1j * WP * TIME), DT))
    assert np.isnan(turns_kept(psi[:1], np.ones(1), DT))


# --- the rule


def test_poisson_limit_is_that_of_the_tables() -> None:
    """Garwood's upper limits, one-sided 95 %: 3.00 for none, 4.74, 6.30, ... 16.96 for ten."""
    np.testing.assert_allclose(poisson_limit([0, 1, 2, 3, 10]), [2.996, 4.744, 6.296, 7.754, 16.962], atol=1e-3)


def test_locked_pair_is_the_measure_on_the_same_realisation() -> None:
    """The pair keeps 0.90 to 1.00; the law 0.95 everywhere: in step where 0.98 of the pair's is no more than that."""
    pair = np.array([0.90, 0.96, 0.97, 1.00])
    found = in_step(np.full(4, 0.95), np.zeros(4), WAVES, pair, np.zeros(4), np.ones(4))
    np.testing.assert_array_equal(found, [True, True, False, False])
    assert in_step([0.98 * 0.96], [0.0], [1000.0], [0.96], [0.0], [True])[0]
    assert not in_step([0.98 * 0.96 - 1e-9], [0.0], [1000.0], [0.96], [0.0], [True])[0]


def test_where_the_pair_lost_lock_its_median_over_the_locked_runs_counts() -> None:
    pair, locked = np.array([0.94, 0.96, 0.99, 0.30]), [True, True, True, False]
    law = np.array([0.94, 0.94, 0.94, 0.94])
    np.testing.assert_array_equal(in_step(law, np.zeros(4), WAVES, pair, np.zeros(4), locked), [1, 0, 0, 0])
    law[3] = 0.98 * 0.96
    assert in_step(law, np.zeros(4), WAVES, pair, np.zeros(4), locked)[3]


@pytest.mark.parametrize("pair", [(), ([0.5, 0.6, 0.4, 0.3], [500.0] * 4, [False] * 4)], ids=["none", "never locked"])
def test_without_a_locked_pair_the_rule_is_absolute(pair: Any) -> None:
    law, slips = [0.98, 0.979, 1.0, 1.0], [0.0, 0.0, 2.9, 3.1]
    np.testing.assert_array_equal(in_step(law, slips, WAVES, *pair), [True, False, True, False])


def test_slips_are_held_against_the_limit_of_the_pair_s_median() -> None:
    """The pair slips 0, 10, 10 and, lost, 400: its median over locked runs is 10, and 16.96 the limit."""
    pair = (np.ones(4), np.array([0.0, 10.0, 10.0, 400.0]), [True, True, True, False])
    np.testing.assert_array_equal(in_step(np.ones(4), [0.0, 16.9, 17.0, 16.9], WAVES, *pair), [1, 1, 0, 1])
    # in half the waves 5 stand for 10 per 1000, and the limit of 5 is 10.5, or 21 per 1000
    half = np.full(4, 500.0)
    np.testing.assert_array_equal(in_step(np.ones(4), [20.9, 21.1, 20.9, 20.9], half, *pair), [1, 0, 1, 1])


def test_laws_stand_in_rows_and_no_number_is_not_in_step() -> None:
    turns = np.array([[1.0, np.nan, 1.0, 0.9], [0.9, 1.0, 1.0, 1.0]])
    slips = np.array([[0.0, 0.0, np.nan, 0.0], [0.0, 0.0, 0.0, 9.0]])
    found = in_step(turns, slips, WAVES, np.ones(4), np.zeros(4), np.ones(4))
    np.testing.assert_array_equal(found, [[1, 0, 0, 0], [0, 1, 1, 0]])


@pytest.mark.parametrize(
    ("count", "needed", "runs", "out"),
    [
        (8, 8, 8, False),
        (6, 8, 8, False),
        (5, 8, 8, True),
        (2, 4, 4, True),
        (0, 0, 4, True),
        (0, 1, 1, True),
        (1, 1, 1, False),
        (15, 13, 16, False),
        (50, 60, 64, True),
        (58, 60, 64, False),
    ],
)
def test_what_chance_does_not_explain_is_too_few(count: int, needed: int, runs: int, out: bool) -> None:
    assert too_few(count, needed, runs) is out


# --- a comparison


@pytest.fixture(scope="module")
def ds(device: gy.Plant) -> Any:
    laws = {name: gy.law(name) for name in ("best_constant", "coupling", "tracking")}
    return compare(device, laws, Realisations(gy.SeaState(), (1, 2, 3, 4, 5), 600.0), quiet=True)


def test_law_that_loses_every_tenth_turn_is_locked_but_not_in_step(ds: Any) -> None:
    slow = ds.sel(law="tracking")
    assert bool(slow.locked.all()) and not bool(slow.in_step.any())
    assert float(slow.turns_kept.mean()) < 0.93
    assert int(ds.sel(law="coupling").in_step.sum()) >= 4 and bool(ds.sel(law="coupling").locked.all())
    own = ds.sel(law="best_constant")
    kept = (ds[name].values for name in ("turns_kept", "cycle_slips", "waves_counted"))
    pair = (own[name].values for name in ("turns_kept", "cycle_slips", "locked"))
    expected = in_step(*kept, *pair)
    np.testing.assert_array_equal(ds.in_step, expected)


def test_share_of_the_time_and_largest_angle_are_those_of_the_trajectory(device: gy.Plant, ds: Any) -> None:
    run = gy.simulate(device, gy.law("coupling"), gy.realise(device, gy.SeaState(), 3, 600.0))
    far = np.maximum(np.abs(run.phi1), np.abs(run.phi3)).values[1000:]
    found = ds.sel(law="coupling", realisation=3)
    assert float(found.outside_share) == pytest.approx(float((far > 0.3).mean()))
    assert float(np.maximum(found.phi1_max, found.phi3_max)) == far.max()
    assert bool(found.outside_model) == (far.max() > 0.3)


def test_limit_of_motion_is_judged_run_by_run(device: gy.Plant, ds: Any) -> None:
    middle = float(ds.phi1_p98.sel(law="coupling").median())
    waves = Realisations(gy.SeaState(), (1, 2, 3, 4, 5), 600.0)
    tight = compare(device, {"coupling": gy.law("coupling")}, waves, motion_limit=middle, quiet=True)
    np.testing.assert_array_equal(tight.over_limit, (tight.phi1_p98 > middle) | (tight.phi3_p98 > middle))
    assert 0 < int(tight.over_limit.sum()) < 5
    assert not bool(ds.over_limit.any())


def test_slipping_law_does_not_win_and_is_named(ds: Any) -> None:
    verdict = judge(evaluate(ds.sel(law=["best_constant", "tracking"])))
    text, beware = " ".join(verdict.sentences), " ".join(verdict.caveats)
    assert verdict.winner == "best_constant"
    assert "tracking gives more power" in text and "in step with the waves in 0 of 5 runs" in text
    assert "Locked but not in step with the waves: tracking in 5 of 5 runs" in beware
    whole = judge(evaluate(ds))
    assert (
        whole.winner == "best_constant" and "of 5 (95 %" in whole.sentences[1] and "of the turns" in whole.sentences[1]
    )


@pytest.mark.slow
def test_every_table_shows_turns_slips_step_and_motion(ds: Any, tmp_path: Path) -> None:
    text = io.StringIO()
    print_table(ds, console=Console(file=text, width=90, color_system=None))
    printed = text.getvalue()
    for heading in ("locked", "in step", "turns", "slips", "stored", "generated", "largest", "> 0.3 rad", "over limit"):
        assert heading in printed, heading
    assert "0/5" in printed
    page = write_report(ds, tmp_path / "report.html").read_text(encoding="utf-8")
    for heading in ("In step", "Turns kept", "Cycle slips", "Beyond 0.3 rad", "Over the limit", "stored"):
        assert heading in page, heading
    for name, law in summarise(ds)["laws"].items():
        own = ds.sel(law=name)
        assert law["in_step"] == int(own.in_step.sum())
        for key in ("turns_kept", "stored_w", "generated_w", "outside_share"):
            assert law[key] == pytest.approx(float(own[key].mean()))
        assert law["mean_power_w"] == pytest.approx(law["generated_w"] + law["stored_w"])
        assert law["phi1_max"] == float(own.phi1_max.max())


@pytest.mark.slow
def test_results_of_before_are_still_read(tmp_path: Path) -> None:
    """A file without the newer variables: they are unknown, not zero, and that is said."""
    old = synthetic(lock=1.0)
    assert not {"turns_kept", "in_step", "generated_w", "outside_share"} & set(old.data_vars)
    save(old, tmp_path / "results.nc")
    again = open_results(tmp_path)
    found = summarise(again)["laws"]["coupling"]
    assert found["in_step"] is None and found["turns_kept"] is None and found["outside_share"] is None
    text = io.StringIO()
    print_table(again, console=Console(file=text, width=90, color_system=None))
    assert "–" in text.getvalue() and "not recorded" in text.getvalue()
    assert "whether it was in step with the waves is not recorded" in " ".join(judge(evaluate(again)).sentences)
    assert write_report(again, tmp_path / "report.html").is_file()


# --- too short to judge


@pytest.mark.parametrize("scored", [1.0, 9.9])
def test_run_too_short_for_the_verdict_is_refused(device: gy.Plant, scored: float) -> None:
    waves = Realisations(gy.SeaState(), (1, 2), 20.0 + scored)
    with pytest.raises(gy.InputError, match="judged by means over 10 s") as caught:
        compare(device, {"best_constant": gy.law("best_constant")}, waves, gy.Settings(blend=20.0), quiet=True)
    assert caught.value.field == "run.duration"


def test_run_of_just_ten_seconds_is_judged(device: gy.Plant) -> None:
    waves = Realisations(gy.SeaState(), (1,), 30.0)
    ds = compare(device, {"best_constant": gy.law("best_constant")}, waves, gy.Settings(blend=20.0), quiet=True)
    assert bool(ds.locked.all())


def test_simulate_says_what_it_cannot_judge(tmp_path: Path) -> None:
    from typer.testing import CliRunner

    from gyroctl.cli.app import app

    def said(duration: str) -> str:
        words = ["simulate", "--law", "coupling", "--out", str(tmp_path / "run.nc"), "--blend", "20"]
        done = CliRunner().invoke(app, [*words, "--duration", duration])
        assert done.exit_code == 0, done.output
        return " ".join(done.output.split())

    assert "lock not judged" in said("25")
    whole = said("60")
    for words in ("kept lock", "generated", "stored", "of the turns kept", "slips per 1000 waves", "largest |phi|"):
        assert words in whole, words
