"""Many closed loops at once, in lanes where that is possible: the bits are those of each run alone."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Hashable, Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.harness.actuation import ActuatorArrays
from gyroctl.harness.lane_loop import LaneKernel, LaneRuns, compiled_lane_loop
from gyroctl.harness.law_entry import CompiledLaw, compile_law, last_state, why_it_stopped
from gyroctl.harness.protocol import Counting, Law, LawError, Machined, Motoring
from gyroctl.harness.run import LawTiming, Settings, beginning, checked_run, run_law, timing_of
from gyroctl.harness.sensing import SensorArrays
from gyroctl.harness.sight import informed
from gyroctl.plant import Plant
from gyroctl.plant.kernel import rows
from gyroctl.plant.lane_steps import lane_room
from gyroctl.plant.measurement import CHANNELS
from gyroctl.plant.packs import LANES, ROOM
from gyroctl.simulation.metrics import Record
from gyroctl.waves import WaveRealisation

WORTH = 4
"""Fewest runs for which lanes are clearly quicker than one after the other: two thirds of the time, of sixteen a third
(`benchmarks/growth.py`)."""

MEMORY = 3e8
"""What the records of one filling of the lanes may take: longer runs go one by one. [B]"""


class Loop(NamedTuple):
    """One run: a law on a realisation, as it acts on the plant."""

    law: Law
    waves: WaveRealisation
    settings: Settings
    name: str = "law"
    time_limit: float = math.inf  # see `run_law`


Outcome = tuple[Record, LawTiming] | LawError
"""A run with the timing of its law, or why the law failed."""


class _Told(NamedTuple):
    """A loop with its law as it is told the realisation, its machine code, and what loops in lanes have in common."""

    loop: Loop
    law: Law
    machine: CompiledLaw | None
    kind: Hashable  # None for a loop that runs alone


def run_together(plant: Plant, loops: Sequence[Loop]) -> list[Outcome]:
    """Run loops side by side: laws of one kind with parameters of their own, on seas, steps and sensors of their own.

    Parameters
    ----------
    plant : Plant
        The device.
    loops : sequence of Loop
        Any number; each is what `run_law` takes.

    Returns
    -------
    list
        For each loop the record and the timing that `run_law` returns, or the `LawError` that it raises.

    Raises
    ------
    InputError
        As `run_law`.
    """
    if len(loops) < WORTH:
        return [_alone(plant, loop) for loop in loops]
    told = [_told(plant, loop) for loop in loops]
    found: dict[int, Outcome] = {}
    for group in _groups(told):
        some = [told[i] for i in group]
        outcomes = _in_lanes(plant, some) if len(group) >= WORTH else [_alone(plant, one.loop) for one in some]
        found |= dict(zip(group, outcomes, strict=True))
    return [found[i] for i in range(len(loops))]


def in_groups(plant: Plant, loops: Sequence[Loop]) -> list[list[int]]:
    """Numbers of the loops that `run_together` runs as one piece of work.

    Loops of one kind of compiled law share the lanes if their realisations have one grid and their actuators one period
    and no controls that move. Each that cannot share stands alone: laws of plain Python, plants beyond the linear
    model or of more states than lanes have room for, runs so long that a filling of the lanes would take more than
    `MEMORY`, and those of which there are fewer than `WORTH`.
    """
    return _groups([_told(plant, loop) for loop in loops])


def _groups(told: Sequence[_Told]) -> list[list[int]]:
    alike: defaultdict[Hashable, list[int]] = defaultdict(list)
    for number, one in enumerate(told):
        alike[number if one.kind is None else one.kind].append(number)
    groups = []
    for numbers in alike.values():
        groups += [numbers[part] for part in pieces(len(numbers))]
    return groups


def pieces(count: int, workers: int = 1) -> list[slice]:
    """Share out so many runs: evenly, no more of them than there are lanes, and something for each worker if worth it.

    Fewer than `WORTH` are shared out one by one.

    Parameters
    ----------
    count : int
        Runs.
    workers : int
        Among whom.
    """
    if count < WORTH:
        return [slice(i, i + 1) for i in range(count)]
    rounds = math.ceil(count / (LANES * workers))
    number = max(math.ceil(count / LANES), min(rounds * workers, count // WORTH))
    edges = [round(i * count / number) for i in range(number + 1)]
    return [slice(a, b) for a, b in pairwise(edges)]


def too_long(plant: Plant, duration: float, period: float) -> bool:
    """Whether the records of a filling of the lanes, runs of `duration` sampled every `period` [s], exceed `MEMORY`."""
    samples = math.floor(duration / period + 1e-9)
    return LANES * samples * (rows(plant.coefficients) + len(CHANNELS)) * 8 > MEMORY


def _told(plant: Plant, loop: Loop) -> _Told:
    waves, actuators, k = loop.waves, loop.settings.actuators, plant.coefficients
    samples = math.floor(waves.duration / actuators.period + 1e-9)
    long = too_long(plant, waves.duration, actuators.period)
    if k.beyond is not None or rows(k) > ROOM or actuators.moves or long:
        return _Told(loop, loop.law, None, None)
    own, _ = informed(loop.law, waves, plant)
    machine = compile_law(own)
    if machine is None:
        return _Told(loop, own, None, None)
    kind = id(machine.entry), machine.p.size, waves.dt, waves.moments.shape, actuators.period, samples
    return _Told(loop, own, machine, kind)


def _alone(plant: Plant, loop: Loop) -> Outcome:
    try:
        return run_law(plant, loop.law, loop.waves, loop.settings, loop.name, time_limit=loop.time_limit)
    except LawError as error:
        return error


def _in_lanes(plant: Plant, told: Sequence[_Told]) -> list[Outcome]:
    """Run up to LANES loops of one kind."""
    loops, machines = [one.loop for one in told], [one.machine for one in told if one.machine is not None]
    runs, waves, tick = len(loops), [loop.waves for loop in loops], loops[0].settings.actuators.period
    samples, n = math.floor(waves[0].duration / tick + 1e-9), len(plant.labels)
    record, held = np.zeros((runs, samples + 1, rows(plant.coefficients))), np.empty((runs, 2))
    signals, every = np.zeros((LANES, waves[0].moments.size)), np.empty(runs, np.int64)
    for run, (loop, one) in enumerate(zip(loops, told, strict=True)):
        every[run] = checked_run(plant, one.law, loop.waves, loop.settings, loop.name)
        record[run, 0, :n], held[run] = beginning(plant, loop.waves, loop.settings)
        signals[run] = loop.waves.moments.T.ravel()
    lanes = LaneRuns(
        p=np.stack([machine.p for machine in machines]),
        s=np.stack([machine.s for machine in machines]),
        every=every,
        record=record,
        commands=np.zeros((runs, samples, 2)),
        controls=np.zeros((runs, samples, 2)),
        held=held,
        saturations=np.zeros(runs, np.int64),
        seen=np.zeros((runs, len(CHANNELS))),
        failed=np.empty(runs, np.int64),
        room=lane_room(rows(plant.coefficients)),
        own=np.zeros((2, LANES, 2)),
    )
    steps, pace = np.array([loop.settings.dt for loop in loops]), plant.parameters.time_scale
    kernel = LaneKernel(plant.coefficients, signals, waves[0].dt, steps, pace)
    sensors = SensorArrays(*_stacked([loop.settings.sensors.arrays(samples, loop.waves.seed, tick) for loop in loops]))
    actuators = ActuatorArrays(*_stacked([_actuators(one) for one in told]))
    compiled_lane_loop(machines[0].entry, lanes, kernel, sensors, actuators, tick)
    found: list[Outcome] = []
    for run, (one, timing) in enumerate(zip(told, _timings(told, lanes.s), strict=True)):
        if lanes.failed[run] >= 0:
            at = lanes.failed[run] * tick
            found.append(why_it_stopped(one.law, one.loop.name, at, lanes.seen[run], lanes.s[run]))
            continue
        lag, saturated = float(one.loop.settings.actuators.cc_lag), int(lanes.saturations[run])
        own = Record(record[run], lanes.commands[run], lanes.controls[run], tick, saturated, None, lag)
        found.append((own, timing))
    return found


def _stacked(parts: Sequence[Sequence[Any]]) -> list[Any]:
    """Arrays of several runs, field by field."""
    return [np.stack([np.asarray(part) for part in field]) for field in zip(*parts, strict=True)]


def _actuators(one: _Told) -> ActuatorArrays:
    return one.loop.settings.actuators.arrays(isinstance(one.law, Motoring) and one.law.motors)


def _timings(told: Sequence[_Told], states: NDArray[np.float64]) -> Iterator[LawTiming]:
    """Timing and counts of each run. Where a law does not time itself one serves all: they differ in numbers alone."""
    timing: LawTiming | None = None
    for one, state in zip(told, states, strict=True):
        counts, itself = isinstance(one.law, Counting), isinstance(one.law, Machined)
        last = last_state(one.law, state) if counts or itself else None
        if timing is None or itself:
            assert one.machine is not None
            timing = timing_of(one.law, one.machine, last)
        yield replace(timing, counters=dict(one.law.counters(last))) if isinstance(one.law, Counting) else timing
