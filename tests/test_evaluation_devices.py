"""The fair tables' true devices, which differ from the design in what they say, and their sea that drifts."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.harness.actuation import Actuators
from gyroctl.harness.run import Settings, lead_in, run_law
from gyroctl.plant.measurement import ROWS
from gyroctl.studies.evaluation.cases import check_design, designs
from gyroctl.studies.evaluation.perturbed_devices import NOMINAL, TYPICAL_RMS, noisy_sensors, truths
from gyroctl.waves import DriftingSea, prepare, realise
from gyroctl.waves.energy import wave_power

# --- true devices


def test_every_truth_differs_from_the_design_in_what_it_says() -> None:
    design = gy.zhang2017()
    found = {truth.name: truth for truth in truths()}
    assert len(found) == 20
    for name in ("k1", "d1", "J14"):
        for sign in (-1, 1):
            truth = found[f"{name} {'+' if sign > 0 else '-'}20 %"].plant
            assert getattr(truth.parameters, name) == pytest.approx((1 + 0.2 * sign) * getattr(design.parameters, name))
            assert truth.replace(**{name: getattr(design.parameters, name)}).coefficients == design.coefficients
    assert len(found["finer radiation"].plant.labels) > len(design.labels)
    late, noisy = found["one sample late"].settings, found["5 % sensor noise"].settings
    assert (late.actuators.delay, late.sensors) == (1, Settings().sensors)
    assert noisy.sensors.omega_rate.noise == pytest.approx(0.05 * 69.0)
    assert noisy.sensors.psi.quantum == Settings().sensors.psi.quantum
    said = {(t.plant.coefficients, t.plant.excitation.sha256, repr((t.settings, t.told))) for t in found.values()}
    assert len(said) == 20
    assert found[NOMINAL].plant.coefficients == design.coefficients
    assert len({id(truth.plant) for truth in found.values()}) == 20, "no truth is another's object"


def test_scaled_excitation_pushes_harder_in_the_same_waves() -> None:
    found = {truth.name: truth.plant for truth in truths()}
    sea = gy.SeaState()
    nominal = realise(found[NOMINAL], sea, 100000, 60.0)
    for name, factor in (("He -20 %", 0.8), ("He +20 %", 1.2)):
        scaled = realise(found[name], sea, 100000, 60.0)
        np.testing.assert_allclose(scaled.moments, factor * nominal.moments, rtol=1e-12, atol=1e-9)
        np.testing.assert_array_equal(scaled.elevation, nominal.elevation)
        assert scaled.sha256 != nominal.sha256


def test_law_that_holds_the_true_device_is_refused(device: gy.Plant) -> None:
    from gyroctl.controllers.nmpc import Nmpc
    from gyroctl.controllers.supervisor import wrap

    law = Nmpc()
    assert len(designs(law)) == 1
    assert designs(wrap(law)) == designs(law)
    assert designs(law)[0].coefficients == gy.zhang2017().coefficients
    check_design(law, device)
    with pytest.raises(gy.InputError, match="device itself"):
        check_design(wrap(Nmpc(plant=device)), device)


def test_typical_rms_are_those_of_a_run(device: gy.Plant) -> None:
    waves = lead_in(realise(device, gy.SeaState(), 100001, 600.0), Settings())
    record, _ = run_law(device, gy.law("load_angle"), waves, Settings())
    for channel, at in zip(TYPICAL_RMS, ROWS, strict=True):
        values = record.states[1000:, at]
        if channel == "psi":
            values = np.angle(np.exp(1j * values))
        assert np.sqrt(np.mean(values**2)) == pytest.approx(TYPICAL_RMS[channel], rel=0.3), channel
    assert noisy_sensors(Settings().sensors).phi1.noise == pytest.approx(0.05 * TYPICAL_RMS["phi1"])


def test_miscalibrated_coupling_gives_what_another_command_would(device: gy.Plant) -> None:
    """cc 0.05 from a coupling that gives 0.8 of it is cc 0.04 from one that is right; cg is not touched."""
    waves = lead_in(realise(device, gy.SeaState(), 100000, 60.0), Settings(blend=20.0))

    def record(cc: float, gain: float, **limits: Any) -> Any:
        settings = Settings(blend=20.0, actuators=Actuators(cc_gain=gain, **limits))
        return run_law(device, gy.law("constant", cc=cc), waves, settings)[0]

    wrong, right = record(0.05, 0.8), record(0.04, 1.0)
    assert np.all(wrong.commands[:, 0] == 0.05)
    np.testing.assert_allclose(wrong.controls[5:], right.controls[5:], rtol=1e-12)
    np.testing.assert_allclose(wrong.states[-1], right.states[-1], rtol=1e-6)
    assert np.abs(wrong.states[-1] - record(0.05, 1.0).states[-1]).max() > 1e-3
    over = record(0.1, 1.2, cc_max=0.11)
    assert over.controls[-1, 0] == 0.11, "the limit is that of the device"
    assert over.saturations == 0, "the law asked for no more than it may"
    with pytest.raises(gy.InputError, match="cc_gain"):
        Actuators(cc_gain=0.0)


# --- a sea that drifts


def test_peak_of_the_drifting_sea_moves_as_it_says(device: gy.Plant) -> None:
    sea = DriftingSea(wp=2.8, wp_end=3.5)
    synthesis = prepare(device, sea)
    step, parts, seeds = synthesis.grid.dt, 4, range(24)
    length = round(2000.0 / parts / step)
    power = np.zeros((parts, length // 2 + 1))
    for seed in seeds:
        elevation = synthesis.elevation(seed)[: parts * length].reshape(parts, length)
        power += np.abs(np.fft.rfft(elevation * np.hanning(length), axis=1)) ** 2
        assert np.std(elevation) * 4 == pytest.approx(sea.hs, rel=0.12)
    omega = 2.0 * np.pi * np.fft.rfftfreq(length, step)
    near = (omega > 2.2) & (omega < 4.2)
    # the mean frequency of the upper part of the spectrum: steadier than its single highest line
    stationary = gy.SeaState().spectrum(3.14 * omega[near] / 3.14)
    offset = omega[near] @ stationary / stationary.sum() - 3.14
    for k in range(parts):
        expected = 2.8 + 0.7 * (k + 0.5) / parts
        assert omega[near] @ power[k, near] / power[k, near].sum() == pytest.approx(expected + offset, abs=0.09)
    variances = power.sum(axis=1)
    assert variances.max() / variances.min() < 1.15, "the height does not drift"


def test_drifting_sea_keeps_its_height_and_its_transfer(device: gy.Plant) -> None:
    sea = DriftingSea()
    time = np.linspace(-10.0, 2500.0, 997)
    np.testing.assert_allclose(np.sum(sea.windows(np.maximum(time, 0.0)) ** 2, axis=0), 1.0, rtol=1e-12)
    assert [round(stage.wp, 9) for stage in sea.stages] == [2.8, 2.9, 3.0, 3.1, 3.2, 3.3, 3.4, 3.5]
    waves = realise(device, sea, 100000)
    taper = np.hanning(waves.elevation.size)
    omega = 2.0 * np.pi * np.fft.rfftfreq(waves.elevation.size, waves.dt)
    through = device.excitation(omega, 0.0) * np.fft.rfft(waves.elevation * taper)
    direct = np.fft.rfft(waves.moments * taper)
    assert np.sum(np.abs(through - direct) ** 2) < 1e-4 * np.sum(np.abs(direct) ** 2)
    low, high = (wave_power(prepare(device, gy.SeaState(wp=wp)), device.depth) for wp in (3.5, 2.8))
    assert low < wave_power(prepare(device, sea), device.depth) < high


def test_drifting_sea_has_its_own_identity(device: gy.Plant) -> None:
    seas_ = [DriftingSea(), DriftingSea(wp_end=3.4), DriftingSea(over=1900.0), gy.SeaState(wp=2.8)]
    assert len({prepare(device, sea).sha256(100000) for sea in seas_}) == 4
    whole, part = (realise(device, DriftingSea(), 100000, duration) for duration in (2000.0, 400.0))
    np.testing.assert_allclose(part.elevation, whole.elevation[: part.elevation.size], atol=1e-12)
    batch = prepare(device, DriftingSea(), 400.0).moments_batch([100001, 100000])
    np.testing.assert_array_equal(batch[1], part.moments)
    with pytest.raises(gy.InputError, match="too short"):
        DriftingSea(over=300.0)
