"""One law on many realisations at once, in lanes where that is possible: the bits are those of each run alone."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.harness.lane_loop import LaneKernel, LaneSensors, compiled_lane_loop
from gyroctl.harness.law_entry import CompiledLaw, compile_law, last_state, why_it_stopped
from gyroctl.harness.protocol import Counting, Law, LawError, Motoring
from gyroctl.harness.run import LawTiming, Settings, beginning, checked_run, run_law, timing_of
from gyroctl.harness.sight import informed
from gyroctl.plant import Plant
from gyroctl.plant.kernel import LANES, rows
from gyroctl.plant.measurement import CHANNELS
from gyroctl.simulation.metrics import Record
from gyroctl.waves import WaveRealisation

Outcome = tuple[Record, LawTiming] | LawError
"""A run with the timing of its law, or why the law failed."""


class _Told(NamedTuple):
    """A law as it is told one realisation, compiled."""

    law: Law
    machine: CompiledLaw


def run_together(
    plant: Plant, law: Law, waves: Sequence[WaveRealisation], settings: Settings, name: str = "law"
) -> list[Outcome]:
    """Run a law on realisations of one grid, side by side.

    Runs that cannot share their steps go one by one: those of a law that runs as plain Python, of actuators that move
    between the samples, and of plants beyond the linear model.

    Parameters
    ----------
    plant, law, settings, name
        As in `run_law`.
    waves : sequence of WaveRealisation
        As they act on the plant, each with a seed of its own; any number.

    Returns
    -------
    list
        For each realisation the record and the timing that `run_law` returns, or the `LawError` that it raises.

    Raises
    ------
    InputError
        As `run_law`.
    """
    told = [_told(law, each) for each in waves]
    grids = {(each.dt, each.moments.shape) for each in waves}
    machines = [one for one in told if one is not None]
    alike = len({(one.machine.p.size, one.machine.s.size) for one in machines}) == 1
    alone = settings.actuators.moves or plant.coefficients.beyond is not None or len(waves) == 1
    if alone or len(machines) < len(waves) or len(grids) > 1 or not alike:
        return [_alone(plant, law, each, settings, name) for each in waves]
    found: list[Outcome] = []
    for first in range(0, len(waves), LANES):
        some = slice(first, first + LANES)
        found += _in_lanes(plant, machines[some], waves[some], settings, name)
    return found


def _told(law: Law, waves: WaveRealisation) -> _Told | None:
    own, _ = informed(law, waves)
    machine = compile_law(own)
    return None if machine is None else _Told(own, machine)


def _alone(plant: Plant, law: Law, waves: WaveRealisation, settings: Settings, name: str) -> Outcome:
    try:
        return run_law(plant, law, waves, settings, name)
    except LawError as error:
        return error


def _in_lanes(
    plant: Plant, told: Sequence[_Told], waves: Sequence[WaveRealisation], settings: Settings, name: str
) -> list[Outcome]:
    """Run up to LANES runs; idle lanes repeat the last one."""
    used, tick = len(waves), settings.actuators.period
    lanes = [min(lane, used - 1) for lane in range(LANES)]
    checks = [checked_run(plant, one.law, each, settings, name) for one, each in zip(told, waves, strict=True)]
    samples, n, k = math.floor(waves[0].duration / tick + 1e-9), len(plant.labels), plant.coefficients
    record = np.zeros((LANES, samples + 1, rows(k)))
    held = np.empty((LANES, 2))
    for lane, run in enumerate(lanes):
        record[lane, 0, :n], held[lane] = beginning(plant, waves[run], settings)
    signals = np.stack([waves[run].moments for run in lanes])
    kernel = LaneKernel(
        k, np.ascontiguousarray(signals.transpose(0, 2, 1)).reshape(LANES, -1), waves[0].dt, settings.dt
    )
    drawn = [settings.sensors.arrays(samples, each.seed) for each in waves]
    sensors = LaneSensors(
        np.stack([drawn[run].error for run in lanes]),
        np.stack([drawn[run].missing for run in lanes]),
        drawn[0].quantum,
        drawn[0].delay,
    )
    p, s = (np.stack([getattr(told[run].machine, part) for run in lanes]) for part in ("p", "s"))
    commands, controls = np.zeros((LANES, samples, 2)), np.zeros((LANES, samples, 2))
    saturations, failed, seen = np.zeros(LANES, np.int64), np.empty(LANES, np.int64), np.zeros((LANES, len(CHANNELS)))
    motors = isinstance(told[0].law, Motoring) and told[0].law.motors
    compiled_lane_loop(
        told[0].machine.entry,
        p,
        s,
        checks[0],
        kernel,
        sensors,
        settings.actuators.arrays(motors),
        tick,
        record,
        commands,
        controls,
        held,
        saturations,
        seen,
        failed,
    )
    lag = float(settings.actuators.cc_lag)
    found: list[Outcome] = []
    for lane, one in enumerate(told):
        if failed[lane] >= 0:
            found.append(why_it_stopped(one.law, name, failed[lane] * tick, seen[lane], s[lane]))
            continue
        own = Record(record[lane], commands[lane], controls[lane], tick, int(saturations[lane]), None, lag)
        found.append((own, _timed(one, s[lane])))
    return found


def _timed(one: _Told, state: NDArray[np.float64]) -> LawTiming:
    last = last_state(one.law, state)
    timing = timing_of(one.law, one.machine, last)
    if isinstance(one.law, Counting):
        timing = replace(timing, counters=dict(one.law.counters(last)))
    return timing
