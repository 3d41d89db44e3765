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


class LaneSensors(NamedTuple):
    """Errors of the runs, see `SensorArrays`: error and missing (runs, n, 7), quantum and delay (runs, 7)."""

    error: NDArray[np.float64]
    missing: NDArray[np.bool_]
    quantum: NDArray[np.float64]
    delay: NDArray[np.int64]


class LaneActuators(NamedTuple):
    """Actuators of the runs, see `ActuatorArrays`: each (runs, 2), delay (runs,)."""

    limit: NDArray[np.float64]
    quantum: NDArray[np.float64]
    rate: NDArray[np.float64]
    lag: NDArray[np.float64]
    delay: NDArray[np.int64]
    floor: NDArray[np.float64]
    gain: NDArray[np.float64]


@inlined
def sensors_of(sensors: LaneSensors, run: int) -> SensorArrays:
    """Those of one run."""
    return SensorArrays(sensors.error[run], sensors.missing[run], sensors.quantum[run], sensors.delay[run])


@inlined
def actuators_of(actuators: LaneActuators, run: int) -> ActuatorArrays:
    """Those of one run."""
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
        entry: Any,
        p: Any,
        s: Any,
        every: Any,
        kernel: LaneKernel,
        sensors: LaneSensors,
        actuators: LaneActuators,
        tick: float,
        record: Any,
        commands: Any,
        controls: Any,
        held: Any,
        saturations: Any,
        seen: Any,
        failed: Any,
        room: Any,
        own: Any,
    ) -> None:
        """Run the loops of up to LANES runs; everything of a run as in `loop.closed_loop`, one row for each.

        Parameters
        ----------
        entry, tick
            As there.
        p, s : (runs, ...) arrays
            Parameters and states of the laws.
        every : (runs,) array
            Samples between the calls of each law.
        record : (runs, n + 1, rows) array
            Its first samples hold the starts.
        commands, controls : (runs, n, 2) arrays
            Filled. [Nms]
        held : (runs, 2) array
            Controls before the first sample, those of the end afterwards. [Nms]
        saturations : (runs,) array
            Counts commands beyond the limits.
        seen : (runs, 7) array
            Measurements of the last sample of each law.
        failed : (runs,) array
            Filled with the sample at which each law failed, or -1: its lane rests from there on.
        room, own : arrays
            Working space: `lane_steps.lane_room`, and (2, LANES, 2) zeros. They come from the caller, who holds them:
            what is lent here is not counted, and room of this function's own would be given back at once.
        """
        assert stamp
        advance_all(
            entry,
            lent(p),
            lent(s),
            lent(every),
            LaneKernel(kernel.k, lent(kernel.waves), kernel.waves_dt, lent(kernel.dt)),
            LaneSensors(lent(sensors.error), lent(sensors.missing), lent(sensors.quantum), lent(sensors.delay)),
            lent_actuators(actuators),
            tick,
            lent(record),
            lent(commands),
            lent(controls),
            lent(held),
            lent(saturations),
            lent(seen),
            lent(failed),
            lent(room),
            lent(own),
        )

    return lane_loop


@inlined
def advance_all(
    entry: Any,
    p: Any,
    s: Any,
    every: Any,
    kernel: LaneKernel,
    sensors: LaneSensors,
    actuators: LaneActuators,
    tick: float,
    record: Any,
    commands: Any,
    controls: Any,
    held: Any,
    saturations: Any,
    seen: Any,
    failed: Any,
    room: Any,
    own: Any,
) -> None:
    """Run the loops: arrays as above, lent, with room for the lanes and `own` (2, LANES, 2) for the controls."""
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
            steps[l] = steps_for(tick, kernel.dt[l], finer * slip_rate(k, held[l, 0]))
            set_out(lanes, l, begin, tick / steps[l])
            anew = True
        if going == 0:
            return
        if anew:  # those of the lanes that are within an interval are found again as they are
            moments_at(lanes, kernel.waves, kernel.waves_dt, 0)
        step_lanes(lanes, k, kernel.waves, kernel.waves_dt)


@inlined
def lent_actuators(a: LaneActuators) -> LaneActuators:
    """See `lent`."""
    return LaneActuators(
        lent(a.limit), lent(a.quantum), lent(a.rate), lent(a.lag), lent(a.delay), lent(a.floor), lent(a.gain)
    )


PARTS = (*loop.PARTS, pack_step.__file__, lane_steps.__file__, __file__)
"""All that is compiled into the loop."""

compiled_lane_loop = entry_point(_lane_loop(source_stamp(PARTS)))
"""The loop, compiled; its laws are, too."""
