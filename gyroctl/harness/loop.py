"""The closed loop: measure -> law.step -> actuate -> advance. One text, run as Python or compiled, bit for bit alike.

A law enters as a function of flat arrays, see `gyroctl.harness.law_entry`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.harness import actuation, sensing
from gyroctl.harness.actuation import ActuatorArrays, actuate
from gyroctl.harness.sensing import SensorArrays, measure
from gyroctl.plant import measurement
from gyroctl.plant.beyond import signal_room
from gyroctl.plant.compiled import entry_point, put, source_stamp
from gyroctl.plant.course import Course, control_at, set_out
from gyroctl.plant.equations import Coefficients
from gyroctl.plant.kernel import SOURCES, hold_into, move_into, slip_rate, steps_for

SWITCHED = 5.0
"""How much finer the slip is resolved after its coupling has changed: its transient carries energy, and with the step
of a steady coupling the ledger would be off by 3e-4 under random switching (4e-7 with this)."""


class Kernel(NamedTuple):
    """What the loop needs to advance the plant: constants, signals of the waves on their grid, longest step."""

    k: Coefficients
    waves: NDArray[np.float64]  # flat, sample by sample [Nm]
    waves_dt: float  # [s]
    dt: float  # [s]
    held: Any = None  # moments that are held from outside, see `gyroctl.plant.held`
    pace: float = 1.0  # unit of time of the device over that of Table 1 [-]


def _closed_loop(stamp: str) -> Callable[..., int]:
    def closed_loop(
        entry: Any,
        p: Any,
        s: Any,
        every: int,
        kernel: Kernel,
        sensors: SensorArrays,
        actuators: ActuatorArrays,
        tick: float,
        record: Any,
        commands: Any,
        controls: Any,
        moved: Any,
        held: Any,
        saturations: Any,
        y: Any,
    ) -> int:
        """Run the loop over all rows of `commands`.

        Parameters
        ----------
        entry, p, s, every
            The law: entry function, parameters, state, samples between its calls.
        tick : float
            Period of the loop. [s]
        record : (n + 1, rows) array
            Row 0 holds the start; filled with state and ledger at each sample.
        commands, controls : (n, 2) arrays
            Filled with what the law asked for and with what the actuators gave from the sample on. [Nms]
        moved : (n, 3) array, or None
            Where controls move between the samples: filled with cc, cg at the end of each interval and with the root
            of the mean square of cg over it. [Nms] None where they jump at the samples and are held: the compiled loop
            is then another one, without what moves them.
        held : (2,) array
            Controls before the first sample, those of the end afterwards. [Nms]
        saturations : (1,) array
            Counts commands beyond the limits.
        y : (7,) array
            Working space: the measurements of the last sample.

        Returns
        -------
        int
            The sample at which the law failed, or -1.
        """
        assert stamp
        u = np.zeros(2)
        state = record[0].copy()
        work = np.empty((5, state.size))
        moments, weight = np.empty(signal_room(kernel.k.beyond, 1)), np.empty(8)
        now, aim = np.empty((2, 1)), held.copy()
        course = Course(np.empty(2), np.empty(2), np.empty(2), np.empty(2), np.empty(2), np.empty(2))
        for sample in range(commands.shape[0]):
            measure(sensors, sample, record, y)
            if sample % every == 0:
                entry(sample * tick, y, p, s, u)
                if not (math.isfinite(u[0]) and math.isfinite(u[1])):
                    return sample
            commands[sample, 0], commands[sample, 1] = u[0], u[1]
            saturations[0] += actuate(actuators, sample, commands, aim)
            finer = SWITCHED if sample > 0 and aim[0] != held[0] else 1.0
            begin = sample * tick
            if moved is not None:
                set_out(course, actuators.lag, actuators.rate, held, aim)
                controls[sample, 0], controls[sample, 1] = control_at(course, 0, 0.0), control_at(course, 1, 0.0)
                move_into(
                    state,
                    work,
                    moments,
                    weight,
                    kernel.k,
                    now,
                    course,
                    begin,
                    tick,
                    kernel.dt,
                    finer,
                    kernel.pace,
                    kernel.waves,
                    kernel.waves_dt,
                    moved[sample],
                    kernel.held,
                )
                held[0], held[1] = moved[sample, 0], moved[sample, 1]
            else:
                put(aim, held)
                put(aim, controls[sample])
                now[0, 0], now[1, 0] = held[0], held[1]
                steps = steps_for(tick, kernel.dt, finer * kernel.pace * slip_rate(kernel.k, held[0]))
                hold_into(
                    state,
                    work,
                    moments,
                    weight,
                    kernel.k,
                    now,
                    begin,
                    tick,
                    steps,
                    kernel.waves,
                    kernel.waves_dt,
                    kernel.held,
                )
            put(state, record[sample + 1])
        return -1

    return closed_loop


PARTS = (*SOURCES, measurement.__file__, sensing.__file__, actuation.__file__, __file__)
"""All that is compiled into the loop."""

closed_loop = _closed_loop(source_stamp(PARTS))
"""The loop as plain Python."""

compiled_loop = entry_point(closed_loop)
"""The same text, compiled."""


def _calls(entry: Any, p: Any, s: Any, y: Any, u: Any, calls: int) -> None:
    for _ in range(calls):
        entry(0.0, y, p, s, u)


compiled_calls = entry_point(_calls)
"""Call a compiled law over and over, to time it."""
