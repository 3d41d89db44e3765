"""The closed loop of many realisations: the plant advances in lanes, each law measures, steps and actuates by itself.

The same texts as in `gyroctl.harness.loop`, in the same order for each lane, so that a run gives the bits that it gives
alone. Controls are held between the samples. No lane waits for another one: each is at a time of its own, and one whose
coupling has just changed falls behind by its shorter steps, without making the others pay.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.harness import loop
from gyroctl.harness.actuation import ActuatorArrays, actuate
from gyroctl.harness.loop import SWITCHED
from gyroctl.harness.sensing import SensorArrays, measure
from gyroctl.plant import lane_steps, pack_step
from gyroctl.plant.compiled import entry_point, inlined, lent, put, source_stamp
from gyroctl.plant.equations import Coefficients
from gyroctl.plant.kernel import slip_rate, steps_for
from gyroctl.plant.lane_steps import lane_state, moments_at, set_out, step_lanes
from gyroctl.plant.packs import LANES


class LaneKernel(NamedTuple):
    """What the loop needs to advance the plant in LANES lanes."""

    k: Coefficients
    waves: NDArray[np.float64]  # (LANES, 2 n), of each run sample by sample [Nm]
    waves_dt: float  # [s]
    dt: NDArray[np.float64]  # (runs,) longest step [s]
    pace: float = 1.0  # unit of time of the device over that of Table 1 [-]


class LaneRuns(NamedTuple):
    """Up to LANES runs, one row for each; all arrays are the caller's."""

    p: NDArray[np.float64]  # (runs, ...) parameters of the laws
    s: NDArray[np.float64]  # (runs, ...) their states
    every: NDArray[np.int64]  # (runs,) samples between the calls of each law
    record: NDArray[np.float64]  # (runs, n + 1, rows), its first samples hold the starts
    commands: NDArray[np.float64]  # (runs, n, 2), filled [Nms]
    controls: NDArray[np.float64]  # (runs, n, 2), filled [Nms]
    held: NDArray[np.float64]  # (runs, 2) controls before the first sample, those of the end afterwards [Nms]
    saturations: NDArray[np.int64]  # (runs,) counts commands beyond the limits
    seen: NDArray[np.float64]  # (runs, 7) measurements of the last sample of each law
    failed: NDArray[np.int64]  # (runs,) the sample at which a law failed and its lane rests, or -1
    room: NDArray[np.float64]  # working space, `lane_steps.lane_room`
    own: NDArray[np.float64]  # working space, (2, LANES, 2)


@inlined
def sensors_of(sensors: SensorArrays, run: int) -> SensorArrays:
    """Sensors of one run, of those that are stacked."""
    return SensorArrays(sensors.error[run], sensors.fate[run], sensors.quantum[run], sensors.delay[run])


@inlined
def actuators_of(actuators: ActuatorArrays, run: int) -> ActuatorArrays:
    """Actuators of one run, of those that are stacked."""
    return ActuatorArrays(
        actuators.limit[run],
        actuators.quantum[run],
        actuators.rate[run],
        actuators.lag[run],
        actuators.delay[run],
        actuators.floor[run],
        actuators.gain[run],
    )


def _lane_loop(stamp: str) -> Callable[..., None]:
    def lane_loop(
        entry: Any, runs: LaneRuns, kernel: LaneKernel, sensors: SensorArrays, actuators: ActuatorArrays, tick: float
    ) -> None:
        """Run the loops; everything of a run as in `loop.closed_loop`.

        Parameters
        ----------
        entry, tick
            As there.
        runs : LaneRuns
            The runs, with their working space: what is lent here is not counted, and an array that was made in this
            function would be given back while it is used.
        kernel : LaneKernel
            The plant.
        sensors : SensorArrays
            Stacked: error and fate (runs, n, 7), quantum and delay (runs, 7).
        actuators : ActuatorArrays
            Stacked: each (runs, 2), delay (runs,).
        """
        assert stamp
        advance_all(entry, lent_runs(runs), lent_kernel(kernel), lent_sensors(sensors), lent_actuators(actuators), tick)

    return lane_loop


@inlined
def advance_all(
    entry: Any, runs: LaneRuns, kernel: LaneKernel, sensors: SensorArrays, actuators: ActuatorArrays, tick: float
) -> None:
    """Run the loops, all arrays lent."""
    p, s, every, record, commands, controls, held, saturations, seen, failed, room, own = runs
    rows, samples, k = record.shape[2], commands.shape[1], kernel.k
    lanes, u, aim = lane_state(room, rows), own[0], own[1]
    going = record.shape[0]
    steps, sample = np.full(LANES, math.inf), np.full(LANES, -1)  # lanes without a run rest
    for i in range(lanes.y.size):
        lanes.y[i] = 0.0
    for l in range(going):
        failed[l], steps[l] = -1, 0.0
        put(held[l], aim[l])
        for row in range(rows):
            lanes.y[row * LANES + l] = record[l, 0, row]
    while True:
        anew = False
        for l in range(LANES):
            if lanes.step[l] < steps[l]:
                continue
            sample[l] += 1
            now = sample[l]
            if now > 0:
                for row in range(rows):
                    record[l, now, row] = lanes.y[row * LANES + l]
            begin = now * tick
            if now < samples:
                measure(sensors_of(sensors, l), now, record[l], seen[l])
                if now % every[l] == 0:
                    entry(begin, seen[l], p[l], s[l], u[l])
                    if not (math.isfinite(u[l, 0]) and math.isfinite(u[l, 1])):
                        failed[l] = now
            if now == samples or failed[l] >= 0:  # the lane rests from here on
                going -= 1
                steps[l] = math.inf
                set_out(lanes, l, 0.0, 0.0)
                continue
            commands[l, now, 0], commands[l, now, 1] = u[l, 0], u[l, 1]
            saturations[l] += actuate(actuators_of(actuators, l), now, commands[l], aim[l])
            finer = SWITCHED if now > 0 and aim[l, 0] != held[l, 0] else 1.0
            put(aim[l], held[l])
            put(aim[l], controls[l, now])
            lanes.cc[l], lanes.cg[l] = held[l, 0], held[l, 1]
            steps[l] = steps_for(tick, kernel.dt[l], finer * kernel.pace * slip_rate(k, held[l, 0]))
            set_out(lanes, l, begin, tick / steps[l])
            anew = True
        if going == 0:
            return
        if anew:  # those of the lanes that are within an interval are found again as they are
            moments_at(lanes, kernel.waves, kernel.waves_dt, 0)
        step_lanes(lanes, k, kernel.waves, kernel.waves_dt)


@inlined
def lent_runs(a: LaneRuns) -> LaneRuns:
    """See `lent`."""
    laws = lent(a.p), lent(a.s), lent(a.every)
    kept = lent(a.record), lent(a.commands), lent(a.controls), lent(a.held), lent(a.saturations)
    return LaneRuns(*laws, *kept, lent(a.seen), lent(a.failed), lent(a.room), lent(a.own))


@inlined
def lent_kernel(a: LaneKernel) -> LaneKernel:
    """See `lent`."""
    return LaneKernel(a.k, lent(a.waves), a.waves_dt, lent(a.dt), a.pace)


@inlined
def lent_sensors(a: SensorArrays) -> SensorArrays:
    """See `lent`."""
    return SensorArrays(lent(a.error), lent(a.fate), lent(a.quantum), lent(a.delay))


@inlined
def lent_actuators(a: ActuatorArrays) -> ActuatorArrays:
    """See `lent`."""
    return ActuatorArrays(
        lent(a.limit), lent(a.quantum), lent(a.rate), lent(a.lag), lent(a.delay), lent(a.floor), lent(a.gain)
    )


PARTS = (*loop.PARTS, pack_step.__file__, lane_steps.__file__, __file__)
"""All that is compiled into the loop."""

compiled_lane_loop = entry_point(_lane_loop(source_stamp(PARTS)))
"""The loop, compiled; its laws are, too."""
