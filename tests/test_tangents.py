"""Tangents in lanes: those of a complex step through the kernel to the last bit, in any directions."""

from __future__ import annotations

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.orbits.flow import STEP, Forcing, changes, directions, flow, run, stretch_of
from gyroctl.plant.equations import OMEGA_RATE, PSI, PSI_RATE
from gyroctl.plant.tangents import LANES, hold_changes, rates_text

DEVICES = {
    "corrected": gy.zhang2017(),
    "paper": gy.zhang2017("paper"),
    "rigid": gy.zhang2017(connection="rigid"),
    "longer filters": gy.zhang2017(radiation="fine"),
    "in drag": gy.zhang2017(drag=0.5),
}
WAVE = gy.Regular(0.25, 2.9)


def somewhere(plant: gy.Plant) -> np.ndarray:
    """A state off every orbit; the flywheel geared where it is."""
    x = np.random.default_rng(3).normal(0.0, 0.05, len(plant.labels))
    x[PSI], x[PSI_RATE], x[OMEGA_RATE] = 2.0, 3.3, 60.0
    if plant.parameters.connection == "rigid":
        x[OMEGA_RATE] = plant.parameters.N * x[PSI_RATE]
    return x


@pytest.mark.parametrize("name", DEVICES)
@pytest.mark.parametrize(("cc", "cg", "periods"), [(0.052, 3.5e-4, 0.5), (0.25, 0.0, 1.0), (0.0, 2e-3, 0.3)])
def test_tangents_have_the_bits_of_a_complex_step(name: str, cc: float, cg: float, periods: float) -> None:
    plant = DEVICES[name]
    k, x = plant.coefficients, somewhere(plant)
    stretch = stretch_of(plant, cc, Forcing.of(plant, WAVE), periods, 0.02)
    seeds = directions(x.size, plant.parameters.N if plant.parameters.connection == "rigid" else None)
    end, columns = changes(k, x, seeds, cc, cg, stretch)
    steps = np.stack([run(k, x + 1j * STEP * seed, cc, cg, stretch)[: x.size] for seed in seeds.T], axis=1)
    np.testing.assert_array_equal(end, steps[:, 0].real)
    np.testing.assert_array_equal(columns, steps.imag / STEP)
    np.testing.assert_array_equal(np.signbit(columns), np.signbit(steps.imag))


def test_tangents_are_the_derivative_of_the_flow(device: gy.Plant) -> None:
    """By differences of the flow itself, which knows no tangent."""
    x, forcing = somewhere(device), Forcing.of(device, WAVE)
    seeds = np.random.default_rng(5).normal(size=(x.size, 2))
    stretch = stretch_of(device, 0.06, forcing, 0.5, 0.01)
    _, columns = changes(device.coefficients, x, seeds, 0.06, 4e-4, stretch)
    for seed, column in zip(seeds.T, columns.T, strict=True):
        ends = [flow(device, x + h * seed, 0.06, 4e-4, forcing, 0.5)[: x.size] for h in (2e-5, -2e-5)]
        np.testing.assert_allclose(column, (ends[0] - ends[1]) / 4e-5, rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("count", [1, LANES, LANES + 1, 2 * LANES + 5])
def test_any_number_of_directions(device: gy.Plant, count: int) -> None:
    x = somewhere(device)
    seeds = np.random.default_rng(7).normal(size=(x.size, count))
    stretch = stretch_of(device, 0.06, Forcing.of(device, WAVE), 0.5, 0.02)
    before = x.copy()
    end, columns = hold_changes(x, seeds, device.coefficients, 0.06, 4e-4, *stretch)
    alone = [hold_changes(x, seed[:, None], device.coefficients, 0.06, 4e-4, *stretch)[1] for seed in seeds.T]
    np.testing.assert_array_equal(columns, np.hstack(alone))
    np.testing.assert_array_equal(x, before)
    np.testing.assert_array_equal(end, hold_changes(x, seeds, device.coefficients, 0.06, 4e-4, *stretch)[0])


def test_no_line_of_the_loop_calls_a_function() -> None:
    """A call would keep the processor from taking several directions at a time."""
    _, _, loop = rates_text((2, 3, 2, 3)).partition("for l in")
    assert loop.count("\n") > 100 and "math." not in loop
