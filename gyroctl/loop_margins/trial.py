"""A margin put to the test: the gain or the delay in the nonlinear loop, and whether a small disturbance grows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.loop_margins.closed_loop_orbit import CONTROLS, SENSORS, LoopOrbit, read
from gyroctl.loop_margins.margins import delayed_transition, in_samples, members, open_loop
from gyroctl.plant.equations import PSI

PERIODS = (80, 800)
"""Fewest and most wave periods of a trial."""


@dataclass(frozen=True)
class LoopTrial:
    """What the nonlinear loop did with a gain or a delay in one signal.

    Parameters
    ----------
    growth : float
        Factor per wave period by which the critical mode grew in the nonlinear loop over the second half. [-]
    predicted : float
        Modulus of the largest multiplier of the linear model. [-]
    deviation : (periods + 1,) array
        Size of the deviation at each wave period, in units of the motion on the orbit.
    """

    growth: float
    predicted: float
    deviation: NDArray[np.float64]

    @property
    def stable(self) -> bool:
        """Whether the disturbance died away: neither its critical mode nor anything else grew."""
        return self.growth < 1.0 and bool(self.deviation[-1] < 10.0 * np.max(self.deviation[:20]))


def try_loop(
    loop: LoopOrbit, channel: str, gain: float = 1.0, delay: float = 0.0, size: float = 1e-7, seed: int = 0
) -> LoopTrial:
    """Simulate the nonlinear loop with a gain or a delay on the deviation of one signal from its periodic course.

    Parameters
    ----------
    loop : LoopOrbit
        The loop about its orbit.
    channel : str
        A control, a sensor, or for a gain also the group "controls" or "sensors".
    gain : float
        Factor on the deviation.
    delay : float
        Age of the deviation when it arrives. [s]
    size : float
        Size of the first disturbance, in units of the motion on the orbit.
    seed : int
        Of its direction.

    Raises
    ------
    InputError
        Where there is no orbit, for an unknown channel, or for gain and delay at once.
    """
    if loop.status not in ("stable", "unstable"):
        raise InputError("loop", loop.status, "there is no orbit to disturb", loop.advice)
    if delay != 0.0 and (gain != 1.0 or len(members(channel)) > 1):
        raise InputError("delay", delay, "one signal with either a gain or a delay", "Try them one after the other")
    opened = open_loop(loop, members(channel))
    linear = opened.closed(gain) if delay == 0.0 else delayed_transition(loop, channel)(delay)
    values, vectors = np.linalg.eig(linear.T)
    worst = int(np.argmax(np.abs(values)))
    predicted = float(np.abs(values[worst]))
    periods = int(np.clip(3.0 / max(abs(np.log(predicted)), 1e-9), *PERIODS))
    course = _simulate(loop, members(channel), gain, delay, size, seed, periods)
    deviation = np.linalg.norm(course[:, : loop.flow.free.size] / _scale(loop), axis=1)
    # the slow modes swing over hundreds of periods: the size alone would take a swing for a growth
    amplitude = np.abs(course @ vectors[:, worst])
    alive = np.flatnonzero((deviation > 1e-3 * size) & (deviation < 1e2 * size))
    part = np.arange(alive[-1] // 2, alive[-1] + 1)
    growth = float(np.exp(np.polyfit(part, np.log(amplitude[part]), 1)[0]))
    return LoopTrial(growth, predicted, deviation)


def _scale(loop: LoopOrbit) -> NDArray[np.float64]:
    """Unit of each free row: the size of its motion on the orbit."""
    scale = np.maximum(np.std(loop.states[:-1], axis=0), 1e-3)[loop.flow.free]
    scale[list(loop.flow.free).index(PSI)] = 1.0
    return np.asarray(scale)


def _simulate(
    loop: LoopOrbit, names: tuple[str, ...], gain: float, delay: float, size: float, seed: int, periods: int
) -> NDArray[np.float64]:
    flow, samples, h = loop.flow, loop.flow.samples, loop.flow.period
    scale = _scale(loop)
    whole, fraction = in_samples(delay, h)
    usual = np.array([read(x) for x in loop.states[:-1]])
    between = _between(loop, 1.0 - fraction)
    offset = _offset(loop, fraction)
    places = [(CONTROLS if names[0] in CONTROLS else SENSORS).index(name) for name in names]
    at_sensor = names[0] in SENSORS

    rng = np.random.default_rng(seed)
    x = loop.states[0] + flow.embedding @ (size * scale * rng.standard_normal(flow.free.size))
    state = loop.law_states[0]
    line = np.zeros(whole + 2)  # deviations of the delayed signal, the latest first
    course = [_deviation(loop, x - loop.states[0], state, line, delay)]
    for i in range(periods * samples):
        k, turn = i % samples, 2.0 * np.pi * loop.sense * (i // samples)
        regular = usual[k].copy()
        regular[0] += turn
        y = np.array(read(x))
        if at_sensor:
            if delay == 0.0:
                y[places] = regular[places] + gain * (y - regular)[places]
            else:
                if fraction == 0.0:
                    line[1:] = line[:-1]
                    line[0] = (y - regular)[places[0]]
                y[places[0]] = regular[places[0]] + line[whole]
        command, state = loop.law.step(i * h, type(read(x))(*y.tolist()), state)
        u = np.array(command, float)
        if not at_sensor and delay == 0.0:
            u[places] = loop.controls[k][places] + gain * (u - loop.controls[k])[places]
        if at_sensor and fraction > 0.0:
            line[1:] = line[:-1]
            middle = flow.advance(x, float(u[0]), float(u[1]), k, 0.0, 1.0 - fraction)
            line[0] = np.array(read(middle))[places[0]] - between[k, places[0]] - (turn if places[0] == 0 else 0.0)
        if at_sensor or delay == 0.0:
            x = flow.advance(x, float(u[0]), float(u[1]), k)
        else:
            line[1:] = line[:-1]
            line[0] = (u - loop.controls[k])[places[0]]
            for value, begin, end in ((line[whole + 1], 0.0, fraction), (line[whole], fraction, 1.0)):
                u[places[0]] = loop.controls[k][places[0]] + value
                x = flow.advance(x, float(u[0]), float(u[1]), k, begin, end)
            x = x - offset[k]
        if k == samples - 1:
            there = loop.states[0].copy()
            there[PSI] += turn + 2.0 * np.pi * loop.sense
            course.append(_deviation(loop, x - there, state, line, delay))
            if not np.linalg.norm(course[-1][: flow.free.size] / scale) < 1e3 * size:
                break
    return np.array(course)


def _deviation(
    loop: LoopOrbit, gap: NDArray[np.float64], state: Any, line: NDArray[np.float64], delay: float
) -> NDArray[np.float64]:
    """Deviation of plant, law and the values on their way, in the order of the linear model."""
    law = np.array(state, float) - np.array(loop.law_states[0], float)
    return np.concatenate([gap[loop.flow.free], law, line[:-1] if delay != 0.0 else line[:0]])


def _between(loop: LoopOrbit, fraction: float) -> NDArray[np.float64]:
    """Measurements (N, 7) on the orbit at a fraction of each sample."""
    points = [
        loop.flow.advance(x, float(u[0]), float(u[1]), k, 0.0, fraction)
        for k, (x, u) in enumerate(zip(loop.states[:-1], loop.controls, strict=True))
    ]
    return np.array([read(x) for x in points])


def _offset(loop: LoopOrbit, fraction: float) -> NDArray[np.float64]:
    """What dividing each sample in two changes on the orbit, some 1e-9: the divided loop is to keep the orbit."""
    out = np.zeros((loop.flow.samples, loop.states.shape[1]))
    for k, (x, u) in enumerate(zip(loop.states[:-1], loop.controls, strict=True)):
        middle = loop.flow.advance(x, float(u[0]), float(u[1]), k, 0.0, fraction)
        out[k] = loop.flow.advance(middle, float(u[0]), float(u[1]), k, fraction, 1.0) - loop.states[k + 1]
    return out
