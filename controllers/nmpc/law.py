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
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.controllers.nmpc.descent import descend
from gyroctl.controllers.nmpc.power_command import PowerCommand
from gyroctl.controllers.nmpc.prediction import STEPS, constants, orders_of, pullback_of, step_of
from gyroctl.controllers.nmpc.preview import Preview, Waves, between, preview
from gyroctl.controllers.nmpc.problem import Problem, Weights, weights
from gyroctl.devices import zhang2017
from gyroctl.errors import InputError
from gyroctl.plant import Plant
from gyroctl.waves.estimation import EstimatorState, MomentEstimator, Predictor, PredictorState, observe, predict, update

NO_OMEGA = np.array([0, 1, 2, 4, 5, 6, 7])
"""Rows of the plant's state that the prediction model has, before the radiation states."""
BEYOND = 10
"""Samples for which the rest of a good plan is followed when no new one comes."""


class Fallback(NamedTuple):
    """A cautious constant pair: what remains when planning fails. It keeps lock in most seas."""

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

    plan: NDArray[np.float64]  # (n,) couplings from this sample on [Nms]
    length: float  # step length of the solver, see `descend`
    mean: float  # integral part of the power [W]
    speed: float  # slow ring speed: the frequency of the waves [rad/s]
    cc: float  # last command [Nms]
    cg: float  # [Nms]
    estimate: EstimatorState
    forecast: PredictorState
    age: int  # samples since the last good plan
    fallback: Any  # state of the fallback law
    fallbacks: int  # samples at which the fallback law acted
    misses: int  # plans that came too late
    failures: int  # plans that failed
    samples: int


@dataclass(frozen=True)
class Nmpc:
    """Nonlinear MPC of the coupling.

    Parameters
    ----------
    information : {"oracle", "forecast", "sensors"}
        Where the moments ahead come from: the realisation itself, a probe `lead` up-wave and a prediction from there,
        or the sensors alone.
    horizon : float
        How far a plan looks. [s]
    iterations : int
        Of the solver, per sample.
    speed_ratio : float
        Flywheel speed wanted, as a part of N times the frequency of the waves. [-]
    proportional, integral : float
        Of the power command. [W/(rad/s)], [W/rad]
    power : float
        Its integral part at the start. [W]
    motion, limit1, limit3 : float
        Weight [J/(rad^2 s)] and limits [rad] of the motion.
    lock, floor : float
        Weight [J s/rad^2] and least ring speed, as a part of the frequency of the waves [-].
    travel : float
        Weight of the coupling's changes. [J/(Nms)^2]
    terminal : float
        Share of the float's mechanical energy that counts at the end of the horizon. [-]
    cc_max, cg_max : float
        Limits of the actuators. [Nms]
    wp : float
        Frequency of the waves to begin with. [rad/s]
    deadline : float
        Processor time that a plan may take; one that takes longer is not used. [s]
    period : float
        Control interval. [s]
    plant : Plant
        The design model.
    fallback : law
        Acts where planning fails: any object with `init` and `step`.

    Raises
    ------
    InputError
        For a horizon, number or level out of range.
    """

    information: Literal["oracle", "forecast", "sensors"] = "sensors"
    horizon: float = 4.0
    iterations: int = 10
    speed_ratio: float = 0.8
    proportional: float = 0.3
    integral: float = 5e-4
    power: float = 8.0
    motion: float = 2000.0
    limit1: float = 0.25
    limit3: float = 0.25
    lock: float = 50.0
    floor: float = 0.5
    travel: float = 0.0
    terminal: float = 0.3
    cc_max: float = 0.12
    cg_max: float = 0.02
    wp: float = 3.14
    deadline: float = 0.1
    period: float = 0.1
    plant: Plant = field(default_factory=zhang2017, repr=False)
    fallback: Any = Fallback()
    seen: Preview | None = field(default=None, repr=False)
    clock: Callable[[], float] = field(default=time.thread_time, repr=False)

    @cached_property
    def intervals(self) -> int:
        """Control intervals of the horizon."""
        return round(self.horizon / self.period)

    @cached_property
    def _tools(self) -> tuple[Any, Any, NDArray[np.float64], NDArray[np.float64], Weights, NDArray[np.intp]]:
        orders = orders_of(self.plant)
        cost = weights(self.plant, self.motion, self.limit1, self.limit3, self.lock, self.floor * self.wp, self.travel,
                       self.terminal)  # fmt: skip
        rows = np.concatenate([NO_OMEGA, np.arange(8, 8 + orders[1] + orders[3])])
        h = np.array([self.period / STEPS])
        return step_of(orders), pullback_of(orders), constants(self.plant), h, cost, rows

    @cached_property
    def _estimator(self) -> MomentEstimator:
        return MomentEstimator.design(self.plant, period=self.period)

    @cached_property
    def _predictor(self) -> Predictor:
        return Predictor.design(self.plant, self.period, horizon=self.horizon, estimator=self._estimator)

    def _ahead(self, t: float, estimate: EstimatorState, forecast: PredictorState) -> NDArray[np.float64]:
        """Moments at each step of the model over the horizon, flat."""
        if self.information == "oracle":
            return self.seen.window(t, STEPS * self.intervals + 1)
        observe(self._predictor, forecast, estimate.me_hat[0], estimate.me_hat[1])
        out = np.empty((2, self.intervals))
        predict(self._predictor, forecast, out)
        return between(np.vstack([forecast.now, out.T])).ravel()

    def informed(self, waves: Waves) -> Nmpc:
        """Return the law with the realisation that it may look into."""
        return replace(self, seen=preview(waves, self.period / STEPS))

    def init(self) -> NmpcState:
        """Before the first sample."""
        return NmpcState(
            np.full(self.intervals, 0.05), 1e-3, self.power, self.wp, 0.052, 3.5e-4, self._estimator.init(), self._predictor.init(), 0,
            self.fallback.init(), 0, 0, 0, 0,
        )  # fmt: skip

    def step(self, t: float, y: Any, state: NmpcState) -> tuple[tuple[float, float], NmpcState]:
        """Estimate, look ahead, command the power, plan, act."""
        begin = self.clock()
        step, pullback, k, h, cost, rows = self._tools
        estimate = EstimatorState(*(a.copy() for a in state.estimate))
        forecast = PredictorState(*(a.copy() for a in state.forecast))
        update(self._estimator, estimate, np.array(y), state.cc, state.cg)
        speed = state.speed + (self.period / 60.0) * (y.psi_rate - state.speed)
        flywheel = estimate.x_hat[7]
        regulator = PowerCommand(self.proportional, self.integral, self.cg_max)
        error = flywheel - self.speed_ratio * self.plant.parameters.N * self.wp
        power, mean = regulator.step(error, flywheel, state.mean, self.period)

        plan = np.append(state.plan[1:], state.plan[-1])
        problem = Problem(
            estimate.x_hat[rows], self._ahead(t, estimate, forecast), power, state.cc, self.cc_max,
            self.period, h, k, cost,
        )  # fmt: skip
        _, after, length, _ = descend(step, pullback, problem, plan, state.length, self.iterations)
        failed, late = not math.isfinite(after), self.clock() - begin > self.deadline
        state = state._replace(
            plan=plan, length=length, mean=mean, speed=speed, cc=plan[0], cg=power / max(flywheel * flywheel, 1.0),
            estimate=estimate, forecast=forecast, samples=state.samples + 1,
        )
        return (state.cc, state.cg), state
