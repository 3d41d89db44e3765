"""The validity card: what happens between the samples, against the run integrated finely."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.harness.arguments import law_of
from gyroctl.harness.run import lead_in, run_law
from gyroctl.plant.contact import contact_load
from gyroctl.plant.kernel import hold_one
from gyroctl.reports.resting import in_words
from gyroctl.reports.wording import number
from gyroctl.simulation.validity import UNITS, floating, validity

SEA = gy.SeaState(0.283, 3.14, 5.0)


@cache
def run(name: str, lag: float = 0.0, duration: float = 160.0) -> Any:
    """Plant, record and waves of a run, blended over the first 40 s."""
    plant, settings = gy.zhang2017(), gy.Settings(blend=40.0, actuators=gy.Actuators(cc_lag=lag))
    waves = lead_in(gy.realise(plant, SEA, 3, duration), settings)
    return plant, run_law(plant, law_of(name), waves, settings, name)[0], waves


def course(record: Any, i: int, t: float) -> float:
    """Coupling `t` after sample `i`: an exponential from the record's begin to its end."""
    begin, end = record.controls[i, 0], record.ends[i, 0]
    if record.lag == 0.0:
        return float(begin)
    aim = begin + (end - begin) / -np.expm1(-record.period / record.lag)
    return float(aim + (begin - aim) * np.exp(-t / record.lag))


def finely(plant: Any, record: Any, waves: Any, begin: float, parts: int = 100) -> Any:
    """Traction and M3, then torque and slip of the coupling, every millisecond: each interval integrated anew."""
    n, first = len(plant.labels), round(begin / record.period)
    flat, step = np.ascontiguousarray(waves.moments.T).ravel(), record.period / parts
    states, controls = [], []
    for i in range(first, record.controls.shape[0]):
        y = record.states[i].copy()
        for part in range(parts):
            cc, cg = course(record, i, part * step), record.controls[i, 1]
            states.append(y[:n])
            controls.append((cc, cg))
            cc = course(record, i, (part + 0.5) * step)
            y = hold_one(y, plant.coefficients, cc, cg, i * record.period + part * step, step, 1, flat, waves.dt)
    x, u = np.array(states).T, np.array(controls).T
    time = first * record.period + np.arange(x.shape[1]) * step
    moments = np.array([np.interp(time, waves.time, moment) for moment in waves.moments])
    slip = x[7] - plant.parameters.N * x[6]
    return contact_load(plant, x, u, moments), u[0] * slip, slip


@pytest.mark.slow
@pytest.mark.parametrize(("name", "lag"), [("coupling", 0.0), ("load_angle", 0.0), ("coupling", 0.02)])
def test_card_is_that_of_a_fine_integration(name: str, lag: float) -> None:
    """Quantiles and shares to a few hundredths, peaks to a few per cent, also right after the coupling is switched."""
    plant, record, waves = run(name, lag)
    card = validity(plant, record, waves, 40.0)
    load, torque, slip = finely(plant, record, waves, 40.0)
    needed = load.traction
    assert card["traction_p99"] == pytest.approx(np.quantile(needed, 0.99), rel=0.03)
    # above 1 the axis has lost its track: there the number is that of a pole, and says no more
    assert min(card["traction_p999"], 1.0) == pytest.approx(min(np.quantile(needed, 0.999), 1.0), rel=0.08)
    assert card["traction_over_03"] == pytest.approx(np.mean(needed > 0.3), rel=0.05, abs=4e-4)
    assert card["traction_over_06"] == pytest.approx(np.mean(needed > 0.6), rel=0.05, abs=4e-4)
    assert card["slip_max"] == pytest.approx(np.max(np.abs(slip)), rel=0.003)
    assert card["coupling_torque_max"] == pytest.approx(np.max(np.abs(torque)), rel=0.01)
    assert card["coupling_loss_max"] == pytest.approx(np.max(np.abs(torque * slip)), rel=0.025)
    pressed = load.M3 >= 0.0
    assert card["reversals"] == np.count_nonzero(pressed[1:] & ~pressed[:-1])


def test_card_has_all_its_numbers_and_a_sentence() -> None:
    """A short run of a constant pair: everything finite, in its range, and told."""
    plant, record, waves = run("constant", duration=70.0)
    card = validity(plant, record, waves, 40.0)
    assert list(card) == list(UNITS)
    assert all(np.isfinite(value) for value in card.values())
    assert 0.1 < card["traction_p99"] <= card["traction_p999"] < 1.0 and card["reversals"] == 0.0
    said = in_words(card, "constant")
    for part in (
        "of constant rest",
        f"{card['traction_p999']:.2f} (99.9",
        f"{number(card['slip_max'])} rad/s",
        "never out",
    ):
        assert part in said
    assert in_words({}) == ""
    for count, told in ((1.0, "once"), (2.0, "2 times"), (0.5, "0.5 times"), (12345.6, "12346 times")):
        assert f"roll backwards {told}" in in_words(card | {"reversals": count})


def test_immersion_is_that_of_the_float_on_still_and_on_moving_water() -> None:
    """At rest the draft balances the weight; lifted out of the water and pushed under, the card says so."""
    plant, record, waves = run("constant", duration=70.0)
    still = floating(plant)
    assert still.arm == pytest.approx(1.049, abs=5e-4)
    p = plant.parameters
    assert still.height == pytest.approx(p.d + p.c * np.sin(np.deg2rad(10.0)), rel=4e-3)  # it is made of panels
    assert 0.4 * still.height < still.draft < 0.6 * still.height
    calm = replace(waves, elevation=np.zeros_like(waves.elevation))
    states = record.states.copy()
    states[:, 1] = 0.0
    states[500, 1], states[501, 1] = 1.01 * still.draft / still.arm, -1.01 * (still.height - still.draft) / still.arm
    card = validity(plant, replace(record, states=states), calm, 40.0)
    scored = states.shape[0] - 400
    assert card["dry_share"] == pytest.approx(1.0 / scored) and card["submerged_share"] == pytest.approx(1.0 / scored)
    assert card["immersion_min"] == pytest.approx(-0.01 * still.draft)
    assert card["immersion_max"] == pytest.approx(still.height + 0.01 * (still.height - still.draft))


def test_a_run_that_is_not_finite_has_no_card() -> None:
    """No number is made of a run that has none."""
    plant, record, waves = run("constant", duration=70.0)
    states = record.states.copy()
    states[-1] = np.nan
    card = validity(plant, replace(record, states=states), waves, 40.0)
    assert all(np.isnan(value) for value in card.values()) and in_words(card) == ""


def test_slip_of_a_coupling_switched_on_is_the_largest_right_then() -> None:
    """A step of the coupling against the slip's own equation: torque cc s at once, gone after a few milliseconds."""
    plant, record, waves = run("constant", duration=70.0)
    states, controls = record.states.copy(), record.controls.copy()
    controls[500, 0] = 0.3
    states[500, 7] += 50.0  # a flywheel ahead of the axis
    card = validity(plant, replace(record, states=states, controls=controls), waves, 40.0)
    slip = states[500, 7] - plant.parameters.N * states[500, 6]
    assert card["slip_max"] == pytest.approx(abs(slip))
    assert card["coupling_torque_max"] == pytest.approx(0.3 * abs(slip))
    assert card["coupling_loss_max"] == pytest.approx(0.3 * slip**2)
    # 5 ms of it in 30 s: far below a thousandth
    assert card["traction_over_06"] < 1e-3
