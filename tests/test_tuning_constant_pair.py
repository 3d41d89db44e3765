"""The best constant pair of a sea: against a brute-force scan, within its budget."""

from __future__ import annotations

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.harness.constant_pairs import scan
from gyroctl.harness.run import lead_in, run_law
from gyroctl.simulation.metrics import evaluate
from gyroctl.tuning import best_pair as constant_pair
from gyroctl.tuning.best_pair import Lengths, best_pair, first_grid
from gyroctl.tuning.goal import Goal
from gyroctl.tuning.pair_means import Trial, means_of


@pytest.mark.slow
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


def test_small_budget_takes_every_other_value_of_the_first_grid(device: gy.Plant) -> None:
    """So that the grid still reaches from end to end, in steps that the fine one bridges."""
    whole, thin = first_grid(gy.Settings()), first_grid(gy.Settings(), constant_pair.EVERY_OTHER)
    assert len(whole) == 4 * len(thin) and set(thin) < set(whole)
    for at in (0, 1):
        every, some = sorted({pair[at] for pair in whole}), sorted({pair[at] for pair in thin})
        assert some == every[1::2]
    budget = 18 * 4 * 200.0 / 0.1
    for enough in (True, False):
        lengths = Lengths(0.025, 200.0 if enough else 201.0, 120.0)
        if enough:
            found = best_pair(device, gy.SeaState(), budget, range(100128, 100132), None, lengths=lengths, quiet=True)
            assert found.spent <= budget
            first = [pair for pair, _, stage in found.seen if stage == "search"][: len(thin)]
            assert first == thin
        else:
            with pytest.raises(gy.InputError, match="grid of 18 pairs"):
                best_pair(device, gy.SeaState(), budget, range(100128, 100132), None, lengths=lengths, quiet=True)


@pytest.mark.slow
def test_pair_whose_contact_may_slip_is_judged_as_a_law_is(device: gy.Plant) -> None:
    """By the plain run of `constant`: turns and reversals stand beside the rest, in the order of the pairs."""
    slipping = gy.zhang2017(drag=0.5, contact="friction", traction=0.6)
    sea, seeds, settings = gy.SeaState(), [100128, 100129], gy.Settings(blend=40.0)
    pairs = [(0.06, 4e-4), (0.08, 2e-4)]
    found = means_of(pairs, Trial(slipping, sea, seeds, 60.0, settings, quiet=True))
    for (cc, cg), row in zip(pairs, found, strict=True):
        hand = []
        for seed in seeds:
            waves = lead_in(gy.realise(slipping, sea, seed, 60.0), settings)
            record, _ = run_law(slipping, gy.law("constant", cc=cc, cg=cg), waves, settings)
            hand.append(evaluate(slipping, record, waves.moments[1], waves.dt, sea.wp, 40.0, np.nan))
        for name in ("mean_power", "turns_kept", "phi1_p98"):
            assert row[name] == pytest.approx(np.mean([one[name] for one in hand]), rel=1e-9), name
        assert row["reversed"] in (0.0, 0.5, 1.0)
    rolling = means_of(pairs, Trial(device, sea, seeds, 60.0, settings, quiet=True))
    assert "turns_kept" not in rolling[0], "the ensemble does not tell"
