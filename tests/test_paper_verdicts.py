"""When a statement of one realisation agrees with an ensemble: the rules on numbers made by hand."""

from __future__ import annotations

import numpy as np
import pytest

from gyroctl.studies.paper.verdicts import close, holds, is_true, larger, loses, one_draw, within


@pytest.mark.parametrize(
    ("held", "verdict", "opposite"), [(64, "agree", "differ"), (0, "differ", "agree"), (32, "open", "open")]
)
def test_lock_is_judged_by_its_interval_against_one_half(held: int, verdict: str, opposite: str) -> None:
    locked = np.arange(64) < held
    assert holds(locked).verdict == verdict
    assert loses(locked).verdict == opposite
    assert holds(locked).value == loses(locked).value == held / 64


def test_a_narrow_majority_of_few_runs_stays_open() -> None:
    """Six of eight: Wilson's interval is 0.41 to 0.93."""
    few = holds(np.arange(8) < 6)
    assert few.verdict == "open"
    assert few.low == pytest.approx(0.409, abs=2e-3)
    assert few.high == pytest.approx(0.929, abs=2e-3)
    assert holds(np.arange(64) < 48).verdict == "agree"  # the same share of more runs decides


def test_one_draw_is_measured_against_the_spread_and_not_the_mean() -> None:
    values = np.linspace(1.0, 2.0, 101)  # mean 1.5 with a narrow interval; the central 95 % are 1.025 to 1.975
    typical = one_draw(values, 1.1, 0.0, "W", "runs")
    assert typical.verdict == "agree"
    assert typical.value == pytest.approx(1.5)
    assert typical.low > 1.1
    assert one_draw(values, 2.0, 0.0, "W", "runs").verdict == "differ"
    assert one_draw(values, 2.0, 0.05, "W", "runs").verdict == "agree"  # as far as its last digit reaches
    assert one_draw(values, 1.0, 0.0, "W", "runs").verdict == "differ"


def test_runs_that_do_not_exist_are_left_out_and_too_few_decide_nothing() -> None:
    values = np.array([1.0, 1.1, 0.9, np.nan, np.nan])
    few = one_draw(values, 1.0, 0.0, "W", "runs that kept lock")
    assert few.verdict == "open"
    assert "only 3" in few.note
    assert few.value == pytest.approx(1.0)
    none = within(np.full(5, np.nan), (1.0, 2.0), "W", "runs")
    assert none.verdict == "open"
    assert np.isnan(none.value)
    assert one_draw(np.append(values, 1.05), 1.0, 0.0, "W", "runs").verdict == "agree"


@pytest.mark.parametrize(
    ("bounds", "verdict"), [((1.0, 2.0), "agree"), ((2.0, 3.0), "differ"), ((0.0, 1.0), "differ"), ((1.5, 3.0), "open")]
)
def test_range_contains_the_interval_of_the_mean(bounds: tuple[float, float], verdict: str) -> None:
    values = np.linspace(1.2, 1.8, 64)  # mean 1.5, interval about 1.46 to 1.54
    assert within(values, bounds, "W", "runs").verdict == verdict


def test_larger_is_judged_on_pairs() -> None:
    rng = np.random.default_rng(0)
    common = 1000.0 * rng.standard_normal(32)
    gain = 10.0 + rng.standard_normal(32)
    assert larger(common + gain, common, "s", "").verdict == "agree"  # hidden without pairing
    assert larger(common, common + gain, "s", "").verdict == "differ"
    assert larger(common, common + rng.standard_normal(32) * 5.0, "s", "").verdict == "open"
    assert larger(common, common, "s", "").verdict == "open"


def test_numbers_without_chance() -> None:
    assert close(1.009, 1.0, 0.01, "").verdict == "agree"
    assert close(1.011, 1.0, 0.01, "").verdict == "differ"
    assert is_true(1.0, True, "", "").verdict == "agree"
    assert is_true(np.nan, False, "", "").verdict == "differ"
