"""Stages of the planning law's sample: rivals that live on, a command that leads a coupling which lags."""

from __future__ import annotations

import math

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.controllers.nmpc.flat import built, row_of
from gyroctl.controllers.nmpc.sample import CC, GOOD, SAMPLE, Work, acted, posed, seen_ring
from gyroctl.errors import InputError
from gyroctl.plant.equations import PSI_RATE


def work_of(law: gy.Law) -> Work:
    """A copy of the law's own memory, to be worked in."""
    work: Work = built(law._first, row_of(law._first)).work
    return work


def test_rivals_live_on_and_are_begun_one_after_the_other() -> None:
    """Two rivals with a life of four: each is shifted at every sample, and begun anew at every fourth, two apart."""
    law = gy.law("nmpc", every=1, retries=3, rivals=2, life=4)
    c, w = law._numbers, work_of(law)
    n, x = w.trial.size, np.zeros(14)
    assert w.rivals.size == 2 * n and w.result.size == 4
    born: list[list[int]] = [[], []]
    w.result[2:] = 7.0
    for sample in range(12):
        w.counts[SAMPLE] = sample
        w.rivals[:] = marks = np.arange(2.0 * n) + 100.0
        assert posed(c, w, x) == 3
        for r in range(2):
            own, before = w.rivals[n * r : n * (r + 1)], marks[n * r : n * (r + 1)]
            if np.array_equal(own, np.append(before[1:], before[-1])):
                assert w.result[2 + r] == 7.0
            else:
                born[r].append(sample)
                assert w.result[2 + r] == c.fresh_rival and np.all(own <= law.cc_max)
                w.result[2 + r] = 7.0
    assert born == [[0, 4, 8], [2, 6, 10]]


def test_rival_without_a_past_is_begun_at_once() -> None:
    law = gy.law("nmpc", every=1, retries=1, rivals=3, life=9)
    c, w = law._numbers, work_of(law)
    w.counts[SAMPLE] = 1
    posed(c, w, np.zeros(14))
    assert w.result[2:].tolist() == [c.fresh_rival] * 3


@pytest.mark.parametrize("held", [0.0, 0.05, 0.08])
def test_command_leads_a_coupling_that_lags_where_it_is_to_grow(held: float) -> None:
    """The mean over the interval of what a first-order lag makes of the command is what the plan says."""
    law, period = gy.law("nmpc", lag=0.03), 0.1
    c, w, u = law._numbers, work_of(law), np.empty(2)
    w.trial[:] = 0.08
    assert not acted(c, w, 70.0, 3.0, held, GOOD, u)
    time = (np.arange(20000) + 0.5) * period / 20000
    followed = u[0] + (held - u[0]) * np.exp(-time / 0.03)
    assert np.mean(followed) == pytest.approx(0.08, rel=1e-6) and w.numbers[CC] == u[0]


@pytest.mark.parametrize("held, planned", [(0.1, 0.08), (0.3, 0.037), (0.2, 0.0), (0.0, 0.29)])
def test_command_does_not_lead_where_the_coupling_is_to_fall(held: float, planned: float) -> None:
    """It ends at what is planned, and within the limits; the mean is larger, so that the ring is not slower."""
    law = gy.law("nmpc", lag=0.03)
    c, w, u = law._numbers, work_of(law), np.empty(2)
    w.trial[:] = planned
    acted(c, w, 70.0, 3.0, held, GOOD, u)
    assert u[0] == (planned if held > planned else law.cc_max)


@pytest.mark.parametrize("ring, let_go", [(3.0, False), (0.1, False), (-0.4, False), (-0.6, True), (-3.0, True)])
def test_ring_that_goes_backwards_is_let_go(ring: float, let_go: bool) -> None:
    """In real water, where a coupling would hold an axis that rolls backwards; a linear plant's contact is ideal."""
    for real, law in ((True, gy.law("nmpc", plant="realistic")), (False, gy.law("nmpc"))):
        c, w, u = law._numbers, work_of(law), np.empty(2)
        w.trial[:] = 0.05
        acted(c, w, 70.0, ring, 0.05, GOOD, u)
        assert (u[0] == 0.0) == (let_go and real) and w.numbers[CC] == u[0]
        assert w.plan[0] == 0.05, "the plan is kept"


def test_ring_is_seen_as_it_is_read_unless_the_reading_is_lost() -> None:
    law = gy.law("nmpc", plant="realistic")
    state = built(law._first, row_of(law._first)).estimate
    state.x_hat[PSI_RATE] = 2.8
    reading = np.array([0.1, -2.9, 68.0, 0.0, 0.0, 0.0, 0.0])
    assert seen_ring(state, reading) == -2.9
    state.missing[1] = 1.0
    assert seen_ring(state, reading) == 2.8


@pytest.mark.parametrize("lag", [-0.01, math.nan, 0.2])
def test_lag_that_cannot_be_made_up_for(lag: float) -> None:
    with pytest.raises(InputError, match="lag"):
        gy.law("nmpc", lag=lag)


def test_design_model_beyond_the_linear_one_takes_the_set_for_real_water() -> None:
    tuned, plain = gy.law("nmpc", plant="realistic"), gy.law("nmpc")
    assert tuned == gy.law("nmpc", tuning="real") and tuned.aims.traction > 0.0 == plain.aims.traction
    assert gy.law("nmpc", plant="realistic", traction=0.45).aims.traction == 0.45
    assert gy.law("nmpc", plant="corrected").aims == plain.aims
