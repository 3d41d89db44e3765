"""Coupling and contact between the samples of a record, where the slip answers to a control within milliseconds.

An interval whose coupling is steady is looked at at its ends. Where the coupling jumps or moves, the slip obeys
s' = f(t) - r cc(t) s with the known rate `slip_rate`; f, what the slip would gain without the coupling, follows from
the accelerations at both ends, and so does all else that the contact carries: these are smooth.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.plant import Plant
from gyroctl.plant.beyond import coupling_torque
from gyroctl.plant.contact import load_of
from gyroctl.plant.equations import OMEGA_RATE, PSI_RATE
from gyroctl.plant.kernel import slip_rate
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
        order = np.argsort(self.traction)
        reached = np.cumsum(self.weight[order])
        return float(self.traction[order[min(np.searchsorted(reached, part * reached[-1]), order.size - 1)]])

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
    dx = plant.derivative(x, u, np.concatenate([signals[:, :-1], signals[:, 1:]], axis=1))
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

    def decay(self, cc: Floats, slip: Floats) -> Floats:
        """Rate at which a slip decays. [1/s]"""
        moved = np.abs(slip) > 1e-9
        return np.asarray(self.rate * np.where(moved, self.torque(cc, slip) / np.where(moved, slip, 1.0), cc))


class _Within(NamedTuple):
    """What happens within intervals."""

    traction: Floats  # mean of each part, (parts, n) [-]
    largest: Floats  # torque [Nm], slip [rad/s], loss [W]


def _within(N: float, law: _Coupling, ends: _Ends, edges: Floats, lag: float) -> _Within:
    """Follow the slip through intervals from edge to edge [s] of their parts."""
    hold, slip = edges[-1], ends.slip[0]
    tractions, largest = [], _largest(law.torque(ends.cc[0], slip), slip)
    for begin, end in pairwise(edges):
        middle, span = 0.5 * (begin + end), end - begin
        free, decay = _between(ends.free, middle / hold), law.decay(_course(ends.cc, middle, hold, lag), slip)
        settling = np.maximum(decay, 1e-9)
        after = slip * np.exp(-decay * span) - free * np.expm1(-settling * span) / settling
        torque = (
            (free - (after - slip) / span) / law.rate if law.rate > 0.0 else 0.0
        )  # mean, from the balance of the slip
        needed = N * np.abs(_between(ends.carried, middle / hold) - law.left * torque)
        with np.errstate(divide="ignore", invalid="ignore"):
            tractions.append(np.where(needed == 0.0, 0.0, needed / np.abs(_between(ends.M3, middle / hold))))
        slip = after
        largest = np.maximum(largest, _largest(law.torque(_course(ends.cc, end, hold, lag), slip), slip))
    return _Within(np.array(tractions), largest)


def _largest(torque: Floats, slip: Floats) -> Floats:
    """Largest size of torque, slip and loss, each zero where there is no interval."""
    return np.array([float(np.max(np.abs(values), initial=0.0)) for values in (torque, slip, torque * slip)])


def _bent(ends: Floats) -> Floats:
    """Append the bend of a smooth quantity to its ends (2, n): an eighth of the mean second difference around."""
    course = np.append(ends[0], ends[1, -1])
    second = np.zeros(course.size)
    second[1:-1] = np.diff(course, 2)
    return np.concatenate([ends, 0.0625 * (second[:-1] + second[1:])[None, :]])


def _between(ends: Floats, part: float) -> Floats:
    """Value at a part of the way from the first end to the second, (2, n) or with the bend (3, n)."""
    straight = ends[0] + part * (ends[1] - ends[0])
    return np.asarray(straight - 4.0 * part * (1.0 - part) * ends[2] if ends.shape[0] > 2 else straight)


def _course(cc: Floats, t: float, hold: float, lag: float) -> Floats:
    """Coupling `t` [s] after the start of its way from one end (2, n) to the other: an exponential, or a ramp. [Nms]"""
    return _between(cc, float(np.expm1(-t / lag) / np.expm1(-hold / lag)) if lag > 0.0 else t / hold)
