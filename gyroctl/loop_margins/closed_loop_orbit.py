"""The periodic solution of plant and law together, and its linear model from sample to sample."""

from __future__ import annotations

from dataclasses import dataclass, field, is_dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.froude import growth
from gyroctl.linearisation.held_flow import HeldFlow, samples_per_wave
from gyroctl.linearisation.periodic import multipliers_of, transition
from gyroctl.loop_margins.dual_numbers import NotDifferentiable, step_jacobian
from gyroctl.nested import leaves, like
from gyroctl.orbits.flow import Forcing, Matrix, Vector
from gyroctl.orbits.nearest_orbit import find_orbit
from gyroctl.orbits.orbit import Orbit
from gyroctl.orbits.wave import RegularWave
from gyroctl.plant import Plant
from gyroctl.plant.equations import OMEGA, OMEGA_RATE, PHI1_RATE, PHI3_RATE, PSI
from gyroctl.plant.measurement import ROWS, read

CONTROLS = ("cc", "cg")
REFERENCE = ((0.052, 3.5e-4), (0.104, 1.5e-4), (0.052, 1e-4), (0.104, 3e-5))
"""Controls whose locked orbit is tried as a start of the loop, at the size of Table 1. [Nms]"""

CC_MAX, CC_LEAST = 0.3, 0.02
"""Largest coupling, and the least that steps are chosen for, at the size of Table 1. [Nms]"""

SINGULAR = 1e14
"""Condition number beyond which a map has a multiplier of 1 to rounding."""

ITERATIONS = 25
CLOSED = 1e-8
"""What is left of a fixed-point equation that is solved. [rad], [rad/s]"""

RESTLESS = (
    "The loop does not settle on one solution per wave, so that it has no multipliers: "
    "judge it by simulation, or try another wave"
)

COUNTS = (
    "The law's state does not come back to itself after a wave, as a counter or a clock in it does not, so that the "
    "loop has a multiplier of 1: keep out of the state what only counts, let what is added up leak, or let a method "
    "`uncounted` return the law without it"
)
"""Where the loop's own map has a fixed direction, which no step of Newton's method can close."""

LoopStatus = Literal["stable", "unstable", "not periodic", "not differentiable", "no orbit"]


@dataclass(frozen=True)
class LoopOrbit:
    """Periodic solution of the loop of plant and law under a regular wave, N samples per wave period.

    Parameters
    ----------
    status : str
        "stable" or "unstable"; "not periodic": the loop does not settle on one solution per wave; "not
        differentiable": it does, but the law's step cannot be differentiated; "no orbit": the wave does not lock.
    advice : str
        What to do about it.
    flow : HeldFlow
        The plant from sample to sample.
    law : object
        The law, with its period set to a whole part of the wave's where it has such a field, and without its counts
        where it has a method `uncounted`.
    states : (N + 1, rows) array
        Plant at the samples.
    law_states : tuple of N tuples
        State of the law before each sample.
    controls : (N, 2) array
        What the law commands. [Nms]
    A, B : (N, n, n), (N, n, 2) arrays
        Plant from sample to sample.
    by_measurement, by_state : (N, 2 + ns, 7), (N, 2 + ns, ns) arrays
        Derivative of the law's command and new state.
    multipliers : complex array
        Of the closed loop over one wave period, largest first.
    """

    status: LoopStatus
    advice: str
    flow: HeldFlow = field(repr=False)
    law: Any
    sense: int
    states: NDArray[np.float64] = field(repr=False)
    law_states: tuple[Any, ...] = field(repr=False)
    controls: NDArray[np.float64] = field(repr=False)
    A: NDArray[np.float64] = field(repr=False)
    B: NDArray[np.float64] = field(repr=False)
    by_measurement: NDArray[np.float64] = field(repr=False)
    by_state: NDArray[np.float64] = field(repr=False)
    multipliers: NDArray[np.complex128]

    @property
    def sensing(self) -> NDArray[np.float64]:
        """Matrix (7, n) from the plant's deviation to the measurements."""
        return self.flow.embedding[list(ROWS)]

    @property
    def power(self) -> float:
        """Mean electrical power, from the samples. [W]"""
        return float(np.mean(self.controls[:, 1] * self.states[:-1, OMEGA_RATE] ** 2))

    @property
    def mean_controls(self) -> tuple[float, float]:
        """Mean of cc and of cg over the orbit. [Nms]"""
        cc, cg = np.mean(self.controls, axis=0)
        return float(cc), float(cg)

    @property
    def load_angle(self) -> float:
        """Angle of the mean of exp(i psi)(phi1' + i phi3') over the samples, as of an `Orbit`. [rad]"""
        return float(np.angle(self._pull()))

    @property
    def lock_share(self) -> float:
        """Used share of the lock capacity, N cg/(J4 V) with the mean cg and V the modulus of that mean. [-]"""
        p = self.flow.plant.parameters
        return p.N * self.mean_controls[1] / (p.J4 * abs(self._pull()))

    @property
    def lock_reserve(self) -> float:
        """Part of the lock capacity that is not used, 1 - `lock_share`."""
        return 1.0 - self.lock_share

    @property
    def decay_time(self) -> float:
        """Time in which the slowest mode of the loop falls by e; negative where it grows. [s]"""
        return -self.flow.samples * self.flow.period / float(np.log(np.abs(self.multipliers[0])))

    def _pull(self) -> complex:
        """Mean of the co-rotating rate of the float. [rad/s]"""
        x = self.states[:-1]
        return complex(np.mean(np.exp(1j * x[:, PSI]) * (x[:, PHI1_RATE] + 1j * x[:, PHI3_RATE])))


def close_loop(
    plant: Plant, wave: RegularWave, law: Any, start: Orbit | None = None, settle: int = 150, dt: float | None = None
) -> LoopOrbit:
    """Find the periodic solution of the loop: let it settle, then Newton's method on plant and law together.

    Parameters
    ----------
    plant : Plant
        The device.
    wave : Regular
        The wave.
    law : Law
        Any object with `period`, `init()` and `step(t, y, state)`.
    start : Orbit, optional
        Where the loop begins; by default the locked orbit at one of `REFERENCE`.
    settle : int
        Wave periods of plain simulation before Newton's method.
    dt : float, optional
        Longest Runge-Kutta step; 0.01 s at the size of Table 1. [s]

    Returns
    -------
    LoopOrbit
        With a status; an unstable solution is reported as such.

    Raises
    ------
    InputError
        For a law's period that is not positive, or longer than the wave's.
    """
    period = 2.0 * np.pi / wave.wp
    if not 0.0 < law.period <= period:
        raise InputError("law.period", law.period, "must be positive and at most the wave period", "Give it in s")
    samples = samples_per_wave(period, law.period)
    law = _uncounted(_with_period(law, period / samples))
    unit = growth("Nms", plant.parameters.length_scale)
    flow = HeldFlow(plant, Forcing.of(plant, wave), samples, unit * CC_MAX, plant.step if dt is None else dt)
    begin = start if start is not None else _reference(plant, wave)
    if begin.status == "no orbit":
        return _failed("no orbit", begin.advice, flow, law, begin.sense)
    x, state, controls = settle_loop(flow, law, begin.x, law.init(), settle)
    if not np.all(np.isfinite(x)):
        return _failed("not periodic", "The loop runs away; another tuning is needed", flow, law, begin.sense)
    flow = replace(flow, cc_max=min(unit * CC_MAX, max(1.2 * float(np.max(controls[:, 0])), unit * CC_LEAST)))
    try:
        closed = _newton(flow, law, x, state, begin.sense)
    except NotDifferentiable as error:
        advice = f"Gain, phase, delay and disk margins need the law's derivative: {error}. The nonlinear ones remain"
        return _failed("not differentiable", advice, flow, law, begin.sense)
    except np.linalg.LinAlgError:
        return _failed("not periodic", COUNTS, flow, law, begin.sense)
    return _failed("not periodic", RESTLESS, flow, law, begin.sense) if closed is None else closed


def settle_loop(flow: HeldFlow, law: Any, x: Vector, state: Any, periods: int) -> tuple[Vector, Any, Matrix]:
    """Simulate the loop for whole wave periods; return plant, law's state and the controls of the last period."""
    x = x.copy()
    controls = np.zeros((flow.samples, 2))
    most = CC_MAX * growth("Nms", flow.plant.parameters.length_scale)
    for i in range(periods * flow.samples):
        command, state = law.step(i * flow.period, read(x), state)
        cc, cg = (max(float(value), 0.0) for value in command)
        controls[i % flow.samples] = cc, cg
        x = flow.advance(x, min(cc, most), cg, i)
        if not np.all(np.isfinite(x)):
            break
    x[OMEGA] = 0.0
    x[PSI] -= 2.0 * np.pi * np.round(x[PSI] / (2.0 * np.pi))
    return x, state, controls


def _newton(flow: HeldFlow, law: Any, x: NDArray[np.float64], state: Any, sense: int) -> LoopOrbit | None:
    n, ns = flow.free.size, len(leaves(state))
    for _ in range(ITERATIONS):
        states, law_states, controls, maps, closed = [x], [], [], [], []
        for k in range(flow.samples):
            values, by_y, by_s = step_jacobian(law, k * flow.period, read(states[-1]), state)
            a, b = flow.jacobian(states[-1], values[0], values[1], k)
            closed.append(_compose(a, b[:, :2], by_y, by_s, flow.embedding[list(ROWS)]))
            law_states.append(state)
            controls.append(values[:2])
            maps.append((a, b[:, :2], by_y, by_s))
            states.append(flow.advance(states[-1], values[0], values[1], k))
            state = like(law_states[0], values[2:].tolist())
        gap = states[-1] - x
        gap[PSI] -= sense * 2.0 * np.pi
        difference = np.concatenate(
            [gap[flow.free], np.array(leaves(state), float) - np.array(leaves(law_states[0]), float)]
        )
        if not np.all(np.isfinite(difference)) or np.max(np.abs(gap)) > 1e3:
            return None
        product = transition(np.array(closed))
        unclosed = np.eye(n + ns) - product
        if np.linalg.cond(unclosed) > SINGULAR and np.max(np.abs(difference[n:]), initial=0.0) > 1e-9:
            raise np.linalg.LinAlgError("a multiplier of 1")
        step = np.linalg.solve(unclosed, difference)
        if np.max(np.abs(step)) < 1e-10:
            multipliers = multipliers_of(product)
            stable = bool(np.abs(multipliers[0]) < 1.0)
            status: LoopStatus = "stable" if stable else "unstable"
            advice = "" if stable else "The loop itself is unstable: no margin"
            course = (np.array(states), tuple(law_states), np.array(controls))
            A, B, by_measurement, by_state = (np.array(each) for each in zip(*maps, strict=True))
            by_state = by_state.reshape(flow.samples, 2 + ns, ns)
            return LoopOrbit(status, advice, flow, law, sense, *course, A, B, by_measurement, by_state, multipliers)
        shrink = min(1.0, 0.3 / max(abs(float(step[list(flow.free).index(PSI)])), 1e-300))
        x = x + shrink * flow.embedding @ step[:n]
        state = like(law_states[0], (np.array(leaves(law_states[0]), float) + shrink * step[n:]).tolist())
    if np.max(np.abs(difference[:n])) < CLOSED < np.max(np.abs(difference[n:]), initial=0.0):
        raise np.linalg.LinAlgError("the plant comes back after a wave, and the law's state does not")
    return None


def _compose(a: Matrix, b: Matrix, by_y: Matrix, by_s: Matrix, sensing: Matrix) -> Matrix:
    """Closed loop over one sample, of plant and law's state."""
    measured = by_y @ sensing
    return np.block([[a + b @ measured[:2], b @ by_s[:2]], [measured[2:], by_s[2:]]])


def _with_period(law: Any, period: float) -> Any:
    """Return the law at another sampling period, where it has such a field; a change of a thousandth, usually."""
    if isinstance(law, tuple) and "period" in getattr(law, "_fields", ()):
        within = {"law": _with_period(law.law, _inner(law, period))} if "law" in law._fields else {}  # type: ignore[attr-defined]
        return law._replace(period=period, **within)  # type: ignore[attr-defined]
    if is_dataclass(law) and not isinstance(law, type) and "period" in law.__dataclass_fields__:
        return replace(law, period=period)  # type: ignore[call-arg]
    return law


def _uncounted(law: Any) -> Any:
    """Return the law without the counts in its state, where it can do without: they never come back after a wave."""
    if hasattr(law, "uncounted"):
        return law.uncounted()
    if isinstance(law, tuple) and "law" in getattr(law, "_fields", ()):
        return law._replace(law=_uncounted(law.law))  # type: ignore[attr-defined]
    return law


def _inner(law: Any, period: float) -> float:
    """Period of the law within a wrapper: the same, or in another unit of time."""
    own = getattr(law.law, "period", law.period)
    return period if own == law.period else period * (own / law.period)


def _reference(plant: Plant, wave: RegularWave) -> Orbit:
    unit = growth("Nms", plant.parameters.length_scale)
    for cc, cg in REFERENCE:
        orbit = find_orbit(plant, wave, unit * cc, unit * cg)
        if orbit.status == "stable":
            break
    return orbit


def _failed(status: LoopStatus, advice: str, flow: HeldFlow, law: Any, sense: int) -> LoopOrbit:
    none = np.zeros((0, 0, 0))
    course = (np.zeros((1, 0)), (), np.zeros((0, 2)))
    return LoopOrbit(status, advice, flow, law, sense, *course, none, none, none, none, np.zeros(0, complex))
