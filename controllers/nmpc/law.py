"""Nonlinear model predictive control of the coupling, with a slow power command for the generator.

At each sample: estimate the state, look ahead at the moments, set the power, shift the last plan by one interval,
improve it by a few iterations and apply its first coupling (real-time iterations: Diehl, Bock, Schloeder, SIAM J.
Control Optim. 43 (2005) 1714-1736). Where a plan fails or comes too late, the rest of the last good plan is followed
for a second, and after that a fallback law, until a plan succeeds again.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.controllers.nmpc.foresight import Foresight, Waves, copied
from gyroctl.controllers.nmpc.planner import FRESH, planner_of
from gyroctl.controllers.nmpc.power_command import PowerCommand
from gyroctl.controllers.nmpc.prediction import STEPS, constants, orders_of
from gyroctl.controllers.nmpc.problem import Weights, weights
from gyroctl.devices import zhang2017
from gyroctl.errors import InputError
from gyroctl.plant import Plant
from gyroctl.plant.equations import OMEGA, OMEGA_RATE, PSI
from gyroctl.waves.estimation import EstimatorState, MomentEstimator, PredictorState, update

PATIENCE = 10
"""Samples for which the rest of a good plan is followed when no new one comes."""


REACH = Weights._fields.index("reach")

PAST = 60
"""Samples of the past that count for the reserve of lock: with the horizon about the ten seconds that judge a loss."""


class Fallback(NamedTuple):
    """A cautious constant pair: what remains when planning fails."""

    cc: float = 0.052  # [Nms]
    cg: float = 2e-4  # [Nms]

    def init(self) -> tuple[()]:
        """No state."""
        return ()

    def step(self, t: float, y: Any, state: tuple[()]) -> tuple[tuple[float, float], tuple[()]]:
        """Return the two constants."""
        return (self.cc, self.cg), state


class NmpcState(NamedTuple):
    """What the law carries from sample to sample; replaced at each, never changed."""

    plan: NDArray[np.float64]  # (n,) couplings from the last sample on [Nms]
    memory: float  # of the solver, see `planner.FRESH`
    power: float  # last power command [W]
    mean: float  # its slow mean [W]
    cc: float  # last command [Nms]
    cg: float  # [Nms]
    angles: NDArray[np.float64]  # (PAST,) of the ring at the last samples, oldest first [rad]
    estimate: EstimatorState
    forecast: PredictorState
    sample: int  # number of the next sample
    age: int  # samples since the last good plan
    fallback: Any  # state of the fallback law
    counts: Counts


class Counts(NamedTuple):
    """What went otherwise than planned, in samples."""

    late: int = 0  # plans beyond the deadline
    failed: int = 0  # plans that are not numbers
    kept: int = 0  # the last good plan was followed on
    fallbacks: int = 0  # the fallback law acted


class Plan(NamedTuple):
    """Answer of the planner, with its status."""

    cc: NDArray[np.float64]  # (n,) [Nms]
    memory: float
    status: Literal["good", "late", "failed"]


@dataclass(frozen=True)
class Nmpc:
    """Nonlinear MPC of the coupling.

    Parameters
    ----------
    information : {"oracle", "forecast", "sensors"}
        Where the moments ahead come from: the realisation itself; a probe that tells them `lead` ahead, and a
        prediction from there; or the sensors alone. The state comes from the sensors in all three.
    horizon : float
        How far a plan looks. [s]
    solver : {"riccati", "osqp", "descent"}
        Real-time iterations with a quadratic program by Riccati recursions, or by OSQP, the baseline; or projected
        gradients.
    iterations : int
        Of the solver, per plan.
    replan : int
        Samples from one plan to the next; the last one is followed in between.
    every, retries : int
        Every so many plans another one is begun elsewhere and gets so many iterations; none with 0.
    lead : float
        How far ahead the probe sees, for "forecast". [s]
    noise : float
        Error of the probe, as a part of the moments' standard deviation. [-]
    flywheel : float
        Flywheel speed wanted, the same in every sea: one that follows the ring would follow it into a stall. [rad/s]
    proportional, integral : float
        Of the power command: part of the mean power by part of the wanted speed [-], and of its change [1/s].
    settling : float
        For so long the mean power is learnt more quickly. [s]
    low, guard : float
        Part of the wanted speed below which the power falls more steeply, and that slope, see `PowerCommand`. [-]
    power : float
        Mean power at the start. [W]
    motion, limit1, limit3 : float
        Weight [J/(rad^2 s)] and limits [rad] of the motion.
    lock, floor : float
        Weight [J s/rad^2] and least ring speed [rad/s].
    turns, reserve : float
        Weight of missing turns [J/rad^2], and the mean ring speed that past and horizon together are to keep [rad/s].
    travel : float
        Weight of the coupling's changes. [J/(Nms)^2]
    terminal : float
        Share of the float's mechanical energy that counts at the end of the horizon. [-]
    cc_max, cg_max : float
        Limits of the plan. [Nms]
    deadline : float
        Time that a sample may take; a plan that comes later is not used. Infinite by default: a simulation is to be
        repeatable, whatever else the machine does. [s]
    period : float
        Control interval. [s]
    plant : Plant
        The design model.
    fallback : law
        Acts where planning fails: any object with `init` and `step`.
    seen : realisation, optional
        Waves that the law may look into; given by `informed`.
    clock : callable
        Time. [s]

    Raises
    ------
    InputError
        For a horizon, number or level out of range.
    """

    information: Literal["oracle", "forecast", "sensors"] = "sensors"
    horizon: float = 4.0
    solver: Literal["riccati", "osqp", "descent"] = "riccati"
    iterations: int = 1
    replan: int = 1
    every: int = 3
    retries: int = 10
    lead: float = 0.0
    noise: float = 0.0
    flywheel: float = 71.65
    proportional: float = 2.31
    integral: float = 0.006346
    settling: float = 1000.0
    low: float = 0.907
    guard: float = 9.204
    power: float = 14.0
    motion: float = 4000.0
    limit1: float = 0.2479
    limit3: float = 0.25
    lock: float = 50.0
    floor: float = 1.57
    turns: float = 28.69
    reserve: float = 2.2
    travel: float = 0.0
    terminal: float = 0.6733
    cc_max: float = 0.3
    cg_max: float = 0.02
    deadline: float = math.inf
    period: float = 0.1
    plant: Plant = field(default_factory=zhang2017, repr=False)
    fallback: Any = field(default_factory=Fallback)
    seen: Waves | None = field(default=None, repr=False)
    clock: Callable[[], float] = field(default=time.perf_counter, repr=False)

    def __post_init__(self) -> None:
        """Refuse what no plan can be made with."""
        if self.information not in ("oracle", "forecast", "sensors"):
            raise InputError(
                "nmpc.information", self.information, "unknown level", "Choose oracle, forecast or sensors"
            )
        if self.solver not in FRESH:
            raise InputError("nmpc.solver", self.solver, "unknown solver", f"Choose one of {', '.join(FRESH)}")
        for name in (
            "horizon",
            "iterations",
            "replan",
            "every",
            "period",
            "cc_max",
            "cg_max",
            "deadline",
            "flywheel",
            "power",
        ):
            value = getattr(self, name)
            finite = math.isfinite(value) or name == "deadline"
            if not (isinstance(value, int | float) and finite and value > 0.0):
                raise InputError(f"nmpc.{name}", value, "must be positive", "Leave it out for the default")
        for name in (
            "proportional",
            "integral",
            "settling",
            "low",
            "guard",
            "retries",
            "lead",
            "noise",
            "motion",
            "limit1",
            "limit3",
            "lock",
            "floor",
            "turns",
            "reserve",
            "travel",
            "terminal",
        ):
            value = getattr(self, name)
            if not (isinstance(value, int | float) and math.isfinite(value) and value >= 0.0):
                raise InputError(f"nmpc.{name}", value, "must not be negative", "Leave it out for the default")
        if not math.isclose(self.intervals * self.period, self.horizon, rel_tol=1e-9):
            raise InputError(
                "nmpc.horizon",
                self.horizon,
                f"is no multiple of the period of {self.period:g} s",
                f"Give for example {max(self.intervals, 1) * self.period:g} s",
            )

    def __getstate__(self) -> dict[str, Any]:
        """Fields alone: compiled tools are found again by whoever receives the law."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    @property
    def intervals(self) -> int:
        """Control intervals of the horizon."""
        return round(self.horizon / self.period)

    def informed(self, waves: Waves) -> Nmpc:
        """Return the law with the realisation that it may look into."""
        knowing = replace(self, seen=waves)
        knowing._foresight  # noqa: B018 - refuses waves that are too short, before the run
        return knowing

    def counters(self, state: NmpcState) -> dict[str, int]:
        """Counts of a run from its last state."""
        c = state.counts
        return {"deadline_misses": c.late, "fallbacks": c.fallbacks, "failed_plans": c.failed, "kept_plans": c.kept}

    def init(self) -> NmpcState:
        """Before the first sample."""
        pair = (0.052, 3.5e-4)
        return NmpcState(
            np.full(self.intervals, pair[0]),
            FRESH[self.solver],
            self.power,
            self.power,
            *pair,
            np.zeros(0),
            self._estimator.init(),
            self._foresight.init(),
            0,
            0,
            self.fallback.init(),
            Counts(),
        )

    def step(self, t: float, y: Any, state: NmpcState) -> tuple[tuple[float, float], NmpcState]:
        """Estimate, look ahead, command the power, plan, act."""
        begin = self.clock()
        state = self._observed(y, state._replace(sample=state.sample + 1))
        moments, forecast = self._foresight.foresee(t, state.estimate, state.forecast)
        state = self._powered(state._replace(forecast=forecast))
        shifted = np.append(state.plan[1:], state.plan[-1])
        if state.sample % self.replan == 0:
            plan = self._planned(moments, shifted, state, begin)
        else:
            plan = Plan(shifted, state.memory, "good")
        return self._acted(t, y, plan, state)

    def _observed(self, y: Any, state: NmpcState) -> NmpcState:
        """Estimate the state."""
        estimate = copied(state.estimate)
        update(self._estimator, estimate, np.array(y), state.cc, state.cg)
        if not np.isfinite(estimate.x_hat).all():
            estimate = self._estimator.init()
            update(self._estimator, estimate, np.array(y), state.cc, state.cg)
        now = estimate.x_hat[PSI]
        steady = now + self.reserve * self.period * np.arange(1 - PAST, 1)  # before the first sample
        angles = np.append(state.angles[1:], now) if state.angles.size else steady
        return state._replace(estimate=estimate, angles=angles)

    def _powered(self, state: NmpcState) -> NmpcState:
        """Set the power by the flywheel's speed."""
        speed = state.estimate.x_hat[OMEGA_RATE]
        regulator = PowerCommand(
            self.flywheel, self.proportional, self.integral, self.settling, self.low, self.guard, self.cg_max
        )
        power, mean = regulator.step(speed, state.mean, self.period, state.sample * self.period)
        return state._replace(power=power, mean=mean)

    def _planned(self, moments: NDArray[np.float64], cc: NDArray[np.float64], state: NmpcState, begin: float) -> Plan:
        """Improve the plan `cc` (n,), which is the last one, shifted by an interval."""
        planner, k, h, cost, rows = self._tools
        now = np.array([state.power, state.cc, self.cc_max, self.period])
        start = state.estimate.x_hat[rows]
        cost = cost.copy()
        cost[REACH] = state.angles[0] + self.reserve * ((PAST - 1) * self.period + self.horizon)
        other, more = self._elsewhere(state.sample, cc)
        after, memory = planner(start, moments, now, cost, h, k, cc, state.memory, self.iterations, other, more)
        if not math.isfinite(after):
            return Plan(cc, FRESH[self.solver], "failed")
        return Plan(cc, memory, "late" if self.clock() - begin > self.deadline else "good")

    def _elsewhere(self, sample: int, cc: NDArray[np.float64]) -> tuple[NDArray[np.float64], int]:
        """Another plan to begin from, and the iterations that it gets at this sample."""
        turn, rest = divmod(sample // self.replan, self.every)
        if rest != 0 or self.retries == 0:
            return cc, 0
        kind = turn % 4
        if kind < 2:
            return np.full(cc.size, (0.0, 0.5 * self.cc_max)[kind]), self.retries
        moved = (kind == 2) * 3 or -3  # the same switching, a little later or sooner
        return np.roll(cc, moved), self.retries

    def _acted(self, t: float, y: Any, plan: Plan, state: NmpcState) -> tuple[tuple[float, float], NmpcState]:
        """Apply the plan, or what stands in for it."""
        speed, counts = state.estimate.x_hat[OMEGA_RATE], state.counts
        cg = min(state.power / max(speed * speed, 1.0), self.cg_max)
        if plan.status == "good":
            command = (float(plan.cc[0]), float(cg))
            return command, state._replace(plan=plan.cc, memory=plan.memory, cc=command[0], cg=command[1], age=0)
        counts = counts._replace(
            late=counts.late + (plan.status == "late"), failed=counts.failed + (plan.status == "failed")
        )
        if state.age < PATIENCE:
            rest = np.append(state.plan[1:], state.plan[-1])
            command, fallback = (float(rest[0]), float(cg)), state.fallback
            counts = counts._replace(kept=counts.kept + 1)
        else:
            rest = np.full(self.intervals, state.cc)
            command, fallback = self.fallback.step(t, y, state.fallback)
            counts = counts._replace(fallbacks=counts.fallbacks + 1)
        state = state._replace(
            plan=rest,
            memory=FRESH[self.solver],
            cc=command[0],
            cg=command[1],
            age=state.age + 1,
            fallback=fallback,
            counts=counts,
        )
        return command, state

    @cached_property
    def _tools(self) -> tuple[Any, ...]:
        """Compiled planner, constants, step and cost of the model; rows of the plant's state that it has."""
        orders = orders_of(self.plant)
        cost = weights(
            self.plant, self.motion, self.limit1, self.limit3, self.lock, self.floor, self.travel, self.terminal
        )._replace(turns=self.turns)
        rows = np.array([row for row in range(len(self.plant.labels)) if row != OMEGA])
        h = np.array([self.period / STEPS])
        return planner_of(orders, self.solver), constants(self.plant), h, np.array(cost), rows

    @cached_property
    def _estimator(self) -> MomentEstimator:
        return MomentEstimator.design(self.plant, period=self.period)

    @cached_property
    def _foresight(self) -> Foresight:
        lead = {"sensors": None, "forecast": self.lead, "oracle": math.inf}[self.information]
        return Foresight.design(self.plant, self._estimator, self.horizon, lead, self.noise, self.seen)
