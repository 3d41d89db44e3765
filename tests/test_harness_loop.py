"""The closed loop: one text compiled and as Python, its start, its periods, its blend."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from user_law import UserLaw

import gyroctl as gy
from gyroctl.harness.law_entry import compile_law
from gyroctl.harness.registry import registered
from gyroctl.harness.run import Settings, run_law
from gyroctl.harness.start import locked_start

Array = NDArray[np.float64]

ROUGH = Settings(
    blend=20.0,
    sensors=gy.Sensors(
        psi=gy.Channel(noise=0.01, quantum=2 * math.pi / 512, delay=1),
        psi_rate=gy.Channel(noise=0.1, dropout=0.1),
        omega_rate=gy.Channel(noise=0.5, bias=1.0, quantum=0.2),
        phi1_rate=gy.Channel(noise=0.02, delay=2, dropout=0.3),
    ),
    actuators=gy.Actuators(
        cc_max=0.2,
        cg_max=0.005,
        cc_lag=0.15,
        cg_lag=0.4,
        cc_rate=0.8,
        cg_rate=0.01,
        cc_quantum=0.004,
        cg_quantum=2e-5,
        delay=2,
    ),
)


def test_every_shipped_law_is_compiled() -> None:
    assert {name for name in registered() if compile_law(gy.law(name)) is None} == set()


@pytest.mark.parametrize("name", sorted(set(registered()) - {"nmpc"}))
@pytest.mark.parametrize("settings", [Settings(blend=20.0), ROUGH], ids=["default", "rough"])
def test_python_loop_has_the_bits_of_the_compiled_loop(
    device: gy.Plant, waves: gy.WaveRealisation, name: str, settings: Settings
) -> None:
    law = gy.law(name)
    one, _ = run_law(device, law, waves, settings, name)
    other, _ = run_law(device, law, waves, settings, name, compiled=False)
    for field in ("states", "commands", "controls"):
        np.testing.assert_array_equal(getattr(one, field), getattr(other, field))
    assert one.saturations == other.saturations
    assert np.all(np.isfinite(one.states))


def test_a_run_repeats_its_bits_and_follows_its_seed(device: gy.Plant, waves: gy.WaveRealisation) -> None:
    law = gy.law("load_angle")
    one, two = (run_law(device, law, waves, ROUGH)[0].states for _ in range(2))
    np.testing.assert_array_equal(one, two)
    another = gy.realise(device, gy.SeaState(), 7, 120.0).blended(20.0)
    assert not np.array_equal(run_law(device, law, another, ROUGH)[0].states, one)


def test_closed_loop_follows_the_equations_between_its_samples(device: gy.Plant, waves: gy.WaveRealisation) -> None:
    """One held interval by scipy from the recorded state, controls and moments."""
    from scipy.integrate import solve_ivp

    record, _ = run_law(device, gy.law("coupling"), waves, Settings(blend=20.0))
    for sample in (0, 401, 1003):
        u = record.controls[sample]
        near = slice(max(2 * sample - 4, 0), 2 * sample + 7)
        fits = [np.polynomial.Polynomial.fit(waves.time[near], m[near], len(m[near]) - 1) for m in waves.moments]

        def rate(t: float, x: Array, u: Array = u, fits: list[Any] = fits) -> Array:
            return np.asarray(device.derivative(x, u, [fit(t) for fit in fits]), np.float64)

        span = (0.1 * sample, 0.1 * (sample + 1))
        end = solve_ivp(rate, span, record.states[sample, :14], "DOP853", rtol=1e-11, atol=1e-12).y[:, -1]
        np.testing.assert_allclose(record.states[sample + 1, :14], end, rtol=2e-5, atol=2e-6)


def test_start_is_the_locked_orbit_or_what_is_given(device: gy.Plant, waves: gy.WaveRealisation) -> None:
    record, _ = run_law(device, gy.law("constant"), waves, Settings(blend=20.0))
    np.testing.assert_array_equal(record.states[0, :14], locked_start(device, waves.sea)[0])
    np.testing.assert_array_equal(record.states[0, 14:], 0.0)
    rest = np.zeros(14)
    record, _ = run_law(device, gy.law("constant"), waves, Settings(blend=20.0), start=rest)
    np.testing.assert_array_equal(record.states[0], 0.0)


def test_law_with_a_longer_period_holds_its_command(device: gy.Plant, waves: gy.WaveRealisation) -> None:
    """Three samples of the actuators to one of the law."""
    record, _ = run_law(device, gy.law("load_angle", period=0.3), waves, Settings(blend=20.0))
    commands = record.commands.reshape(400, 3, 2)
    np.testing.assert_array_equal(commands, np.repeat(commands[:, :1], 3, axis=1))
    assert len(np.unique(commands[:, 0, 1])) > 50


@pytest.mark.parametrize("period", [0.25, 0.05, 0.15, 0.0])
def test_period_that_does_not_fit_is_refused(device: gy.Plant, waves: gy.WaveRealisation, period: float) -> None:
    with pytest.raises(gy.InputError, match="multiple of actuators") as caught:
        run_law(device, gy.law("constant", period=period), waves, Settings(blend=20.0), "mine")
    assert caught.value.field == "laws.mine.period"


def test_unstable_step_is_refused_before_anything_runs(device: gy.Plant, waves: gy.WaveRealisation) -> None:
    """h * 683 cc > 2.5, by the law's own cc or by the most that the actuator can give."""
    settings = Settings(dt=0.02, blend=20.0)
    with pytest.raises(gy.InputError, match=r"unstable.*dt <=") as caught:
        run_law(device, gy.law("constant", cc=0.25), waves, settings)
    assert caught.value.field == "run.dt"
    with pytest.raises(gy.InputError, match="unstable"):
        run_law(device, UserLaw(lambda t, y, s: ((0.01, 1e-4), s)), waves, settings)
    run_law(device, gy.law("constant", cc=0.052), waves, settings)


def test_blend_is_put_in_once(device: gy.Plant) -> None:
    plain = gy.realise(device, gy.SeaState(), 2, 60.0)
    settings = Settings(blend=20.0)
    one = gy.simulate(device, gy.law("constant"), plain, settings)
    two = gy.simulate(device, gy.law("constant"), plain.blended(20.0), settings)
    assert one.attrs["sha256"] == two.attrs["sha256"] == plain.blended(20.0).sha256
    np.testing.assert_array_equal(one.phi3, two.phi3)
    unblended = gy.simulate(device, gy.law("constant"), plain, Settings(blend=0.0))
    assert unblended.attrs["sha256"] == plain.sha256
