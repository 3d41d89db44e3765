"""A margin put to the test: the gain or the delay in the nonlinear loop, and whether a small disturbance grows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.loop_margins.closed_loop_orbit import CONTROLS, LoopOrbit
from gyroctl.loop_margins.margins import delayed_transition, in_samples, members, open_loop
from gyroctl.nested import leaves
from gyroctl.orbits.flow import Vector
from gyroctl.plant.equations import PSI
from gyroctl.plant.measurement import CHANNELS as SENSORS
from gyroctl.plant.measurement import Measurement, read

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
    # a disturbance may first rise a hundredfold before its modes are seen: then all that was simulated tells of them
    last = int(alive[-1]) if alive.size > 1 else deviation.size - 1
    part = np.arange(last // 2, last + 1)
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
    flow, samples, scale = loop.flow, loop.flow.samples, _scale(loop)
    whole, fraction = in_samples(delay, flow.period)
    usual = np.array([read(x) for x in loop.states[:-1]])
    between = np.array([read(x) for x in _middles(loop, 1.0 - fraction)])
    offset = _offset(loop, fraction)
    places = [(CONTROLS if names[0] in CONTROLS else SENSORS).index(name) for name in names]
    place, at_sensor = places[0], names[0] in SENSORS

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
        if at_sensor and delay == 0.0:
            y[places] = regular[places] + gain * (y - regular)[places]
        elif at_sensor:
            if fraction == 0.0:
                line = _pushed(line, (y - regular)[place])
            y[place] = regular[place] + line[whole]
        command, state = loop.law.step(i * flow.period, Measurement(*y.tolist()), state)
        u, usual_u = np.array(command, float), loop.controls[k]
        if not at_sensor and delay == 0.0:
            u[places] = usual_u[places] + gain * (u - usual_u)[places]
        if at_sensor and fraction > 0.0:
            middle = flow.advance(x, u[0], u[1], k, 0.0, 1.0 - fraction)
            line = _pushed(line, np.array(read(middle))[place] - between[k, place] - (turn if place == 0 else 0.0))
        if at_sensor or delay == 0.0:
            x = flow.advance(x, u[0], u[1], k)
        else:
            line = _pushed(line, (u - usual_u)[place])
            for value, begin, end in ((line[whole + 1], 0.0, fraction), (line[whole], fraction, 1.0)):
                u[place] = usual_u[place] + value
                x = flow.advance(x, u[0], u[1], k, begin, end)
            x = x - offset[k]
        if k == samples - 1:
            there = loop.states[0].copy()
            there[PSI] += turn + 2.0 * np.pi * loop.sense
            course.append(_deviation(loop, x - there, state, line, delay))
            if not np.linalg.norm(course[-1][: flow.free.size] / scale) < 1e3 * size:
                break
    return np.array(course)


def _deviation(loop: LoopOrbit, gap: Vector, state: Any, line: Vector, delay: float) -> Vector:
    """Deviation of plant, law and the values on their way, in the order of the linear model."""
    law = np.array(leaves(state), float) - np.array(leaves(loop.law_states[0]), float)
    return np.concatenate([gap[loop.flow.free], law, line[:-1] if delay != 0.0 else line[:0]])


def _pushed(line: Vector, value: float) -> Vector:
    return np.array([value, *line[:-1]])


def _middles(loop: LoopOrbit, fraction: float) -> list[Vector]:
    """States on the orbit at a fraction of each sample."""
    course = enumerate(zip(loop.states[:-1], loop.controls, strict=True))
    return [loop.flow.advance(x, u[0], u[1], k, 0.0, fraction) for k, (x, u) in course]


def _offset(loop: LoopOrbit, fraction: float) -> NDArray[np.float64]:
    """What dividing each sample in two changes on the orbit, some 1e-9: the divided loop is to keep the orbit."""
    course = enumerate(zip(_middles(loop, fraction), loop.controls, strict=True))
    divided = [loop.flow.advance(x, u[0], u[1], k, fraction, 1.0) for k, (x, u) in course]
    return np.array(divided) - loop.states[1:]
