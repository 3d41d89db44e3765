"""The planner as machine code: the bits of its Python text, alone, in lanes and resumed; rows of numbers; times."""

from __future__ import annotations

import math
import pickle
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest
from numba import njit

import gyroctl as gy
from gyroctl.controllers.nmpc import Nmpc, flat, stopwatch
from gyroctl.controllers.nmpc.law import call
from gyroctl.controllers.nmpc.sample import CC, FAILURES, FALLBACKS, SAMPLE
from gyroctl.controllers.nmpc.views import view
from gyroctl.harness.law_entry import compile_law, last_state
from gyroctl.harness.protocol import Measurement
from gyroctl.harness.run import Settings, lead_in, run_law

SETTINGS = Settings(blend=10.0)
SEEN = Measurement(0.1, 3.0, 68.0, 0.05, 0.02, 0.1, 0.1)


def by_python(law: Nmpc) -> Nmpc:
    """The same law, whose sample goes through Python: it looks at the clock, and is never late."""
    other = replace(law, deadline=1e9)
    assert compile_law(law) is not None and compile_law(other) is None
    return other


def waves(device: gy.Plant, seed: int = 100000, duration: float = 30.0) -> Any:
    return lead_in(gy.realise(device, gy.SeaState(), seed, duration=duration), SETTINGS)


def run(device: gy.Plant, law: Nmpc, seed: int = 100000) -> Any:
    return run_law(device, law, waves(device, seed), SETTINGS)


def test_machine_gives_the_bits_of_the_python_text(device: gy.Plant) -> None:
    """Long enough to learn the sea several times, and to begin plans elsewhere."""
    law = Nmpc()
    compiled, timing = run(device, law)
    plain, other = run(device, by_python(law))
    np.testing.assert_array_equal(compiled.states, plain.states)
    np.testing.assert_array_equal(compiled.commands, plain.commands)
    assert timing.counters == other.counters
    assert len(np.unique(compiled.commands[:, 0])) > 100


def test_plans_that_fail_are_stood_in_for_alike(device: gy.Plant) -> None:
    """A weight so large that no cost is a number: the rest of the plan for ten samples, then the fallback law."""
    law = gy.law("nmpc", turns=1e308, reserve=1e10)
    compiled, timing = run(device, law)
    plain, other = run(device, by_python(law))
    np.testing.assert_array_equal(compiled.commands, plain.commands)
    assert timing.counters == other.counters
    assert timing.counters["failed_plans"] == 300 and timing.counters["kept_plans"] == 10
    np.testing.assert_array_equal(compiled.commands[20:], np.tile([0.052, 2e-4], (280, 1)))


def test_a_step_is_a_sample_of_the_machine_and_leaves_its_state_alone() -> None:
    law = Nmpc()
    machine = compile_law(law)
    assert machine is not None
    s, u, state = machine.s.copy(), np.empty(2), law.init()
    for sample in range(200):
        call(machine.entry.address, 0.1 * sample, np.array(SEEN), machine.p, s, u)
        before = state.row.copy()
        command, later = law.step(0.1 * sample, SEEN, state)
        assert command == tuple(u) and state.row.tobytes() == before.tobytes()
        state = later
    one, two = law.memory(state), law.memory(last_state(law, s))
    np.testing.assert_array_equal(one.work.plan, two.work.plan)
    np.testing.assert_array_equal(one.forecast.memory.whitener, two.forecast.memory.whitener)
    assert one.work.counts[SAMPLE] == 200 and one.work.numbers[CC] == u[0]


def test_run_goes_on_from_a_kept_state() -> None:
    law, other = Nmpc(), Nmpc()
    state, answers = law.init(), []
    for sample in range(140):
        if sample == 130:
            kept = state
        command, state = law.step(0.1 * sample, SEEN, state)
        answers.append(command)
    for sample in range(130, 140):
        command, kept = other.step(0.1 * sample, SEEN, kept)
        assert command == answers[sample]


def test_a_lost_measurement_leaves_the_estimate_whole() -> None:
    """A reading that is no number is left out: the plan goes on, and no number of the estimate is lost."""
    law = Nmpc()
    lost = SEEN._replace(phi1=math.nan)
    for one in (law, by_python(law)):
        state = one.init()
        for sample in range(3):
            _, state = one.step(0.1 * sample, SEEN, state)
        _, state = one.step(0.3, lost, state)
        assert one.memory(state).work.counts[FAILURES] == 0 and one.memory(state).work.counts[FALLBACKS] == 0
        assert one.memory(state).estimate.missing[3] == 1.0
        command, state = one.step(0.4, SEEN, state)
        assert np.isfinite(one.memory(state).estimate.x_hat).all() and np.isfinite(command).all()


class Inner(NamedTuple):
    """A group."""

    table: Any
    nothing: None
    count: int


class Outer(NamedTuple):
    """A group with a group."""

    number: float
    inner: Inner
    pair: tuple[float, float]
    places: Any


VALUE = Outer(1.5, Inner(np.arange(6.0).reshape(2, 3), None, 7), (2.5, 3.5), np.array([4, 5], np.int64))


def test_rows_are_built_back_and_share_their_memory() -> None:
    row = flat.row_of(VALUE)
    found = flat.built(VALUE, row)
    assert (found.number, found.inner.nothing, found.inner.count, found.pair) == (1.5, None, 7, (2.5, 3.5))
    np.testing.assert_array_equal(found.inner.table, VALUE.inner.table)
    np.testing.assert_array_equal(found.places, VALUE.places)
    found.inner.table[1, 2], found.places[0] = 9.0, 8
    again = flat.built(VALUE, row)
    assert again.inner.table[1, 2] == 9.0 and again.places[0] == 8


def test_text_builds_what_python_builds() -> None:
    """Of a row of another size as well: the sizes stand in the row."""
    kinds: dict[str, Any] = {}
    text = flat.joined(flat.text_of(VALUE, "whole", "numbers", kinds))
    larger = VALUE._replace(inner=VALUE.inner._replace(table=np.arange(20.0).reshape(4, 5)))
    for value in (VALUE, larger):
        whole, numbers = flat.parts_of(flat.row_of(value))
        found = eval(text, {**kinds, "whole": whole, "numbers": numbers, "view": viewed})
        assert found.pair == value.pair and found.inner.count == 7 and found.number == 1.5
        np.testing.assert_array_equal(found.inner.table, value.inner.table)
        np.testing.assert_array_equal(found.places, value.places)


def viewed(row: Any, begin: int, shape: tuple[int, ...]) -> Any:
    """What `views.view` compiles to."""
    found = view_of[len(shape)](row, begin, shape)
    assert found.flags.c_contiguous and np.shares_memory(found, row)
    return found


view_of = {1: njit(lambda row, at, shape: view(row, at, shape)), 2: njit(lambda row, at, shape: view(row, at, shape))}


@pytest.mark.parametrize("value", [("text",), (True,), (np.array([1], np.int32),)])
def test_what_is_no_number_is_refused(value: Any) -> None:
    with pytest.raises(flat.NotFlat):
        flat.row_of(value)


def test_quantiles_are_those_of_the_times() -> None:
    counts = np.zeros(stopwatch.BINS, np.int64)
    times = np.random.default_rng(0).lognormal(math.log(2e-4), 0.7, 5000)
    for spent in times:
        stopwatch.note(spent, counts)
    assert counts.sum() == 5000
    for part in (0.5, 0.99):
        assert stopwatch.quantile(counts, part) == pytest.approx(np.quantile(times, part), rel=0.03)
    assert math.isnan(stopwatch.quantile(np.zeros(5, np.int64), 0.5))


@pytest.mark.skipif(stopwatch.clock_address() == 0, reason="no clock that compiled code can call")
def test_samples_are_timed(device: gy.Plant) -> None:
    _, timing = run(device, Nmpc())
    assert 0.01 < timing.median < timing.p99 < 1000.0


@pytest.mark.parametrize("law, count", [(Nmpc(), 6), (Nmpc(deadline=1.0), 6), (gy.law("nmpc", solver="descent"), 5)])
def test_preparations_travel_to_processes_and_bring_nothing_back(law: Any, count: int) -> None:
    parts = pickle.loads(pickle.dumps(law.preparations()))
    assert len(parts) == count and all(part() is None for part in parts)
