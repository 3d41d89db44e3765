"""What else the choices beyond the linear model rest on: lead-in of the pressure, parts of the table, the card."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.errors import InputError
from gyroctl.harness.run import run_law
from gyroctl.hydrodynamics import shipped
from gyroctl.hydrodynamics.dispersion import wavenumber
from gyroctl.hydrodynamics.floating import floating
from gyroctl.hydrodynamics.reduced import checked
from gyroctl.plant.contact import contact_load
from gyroctl.plant.equations import OMEGA_RATE, PHI1, PSI_RATE
from gyroctl.plant.kernel import hold_one
from gyroctl.simulation.balance import electrical
from gyroctl.simulation.second_look import Look, look
from gyroctl.simulation.validity import validity

SEA = gy.SeaState(gamma=5.0)


def test_pressure_is_led_in_like_the_moments() -> None:
    """Of the regular wave in the beginning, of the sea after the blend; at the float's place only where that moves."""
    plant = gy.zhang2017(wetted="surface")
    waves, regular = gy.realise(plant, SEA, 1, 20.0), gy.Regular(SEA.hs / np.sqrt(2.0), SEA.wp)
    led, whole, wave = (
        waves.blended(10.0).held(plant),
        waves.held(plant),
        gy.realise(plant, regular, 1, 20.0).held(plant),
    )
    assert led is not None and whole is not None and wave is not None
    np.testing.assert_allclose(led.fields.rows[0, 0], wave.fields.rows[0, 0], atol=1e-9)
    np.testing.assert_array_equal(led.fields.rows[0, 200:], whole.fields.rows[0, 200:])
    assert np.max(np.abs(whole.fields.rows[0, 0] - wave.fields.rows[0, 0])) > 0.01
    moving = waves.held(plant.replace(position="moving"))
    assert led.model.moving == 0.0 and moving is not None and moving.model.moving == 1.0


def test_undisturbed_moments_are_those_of_the_table() -> None:
    hydro = shipped()
    found = floating(hydro)
    assert found is not None and found.undisturbed is not None and hydro.froude_krylov is not None
    heading = int(np.flatnonzero(hydro.headings == 0.0)[0])
    some = hydro.omega[10:-10:7]
    np.testing.assert_allclose(
        found.undisturbed(some, 0.0), hydro.froude_krylov[:, heading, 10:-10:7], rtol=1e-9, atol=1e-6
    )


@pytest.mark.parametrize(
    "wrong", [{"low": 0.1}, {"high": -0.1}, {"moment1": (np.nan,)}, {"moment3": ()}, {"soft": 0.0}, {"stiffness": -1.0}]
)
def test_what_is_no_fit_is_refused(wrong: dict[str, object]) -> None:
    fit = shipped().wetted
    assert fit is not None and checked(fit) is fit
    with pytest.raises(InputError, match="no fit"):
        checked(fit._replace(**wrong))


def test_electrical_energy_is_less_than_what_is_given_and_more_than_what_is_taken() -> None:
    """A step of 10 J into the generator, 4 J out of it as a motor, at 0.8: 8 J gained, 5 J paid."""
    np.testing.assert_allclose(electrical(np.array([3.0, 13.0, 9.0]), 0.8), [3.0, 11.0, 6.0], rtol=1e-12)


def test_quantile_of_the_traction_is_weighted_by_time() -> None:
    found = Look(np.array([3.0, 1.0, 2.0]), np.array([1.0, 8.0, 1.0]), np.zeros(3, int), np.ones((1, 2)), 0.0, 0.0, 0.0)
    assert (found.quantile(0.5), found.quantile(0.85), found.quantile(0.95)) == (1.0, 2.0, 3.0)
    assert found.over(1.5) == pytest.approx([0.2])


def test_card_counts_each_way_into_rolling_backwards_once() -> None:
    """The ring made to turn backwards twice, for half a second and a whole one; k X from its largest swing."""
    plant = gy.zhang2017()
    waves = gy.realise(plant, SEA, 1, 60.0).blended(20.0)
    record, _ = run_law(plant, gy.law("constant", cc=0.05, cg=3e-4), waves, gy.Settings(blend=20.0))
    states = record.states.copy()
    states[300:305, PSI_RATE] *= -1.0
    states[400:410, PSI_RATE] *= -1.0
    card = validity(plant, replace(record, states=states), waves, 20.0)
    assert card["reversals"] == 2.0
    k = float(wavenumber(np.array([SEA.wp]), plant.depth)[0])
    assert card["kx_max"] == pytest.approx(k * 1.049 * np.max(np.abs(states[200:, PHI1])), rel=1e-3)


def test_contact_is_followed_through_a_transient_of_the_coupling() -> None:
    """A flywheel ahead of the axis is caught in tens of milliseconds: traction against a fine integration."""
    plant, i, pair = gy.zhang2017(), 350, (0.05, 3e-4)
    waves = gy.realise(plant, SEA, 1, 60.0).blended(20.0)
    record, _ = run_law(plant, gy.law("constant", cc=pair[0], cg=pair[1]), waves, gy.Settings(blend=20.0))
    n, k, fine = len(plant.labels), plant.coefficients, 1e-4
    states, controls = record.states.copy(), record.controls.copy()
    states[i, OMEGA_RATE] += 50.0
    controls[i - 1, 0] = 0.02  # so that the coupling is switched at the sample
    flat, time, needed = np.ascontiguousarray(waves.moments.T).ravel(), 0.1 * np.arange(states.shape[0]), []
    y = states[i].copy()
    for step in range(1000):
        t = 0.1 * i + fine * step
        moments = [np.interp(t, waves.time, moment) for moment in waves.moments]
        needed.append(float(contact_load(plant, y[:n], pair, moments).traction))
        y = hold_one(y, k, *pair, t, fine, 1, flat, waves.dt)
    states[i + 1] = y
    signals = np.array([np.interp(time, waves.time, moment) for moment in waves.moments])
    found = look(plant, replace(record, states=states, controls=controls), 200, signals[:, 200:])
    own = found.interval == i - 200
    middle = np.cumsum(found.weight[own]) - 0.5 * found.weight[own]
    truth = np.interp(middle, fine * np.arange(1000), needed)
    assert own.sum() > 10 and np.ptp(truth) > 0.1
    np.testing.assert_allclose(found.traction[own], truth, atol=0.02)
