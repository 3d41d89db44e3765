"""Powers of the energy ledger by their own names, each from its formula."""

from __future__ import annotations

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.plant.equations import LEDGER
from gyroctl.plant.kernel import hold_one


def state(device: gy.Plant, seed: int) -> np.ndarray:
    x = 0.2 * np.random.default_rng(seed).standard_normal(len(device.labels))
    x[device.labels.index("psi_rate")] += 3.0
    x[device.labels.index("omega_rate")] += 65.0
    return x


@pytest.mark.parametrize("seed", range(5))
def test_each_power_is_what_its_name_says(device: gy.Plant, seed: int) -> None:
    plant = device.replace(d3=0.7)
    x, (cc, cg), (me1, me3) = state(plant, seed), (0.06, 4e-4), (12.0, -35.0)
    v1, v3, w, W = (x[plant.labels.index(f"{name}_rate")] for name in ("phi1", "phi3", "psi", "omega"))
    found = plant.powers(x, (cc, cg), (me1, me3))
    N = plant.parameters.N
    chain = x[[plant.labels.index(f"z{j}_{i + 1}") for j in (1, 3) for i in range(3)]]
    radiated = 0.0
    for rate, states, fit in zip((v1, v3), (chain[:3], chain[3:]), plant.radiation, strict=True):
        radiated += rate * float(np.array(fit.p[::-1]) @ states[: len(fit.p)])
    assert found["generator"] == pytest.approx(cg * W**2)
    assert found["slip"] == pytest.approx(cc * (W - N * w) ** 2)
    assert found["hinge"] == pytest.approx(2.0 * v1**2 + 0.7 * v3**2)
    assert found["wave_input"] == pytest.approx(me1 * v1 + me3 * v3)
    assert found["radiated"] == pytest.approx(radiated)


def test_ledger_of_a_run_is_in_the_same_order(device: gy.Plant) -> None:
    """Integrated over a moment by the compiled kernel: power times time, under the same names."""
    x, n, h = state(device, 7), len(device.labels), 1e-6
    waves = np.tile([12.0, -35.0], 40)
    end = hold_one(np.concatenate([x, np.zeros(len(LEDGER))]), device.coefficients, 0.06, 4e-4, 0.5, h, 1, waves, 0.05)
    powers = device.powers(x, (0.06, 4e-4), (12.0, -35.0))
    for i, name in enumerate(LEDGER):
        assert end[n + i] / h == pytest.approx(powers[name], rel=1e-3, abs=1e-4), name
