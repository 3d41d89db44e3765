"""The best constant pair of a sea: against a brute-force scan, within its budget."""

from __future__ import annotations

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.harness.constant_pairs import scan
from gyroctl.tuning import best_pair as constant_pair
from gyroctl.tuning.best_pair import best_pair
from gyroctl.tuning.goal import Goal


def test_best_pair_is_the_best_of_a_brute_force_scan(device: gy.Plant, monkeypatch: pytest.MonkeyPatch) -> None:
    """On short runs: within the goal no pair of a plain grid gives more than a few percent more."""
    monkeypatch.setattr(constant_pair, "WINDOW", 200.0)
    monkeypatch.setattr(constant_pair, "FULL", 300.0)
    sea, seeds = gy.SeaState(hs=0.25, gamma=5.0), range(100128, 100134)
    goal = Goal(locked=0.99, motion=0.34)
    budget = 72 * 4 * 200.0 / 0.1 + 1.0
    found = best_pair(device, sea, budget, seeds, goal, quiet=True)
    assert found.met
    assert found.spent <= budget
    pairs = [(cc, cg) for cc in (0.04, 0.055, 0.075, 0.1) for cg in np.geomspace(1e-4, 2e-3, 14).tolist()]
    run = scan(device, sea, pairs, seeds, 300.0, dt=0.025, workers=1, quiet=True)
    held = run.locked.all(axis=1) & (np.maximum(run.phi1_p98, run.phi3_p98).mean(axis=1) <= 0.34)
    assert found.means["mean_power"] >= 0.95 * run.mean_power.mean(axis=1)[held].max()
    own = scan(device, sea, [(found.cc, found.cg)], seeds, 300.0, workers=1, quiet=True)
    # what is judged counts what is stored too, some tens of joules over 200 s
    assert own.mean_power.mean() == pytest.approx(found.means["mean_power"], rel=0.1)


def test_best_pair_refuses_a_small_budget(device: gy.Plant) -> None:
    with pytest.raises(gy.InputError, match="too small"):
        best_pair(device, gy.SeaState(), 1e5, range(100128, 100130), quiet=True)
