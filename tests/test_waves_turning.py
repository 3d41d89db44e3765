"""Seas of more than one kind at a time: a heading that turns, and a spectrum with two peaks."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.plant.equations import PHI1, PHI3
from gyroctl.waves import TurningSea, TwoPeaks
from gyroctl.waves.channels import transfers
from gyroctl.waves.energy import wave_power
from gyroctl.waves.synthesis import prepare

TURN = TurningSea(heading=-5.0, heading_end=15.0, over=100.0)


def fixed(heading: float) -> gy.SeaState:
    return gy.SeaState(heading=heading)


# --- a heading that turns ------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def moving() -> gy.Plant:
    """A device that asks for many signals: its float moves, with drag."""
    return gy.zhang2017(position="moving", drag=0.5)


def test_elevation_is_that_of_the_sea_that_does_not_turn(device: gy.Plant) -> None:
    turning, still = (gy.realise(device, sea, 100000, 200.0) for sea in (TURN, fixed(-5.0)))
    np.testing.assert_allclose(turning.elevation, still.elevation, atol=1e-12)
    assert turning.sha256 != still.sha256
    powers = [wave_power(prepare(device, sea, 200.0)) for sea in (TURN, fixed(-5.0))]
    assert powers[0] == pytest.approx(powers[1], rel=1e-12)


def test_signals_at_the_ends_of_the_turn_are_those_of_the_two_headings(moving: gy.Plant) -> None:
    turning, first, last = (
        gy.realise(moving, sea, 100000, 200.0).signals(moving) for sea in (TURN, fixed(-5.0), fixed(15.0))
    )
    scale = np.std(last, axis=1, keepdims=True)
    np.testing.assert_allclose(turning[:, 0] / scale[:, 0], first[:, 0] / scale[:, 0], atol=1e-9)
    np.testing.assert_allclose(turning[:, 2000:] / scale, last[:, 2000:] / scale, atol=1e-9)
    assert np.max(np.abs(turning[:, :2000] - last[:, :2000]) / scale) > 0.1


def test_signals_within_the_turn_are_those_of_the_heading_of_the_instant(moving: gy.Plant) -> None:
    """Summed wave by wave with the exact transfer at that heading, between the headings that are blended too."""
    synthesis = prepare(moving, TURN, 200.0)
    signals = synthesis.signals(moving, [100000])[0]
    still = prepare(moving, fixed(0.0), 200.0)
    omega, waves = still.waves.omega, still.waves.amplitude * np.exp(1j * still.phases(100000))
    scale = np.std(signals, axis=1)
    for t in (12.5, 37.0, 50.0, 88.0):
        transfer = transfers(moving, omega, -5.0 + 0.2 * t)
        expected = (transfer * waves * np.exp(1j * omega * t)).sum(axis=1).real
        np.testing.assert_allclose(signals[:, round(t / 0.05)] / scale, expected / scale, atol=4e-3)


def test_weights_of_the_headings_add_up_to_one_and_reach_no_further_than_a_neighbour() -> None:
    time = np.linspace(0.0, 200.0, 4001)
    weights = TURN.weights(time)
    assert TURN.headings == (-5.0, 0.0, 5.0, 10.0, 15.0)
    np.testing.assert_allclose(weights.sum(axis=0), 1.0, atol=1e-12)
    assert np.all(np.sum(weights > 0.0, axis=0) <= 2)
    np.testing.assert_allclose(weights.T @ TURN.headings, np.minimum(-5.0 + 0.2 * time, 15.0), atol=1e-9)


def held_at(plant: gy.Plant, sea: Any, t: float, phi1: float, phi3: float) -> np.ndarray[Any, Any]:
    held = gy.realise(plant, sea, 100000, 200.0).held(plant)
    assert held is not None
    x = np.zeros((len(plant.labels), 1))
    x[PHI1], x[PHI3] = phi1, phi3
    found: np.ndarray[Any, Any] = held.model.along(held.fields, np.array([t]), x)[:, 0]
    return found


@pytest.mark.slow
def test_wetted_surface_meets_the_waves_from_where_they_come() -> None:
    """Where the turn is at a heading that is blended, and after its end, it is the surface in that fixed sea."""
    plant = gy.zhang2017(position="moving", wetted="surface")
    for t, heading in ((0.0, -5.0), (50.0, 5.0), (75.0, 10.0), (150.0, 15.0)):
        for phi1, phi3 in ((0.2, 0.1), (-0.15, 0.05)):
            turned = held_at(plant, TURN, t, phi1, phi3)
            np.testing.assert_allclose(turned, held_at(plant, fixed(heading), t, phi1, phi3), rtol=1e-9, atol=1e-9)
    assert np.max(np.abs(held_at(plant, TURN, 75.0, 0.2, 0.1) - held_at(plant, fixed(-5.0), 75.0, 0.2, 0.1))) > 0.1


@pytest.mark.slow
def test_compiled_surface_turns_as_the_one_of_the_record() -> None:
    """The loop gives the same bits compiled and as Python, and a device in a sea that turns goes another way."""
    from gyroctl.harness.run import Settings, lead_in, run_law

    plant, settings = gy.zhang2017(position="moving", wetted="surface"), Settings(blend=0.0)
    sea = TurningSea(heading=0.0, heading_end=15.0, over=45.0)
    waves = lead_in(gy.realise(plant, sea, 100000, 50.0), settings)
    record, _ = run_law(plant, gy.law("constant"), waves, settings)
    same, _ = run_law(plant, gy.law("constant"), waves, settings, compiled=False)
    np.testing.assert_array_equal(record.states, same.states)
    still = lead_in(gy.realise(plant, fixed(0.0), 100000, 50.0), settings)
    other, _ = run_law(plant, gy.law("constant"), still, settings)
    assert np.max(np.abs(record.states[-100:, PHI1] - other.states[-100:, PHI1])) > 1e-3


@pytest.mark.parametrize(
    ("field", "given"),
    [
        ("sea.heading_end", {"heading_end": 200.0}),
        ("sea.heading", {"heading": math.nan}),
        ("sea.over", {"over": 10.0}),
        ("sea.over", {"heading_end": 0.0, "over": 0.0}),
        ("sea.hs", {"hs": 0.0}),
    ],
)
def test_turn_that_cannot_be_is_refused(field: str, given: dict[str, float]) -> None:
    with pytest.raises(gy.InputError) as caught:
        TurningSea(**given)
    assert caught.value.field == field and caught.value.mend


# --- two peaks -----------------------------------------------------------------------------------------------------


def test_two_peaks_share_the_variance() -> None:
    """The area is that of the height; without the first sea's part at the second peak, that of the second."""
    sea = TwoPeaks(hs=0.3, wp=3.5, wp_second=1.2, gamma_second=50.0, share=0.4)
    omega = np.linspace(1e-3, 40.0, 400_001)
    whole, below = sea.spectrum(omega), omega < 1.9
    assert np.trapezoid(whole, omega) == pytest.approx(0.3**2 / 16.0, rel=1e-4)
    assert np.trapezoid(whole[below], omega[below]) == pytest.approx(0.4 * 0.3**2 / 16.0, rel=0.1)
    peaks = omega[1:-1][(whole[1:-1] > whole[:-2]) & (whole[1:-1] > whole[2:])]
    np.testing.assert_allclose(peaks, [1.2, 3.5], rtol=0.01)


def test_one_peak_is_the_plain_sea(device: gy.Plant) -> None:
    one = gy.realise(device, TwoPeaks(share=0.0), 100000, 100.0)
    plain = gy.realise(device, gy.SeaState(), 100000, 100.0)
    np.testing.assert_allclose(one.moments, plain.moments, rtol=1e-9, atol=1e-9)


def test_realisation_of_two_peaks_has_both(device: gy.Plant) -> None:
    waves = gy.realise(device, TwoPeaks(), 100000, 2000.0)
    assert waves.elevation[:-1].std() == pytest.approx(0.283 / 4.0, rel=1e-6)
    spectrum = np.abs(np.fft.rfft(waves.elevation[:-1])) ** 2
    omega = 2.0 * np.pi * np.fft.rfftfreq(waves.elevation.size - 1, 0.05)
    low, fine = omega < 2.4, np.linspace(1e-3, 12.5, 20_001)
    density = 0.75 * gy.SeaState(wp=3.14).spectrum(fine) + 0.25 * gy.SeaState(wp=1.8).spectrum(fine)
    assert spectrum[low].sum() / spectrum.sum() == pytest.approx(density[fine < 2.4].sum() / density.sum(), abs=0.005)


@pytest.mark.parametrize(
    ("field", "given"),
    [
        ("sea.share", {"share": 1.2}),
        ("sea.wp_second", {"wp_second": 0.0}),
        ("sea.gamma_second", {"gamma_second": 0.5}),
        ("sea.gamma", {"gamma": 0.5}),
        ("sea.heading", {"heading": 400.0}),
    ],
)
def test_two_peaks_that_cannot_be_are_refused(field: str, given: dict[str, float]) -> None:
    with pytest.raises(gy.InputError) as caught:
        TwoPeaks(**given)
    assert caught.value.field == field and caught.value.mend
