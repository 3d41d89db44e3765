"""Search for the best plan of a window, from several starts, each verified by the plant's own kernel."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.controllers.nmpc.problem import FLYWHEEL, weights
from gyroctl.errors import InputError
from gyroctl.plant import Plant
from gyroctl.plant.equations import OMEGA_RATE
from gyroctl.plant.kernel import hold_one, rows, slip_rate, steps_for
from gyroctl.simulation.metrics import Record
from gyroctl.studies.bound.cut import TAIL, Cut, Motion
from gyroctl.studies.bound.misfit import mended
from gyroctl.studies.bound.oracles import HABITS, oracle_runs
from gyroctl.studies.bound.replay import Control, replay
from gyroctl.studies.bound.shooting import optimise
from gyroctl.studies.bound.starts import beam, receding
from gyroctl.studies.bound.tracker import Tracker
from gyroctl.studies.bound.window import SUBSTEPS, Plan, Window, reduced, window

MARGIN = 0.02
"""What a plan keeps below the limits of motion at first. [rad]"""

PENALTY = 2000.0
"""Weight of motion beyond the limit of a plan. [J/(rad^2 s)]"""

STIFF = 8000.0
"""The same beyond the linear plant, where the waves carry the float along and its motion is what binds a plan."""

TERMINAL = 0.3
"""Share of the float's energy that counts at the end of the plan, in the tail. [-]"""

BEAMS = ((12.0, 50), (8.0, 40))
"""Beam searches for starts: generator power to begin with [W], control intervals between two choices."""

EXCESS = 20.0
"""What motion beyond the limit is reckoned to have brought. [W/rad]"""

COSTLY = 100.0
"""The same of a run that a plan may begin with: one within the limits, if it is not much worse. [W/rad]"""

RETURN = 5
"""Control intervals after which the replay looks again how to keep to its plan."""

STEADY = 0.02
"""Power CV below which a law's own run counts as one of constant power. [-]"""

ROUGH = 2
"""Model steps in a control interval while many starts are tried."""

Tick = Callable[[], None]


@dataclass(frozen=True)
class Effort:
    """How hard to search."""

    rounds: int = 4  # of `optimise`, per start
    iterations: int = 600  # of L-BFGS-B in each round, at most
    beams: int = 1  # beam searches
    width: int = 6  # of a beam search
    each: int = 2  # plans of each beam that are optimised
    polish: int = 250  # iterations per round with the fine model, on the best
    finalists: int = 2  # starts that are polished
    repairs: int = 1  # times that the motion limit of the plan is moved until the true 98 % motion fits
    oracles: int = len(HABITS)  # runs of the planning law that are tried, beyond the linear plant
    picked: int = 4  # runs of laws that plans begin with, the best of them, beyond the linear plant
    learning: int = 2  # times more that a plan is made anew with what its model missed, beyond the linear plant


FULL = Effort()


def quick(plant: Plant) -> Effort:
    """A tenth of the effort, to look around; beyond the linear plant, whose model costs more, from one start alone.

    Parameters
    ----------
    plant : Plant
        The device.

    Returns
    -------
    Effort
        For `best_found` and `bound_report`.
    """
    if not beyond_linear(plant):
        return Effort(2, 200, 1, 2, 1, finalists=1, repairs=1)
    return Effort(2, 150, 0, polish=100, finalists=1, repairs=1, oracles=3, picked=1, learning=1)


class Found(NamedTuple):
    """Best plan of a window."""

    values: Mapping[str, float]  # metrics of the run through the true plant, see `Cut.worth` [unit of each]
    record: Record  # that run
    origin: str  # start from which it was found
    planned_w: float  # harvest that the model promised [W]
    starts: Mapping[str, tuple[float, float]]  # harvest of each start and of what came of it, NaN beyond a limit [W]
    plan: Plan | None = None  # None where a law's own run was the best


def best_found(cut: Cut, runs: Mapping[str, Record], effort: Effort = FULL, tick: Tick = lambda: None) -> Found:
    """Search a window with constant generator power.

    Parameters
    ----------
    cut : Cut
        The window.
    runs : mapping of str to Record
        Runs of laws through the whole window and its tail: further starts, and further candidates.
    effort : Effort
        How hard to search.
    tick : callable
        Called `ticks` times.

    Raises
    ------
    InputError
        Field ``seeds``: where nothing found keeps lock and motion limit.
    """
    rough = problem_of(cut, ROUGH, closer(cut.motion, MARGIN))
    if beyond_linear(cut.plant):
        runs = {**oracle_runs(cut, effort.oracles), **runs}
    starts: dict[str, Plan] = {}
    if effort.beams > 0 or not beyond_linear(cut.plant):
        starts["receding horizon"] = receding(cut.plant, rough, BEAMS[0][0])
    for power, piece in BEAMS[: effort.beams]:
        plans = beam(cut.plant, rough, power, effort.width, piece)
        for index, plan in enumerate(plans[:: max(len(plans) // effort.each, 1)][: effort.each]):
            starts[f"beam from {power:g} W, {index + 1}"] = plan
        tick()
    starts |= {name: _plan_of(cut, rough, record) for name, record in _picked(cut, runs, effort).items()}
    found: list[Found] = []
    table: dict[str, tuple[float, float]] = {}
    for name, start in starts.items():
        plan = optimise(cut.plant, rough, start, True, effort.rounds, effort.iterations)
        found.append(verify(cut, rough, plan, name))
        table[name] = (_planned(cut, start), _score(cut, found[-1]))
        tick()
    # a plan that the replay could not hold, or whose motion is a little too large, may still be the best start
    found.sort(key=lambda one: _promise(cut, one), reverse=True)
    for one in found[: effort.finalists]:
        found += _polished(cut, one, True, effort, tick)
    return _best(cut, found, runs, True)._replace(starts=table)


def _picked(cut: Cut, runs: Mapping[str, Record], effort: Effort) -> Mapping[str, Record]:
    """Runs to begin a plan with: all, or beyond the linear plant the best; two that ended alike count once."""
    if not beyond_linear(cut.plant):
        return runs
    worth = {name: cut.worth(cut.counted(run)) for name, run in runs.items()}
    order = sorted(runs, key=lambda name: worth[name]["harvest_w"] + COSTLY * min(cut.motion.room(worth[name]), 0.0))
    ended = {round(worth[name]["harvest_w"], 9): name for name in order if worth[name]["locked"]}
    return {name: runs[name] for name in list(ended.values())[: -effort.picked - 1 : -1]}


def loosened(
    cut: Cut, smooth: Found, runs: Mapping[str, Record], effort: Effort = FULL, tick: Tick = lambda: None
) -> Found:
    """Improve on the best of constant power with a generator power that is free in each interval; else as there.

    Parameters
    ----------
    cut : Cut
        The window.
    smooth : Found
        Best of constant power there.
    runs : mapping of str to Record
        Runs of laws to begin from.
    effort : Effort
        How much is tried.
    tick : callable
        Called after each step.

    Returns
    -------
    Found
        At least as good as `smooth`.

    Raises
    ------
    InputError
        Where the planner refuses the device.
    """
    found = [smooth]
    if smooth.plan is not None:
        rough = problem_of(cut, ROUGH, closer(cut.motion, MARGIN))
        # many more unknowns, which would rather live on the gaps than on the waves: close them firmly from the start
        plan = optimise(cut.plant, rough, smooth.plan, False, effort.rounds + 1, effort.iterations, rho=400.0)
        found.append(verify(cut, rough, plan, smooth.origin))
        tick()
        found += _polished(cut, found[-1], False, effort, tick)
    return _best(cut, found, runs, False)._replace(starts={})


def _polished(cut: Cut, found: Found, smooth: bool, effort: Effort, tick: Tick) -> list[Found]:
    """Go on with the fine model, and move the motion limit of the plan until the true motion fits.

    Beyond the linear plant each plan knows what the model missed in the run before it.
    """
    assert found.plan is not None
    limit, plan, out, learns = closer(cut.motion, MARGIN), found.plan, [], beyond_linear(cut.plant)
    most = closer(cut.motion, -0.03)
    seen = found
    for _ in range(_stages(cut.plant, effort)):
        problem = problem_of(cut, SUBSTEPS, limit)
        if learns and math.isfinite(seen.values["harvest_w"]):
            problem = mended(cut.plant, problem, seen.record)
        plan = optimise(cut.plant, problem, plan, smooth, 2, effort.polish, rho=400.0)
        seen = verify(cut, problem, plan, found.origin)
        out.append(seen)
        if seen.values["locked"]:
            room = 0.8 * closer(cut.motion, 0.003).room(seen.values)
            limit = Motion(*(min(max(now + room, 0.2), top) for now, top in zip(limit, most, strict=True)))
        tick()
    return out


def _stages(plant: Plant, effort: Effort) -> int:
    """Number of plans with the fine model, for each that is polished."""
    return 1 + effort.repairs + (effort.learning if beyond_linear(plant) else 0)


def _best(cut: Cut, found: list[Found], runs: Mapping[str, Record], smooth: bool) -> Found:
    """Best of the plans and, where a law did better, its own run.

    Beyond the linear plant whatever its power: there the plans are those of a model that is not the plant.
    """
    for name, record in runs.items():
        counted = cut.counted(record)
        own = Found(cut.worth(counted), counted, f"{name} itself", math.nan, {})
        if not smooth or beyond_linear(cut.plant) or own.values["power_cv"] < STEADY:
            found = [*found, own]
    kept = [one for one in found if math.isfinite(_score(cut, one))]
    if not kept:
        problem = "nothing found keeps the lock and the motion limit in this window"
        raise InputError(
            "seeds", cut.waves.seed, problem, "Choose another seed, a lower Hs, or a wider limit of motion"
        )
    return max(kept, key=lambda one: _score(cut, one))


def ticks(plant: Plant, runs: int, effort: Effort, free: bool = False) -> int:
    """Number of stages of `best_found`, and of `loosened` after it."""
    if beyond_linear(plant):
        starts = min(runs + effort.oracles, effort.picked) + (1 if effort.beams > 0 else 0)
    else:
        starts = 1 + runs
    starts += effort.beams * (1 + effort.each)
    return starts + effort.finalists * _stages(plant, effort) + (1 + _stages(plant, effort) if free else 0)


def beyond_linear(plant: Plant) -> bool:
    """Whether a plant is more than the linear one."""
    return plant.coefficients.beyond is not None


def closer(motion: Motion, margin: float) -> Motion:
    """Limits of motion less a margin [rad]."""
    return Motion(motion.phi1 - margin, motion.phi3 - margin)


def verify(cut: Cut, w: Window, plan: Plan, origin: str) -> Found:
    """Follow a plan with the plant's kernel, held to its path by the coupling alone; the power is as planned."""
    record = cut.counted(_follow(cut, w, plan))
    return Found(cut.worth(record), record, origin, _planned(cut, plan), {}, plan)


def _planned(cut: Cut, plan: Plan) -> float:
    """Harvest by the model's account. [W]"""
    J4, n = cut.plant.parameters.J4, cut.intervals
    speed = plan.states[:, FLYWHEEL]
    return float(plan.power[:n].mean()) + 0.5 * J4 * float(speed[n] ** 2 - speed[0] ** 2) / cut.duration


def _follow(cut: Cut, w: Window, plan: Plan) -> Record:
    """Follow a plan through the plant; the way back to it is found from the true state."""
    tracker, cg_max = Tracker(cut.plant, w, plan), cut.settings.actuators.cg_max
    way_back = plan.cc

    def control(i: int, y: NDArray[np.float64], acts: float) -> tuple[float, float]:
        nonlocal way_back
        if i % RETURN == 0:
            way_back = tracker.back(i, reduced(cut.plant, y), acts)
        return float(way_back[i % RETURN]), min(plan.power[i] / max(y[OMEGA_RATE] ** 2, 1.0), cg_max)

    if beyond_linear(cut.plant) or cut.settings.actuators.moves:
        return replay(cut, control, plan.cc.size)
    return _held(cut, control, plan.cc.size)


def _held(cut: Cut, control: Control, intervals: int) -> Record:
    """Replay in the linear plant, each interval of steps that do not depend on the one before."""
    k, waves, period = cut.plant.coefficients, cut.waves, cut.settings.actuators.period
    flat = np.ascontiguousarray(waves.moments.T).ravel()
    y = np.zeros(rows(k))
    states, controls = np.zeros((intervals + 1, y.size)), np.zeros((intervals, 2))
    y[: cut.start.size] = cut.start
    states[0] = y
    for i in range(intervals):
        controls[i] = cc, cg = control(i, y, 0.0)
        steps = 2 * steps_for(period, cut.settings.dt, slip_rate(k, cc))  # twice: the coupling switches hard here
        y = hold_one(y, k, cc, cg, i * period, period, steps, flat, waves.dt)
        states[i + 1] = y
    return Record(states, controls, controls, period, 0)


def problem_of(cut: Cut, substeps: int, limit: Motion) -> Window:
    """Problem of a window and its tail, with limits of the plan's motion."""
    priced = weights(cut.plant, STIFF if beyond_linear(cut.plant) else PENALTY, *limit, 0.0, 1.0, 0.0, TERMINAL)
    return window(cut, priced, round((cut.duration + TAIL) / cut.settings.actuators.period), substeps)


def _plan_of(cut: Cut, w: Window, record: Record) -> Plan:
    """What a law did, as a plan."""
    n = w.intervals
    power = record.controls[:n, 1] * record.states[:n, OMEGA_RATE] ** 2
    asked = np.minimum(np.maximum(record.commands[:n, 0], 0.0), w.cc_max)
    return Plan(asked, power, reduced(cut.plant, record.states[: n + 1]))


def _promise(cut: Cut, found: Found) -> float:
    """What a plan may be worth once its motion is brought within the limit. [W]"""
    v = found.values
    harvest = v["harvest_w"] if v["locked"] else found.planned_w - 1.0
    return harvest - EXCESS * max(-cut.motion.room(v), 0.0) * v["locked"]


def _score(cut: Cut, found: Found) -> float:
    """Harvest, or NaN where the run broke a limit."""
    kept = found.values["locked"] and cut.motion.room(found.values) >= 0.0
    return found.values["harvest_w"] if kept else math.nan
