"""Ranks of the search, scores by the goal, the choice among the confirmed, and the front."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from cmaes import CMA
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from gyroctl.tuning.goal import Goal
from gyroctl.tuning.pareto_front import FrontRow, front_rows, nondominated, write_front
from gyroctl.tuning.stages import Seen, ranked
from gyroctl.tuning.task import SEAS
from gyroctl.tuning.tune import chosen


def means(**changes: float) -> dict[str, float]:
    base = {
        "mean_power": 2.0,
        "power_cv": 0.3,
        "locked": 1.0,
        "phi1_p98": 0.2,
        "phi3_p98": 0.2,
        "cycle_slips": 0.0,
        "short_reserve": 0.0,
        "turns_kept": 0.96,
        "reversed": 0.0,
    }
    return {**base, **changes}


# --- the search ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scale", [1.0, 100.0])
def test_search_finds_the_top_of_a_stretched_hill(scale: float) -> None:
    """An ellipsoid with axes in the ratio of `scale`, turned: the covariance has to adapt."""
    turn = np.linalg.qr(np.random.default_rng(0).standard_normal((5, 5)))[0]
    top, weights = np.array([0.5, -1.0, 0.2, 0.0, 0.7]), scale ** np.linspace(0.0, 1.0, 5)
    strategy = CMA(np.zeros(5), 0.3, seed=3, population_size=12)
    for _ in range(220):
        points = [strategy.ask() for _ in range(12)]
        strategy.tell(ranked(points, [-float(weights @ ((point - top) @ turn) ** 2) for point in points]))
    np.testing.assert_allclose(strategy.mean, top, atol=1e-5)


def test_search_is_told_ranks_alone_and_what_is_no_number_comes_last() -> None:
    points = [np.full(2, i) for i in range(6)]
    told = ranked(points, [math.nan, 2.0, -math.inf, 5.0, 2.0, math.nan])
    assert [int(point[0]) for point, _ in told] == [3, 1, 4, 2, 0, 5]
    assert [rank for _, rank in told] == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]


# --- goals and choice ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "worse",
    [
        {"mean_power": 1.5},
        {"locked": 0.98},
        {"phi1_p98": 0.4},
        {"phi3_p98": 0.4},
        {"power_cv": 0.6},
        {"short_reserve": 0.01},
    ],
    ids=lambda changes: next(iter(changes)),
)
def test_score_falls_with_everything_that_is_worse(worse: dict[str, float]) -> None:
    goal = Goal(power_cv=0.35)
    assert goal.score(means(**worse), 2.0) < goal.score(means(), 2.0)


def test_one_loss_in_sixty_four_outweighs_a_fifth_of_the_power() -> None:
    goal = Goal()
    assert goal.score(means(mean_power=2.4, locked=63 / 64), 2.0) < goal.score(means(), 2.0)


def test_goal_is_met_within_its_limits_only() -> None:
    goal = Goal(locked=0.99, motion=0.34, power_cv=0.35)
    assert goal.met(means())
    assert goal.missed(means()) == []
    for worse in ({"locked": 63 / 64}, {"phi1_p98": 0.35}, {"phi3_p98": 0.35}, {"power_cv": 0.36}):
        assert not goal.met(means(**worse))
        (told,) = goal.missed(means(**worse))
        assert f"{next(iter(worse.values())):.4g}" in told
    nothing = Goal(turns=0.98, forward=0.9).missed(means(turns_kept=math.nan, reversed=0.5))
    assert nothing == ["turns kept nan, at least 0.98", "runs without a reversal 0.5, at least 0.9"]


def test_chosen_meets_the_goal_before_it_has_power() -> None:
    seas = {"gamma5": SEAS["gamma5"]}
    strong = Seen({"cg": 2.0}, {"gamma5": means(mean_power=4.0, power_cv=0.36)}, "confirm")
    good = Seen({"cg": 1.0}, {"gamma5": means()}, "confirm")
    assert chosen([strong, good], {"gamma5": Goal(power_cv=0.35)}, seas) is good
    assert chosen([strong, good], {"gamma5": Goal()}, seas) is strong


@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.lists(st.tuples(*[st.integers(0, 4)] * 3), min_size=1, max_size=30))
def test_front_is_what_no_point_beats(points: list[tuple[int, int, int]]) -> None:
    def beats(a: tuple[int, int, int], b: tuple[int, int, int]) -> bool:
        return a != b and all(x >= y for x, y in zip(a, b, strict=True))

    expected = [not any(beats(other, point) for other in points) for point in points]
    assert nondominated(np.array(points, float)).tolist() == expected


def test_front_keeps_to_the_motion_limit_and_tells_what_ships(tmp_path: Path) -> None:
    archive = [
        Seen({"cg": 1.0}, {"mild": means()}, "confirm"),
        Seen({"cg": 2.0}, {"mild": means(mean_power=3.0, phi1_p98=0.5)}, "confirm"),
        Seen({"cg": 3.0}, {"mild": means(mean_power=1.0)}, "search"),
    ]
    sets = {"mild": {"parameters": {"cg": 1.0}, "result": {"mild": {}}}}
    rows = front_rows(archive, sets, {"mild": 0.34})
    assert [(row.stage, row.front, row.chosen) for row in rows] == [
        ("search", True, ""),
        ("confirm", True, "mild"),
        ("confirm", False, ""),
    ]
    write_front(rows, tmp_path / "front.csv")
    text = (tmp_path / "front.csv").read_text().splitlines()
    assert text[0].startswith("sea,stage,mean_power_w") and text[0].endswith(",cg")
    assert text[1].startswith("mild,confirm,3,0.3,1,0.5,0,")
    assert isinstance(rows[0], FrontRow)


def test_turns_and_reversals_count_where_they_are_asked_for() -> None:
    bad = means(turns_kept=0.9, reversed=0.25)
    assert Goal().met(bad) and Goal().score(bad, 1.0) == Goal().score(means(), 1.0)
    turning, forward = Goal(turns=0.94), Goal(forward=0.9)
    assert turning.met(means()) and not turning.met(bad) and forward.met(means()) and not forward.met(bad)
    assert turning.score(bad, 1.0) == pytest.approx(turning.score(means(), 1.0) - 30.0 * 0.04)
    assert forward.score(bad, 1.0) == pytest.approx(forward.score(means(), 1.0) - 4.0 * 0.25)
    assert forward.met(means(reversed=0.1)) and forward.score(means(reversed=0.1), 1.0) < forward.score(means(), 1.0)
