"""Coupling and contact between the samples of a record, where the slip answers to a control within milliseconds.

An interval whose coupling is steady is looked at at its ends. Where the coupling jumps or moves, the slip obeys
s' = f(t) - r cc(t) s with the known rate `slip_rate`; f, what the slip would gain without the coupling, follows from
the accelerations at both ends, and so does all else that the contact carries: these are smooth.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.plant import Plant
from gyroctl.plant.beyond import coupling_torque
from gyroctl.plant.compiled import entry_point, inlined
from gyroctl.plant.contact import load_of
from gyroctl.plant.equations import OMEGA_RATE, PSI_RATE
from gyroctl.plant.kernel import slip_rate
from gyroctl.plant.rates import rates
from gyroctl.simulation.metrics import Record

Floats = NDArray[np.float64]

STEADY = np.array([0.0, 0.5, 1.0])
"""Parts of an interval without transient that are looked at apart."""

TRANSIENT = np.concatenate([[0.0], 1.5 ** np.arange(-12.0, 1.0)])
"""Parts of an interval with a transient, the first of less than a hundredth."""

FINE = np.union1d(TRANSIENT, np.linspace(0.0, 1.0, 51))
"""Parts of an interval in which little presses the axis on its track, so that the traction changes fast."""

WEAK = 0.3
"""What is little, as a part of the root mean square. [-]"""


@dataclass(frozen=True)
class Look:
    """What coupling and contact went through in the intervals of a record.

    Parameters
    ----------
    traction : (m,) array
        Coefficients of friction that rolling needs. [-]
    weight : (m,) array
        Time for which each of them holds. [s]
    interval : (m,) array of int
        Interval that it belongs to.
    M3 : (n, 2) array
        Moment that presses the spin axis on its track, at both ends of each interval. [Nm]
    torque, slip, loss : float
        Largest torque [Nm], slip [rad/s] and loss [W] of the coupling.
    """

    traction: Floats
    weight: Floats
    interval: NDArray[np.int64]
    M3: Floats
    torque: float
    slip: float
    loss: float

    def quantile(self, part: float) -> float:
        """Traction that is enough for this part of the time. [-]"""
        order, reached = self._reached
        return float(self.traction[order[min(np.searchsorted(reached, part * reached[-1]), order.size - 1)]])

    @cached_property
    def _reached(self) -> tuple[NDArray[np.int64], Floats]:
        """Order of the tractions, and the time up to each of them. [s]"""
        order = np.argsort(self.traction)
        return order, np.cumsum(self.weight[order])

    def over(self, limit: float) -> Floats:
        """Part of each interval, (n,), in which a traction above `limit` is needed."""
        held = np.where(self.traction > limit, self.weight, 0.0)
        total = np.bincount(self.interval, self.weight, self.M3.shape[0])
        return np.asarray(np.bincount(self.interval, held, self.M3.shape[0]) / total)


class _Ends(NamedTuple):
    """Values at both ends of intervals, each (2, n); with a third row, how far the middle lies below their mean."""

    cc: Floats  # coupling [Nms]
    slip: Floats  # [rad/s]
    free: Floats  # gain of the slip without the coupling [rad/s^2]
    carried: Floats  # torque of the contact without the coupling [Nm]
    M3: Floats  # [Nm]

    def of(self, chosen: NDArray[np.bool_]) -> _Ends:
        """The same of some intervals."""
        return _Ends(*(values[:, chosen] for values in self))


def look(plant: Plant, record: Record, first: int, signals: Floats) -> Look:
    """Look at a record again, from sample `first` on, with the signals of the waves there, (channels, samples)."""
    k, states = plant.coefficients, record.states[first:, : len(plant.labels)]
    x = np.concatenate([states[:-1], states[1:]]).T
    u = np.concatenate([record.controls[first:], record.ends[first:]]).T
    dx = rates(plant, x, u, np.concatenate([signals[:, :-1], signals[:, 1:]], axis=1))
    load = load_of(k, x, dx, u)
    axis, rate = (x[-1], dx[-1]) if plant.slips else (k.N * x[PSI_RATE], k.N * dx[PSI_RATE])
    law = _Coupling(k.beyond, float(slip_rate(k, 1.0)), 1.0 - 2.0 * k.J3 * k.N * (k.N * k.Gpp - k.Gpo))
    if plant.slips:  # the grip of the axis settles as fast as the slip: both are taken as they are at the ends
        law = law._replace(rate=0.0, left=0.0)
    slip, gain = x[OMEGA_RATE] - axis, dx[OMEGA_RATE] - rate
    torque = law.torque(u[0], slip)
    values = u[0], slip, gain + law.rate * torque, load.torque + law.left * torque, load.M3
    ends = _Ends(*(value.reshape(2, -1) for value in values))
    if plant.slips:
        ends = ends._replace(free=np.repeat(np.diff(ends.slip, axis=0) / record.period, 2, axis=0))
    ends = ends._replace(**{name: _bent(getattr(ends, name)) for name in ("free", "carried", "M3")})
    before = np.concatenate([record.ends[first - 1 : first, 0] if first else [np.nan], ends.cc[1, :-1]])
    jumps = (ends.cc[0] != before) | (ends.cc[1] != ends.cc[0])
    largest, parted = np.zeros(3), []
    weak = np.min(np.abs(ends.M3[:2]), axis=0) < WEAK * np.sqrt(np.mean(ends.M3[:2] ** 2))
    weak |= ends.M3[0] * ends.M3[1] <= 0.0
    for chosen, parts in ((~jumps & ~weak, STEADY), (jumps & ~weak, TRANSIENT), (weak, FINE)):
        which = np.flatnonzero(chosen)
        at = _within(k.N, law, ends.of(chosen), parts * record.period, record.lag)
        largest = np.maximum(largest, at.largest)
        span = np.repeat(np.diff(parts) * record.period, which.size)
        parted.append((at.traction.ravel(), span, np.tile(which, parts.size - 1)))
    traction, weight, interval = (np.concatenate(values) for values in zip(*parted, strict=True))
    return Look(traction, weight, interval, ends.M3[:2].T, *map(float, largest))


class _Coupling(NamedTuple):
    """Torque of the coupling, and what it does."""

    beyond: Any  # terms of the plant
    rate: float  # gain of the slip for each Nm [rad/s^2]
    left: float  # part of the torque that the contact carries; the rest turns the axis itself

    def torque(self, cc: Floats, slip: Floats) -> Floats:
        """Torque at a slip [rad/s]. [Nm]"""
        return np.asarray(coupling_torque(self.beyond, cc, slip))


class _Within(NamedTuple):
    """What happens within intervals."""

    traction: Floats  # mean of each part, (parts, n) [-]
    largest: Floats  # torque [Nm], slip [rad/s], loss [W]


def _within(N: float, law: _Coupling, ends: _Ends, edges: Floats, lag: float) -> _Within:
    """Follow the slip through intervals from edge to edge [s] of their parts."""
    hold, middle = edges[-1], 0.5 * (edges[:-1] + edges[1:])
    spans, ways = np.diff(edges), np.stack([_way(middle, hold, lag), _way(edges[1:], hold, lag)])
    traction, largest = np.zeros((spans.size, ends.slip.shape[1])), np.zeros(3)
    course = Course(*(np.ascontiguousarray(v) for v in (ends.cc, ends.slip[0], ends.free, ends.carried, ends.M3)))
    followed(law.beyond, law.rate, law.left, N, course, spans, middle / hold, ways, traction, largest)
    return _Within(traction, largest)


@inlined
def _held_rate(beyond: Any, rate: float, cc: float, slip: float) -> Any:
    """Rate at which a slip decays. [1/s]"""
    return rate * (coupling_torque(beyond, cc, slip) / slip if abs(slip) > 1e-9 else cc)


@inlined
def _noted(torque: float, slip: float, largest: Floats) -> None:
    """Keep the largest size of torque, slip and loss."""
    largest[0] = max(largest[0], abs(torque))
    largest[1] = max(largest[1], abs(slip))
    largest[2] = max(largest[2], abs(torque * slip))


class Course(NamedTuple):
    """What intervals begin with, and what is smooth in them: as in `_Ends`, in the order of memory."""

    cc: Floats  # (2, n) coupling at both ends [Nms]
    slip: Floats  # (n,) at the first end [rad/s]
    free: Floats  # (3, n) [rad/s^2]
    carried: Floats  # (3, n) [Nm]
    M3: Floats  # (3, n) [Nm]


@inlined
def _bowed(ends: Floats, i: int, part: float) -> Any:
    """Value of an interval at a part of the way from its first end to the second, (3, n) with the bend."""
    return ends[0, i] + part * (ends[1, i] - ends[0, i]) - 4.0 * part * (1.0 - part) * ends[2, i]


@entry_point
def followed(
    beyond: Any,
    rate: float,
    left: float,
    N: float,
    course: Course,
    spans: Floats,
    parts: Floats,
    ways: Floats,
    traction: Floats,
    largest: Floats,
) -> None:
    """Follow the slip through each interval, part by part.

    Parameters
    ----------
    beyond : NamedTuple or None
        Terms of the plant, for the torque of the coupling.
    rate, left, N : float
        As in `_Coupling`, and the gear ratio.
    course : Course
        Of n intervals.
    spans, parts : (m,) arrays
        Length of each part of an interval [s], and where its middle lies, as a part of the whole. [-]
    ways : (2, m) array
        How far the coupling has come in the middle of each part and at its end. [-]
    traction : (m, n) array
        Filled: mean friction that rolling needs in each part. [-]
    largest : (3,) array
        Torque, slip and loss; raised where they are larger here. [Nm, rad/s, W]
    """
    cc = course.cc
    for i in range(course.slip.shape[0]):
        slip, moved = course.slip[i], cc[1, i] - cc[0, i]
        _noted(coupling_torque(beyond, cc[0, i], slip), slip, largest)
        for j in range(spans.shape[0]):
            gain = _bowed(course.free, i, parts[j])
            decay = _held_rate(beyond, rate, cc[0, i] + ways[0, j] * moved, slip)
            settling = max(decay, 1e-9)
            change = -gain * math.expm1(-settling * spans[j]) / settling + slip * math.expm1(-decay * spans[j])
            # the mean torque, from the balance of the slip
            torque = (gain - change / spans[j]) / rate if rate > 0.0 else 0.0
            needed = N * abs(_bowed(course.carried, i, parts[j]) - left * torque)
            pressed = abs(_bowed(course.M3, i, parts[j]))
            traction[j, i] = 0.0 if needed == 0.0 else needed / pressed
            slip += change
            _noted(coupling_torque(beyond, cc[0, i] + ways[1, j] * moved, slip), slip, largest)


def _bent(ends: Floats) -> Floats:
    """Append the bend of a smooth quantity to its ends (2, n): an eighth of the mean second difference around."""
    course = np.append(ends[0], ends[1, -1])
    second = np.zeros(course.size)
    second[1:-1] = np.diff(course, 2)
    return np.concatenate([ends, 0.0625 * (second[:-1] + second[1:])[None, :]])


def _way(t: Floats, hold: float, lag: float) -> Floats:
    """Part of the way from one coupling to the next after `t` [s] of `hold`: an exponential, or a ramp. [-]"""
    return np.asarray(np.expm1(-t / lag) / np.expm1(-hold / lag) if lag > 0.0 else t / hold)
