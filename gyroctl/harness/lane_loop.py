"""The closed loop of many realisations: the plant advances in lanes, each law measures, steps and actuates by itself.

The same texts as in `gyroctl.harness.loop`, in the same order for each lane, so that a run gives the bits that it gives
alone. Controls are held between the samples. Where a coupling has just changed its lane needs shorter steps than the
others: it takes them alone, and the others do not pay.
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
from gyroctl.plant.beyond import signal_room
from gyroctl.plant.compiled import aligned, entry_point, put, source_stamp
from gyroctl.plant.equations import Coefficients
from gyroctl.plant.kernel import LANES, advance, hold_into, slip_rate, steps_for
from gyroctl.plant.lagrange import TAPS

NEVER = np.iinfo(np.int64).max
"""Steps of an interval that no run goes through."""


class LaneKernel(NamedTuple):
    """What the loop needs to advance the plant in LANES lanes."""

    k: Coefficients
    waves: NDArray[np.float64]  # flat, the lanes side by side, see `gyroctl.plant.instants.interpolate` [Nm]
    alone: NDArray[np.float64]  # (LANES, 2 n) those of each lane by itself [Nm]
    waves_dt: float  # [s]
    dt: float  # longest step [s]


class LaneSensors(NamedTuple):
    """Errors of LANES realisations, see `SensorArrays`: error and missing (LANES, n, 7), quantum and delay (7,)."""

    error: NDArray[np.float64]
    missing: NDArray[np.bool_]
    quantum: NDArray[np.float64]
    delay: NDArray[np.int64]


def _lane_loop(stamp: str) -> Callable[..., None]:
    def lane_loop(
        entry: Any,
        p: Any,
        s: Any,
        every: int,
        kernel: LaneKernel,
        sensors: LaneSensors,
        actuators: ActuatorArrays,
        tick: float,
        record: Any,
        commands: Any,
        controls: Any,
        held: Any,
        saturations: Any,
        seen: Any,
        failed: Any,
    ) -> None:
        """Run the loops of LANES runs; everything of a run as in `loop.closed_loop`, one row for each lane.

        Parameters
        ----------
        entry, every, tick
            As there.
        p, s : (LANES, ...) arrays
            Parameters and states of the laws.
        record : (LANES, n + 1, rows) array
            Its first samples hold the starts.
        commands, controls : (LANES, n, 2) arrays
            Filled. [Nms]
        held : (LANES, 2) array
            Controls before the first sample, those of the end afterwards. [Nms]
        saturations : (LANES,) array
            Counts commands beyond the limits.
        seen : (LANES, 7) array
            Measurements of the last sample of each law.
        failed : (LANES,) array
            Filled with the sample at which each law failed, or -1: its lane goes on with the controls it had.
        """
        assert stamp
        rows, L, k = record.shape[2], LANES, kernel.k
        size = rows * L
        y, x, slope = aligned(size), aligned(size), aligned(4 * size).reshape(4, size)
        moments, weight = aligned(signal_room(k.beyond, L)), np.empty(TAPS)
        own, work, few = np.empty((L, rows)), np.empty((5, rows)), np.empty(signal_room(k.beyond, 1))
        cc, cg, steps, u, now = np.zeros(L), np.zeros(L), np.zeros(L, np.int64), np.zeros((L, 2)), np.empty((2, 1))
        aim = held.copy()
        moving, since, no_held = None, 0.0, None
        for l in range(L):
            failed[l] = -1
            for row in range(rows):
                y[row * L + l] = record[l, 0, row]
        for sample in range(commands.shape[1]):
            begin, least = sample * tick, NEVER
            for l in range(L):
                if failed[l] >= 0:
                    continue
                errors = SensorArrays(sensors.error[l], sensors.missing[l], sensors.quantum, sensors.delay)
                measure(errors, sample, record[l], seen[l])
                if sample % every == 0:
                    entry(begin, seen[l], p[l], s[l], u[l])
                    if not (math.isfinite(u[l, 0]) and math.isfinite(u[l, 1])):
                        failed[l], steps[l] = sample, 0
                        continue
                commands[l, sample, 0], commands[l, sample, 1] = u[l, 0], u[l, 1]
                saturations[l] += actuate(actuators, sample, commands[l], aim[l])
                finer = SWITCHED if sample > 0 and aim[l, 0] != held[l, 0] else 1.0
                put(aim[l], held[l])
                put(aim[l], controls[l, sample])
                cc[l], cg[l] = held[l, 0], held[l, 1]
                steps[l] = steps_for(tick, kernel.dt, finer * slip_rate(k, cc[l]))
                least = min(least, steps[l])
            if least == NEVER:
                return
            for l in range(L):
                if steps[l] > least:
                    for row in range(rows):
                        own[l, row] = y[row * L + l]
                    now[0, 0], now[1, 0] = cc[l], cg[l]
                    alone, wide = kernel.alone[l], kernel.waves_dt
                    hold_into(own[l], work, few, weight, k, now, begin, tick, steps[l], alone, wide, no_held)
            waves, wide, more = kernel.waves, kernel.waves_dt, k.beyond
            advance(
                y, x, slope, moments, weight, L, k, cc, cg, begin, tick, least, waves, wide, moving, since, None, more
            )
            for l in range(L):
                if steps[l] > least:
                    for row in range(rows):
                        y[row * L + l] = own[l, row]
                for row in range(rows):
                    record[l, sample + 1, row] = y[row * L + l]

    return lane_loop


PARTS = (*loop.PARTS, __file__)
"""All that is compiled into the loop."""

compiled_lane_loop = entry_point(_lane_loop(source_stamp(PARTS)))
"""The loop, compiled; its laws are, too."""
