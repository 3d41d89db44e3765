"""Margins of a law in the loop: gain, phase, delay and disk, at each control and each sensor.

What is perturbed is the deviation of a signal from its own periodic course on the loop's orbit, as is usual for
a linear margin: the orbit stays, its stability changes. A gain of 2 at cg doubles what the law adds to or takes from
its periodic cg; a delay holds that deviation back. All margins but the disk's come from the multipliers of the
closed loop, without approximation of the periodic system by a time-invariant one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, partial
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.linearisation.lifted import lift_matrices
from gyroctl.linearisation.norms import hinf_of
from gyroctl.linearisation.periodic import multipliers_of, transition
from gyroctl.loop_margins.closed_loop_orbit import CONTROLS, LoopOrbit
from gyroctl.orbits.flow import Matrix
from gyroctl.plant.measurement import CHANNELS as SENSORS

GAIN_MAX = 100.0
"""Gains beyond this are reported as infinite: they are no longer a matter of stability but of saturation."""

DELAY_MAX = 2.0
"""Longest delay that is looked for, in wave periods."""

EVERY = (*CONTROLS, *SENSORS, "controls", "sensors")


@dataclass(frozen=True)
class OpenedLoop:
    """The loop cut at some signals: w enters where they arrive, v = C x comes out where they are made.

    The state is the plant's and the law's; v never depends on w of the same sample.

    Parameters
    ----------
    channels : tuple of str
        The signals, all controls or all sensors.
    A, B, C : (N, n, n), (N, n, c), (N, c, n) arrays
        From sample to sample of the wave period.
    """

    channels: tuple[str, ...]
    A: Matrix
    B: Matrix
    C: Matrix

    def multipliers(self, gain: complex = 1.0) -> NDArray[np.complex128]:
        """Multipliers over one wave period with w = gain v, largest first."""
        return multipliers_of(self.closed(gain))

    def closed(self, gain: complex = 1.0) -> NDArray[np.complex128] | Matrix:
        """Transition matrix over one wave period with w = gain v."""
        return transition(self.A + gain * self.B @ self.C)

    def radius(self, gain: complex = 1.0) -> float:
        """Modulus of the largest multiplier with w = gain v."""
        return float(np.abs(self.multipliers(gain)[0]))

    def gain_margin(self) -> tuple[float, float]:
        """Gains below and above 1 at which stability ends: 0 where the loop may be cut, infinite above `GAIN_MAX`."""
        low = _crossing(self.radius, np.linspace(1.0, 0.0, 41))
        return low if np.isfinite(low) else 0.0, _crossing(self.radius, np.geomspace(1.0, GAIN_MAX, 80))

    def phase_margin(self) -> float:
        """Constant phase, of either sign, at which stability ends; 180 where it does not. [deg]"""
        angle = _crossing(lambda turn: self.radius(np.exp(1j * turn)), np.linspace(0.0, np.pi, 91))
        return float(np.degrees(min(angle, np.pi)))

    def loop_gain(self, angles: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Lifted loop transfer L, (len(angles), N c, N c), at z = exp(i angle), with the sign that makes 1 + L vanish.

        Its eigenvalues over the angles are the harmonic Nyquist plot; -1 is the critical point.
        """
        a, b, c, d = lift_matrices(self.A, self.B, self.C, np.zeros((*self.C.shape[:2], self.B.shape[2])))
        unit = np.eye(a.shape[0])
        return np.array([-(c @ np.linalg.solve(np.exp(1j * w) * unit - a, b) + d) for w in angles], complex)

    def nyquist(self, points: int = 200) -> tuple[NDArray[np.float64], NDArray[np.complex128]]:
        """Angles (points,) from 0 to pi and the eigenvalues (points, N c) of `loop_gain`, largest first."""
        angles = np.linspace(0.0, np.pi, points)
        loci = np.linalg.eigvals(self.loop_gain(angles)).astype(complex)
        order = np.argsort(-np.abs(loci), axis=1)
        return angles, np.take_along_axis(loci, order, axis=1)

    def disk(self) -> float:
        """Disk margin alpha = 1/||S - 1/2|| of the lifted loop; 0 where it is unstable.

        The norm allows a different gain and phase in each sample of the period, even changing from period to period
        and between the channels, so that the guaranteed region is on the safe side for constant ones.
        """
        cut = np.eye(self.B.shape[2])[None].repeat(self.A.shape[0], 0)
        norm, _ = hinf_of(*lift_matrices(self.A + self.B @ self.C, self.B, self.C, 0.5 * cut))
        return 1.0 / norm


@dataclass(frozen=True)
class ChannelMargins:
    """Margins at one signal, or at a group of signals that are perturbed alike.

    Parameters
    ----------
    channels : tuple of str
        The signals.
    gain : (float, float)
        The loop is stable for gains between these two: 0 where it may be cut altogether, infinite above `GAIN_MAX`.
    phase : float
        Constant phase that makes it unstable, in either direction; 180 where none does. [deg]
    delay : float
        Shortest delay that makes it unstable, on a grid of half samples; a longer one may be stable again. Infinite
        where none below `DELAY_MAX` wave periods does, NaN for a group. [s]
    disk : float
        Disk margin alpha.
    guaranteed_gain : (float, float)
        Gains that the disk allows together with no phase.
    guaranteed_phase : float
        Phase that the disk allows together with no gain. [deg]
    """

    channels: tuple[str, ...]
    gain: tuple[float, float]
    phase: float
    delay: float
    disk: float
    guaranteed_gain: tuple[float, float]
    guaranteed_phase: float


@dataclass(frozen=True)
class LoopMargins:
    """Margins of a law at each control and sensor, and at all controls and all sensors together.

    Parameters
    ----------
    status : str
        That of the loop's orbit; there are margins only where it is "stable".
    advice : str
        What to do where it is not.
    channels : dict
        `ChannelMargins` by name: cc, cg, the seven sensors, "controls", "sensors".
    """

    status: str
    advice: str
    channels: dict[str, ChannelMargins]


def loop_margins(loop: LoopOrbit, channels: tuple[str, ...] = EVERY) -> LoopMargins:
    """Find all margins of a loop.

    Parameters
    ----------
    loop : LoopOrbit
        From `close_loop`.
    channels : tuple of str
        Signals, or the groups "controls" and "sensors".

    Raises
    ------
    InputError
        For an unknown channel.
    """
    looked_at = channels if loop.status == "stable" else ()
    return LoopMargins(loop.status, loop.advice, {name: channel_margins(loop, name) for name in looked_at})


def channel_margins(loop: LoopOrbit, channel: str) -> ChannelMargins:
    """Margins of a stable loop at one signal, or at the group "controls" or "sensors"."""
    names = members(channel)
    opened = open_loop(loop, names)
    delay = np.nan
    if len(names) == 1:
        after = delayed_transition(loop, channel)
        grid = np.arange(0.0, DELAY_MAX * loop.flow.samples + 0.25, 0.5) * loop.flow.period
        delay = _crossing(lambda time: float(np.abs(multipliers_of(after(time))[0])), grid)
    alpha = opened.disk()
    bounds = ((2.0 - alpha) / (2.0 + alpha), (2.0 + alpha) / (2.0 - alpha)) if alpha < 2.0 - 1e-6 else (0.0, np.inf)
    turn = float(np.degrees(2.0 * np.arctan(0.5 * alpha)))
    return ChannelMargins(names, opened.gain_margin(), opened.phase_margin(), delay, alpha, bounds, turn)


def members(channel: str) -> tuple[str, ...]:
    """Signals of a channel: itself, or all of the group "controls" or "sensors"."""
    return {"controls": CONTROLS, "sensors": SENSORS}.get(channel, (channel,))


def open_loop(loop: LoopOrbit, channels: tuple[str, ...]) -> OpenedLoop:
    """Cut the loop at some controls, or at some sensors.

    Raises
    ------
    InputError
        For an unknown signal, or controls and sensors mixed.
    """
    if not channels or not (set(channels) <= set(CONTROLS) or set(channels) <= set(SENSORS)):
        mend = f"Choose from {', '.join(CONTROLS)} or from {', '.join(SENSORS)}"
        raise InputError("channels", channels, "must be controls or sensors, not both", mend)
    a, b, c = zip(*(_open_sample(loop, channels, k) for k in range(loop.flow.samples)), strict=True)
    return OpenedLoop(channels, np.array(a), np.array(b), np.array(c))


def delayed_transition(loop: LoopOrbit, channel: str) -> Callable[[float], Matrix]:
    """Transition matrix over one wave period as a function of a delay [s] of one signal's deviation.

    Its state is the plant's, the law's, and the delayed values on their way, the latest first.

    A delay of a control moves the instant at which the held value changes; a delay of a sensor lets the law see the
    deviation of an earlier instant, between samples too. Both are exact.
    """
    split = lru_cache(maxsize=64)(partial(_split, loop, channel))

    def over_a_period(delay: float) -> Matrix:
        whole, fraction = in_samples(delay, loop.flow.period)
        a, new, old, out, through = split(fraction)
        # the line holds v of the samples before, the latest first; w is its entry `whole` (new) or the next (old)
        n, line = a.shape[1], whole + 1
        product = np.eye(n + line)
        for k in range(a.shape[0]):
            step = np.zeros((n + line, n + line))
            step[:n, :n] = a[k]
            for place, entry in ((whole, new[k]), (whole + 1, old[k])):
                if place == 0:  # v of this very sample
                    step[:n, :n] += np.outer(entry, out[k])
                else:
                    step[:n, n + place - 1] += entry
            step[n, :n] = out[k]
            step[n, n + whole] += through[k]  # only a sensor between samples: what the law did meanwhile
            step[n + 1 :, n:-1] = np.eye(line - 1)
            product = step @ product
        return product

    return over_a_period


def in_samples(delay: float, period: float) -> tuple[int, float]:
    """Whole samples in a delay, and the fraction of one that is left."""
    whole = int(np.floor(delay / period + 1e-9))
    return whole, max(round(delay / period - whole, 12), 0.0)


def _open_sample(loop: LoopOrbit, channels: tuple[str, ...], k: int) -> tuple[Matrix, Matrix, Matrix]:
    """A, B, C of the opened loop over sample k."""
    n, ns = loop.A.shape[1], loop.by_state.shape[2]
    sensing, by_y, by_s = loop.sensing, loop.by_measurement[k], loop.by_state[k]
    at_sensor = channels[0] in SENSORS
    cut = [(SENSORS if at_sensor else CONTROLS).index(name) for name in channels]
    kept = sensing.copy()
    if at_sensor:
        kept[cut] = 0.0
    law = np.hstack([by_y @ kept, by_s])
    applied = law[:2].copy()
    if at_sensor:
        into, out = by_y[:, cut], np.hstack([sensing[cut], np.zeros((len(cut), ns))])
    else:
        into, out = np.zeros((2 + ns, len(cut))), law[cut]
        into[cut, range(len(cut))] = 1.0
        applied[cut] = 0.0
    a = np.vstack([np.hstack([loop.A[k], np.zeros((n, ns))]) + loop.B[k] @ applied, law[2:]])
    return a, np.vstack([loop.B[k] @ into[:2], into[2:]]), out


def _split(loop: LoopOrbit, channel: str, fraction: float) -> tuple[Matrix, Matrix, Matrix, Matrix, Matrix]:
    """Matrices of `delayed_transition` for a delay by a fraction of a sample.

    Returns A (N, n, n), entries (N, n) of the newer and of the older value of w, output row (N, n) and what it takes
    (N,) from w itself.
    """
    n, ns = loop.A.shape[1], loop.by_state.shape[2]
    samples = []
    for k in range(loop.flow.samples):
        opened, entry, row = _open_sample(loop, (channel,), k)
        x, (cc, cg) = loop.states[k], loop.controls[k]
        first, second, taken = entry[:, 0], np.zeros(n + ns), 0.0
        row = row[0]
        if fraction > 0.0 and channel in CONTROLS:
            middle = loop.flow.advance(x, cc, cg, k, 0.0, fraction)
            ahead, late = loop.flow.jacobian(middle, cc, cg, k, fraction, 1.0)
            _, early = loop.flow.jacobian(x, cc, cg, k, 0.0, fraction)
            i = CONTROLS.index(channel)
            first, second = np.zeros(n + ns), np.zeros(n + ns)
            first[:n], second[:n] = late[:, i], ahead @ early[:, i]
        elif fraction > 0.0:
            # the value at (1 - fraction) of this sample: made now, from the state and what the law does now
            part, held = loop.flow.jacobian(x, cc, cg, k, 0.0, 1.0 - fraction)
            i = SENSORS.index(channel)
            kept = loop.sensing.copy()
            kept[i] = 0.0
            command = np.hstack([loop.by_measurement[k, :2] @ kept, loop.by_state[k, :2]])
            row = loop.sensing[i] @ (np.hstack([part, np.zeros((n, ns))]) + held[:, :2] @ command)
            taken = float(loop.sensing[i] @ held[:, :2] @ loop.by_measurement[k, :2, i])
            first, second = second, first  # it can be used one sample later only
        samples.append((opened, first, second, row, taken))
    a, new, old, out, through = (np.array(each) for each in zip(*samples, strict=True))
    return a, new, old, out, through


def _crossing(radius: Callable[[float], float], grid: NDArray[np.float64]) -> float:
    """Nearest point to the first of a grid where `radius` passes 1; infinite where it does not."""
    from scipy.optimize import brentq

    for one, two in pairwise(grid):
        if radius(float(two)) >= 1.0:
            return float(brentq(lambda value: radius(value) - 1.0, one, two, xtol=1e-10, rtol=1e-10))
    return np.inf
