"""The rows of the study's tables by hand: pairing, locks, motion of both joints, what is no number, other waves."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import ttest_1samp

import gyroctl as gy
from gyroctl.reports.layout import MOTION_LIMIT
from gyroctl.statistics import paired_ratio
from gyroctl.statistics.intervals import chance_of_no_lead
from gyroctl.studies.evaluation.cases import Runs, check_waves, common_seeds
from gyroctl.studies.evaluation.entrants import Entrant
from gyroctl.studies.evaluation.rows import row

OWN = {11: 4.0, 12: 5.0, 13: 7.5, 14: 6.0, 15: 9.0, 16: 2.0}
"""Mean power of the law by seed. [W]"""

OTHER = {16: 1.0, 15: 2.5, 14: 2.0, 13: 3.0, 12: 2.0, 10: 50.0}
"""And that of the reference: in another order, on other seeds. [W]"""

COMMON = (12, 13, 14, 15, 16)


class Metrics(dict[str, NDArray[np.float64]]):
    """Metrics of n runs: those that are given, zeros for every other."""

    def __init__(self, n: int, given: dict[str, Any]) -> None:
        super().__init__({name: np.array(values, float) for name, values in given.items()})
        self.n = n

    def __missing__(self, name: str) -> NDArray[np.float64]:
        return np.zeros(self.n)


def made(power: dict[int, float], label: str = "law", **given: Any) -> Runs:
    """Runs of a law with that mean power by seed; `given` are its other metrics."""
    n = len(power)
    values = Metrics(n, {"mean_power": list(power.values()), "locked": np.ones(n), **given})
    hashes = tuple(str(seed) for seed in power)
    return Runs(Entrant(label, label), "simple", "sensors", np.array(list(power), np.int64), hashes, values)


@pytest.fixture(scope="module")
def reference() -> Runs:
    return made(OTHER, "best_constant")


def test_law_and_reference_are_paired_seed_by_seed(reference: Runs) -> None:
    found = row(made(OWN), reference)
    own, other = (np.array([power[seed] for seed in COMMON]) for power in (OWN, OTHER))
    assert found.pairs == len(COMMON)
    assert found.difference.value == pytest.approx(np.mean(own - other))
    assert found.ratio.value == pytest.approx(own.mean() / other.mean())
    # the p-value and the intervals know which runs belong together, the means do not
    for values, same in ((other, True), (other[::-1], False)):
        p_value = max(ttest_1samp(own - values, 0.0).pvalue, float(chance_of_no_lead(own, values)))
        assert bool(abs(found.p_value - p_value) < 1e-6 * p_value) is same
    assert found.difference.low < found.difference.value < found.difference.high
    assert found.ratio.high == pytest.approx(paired_ratio(own, other).high)


def test_values_are_those_of_the_seeds_that_are_asked_for(reference: Runs) -> None:
    assert common_seeds(made(OWN), reference) == COMMON
    assert common_seeds(reference, made(OWN)) == COMMON[::-1]
    assert reference.on((12, 10, 16), "mean_power").tolist() == [2.0, 50.0, 1.0]


def test_runs_that_lost_lock_are_counted_and_their_power_kept_apart(reference: Runs) -> None:
    found = row(made(OWN, locked=[1, 0, 1, 1, 0, 1]), reference)
    assert (found.locked, found.runs) == (4, 6)
    assert found.lock.value == pytest.approx(4 / 6)
    assert found.power_locked == pytest.approx(np.mean([4.0, 7.5, 6.0, 2.0]))
    assert found.power.value == pytest.approx(np.mean(list(OWN.values()))), "lost runs count in the mean"
    assert row(made(OWN, locked=np.zeros(6)), reference).locked == 0


def test_either_joint_beyond_the_limit_counts(reference: Runs) -> None:
    over, within, nan = 1.01 * MOTION_LIMIT, 0.99 * MOTION_LIMIT, np.nan
    phi1 = [over, within, over, within, within, nan]
    phi3 = [within, over, over, within, nan, within]
    found = row(made(OWN, phi1_p98=phi1, phi3_p98=phi3), reference)
    assert found.over_limit == 5, "what is no number is not within a limit"
    apart = row(made(OWN, phi1_p98=[0.1, 0.2, 0.3, 0.1, 0.2, 0.3], phi3_p98=[0.1, 0.2, 0.1, 0.2, 0.1, 0.9]), reference)
    assert (apart.phi1_worst, apart.phi3_worst) == (0.3, 0.9)
    assert apart.phi1_p98 == pytest.approx(0.2)
    assert apart.motion == pytest.approx(1.6 / 6), "the larger of the two means"


@pytest.mark.parametrize("name", ["phi1_p98", "phi3_p98"])
def test_motion_that_is_no_number_stays_none(reference: Runs, name: str) -> None:
    spoilt = row(made(OWN, **{name: np.full(6, np.nan), "locked": np.ones(6)}), reference)
    assert np.isnan(spoilt.motion)


def test_run_without_a_power_is_no_run_of_zero_watts(reference: Runs) -> None:
    found = row(made({**OWN, 13: np.nan}), reference)
    assert found.power.value == pytest.approx(np.mean([4.0, 5.0, 6.0, 9.0, 2.0]))
    assert "not finite" in found.power.note, "and is told of"
    kept = [seed for seed in COMMON if seed != 13]
    difference = np.mean([OWN[seed] - OTHER[seed] for seed in kept])
    assert found.difference.value == pytest.approx(difference)
    assert "not finite" in found.difference.note


def test_each_column_is_that_of_its_name(reference: Runs) -> None:
    steps = {"step_ms_median": np.full(6, 2.0), "step_ms_p99": [3.0, 4.0, 3.0, 3.0, 3.0, 3.0]}
    given = {
        "power_cv": [0.1, 0.2, 0.3, 0.4, 0.5, 0.6],
        "power_cv_1s": [0.01, 0.02, 0.03, 0.04, 0.05, 0.06],
        "ledger_residual": [1e-9, -5e-3, 1e-9, 1e-9, 1e-9, 1e-9],
        "cycle_slips": np.full(6, 7.0),
        "slip_loss_w": np.full(6, 0.5),
        "wave_input_w": np.full(6, 16.0),
        "saturations": np.full(6, 11.0),
        "fallbacks": np.full(6, 2.0),
        "deadline_misses": np.full(6, 3.0),
    }
    found = row(made(OWN, **given, **steps), reference)
    assert found.cv.value == pytest.approx(0.35)
    assert found.cv_1s.value == pytest.approx(0.035)
    assert found.ledger_residual == 5e-3
    assert (found.cycle_slips, found.slip_loss_w, found.wave_input_w, found.saturations) == (7.0, 0.5, 16.0, 11.0)
    assert (found.fallbacks, found.deadline_misses) == (12, 18)
    assert (found.step_ms_median, found.step_ms_p99) == (2.0, 4.0)


def test_other_waves_under_a_seed_are_refused() -> None:
    one, other = made(OWN), made(OTHER, "other")
    check_waves([one, other])
    foreign = Runs(other.entrant, "simple", "sensors", other.seeds, ("x",) * len(OTHER), other.values)
    with pytest.raises(gy.InputError, match="other waves under seed"):
        check_waves([one, foreign])
