"""Machine code gives the bits of Python: every compiled law, on many realisations, in every mode of a supervisor."""

from __future__ import annotations

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.harness.law_entry import compile_law
from gyroctl.harness.registry import registered
from gyroctl.harness.run import Settings, lead_in, run_law

PLAIN = {"nmpc"}
"""Laws that bring machine code of their own, which their Python text calls: see `tests/test_nmpc_entry.py`."""

SEEDS = range(100000, 100020)
DURATION = 200.0


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(set(registered()) - PLAIN))
def test_machine_code_has_the_bits_of_python_on_twenty_realisations(device: gy.Plant, name: str) -> None:
    law, settings = gy.law(name), Settings(blend=20.0)
    assert compile_law(law) is not None
    differ = {}
    for seed in SEEDS:
        waves = lead_in(gy.realise(device, gy.SeaState(), seed, DURATION), settings)
        one, _ = run_law(device, law, waves, settings, name)
        other, _ = run_law(device, law, waves, settings, name, compiled=False)
        samples = np.flatnonzero(np.any(one.commands != other.commands, axis=1))
        differ |= {seed: samples[0]} if samples.size else {}
    assert differ == {}


@pytest.mark.slow
@pytest.mark.parametrize("wraps", ["load_angle", "coupling"])
def test_start_from_rest_has_the_bits_of_python(device: gy.Plant, wraps: str) -> None:
    """The motor, the pull into step and the hand-over."""
    settings = Settings(start="rest", actuators=gy.Actuators(cg_min=-0.02))
    law = gy.law("supervisor", wraps=wraps)
    for seed in (100001, 100002, 100003):
        waves = gy.realise(device, gy.SeaState(), seed, 300.0)
        one, _ = run_law(device, law, waves, settings)
        other, _ = run_law(device, law, waves, settings, compiled=False)
        assert one.commands[:, 1].min() < 0.0
        np.testing.assert_array_equal(one.commands, other.commands)
        np.testing.assert_array_equal(one.states, other.states)


def test_squares_by_a_power_are_why_a_law_writes_products() -> None:
    """Python's `x**2` is the library's power, machine code's a product: they differ now and then, products never."""
    x = np.random.default_rng(0).uniform(0.0, 2.0, 20_000).tolist()
    product = np.array([value * value for value in x])
    assert np.array_equal(product, np.array(x) ** 2), "numpy multiplies as machine code does"
    power = np.array([value**2 for value in x])
    np.testing.assert_allclose(power, product, rtol=3e-16)
