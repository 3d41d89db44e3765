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
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from gyroctl.controllers.nmpc.entry import Texts, entry_at, learn_of, sample_of, texts_of
from gyroctl.controllers.nmpc.flat import NotFlat, built, row_of
from gyroctl.controllers.nmpc.foresight import Foresight, Waves, between
from gyroctl.controllers.nmpc.planner import (
    ELSEWHERE,
    FRESH,
    MODEL,
    addresses_of,
    compiled_planner,
    model_of,
    planner_of,
)
from gyroctl.controllers.nmpc.power_command import PowerCommand
from gyroctl.controllers.nmpc.prediction import STEPS, constants, kind_of, width_of
from gyroctl.controllers.nmpc.problem import weights
from gyroctl.controllers.nmpc.sample import (
    FAILED,
    FAILURES,
    FALLBACKS,
    GOOD,
    KEPT,
    LATE,
    LATES,
    Constants,
    Memory,
    Numbers,
    acted,
    acted_on,
    doubted,
    fell_back,
    first_memory,
    observed,
    placed,
    posed,
    powered,
    seen_ring,
)
from gyroctl.controllers.nmpc.settings import SETTINGS, Aims, Effort, Information, Preview, check
from gyroctl.controllers.nmpc.stopwatch import BINS, clock_address, quantile
from gyroctl.devices import zhang2017
from gyroctl.errors import InputError
from gyroctl.faces.law import law_face
from gyroctl.faces.show import shown
from gyroctl.plant import Plant
from gyroctl.plant.compiled import entry_point
from gyroctl.plant.equations import OMEGA, OMEGA_RATE
from gyroctl.waves.estimation import MomentEstimator, look_to_then, predict
from gyroctl.waves.estimation.learning import learn
from gyroctl.waves.estimation.predictor import take
from gyroctl.waves.gauge import Gauge, Readings

BEFORE = (0.052, 3.5e-4)
"""Command before the first sample. [Nms]"""

LATEST = 10
"""Longest delay that is made up for: beyond a second nothing is foreseen well enough. [samples]"""

FIRST = (0.0, 3.0, 70.0, 0.0, 0.0, 0.0, 0.0)
"""Measurements to call a sample with, so that it is compiled."""


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

    row: NDArray[np.float64]  # a `Memory` as one row of numbers, see `Nmpc.memory`
    fallback: Any  # state of the fallback law


@shown(law_face)
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
    # seconds ahead, and a prediction from there; "gauge", the elevation up-wave and the sensors; "sensors" alone. The
    # state comes from the sensors in all of them.
    information: Information = "sensors"
    horizon: float = 4.0  # how far a plan looks [s]
    period: float = 0.1  # control interval [s]
    effort: Effort = Effort()  # how a plan is made
    probe: Preview = Preview()  # what a probe tells, for "forecast"
    gauge: Gauge = Gauge()  # what is read up-wave, for "gauge"
    command: PowerCommand = PowerCommand()  # the generator's power
    aims: Aims = Aims()  # what a plan weighs
    cc_max: float = 0.3  # limits of a plan [Nms]
    cg_max: float = 0.02  # [Nms]
    # time that a sample may take; a plan that comes later is not used. Infinite by default: a simulation is to be
    # repeatable, whatever else the machine does. [s]
    deadline: float = math.inf
    # samples by which a command acts later than its measurements were taken, in the sensors and the actuators together,
    # as far as that is known: estimate and plan reckon with it
    delay: int = 0
    lag: float = 0.0  # time constant with which the coupling follows its command, as far as that is known [s]
    plant: Plant = field(default_factory=zhang2017, repr=False)  # the design model
    fallback: Any = field(default_factory=Fallback)  # acts where planning fails: any object with `init` and `step`
    # waves that the law may look into, or readings of its gauge; given by `informed`
    seen: Waves | Readings | None = field(default=None, repr=False)
    clock: Callable[[], float] = field(default=time.perf_counter, repr=False)  # time [s]

    def __post_init__(self) -> None:
        """Refuse what no plan can be made with."""
        check({name: getattr(self, name) for name in SETTINGS}, self.gauge)
        if isinstance(self.delay, bool) or not isinstance(self.delay, int) or not 0 <= self.delay <= LATEST:
            mend = f"Give 0 to {LATEST}, in samples, without it none"
            raise InputError("nmpc.delay", self.delay, "is no delay that can be made up for", mend)
        if not (math.isfinite(self.lag) and 0.0 <= self.lag <= self.period):
            mend = f"Give 0 to {self.period:g} s, without it none"
            raise InputError("nmpc.lag", self.lag, "is no lag that can be made up for", mend)
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
        return {"sensors": 0.0, "gauge": 0.0, "forecast": lead, "oracle": math.inf}[self.information]

    @property
    def intervals(self) -> int:
        """Control intervals of the horizon."""
        return round(self.horizon / self.period)

    def informed(self, waves: Waves | Readings) -> Nmpc:
        """Return the law with the realisation, or the window on it, that it may look into; or with what it reads."""
        knowing = replace(self, seen=waves)
        knowing._foresight  # noqa: B018 - refuses waves that are too short, before the run
        return knowing

    def preparations(self) -> tuple[Callable[[], None], ...]:
        """What a new installation compiles, in parts that need not wait for one another."""
        solver, alone = self.effort.solver, replace(self, information="sensors", seen=None, deadline=math.inf)
        if not alone._whole:
            return (alone._compile_step,)
        kind = kind_of(self.plant)
        parts: list[tuple[Callable[[Any], Any], Any]] = [(compiled_planner, solver)]
        parts += [(part, kind) for part in MODEL[solver]]
        parts += [(learn_of, alone._texts), (sample_of, alone._texts)]
        return tuple(partial(prepare, function, given) for function, given in parts)

    def _compile_step(self) -> None:
        """Every part that a sample needs, by a sample of it."""
        self.step(0.0, FIRST, self.init())

    def memory(self, state: NmpcState) -> Memory:
        """Name what a state holds; the arrays are views of it, not to be changed."""
        return cast(Memory, built(self._first, state.row))

    def counters(self, state: NmpcState) -> dict[str, int]:
        """Counts of a run from its last state."""
        counts = self.memory(state).work.counts
        names = {"deadline_misses": LATES, "fallbacks": FALLBACKS, "failed_plans": FAILURES, "kept_plans": KEPT}
        return {name: int(counts[place]) for name, place in names.items()}

    def init(self) -> NmpcState:
        """Before the first sample."""
        return NmpcState(row_of(self._first), self.fallback.init())

    def step(self, t: float, y: Any, state: NmpcState) -> tuple[tuple[float, float], NmpcState]:
        """Estimate, look ahead, command the power, plan, act."""
        begin, row, u = self.clock(), state.row.copy(), np.empty(2)
        if self._whole:
            call(self._machine.address, t, np.array(y, np.float64), self._row, row, u)
            return (float(u[0]), float(u[1])), NmpcState(row, state.fallback)
        c, memory, fallback = self._constants, built(self._first, row), state.fallback
        law, w, estimate, forecast = c.law, memory.work, memory.estimate, memory.forecast
        observed(c.estimator, estimate, law, w, np.array(y, np.float64))
        look_to_then(c.estimator, estimate)
        speed = estimate.then[OMEGA_RATE]
        if self._foresight.probe is not None:
            self._foresight.foresee(t, self._foresight.probe, forecast, memory.ahead)
        else:
            learnt = take(c.predictor, forecast, estimate.me_hat[0], estimate.me_hat[1], placed(estimate))
            if learnt:
                learn(c.predictor.learner, forecast.memory)
            said = forecast.placed
            if memory.gauge is None:
                predict(c.predictor, forecast, memory.ahead)
            elif self._foresight.read(t, learnt, forecast, memory.gauge, memory.ahead):
                said = memory.gauge.waves
        between(forecast.now, memory.ahead, self.period, memory.moments)
        powered(law, w, speed)
        if self._foresight.probe is None:
            doubted(law, w, said.spread)
        more, status = posed(law, w, estimate.then), GOOD
        if more >= 0:
            moments = acted_on(law, memory.ahead, memory.moments)
            given = w.start, moments, w.now, w.weights, law.h, law.k, w.trial, w.rivals, w.result
            self._planner(*given, law.iterations, more, law.varied, law.newton)
            if not math.isfinite(w.result[0]):
                status = FAILED
            elif self.clock() - begin > self.deadline:
                status = LATE
        if acted(law, w, speed, seen_ring(estimate, y), estimate.held[0], status, u):
            command, fallback = self.fallback.step(t, y, fallback)
            fell_back(w, float(command[0]), float(command[1]), u)
        return (float(u[0]), float(u[1])), NmpcState(row, fallback)

    def machine(self) -> tuple[Any, NDArray[np.float64], NDArray[np.float64]] | None:
        """Entry, parameters and first state of the law as machine code, or None where a sample needs Python."""
        return (self._machine, self._row, row_of(self._first)) if self._whole else None

    def state_of(self, row: NDArray[np.float64]) -> NmpcState:
        """State of the law that a machine has left as a row of numbers."""
        return NmpcState(row.copy(), self.fallback.init())

    def spent(self, state: NmpcState) -> tuple[float, float]:
        """Median and 99 % of the times that the samples of a machine took. [s]"""
        counts = self.memory(state).spent
        return quantile(counts, 0.5), quantile(counts, 0.99)

    @cached_property
    def _whole(self) -> bool:
        """Whether a sample is machine code as a whole."""
        plain = self.information == "sensors" and type(self.fallback) is Fallback and self.deadline == math.inf
        if not (plain and self.effort.solver in MODEL):
            return False
        try:
            row_of(self._constants)
        except NotFlat:
            return False
        return True

    @cached_property
    def _constants(self) -> Constants:
        """What a sample goes by; the addresses are known to `_row` alone."""
        return Constants(estimator=self._estimator, predictor=self._foresight.predictor, law=self._numbers)

    @cached_property
    def _numbers(self) -> Numbers:
        a, effort, pair = self.aims, self.effort, self.fallback
        grip = 1.0 / a.traction if a.traction > 0.0 else 0.0
        cost = weights(self.plant, a.motion, a.limit1, a.limit3, a.lock, a.floor, a.travel, a.terminal)
        return Numbers(
            command=PowerCommand(*(float(value) for value in self.command)),
            rows=np.array([row for row in range(len(self.plant.rolling.labels)) if row != OMEGA], np.int64),
            h=np.array([self.period / STEPS]),
            k=constants(self.plant, beyond=True),
            weights=np.array(cost._replace(turns=a.turns, grip=grip, ceiling=a.ceiling), np.float64),
            doubt=float(a.doubt) * grip / np.array([cost.I1, cost.I3]),
            sure=float(a.sure) if self._knows_its_doubt else 0.0,
            period=float(self.period),
            horizon=float(self.horizon),
            reserve=float(a.reserve),
            cc_max=float(self.cc_max),
            cg_max=float(self.cg_max),
            lagging=self.lag / self.period * -math.expm1(-self.period / self.lag) if self.lag > 0.0 else 0.0,
            fresh=FRESH[effort.solver],
            delay=int(self.delay),
            iterations=int(effort.iterations),
            replan=int(effort.replan),
            every=int(effort.every),
            retries=int(effort.retries),
            life=int(effort.life),
            varied=int(effort.varied),
            newton=int(effort.newton),
            fresh_rival=ELSEWHERE[effort.solver],
            fallback=(float(pair.cc), float(pair.cg)) if type(pair) is Fallback else (0.0, 0.0),
            addresses=(0, 0, 0, 0, 0, 0),
        )

    @property
    def _knows_its_doubt(self) -> bool:
        """Whether the forecast tells how far it is off, or is the truth."""
        if self._foresight.probe is not None:
            return self.preview >= self.horizon + self.delay * self.period and self.probe.noise == 0.0
        told = self._foresight.gauge is not None or self._foresight.predictor.placed is not None
        return told and self.aims.doubt > 0.0 and self.aims.traction > 0.0

    @cached_property
    def _first(self) -> Memory:
        told = self._foresight.gauge
        gauge, width = None if told is None else told.init(), width_of(kind_of(self.plant))
        return first_memory(self._constants, BEFORE, self.intervals, width, int(self.effort.rivals), BINS, gauge)

    @cached_property
    def _texts(self) -> Texts:
        return texts_of(self._constants, self._first)

    @cached_property
    def _parts(self) -> tuple[Any, ...]:
        """Planner, functions of its model, and what learns the sea, compiled; kept, since their code goes with them."""
        solver = self.effort.solver
        return compiled_planner(solver), *model_of(kind_of(self.plant), solver), learn_of(self._texts)

    @cached_property
    def _machine(self) -> Any:
        return sample_of(self._texts)

    @cached_property
    def _row(self) -> NDArray[np.float64]:
        planner, *model, learn = self._parts
        addresses = planner.address, *addresses_of(model), learn.address, clock_address()
        law = self._numbers._replace(addresses=addresses)
        return row_of(self._constants._replace(law=law))

    @cached_property
    def _planner(self) -> Callable[..., None]:
        return planner_of(kind_of(self.plant), self.effort.solver)

    @cached_property
    def _estimator(self) -> MomentEstimator:
        return MomentEstimator.design(self.plant, period=self.period, delay=self.delay, lag=(self.lag, 0.0))

    @cached_property
    def _foresight(self) -> Foresight:
        far = self.horizon + self.delay * self.period  # the plan begins where the command acts
        if self.information == "gauge":
            readings = self.seen if isinstance(self.seen, Readings) else None
            return Foresight.gauged(self.plant, self._estimator, far, self.gauge, readings)
        lead = {"sensors": None, "forecast": self.probe.lead, "oracle": math.inf}[self.information]
        seen = None if isinstance(self.seen, Readings) else self.seen
        return Foresight.design(self.plant, self._estimator, far, lead, self.probe.noise, seen)


def prepare(function: Callable[[Any], Any], given: Any) -> None:
    """Let a part be compiled, and return nothing: machine code does not travel between processes."""
    function(given)


@entry_point
def call(address: int, t: float, y: Any, p: Any, s: Any, u: Any) -> None:
    """Call an entry from Python."""
    entry_at(address)(t, y, p, s, u)
