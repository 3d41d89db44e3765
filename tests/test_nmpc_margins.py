"""What a plan asks of the ring: its floor, the grip of the contact, and room for what is not known of the waves."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from test_nmpc_sample import work_of

import gyroctl as gy
from gyroctl.controllers.nmpc.problem import NOW, RING, RING_ANGLE, V1, V3, Weights, stage_cost, weights
from gyroctl.controllers.nmpc.sample import CERTAIN, DOUBT, DOUBTED, DOUBTFUL, LIMIT1, doubted, posed
from gyroctl.harness.actuation import Actuators
from gyroctl.harness.run import Settings, lead_in, run_law
from gyroctl.harness.sensing import Sensors
from gyroctl.plant.compiled import entry_point
from gyroctl.waves.gauge import Readings

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
    assert w.numbers[DOUBT] == pytest.approx(expected[-1] * law.period * n / DOUBTED, rel=1e-12)  # of the whole horizon


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
    assert not np.any(w.now[NOW:]) and w.numbers[DOUBT] == 0.0
    w = work_of(blind)
    doubted(blind._numbers, w, blind._first.forecast.placed.spread)
    assert not np.any(w.now[NOW:]) and w.numbers[DOUBT] == 0.0


@pytest.mark.parametrize(
    ("doubt", "left"),
    [(0.0, 1.0), (CERTAIN, 1.0), (0.75 * CERTAIN + 0.25 * DOUBTFUL, 0.75), (DOUBTFUL, 0.0), (40.0 * DOUBTFUL, 0.0)],
)
def test_motion_that_is_allowed_falls_with_the_doubt(doubt: float, left: float) -> None:
    """All of `sure` up to `CERTAIN`, none from `DOUBTFUL` on; what stands in the problem is what the plan goes by."""
    law = gy.law("nmpc", plant="realistic", limit1=0.3, sure=0.08)
    c, w = law._numbers, work_of(law)
    w.now[NOW:] = 0.3  # the margins of the next moment are another matter
    for _ in range(2):  # it does not add up
        w.numbers[DOUBT] = doubt
        posed(c, w, np.zeros(14))
        assert w.weights[LIMIT1] == pytest.approx(0.3 + 0.08 * left, rel=1e-12)


@pytest.mark.parametrize(
    ("told", "sure"),
    [
        ({"plant": "realistic"}, 0.08),  # its forecast tells its deviation
        ({"plant": "realistic", "doubt": 0.0}, 0.0),  # it does, and nobody asks
        ({}, 0.0),  # none is told at rest
        ({"information": "oracle"}, 0.08),
        ({"information": "forecast", "lead": 2.0}, 0.0),  # half of the horizon is a guess
        ({"information": "forecast", "lead": 4.0}, 0.08),
        ({"information": "forecast", "lead": 4.0, "delay": 1}, 0.0),
        ({"information": "forecast", "lead": 4.0, "noise": 0.1}, 0.0),
        ({"information": "gauge", "plant": "realistic"}, 0.08),
    ],
)
def test_more_motion_is_for_those_who_know_what_they_do_not_know(told: dict[str, object], sure: float) -> None:
    law = gy.law("nmpc", **{"sure": 0.08, **told})
    if law.information in ("oracle", "forecast"):
        law = law.informed(gy.realise(gy.zhang2017(), gy.SeaState(), 1, 40.0))
    assert law._numbers.sure == sure


@pytest.mark.parametrize(("distance", "least"), [(10.0, 0.9), (20.0, 0.9), (None, 0.0)])
def test_gauge_gets_the_room_for_motion_that_sensors_alone_do_not(
    distance: float | None, least: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In a sea of gamma 5, once the spectrum is learnt: by what the forecast says of itself, in the closed loop."""
    given: list[float] = []

    def seen(c: Any, w: Any, x: Any) -> int:
        more = posed(c, w, x)
        given.append((w.weights[LIMIT1] - c.weights[LIMIT1]) / c.sure)
        return more

    monkeypatch.setattr("gyroctl.controllers.nmpc.law.posed", seen)
    told = {} if distance is None else {"information": "gauge", "distance": distance}
    law = gy.law("nmpc", plant="realistic", deadline=1e6, **told)  # with a deadline a sample is Python
    device, settings = (
        gy.zhang2017(variant="realistic"),
        Settings(blend=10.0, sensors=Sensors(), actuators=Actuators(cc_lag=0.02)),
    )
    run_law(device, law, lead_in(gy.realise(device, gy.SeaState(gamma=5.0), 100150, 70.0), settings), settings)
    late = np.array(given)[450:]
    assert late.size > 200 and (np.mean(late) >= least if distance else np.max(late) == 0.0)


def test_doubt_is_that_of_the_sensors_where_the_gauge_is_silent() -> None:
    """Without readings a law with a gauge plans as the one without: the same margins, and the same coupling."""
    alone, gauge = gy.law("nmpc", plant="realistic"), gy.law("nmpc", plant="realistic", information="gauge")
    silent = gauge.informed(Readings(np.full(600, np.nan), 0.1, 60.0))
    states, t = [alone.init(), silent.init()], 0.0
    for sample in range(20):
        t, phase = 0.1 * sample, 3.14 * 0.1 * sample
        y = np.array([phase, 3.14, 68.0, 0.2 * np.cos(phase), 0.2 * np.sin(phase), -0.6 * np.sin(phase), 0.6])
        commands = []
        for i, law in enumerate((alone, silent)):
            command, states[i] = law.step(t, y + 1e-3 * np.sin(sample * np.arange(7.0)), states[i])
            commands.append(command)
        assert commands[0] == pytest.approx(commands[1], abs=1e-6)
    margins = [law.memory(state).work.now[NOW:] for law, state in zip((alone, silent), states, strict=True)]
    np.testing.assert_allclose(margins[0], margins[1], rtol=1e-6)
    assert margins[0][-1] > 0.0
