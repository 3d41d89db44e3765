"""Replay of controls by the plant itself, in the closed loop of every run: friction, held pressure, lag and all."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.harness.loop import Kernel, closed_loop
from gyroctl.harness.run import beginning
from gyroctl.plant.kernel import rows
from gyroctl.plant.measurement import CHANNELS
from gyroctl.simulation.metrics import Record
from gyroctl.studies.bound.cut import Cut

Control = Callable[[int, NDArray[np.float64], float], tuple[float, float]]
"""What to ask for, (cc, cg) [Nms], in a control interval: its number, the state (rows,) and the coupling that acts."""


def replay(cut: Cut, control: Control, intervals: int) -> Record:
    """Run controls that may look at the true state through a window.

    Parameters
    ----------
    cut : Cut
        The window.
    control : callable
        See `Control`.
    intervals : int
        Control intervals, from the start of the window.

    Returns
    -------
    Record
        As `run_law` gives it: a law's own commands give its own run.
    """
    plant, waves, actuators = cut.plant, cut.waves, cut.settings.actuators
    states = np.zeros((intervals + 1, rows(plant.coefficients)))
    states[0, : cut.start.size] = cut.start
    commands, controls, moved = np.zeros((intervals, 2)), np.zeros((intervals, 2)), actuators.room(intervals)
    held, saturations = np.array(beginning(plant, waves, cut.settings)[1]), np.zeros(1, np.int64)
    signals = np.ascontiguousarray(waves.signals(plant).T).ravel()
    kernel = Kernel(
        plant.coefficients, signals, waves.dt, cut.settings.dt, waves.held(plant), plant.parameters.time_scale
    )

    def entry(t: float, y: Any, p: Any, s: Any, u: Any) -> None:
        i = round(t / actuators.period)
        u[0], u[1] = control(i, states[i], float(held[0]))

    nothing, sensors, limits = np.zeros(1), cut.settings.sensors.arrays(intervals, waves.seed), actuators.arrays()
    room = moved, held, saturations, np.zeros(len(CHANNELS))
    failed = closed_loop(
        entry, nothing, nothing, 1, kernel, sensors, limits, actuators.period, states, commands, controls, *room
    )
    if failed >= 0:
        states[failed + 1 :] = np.nan
    return Record(states, commands, controls, actuators.period, int(saturations[0]), moved, float(actuators.cc_lag))
