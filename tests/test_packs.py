"""Packs of runs: each lane is what a scalar would be, to the last bit, and what nobody asks for is not missed."""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numba import njit
from numpy.typing import NDArray

import gyroctl as gy
from gyroctl.harness.start import locked_start
from gyroctl.plant import pack_run, pack_step
from gyroctl.plant.compiled import source_stamp
from gyroctl.plant.equations import LEDGER
from gyroctl.plant.kernel import RECORDED, SOURCES, hold_one, rows
from gyroctl.plant.pack_run import BLOCK, run_packs
from gyroctl.plant.packs import LANES, packs, room, settle
from gyroctl.plant.trigonometry import cos_sin
from gyroctl.simulation.ensemble import EnsembleRun, run_ensemble
from gyroctl.simulation.quantile import size_quantile

Array = NDArray[np.float64]
SEA = gy.SeaState()
RNG = np.random.default_rng(5)
OPERATIONS = (operator.add, operator.sub, operator.mul, operator.truediv)


def applied(operation: Callable[[Any, Any], Any]) -> Callable[[Array, float], None]:
    def apply(flat: Array, scalar: float) -> None:
        """Of packs 0 and 1 write what they give together, with a number behind and before it, and with a whole one."""
        held, kept = packs(flat), room()
        kept[3] = operation(held[0], held[1])
        held[2] = kept[3]
        held[3] = operation(held[0], scalar)
        held[4] = operation(scalar, held[0])
        settle(held)
        held[5] = operation(3, held[4])

    return apply


def turned(flat: Array) -> None:
    held = packs(flat)
    held[1], held[2] = cos_sin(held[0])


def turned_alone(flat: Array) -> None:
    for lane in range(LANES):
        flat[LANES + lane], flat[2 * LANES + lane] = cos_sin(flat[lane])


@pytest.mark.parametrize("operation", OPERATIONS, ids=lambda one: one.__name__)
@pytest.mark.parametrize("begin", [0, 3])  # also where no cache line begins
@pytest.mark.parametrize("compiled", [True, False])
def test_each_lane_is_computed_as_a_scalar(operation: Callable[[Any, Any], Any], begin: int, compiled: bool) -> None:
    flat = RNG.standard_normal(begin + 6 * LANES)[begin:]
    one, other = flat[:LANES].copy(), flat[LANES : 2 * LANES].copy()
    apply = applied(operation)
    (njit(error_model="numpy")(apply) if compiled else apply)(flat, 0.3)
    expected = operation(one, other), operation(one, 0.3), operation(0.3, one), operation(3.0, operation(0.3, one))
    np.testing.assert_array_equal(flat[2 * LANES :], np.concatenate(expected))


@pytest.mark.slow
def test_cosine_and_sine_of_a_pack_are_those_of_its_angles() -> None:
    """In every quadrant, on both sides of zero, and after a thousand turns."""
    for first in (-7.0, -0.1, 0.0, 3.0, 6283.0, -6283.0):
        angles = first + np.arange(LANES) * 0.91
        together, alone = np.zeros((2, 3 * LANES))
        together[:LANES] = alone[:LANES] = angles
        njit(error_model="numpy")(turned)(together)
        njit(error_model="numpy")(turned_alone)(alone)
        np.testing.assert_array_equal(together.view(np.int64), alone.view(np.int64))
        np.testing.assert_allclose(together[LANES:], [*np.cos(angles), *np.sin(angles)], atol=1e-12)


@pytest.mark.parametrize("steps", [1, 10, BLOCK, BLOCK + 3, 2 * BLOCK + 1])
def test_lanes_take_the_steps_of_the_single_run(device: gy.Plant, steps: int) -> None:
    """From the first sample of the record to its last, each lane with controls and waves of its own."""
    k, size, intervals, hold, dt = device.coefficients, rows(device.coefficients), 60, 0.1, 0.05
    signals = 20.0 * RNG.standard_normal((5, 2, round(intervals * hold / dt) + 1))
    of_lane = np.arange(LANES) % 5
    cc, cg = RNG.uniform(0.0, 0.06, LANES), RNG.uniform(0.0, 1e-3, LANES)
    start, _ = locked_start(device, SEA)
    first = np.concatenate([start, np.zeros(len(LEDGER))])
    y = np.repeat(first[:, None], LANES, axis=1).ravel()
    record, marked = np.empty((len(RECORDED), intervals + 1, LANES)), np.empty_like(y)
    run_packs(y, k, cc, cg, hold, steps, signals, of_lane, dt, record, 7, marked, True)
    ends, marks = y.reshape(size, LANES), marked.reshape(size, LANES)
    for lane in (0, 4, 7, 8, LANES - 1):
        waves, alone = np.ascontiguousarray(signals[of_lane[lane]].T).ravel(), first
        for i in range(intervals):
            np.testing.assert_array_equal(record[:, i, lane], alone[list(RECORDED)])
            if i == 7:
                np.testing.assert_array_equal(marks[:, lane], alone)
            alone = hold_one(alone, k, cc[lane], cg[lane], i * hold, hold, steps, waves, dt)
        np.testing.assert_array_equal(ends[:, lane], alone)


def test_stamp_of_the_lanes_covers_what_is_compiled_into_them() -> None:
    files = (*SOURCES, pack_step.__file__, pack_run.__file__)
    assert run_packs.py_func.__qualname__.endswith(f"_{source_stamp(files)[:16]}")


@pytest.mark.parametrize("name", ["linear", "realistic"])
def test_without_the_ledger_all_else_is_the_same(device: gy.Plant, name: str) -> None:
    plant = device if name == "linear" else device.replace(windage=1e-6)
    pairs, seeds = [(0.052, 3.5e-4), (0.2, 5e-4), (0.0, 0.0)], [1, 2, 3]
    start, _ = locked_start(device, SEA)

    def ensemble(ledger: bool) -> EnsembleRun:
        return run_ensemble(plant, SEA, pairs, seeds, start, 60.0, 20.0, workers=1, quiet=True, ledger=ledger)

    kept, left = ensemble(True), ensemble(False)
    for field in ("loss_time", "mean_power", "power_cv", "phi1_p98", "phi3_p98"):
        np.testing.assert_array_equal(getattr(left, field), getattr(kept, field))
    for field in ("ledger_residual", "slip_loss_w", "wave_input_w"):
        assert np.all(np.isfinite(getattr(kept, field)))
        assert np.all(np.isnan(getattr(left, field)))


@pytest.mark.parametrize("count", [1, 2, 50, 51, 1001])
@pytest.mark.parametrize("share", [0.0, 0.5, 0.98, 1.0])
def test_quantile_is_the_library_s(count: int, share: float) -> None:
    values = RNG.standard_normal((count, 3))
    np.testing.assert_array_equal(size_quantile(values, share), np.quantile(np.abs(values), share, axis=0))
    values[count // 2, 1] = np.nan
    found = size_quantile(values, share)
    assert np.isnan(found[1])
    assert np.all(np.isfinite(found[[0, 2]]))


def test_window_holds_the_sample_before(device: gy.Plant) -> None:
    """By rounding an interval may begin a sample before the last one ended, also where the window moves on."""
    k, size, hold, steps, dt, intervals = device.coefficients, rows(device.coefficients), 0.1, 10, 0.05, 3000
    number = np.arange(intervals)
    ends, starts = (number * hold + steps * (hold / steps)) / dt, (number + 1) * hold / dt
    assert np.any(np.floor(starts) < np.floor(ends))
    signals = RNG.standard_normal((1, 2, round(intervals * hold / dt) + 1))
    start, _ = locked_start(device, SEA)
    alone = np.concatenate([start, np.zeros(len(LEDGER))])
    y, zero = np.repeat(alone[:, None], LANES, axis=1).ravel(), np.zeros(LANES)
    record = np.empty((len(RECORDED), intervals + 1, LANES))
    run_packs(y, k, zero, zero, hold, steps, signals, zero.astype(np.int64), dt, record, 0, y.copy(), True)
    waves = np.ascontiguousarray(signals[0].T).ravel()
    for i in range(intervals):
        alone = hold_one(alone, k, 0.0, 0.0, i * hold, hold, steps, waves, dt)
    np.testing.assert_array_equal(y.reshape(size, LANES)[:, 0], alone)
