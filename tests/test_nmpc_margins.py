"""What a plan asks of the ring: its floor, the grip of the contact, and room for what is not known of the waves."""

from __future__ import annotations

import math

import numpy as np
import pytest
from test_nmpc_sample import work_of

import gyroctl as gy
from gyroctl.controllers.nmpc.problem import NOW, RING, RING_ANGLE, V1, V3, Weights, stage_cost, weights
from gyroctl.controllers.nmpc.sample import DOUBTED, doubted
from gyroctl.plant.compiled import entry_point

FLOOR, LOCK, GRIP = 1.3, 2000.0, 3.0
_cost = entry_point(stage_cost)


@pytest.fixture(scope="module")
def asked() -> Weights:
    """Weights of a device whose motion is nowhere near its limits."""
    return weights(gy.zhang2017(), 4000.0, 9.0, 9.0, LOCK, FLOOR, 0.0, 0.5)._replace(grip=GRIP)


def penalty(w: Weights, across: float, ring: float, margin: float = 0.0) -> float:
    """Penalty of a ring speed where the float's rate across the axis is given."""
    x = np.zeros(7)
    x[RING_ANGLE], x[V3], x[RING] = 0.0, across, ring
    slope = np.zeros(7)
    value = float(_cost(x, w, margin, slope))
    assert slope[V1] == 0.0
    return value


def test_grip_asks_for_no_more_than_a_closed_coupling_gives(asked: Weights) -> None:
    """Beyond the ceiling the penalty is that of the ceiling, and the float's rates are not blamed for it."""
    capped = asked._replace(ceiling=2.4)
    assert penalty(asked, 0.9, 2.0) == pytest.approx(LOCK * (GRIP * 0.9 - 2.0) ** 2)
    assert penalty(capped, 0.9, 2.0) == pytest.approx(LOCK * 0.4**2)
    assert penalty(capped, 0.9, 2.5) == 0.0 < penalty(asked, 0.9, 2.5)
    assert penalty(capped, 0.7, 2.0) == penalty(asked, 0.7, 2.0) == pytest.approx(LOCK * 0.1**2)
    assert penalty(capped, 0.1, 1.0) == pytest.approx(LOCK * (FLOOR - 1.0) ** 2)


@pytest.mark.parametrize("across", [0.0, 0.9])
def test_margin_raises_what_is_asked_of_the_ring(asked: Weights, across: float) -> None:
    need = max(FLOOR, GRIP * across)
    assert penalty(asked, across, need, margin=0.25) == pytest.approx(LOCK * 0.25**2)
    assert penalty(asked, across, need + 0.25, margin=0.25) == 0.0


def test_margins_are_what_the_forecasts_deviations_add_up_to() -> None:
    """Errors of both moments, each the same at all instants, turn the float's rates; mu says what that asks for."""
    device = gy.zhang2017("realistic")
    law = gy.law("nmpc", plant=device, doubt=0.5, traction=0.4)
    c, w = law._numbers, work_of(law)
    n, k = w.trial.size, device.coefficients
    spread = np.tile([[8.0], [20.0]], n + 1)  # Nm
    doubted(c, w, spread)
    time = np.minimum(law.period * np.arange(1, n + 1), DOUBTED)
    rates = [8.0 * time * k.i1, 20.0 * time * k.i3]  # rad/s
    expected = 0.5 / 0.4 * np.sqrt(0.5 * (rates[0] ** 2 + rates[1] ** 2))
    np.testing.assert_allclose(w.now[NOW:], expected, rtol=1e-12)
    assert 0.0 < expected[-1] < 1.0


def test_margins_of_a_command_that_acts_later_begin_later() -> None:
    made = [gy.law("nmpc", plant="realistic", doubt=1.0, delay=delay) for delay in (0, 1)]
    told = []
    for law in made:
        w = work_of(law)
        leads = w.trial.size + law.delay
        doubted(law._numbers, w, np.array([[1.0], [2.0]]) * np.arange(leads + 1.0))
        told.append(w.now[NOW:])
    np.testing.assert_allclose(told[1][:-1], told[0][1:], rtol=1e-12)
    assert math.isclose(told[0][-1], told[0][6]) and told[0][4] < told[0][5]


def test_no_margins_without_doubt_or_where_the_forecast_tells_no_deviation() -> None:
    sure, blind = gy.law("nmpc", plant="realistic", doubt=0.0), gy.law("nmpc", doubt=1.0, traction=0.4)
    w = work_of(sure)
    doubted(sure._numbers, w, np.full((2, w.trial.size + 1), 30.0))
    assert not np.any(w.now[NOW:])
    w = work_of(blind)
    doubted(blind._numbers, w, blind._first.forecast.placed.spread)
    assert not np.any(w.now[NOW:])
