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
from functools import cached_property, partial
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.controllers.nmpc.foresight import Foresight, Waves, copied
from gyroctl.controllers.nmpc.planner import FRESH, compile_planner, planner_of
from gyroctl.controllers.nmpc.power_command import PowerCommand
from gyroctl.controllers.nmpc.prediction import STEPS, constants, orders_of
from gyroctl.controllers.nmpc.problem import Weights, weights
from gyroctl.controllers.nmpc.settings import SETTINGS, Aims, Effort, Information, Preview, check
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

    ``gyroctl.law("nmpc", ...)`` takes the settings within the groups by their own names, as ``limit1=0.3``.

    Raises
    ------
    InputError
        For a horizon, number or level out of range.
    """

    # where the moments ahead come from: "oracle", the realisation itself; "forecast", a probe that tells them some
    # seconds ahead, and a prediction from there; "sensors" alone. The state comes from the sensors in all three.
    information: Information = "sensors"
    horizon: float = 4.0  # how far a plan looks [s]
    period: float = 0.1  # control interval [s]
    effort: Effort = Effort()  # how a plan is made
    probe: Preview = Preview()  # what a probe tells, for "forecast"
    command: PowerCommand = PowerCommand()  # the generator's power
    aims: Aims = Aims()  # what a plan weighs
    cc_max: float = 0.3  # limits of a plan [Nms]
    cg_max: float = 0.02  # [Nms]
    # time that a sample may take; a plan that comes later is not used. Infinite by default: a simulation is to be
    # repeatable, whatever else the machine does. [s]
    deadline: float = math.inf
    plant: Plant = field(default_factory=zhang2017, repr=False)  # the design model
    fallback: Any = field(default_factory=Fallback)  # acts where planning fails: any object with `init` and `step`
    seen: Waves | None = field(default=None, repr=False)  # waves that the law may look into; given by `informed`
    clock: Callable[[], float] = field(default=time.perf_counter, repr=False)  # time [s]

    def __post_init__(self) -> None:
        """Refuse what no plan can be made with."""
        check({name: getattr(self, name) for name in SETTINGS})
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
    def preview(self) -> float:
        """How far ahead it is told the moments. [s]"""
        lead = round(self.probe.lead / self.period) * self.period
        return {"sensors": 0.0, "forecast": lead, "oracle": math.inf}[self.information]

    @property
    def intervals(self) -> int:
        """Control intervals of the horizon."""
        return round(self.horizon / self.period)

    def informed(self, waves: Waves) -> Nmpc:
        """Return the law with the realisation, or the window on it, that it may look into."""
        knowing = replace(self, seen=waves)
        knowing._foresight  # noqa: B018 - refuses waves that are too short, before the run
        return knowing

    def preparations(self) -> tuple[Callable[[], None], ...]:
        """What a new installation compiles: the planner, and its model with estimation and forecast."""
        alone = replace(self, information="sensors", seen=None)
        return partial(compile_planner, self.effort.solver), alone._compile_model

    def _compile_model(self) -> None:
        """Prediction model, estimation and forecast."""
        self._tools  # noqa: B018 - makes the functions of the model
        estimate, forecast = self._estimator.init(), self._foresight.init()
        for sample in range(PAST + 1):  # long enough to learn the sea once
            update(self._estimator, estimate, np.full(7, 0.1), 0.05, 1e-3)
            _, forecast = self._foresight.foresee(self.period * sample, estimate, forecast)

    def counters(self, state: NmpcState) -> dict[str, int]:
        """Counts of a run from its last state."""
        c = state.counts
        return {"deadline_misses": c.late, "fallbacks": c.fallbacks, "failed_plans": c.failed, "kept_plans": c.kept}

    def init(self) -> NmpcState:
        """Before the first sample."""
        pair = (0.052, 3.5e-4)
        return NmpcState(
            np.full(self.intervals, pair[0]),
            FRESH[self.effort.solver],
            self.command.power,
            self.command.power,
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
        ahead = shifted(state.plan, state.plan[-1])
        if state.sample % self.effort.replan == 0:
            plan = self._planned(moments, ahead, state, begin)
        else:
            plan = Plan(ahead, state.memory, "good")
        return self._acted(t, y, plan, state)

    def _observed(self, y: Any, state: NmpcState) -> NmpcState:
        """Estimate the state."""
        estimate = copied(state.estimate)
        update(self._estimator, estimate, np.array(y), state.cc, state.cg)
        if not np.isfinite(estimate.x_hat).all():
            estimate = self._estimator.init()
            update(self._estimator, estimate, np.array(y), state.cc, state.cg)
        now = estimate.x_hat[PSI]
        if state.angles.size:
            angles = shifted(state.angles, now)
        else:  # before the first sample
            angles = now + self.aims.reserve * self.period * np.arange(1 - PAST, 1)
        return state._replace(estimate=estimate, angles=angles)

    def _powered(self, state: NmpcState) -> NmpcState:
        """Set the power by the flywheel's speed."""
        speed, since = state.estimate.x_hat[OMEGA_RATE], state.sample * self.period
        power, mean = self.command.step(speed, state.mean, self.period, since, self.cg_max)
        return state._replace(power=power, mean=mean)

    def _planned(self, moments: NDArray[np.float64], cc: NDArray[np.float64], state: NmpcState, begin: float) -> Plan:
        """Improve the plan `cc` (n,), which is the last one, shifted by an interval."""
        planner, k, h, cost, rows = self._tools
        now = np.array([state.power, state.cc, self.cc_max, self.period])
        start = state.estimate.x_hat[rows]
        cost = cost.copy()
        cost[REACH] = state.angles[0] + self.aims.reserve * ((PAST - 1) * self.period + self.horizon)
        other, more = self._elsewhere(state.sample, cc)
        after, memory = planner(start, moments, now, cost, h, k, cc, state.memory, self.effort.iterations, other, more)
        if not math.isfinite(after):
            return Plan(cc, FRESH[self.effort.solver], "failed")
        return Plan(cc, memory, "late" if self.clock() - begin > self.deadline else "good")

    def _elsewhere(self, sample: int, cc: NDArray[np.float64]) -> tuple[NDArray[np.float64], int]:
        """Another plan to begin from, and the iterations that it gets at this sample."""
        turn, rest = divmod(sample // self.effort.replan, self.effort.every)
        if rest != 0 or self.effort.retries == 0:
            return cc, 0
        kind = turn % 4
        if kind < 2:
            return np.full(cc.size, (0.0, 0.5 * self.cc_max)[kind]), self.effort.retries
        moved = (kind == 2) * 3 or -3  # the same switching, a little later or sooner
        return np.roll(cc, moved), self.effort.retries

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
            rest = shifted(state.plan, state.plan[-1])
            command, fallback = (float(rest[0]), float(cg)), state.fallback
            counts = counts._replace(kept=counts.kept + 1)
        else:
            rest = np.full(self.intervals, state.cc)
            command, fallback = self.fallback.step(t, y, state.fallback)
            counts = counts._replace(fallbacks=counts.fallbacks + 1)
        state = state._replace(
            plan=rest,
            memory=FRESH[self.effort.solver],
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
        a = self.aims
        cost = weights(self.plant, a.motion, a.limit1, a.limit3, a.lock, a.floor, a.travel, a.terminal)
        cost = cost._replace(turns=a.turns)
        rows = np.array([row for row in range(len(self.plant.rolling.labels)) if row != OMEGA])
        h = np.array([self.period / STEPS])
        return planner_of(orders, self.effort.solver), constants(self.plant), h, np.array(cost), rows

    @cached_property
    def _estimator(self) -> MomentEstimator:
        return MomentEstimator.design(self.plant, period=self.period)

    @cached_property
    def _foresight(self) -> Foresight:
        lead = {"sensors": None, "forecast": self.probe.lead, "oracle": math.inf}[self.information]
        return Foresight.design(self.plant, self._estimator, self.horizon, lead, self.probe.noise, self.seen)


def shifted(values: NDArray[np.float64], last: float) -> NDArray[np.float64]:
    """Values one sample later (n,), in a new array; `np.append` takes five times as long."""
    later = np.empty(values.size)
    later[:-1] = values[1:]
    later[-1] = last
    return later
