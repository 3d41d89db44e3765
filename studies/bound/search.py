"""Search for the best plan of a window, from several starts, each verified by the plant's own kernel."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gyroctl.controllers.nmpc.problem import FLYWHEEL, weights
from gyroctl.errors import InputError
from gyroctl.plant.equations import OMEGA_RATE
from gyroctl.plant.kernel import hold_one, rows, slip_rate, steps_for
from gyroctl.simulation.metrics import Record
from gyroctl.studies.bound.cut import TAIL, Cut
from gyroctl.studies.bound.shooting import optimise
from gyroctl.studies.bound.starts import beam, receding
from gyroctl.studies.bound.tracker import Tracker
from gyroctl.studies.bound.window import SUBSTEPS, Plan, Window, reduced, window

MOTION = 0.35
"""Limit of the 98 % motion. [rad]"""

PENALTY = 2000.0
"""Weight of motion beyond the limit of a plan. [J/(rad^2 s)]"""

TERMINAL = 0.3
"""Share of the float's energy that counts at the end of the plan, in the tail. [-]"""

BEAMS = ((12.0, 50), (8.0, 40))
"""Beam searches for starts: generator power to begin with [W], control intervals between two choices."""

EXCESS = 20.0
"""What motion beyond the limit is reckoned to have brought. [W/rad]"""

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


FULL = Effort()


class Found(NamedTuple):
    """Best plan of a window."""

    values: Mapping[str, float]  # metrics of the run through the true plant, see `Cut.worth`
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
    rough = problem_of(cut, ROUGH, MOTION - 0.02)
    starts: dict[str, Plan] = {"receding horizon": receding(cut.plant, rough, BEAMS[0][0])}
    for power, piece in BEAMS[: effort.beams]:
        plans = beam(cut.plant, rough, power, effort.width, piece)
        for index, plan in enumerate(plans[:: max(len(plans) // effort.each, 1)][: effort.each]):
            starts[f"beam from {power:g} W, {index + 1}"] = plan
        tick()
    starts |= {name: _plan_of(rough, record) for name, record in runs.items()}
    found: list[Found] = []
    table: dict[str, tuple[float, float]] = {}
    for name, start in starts.items():
        plan = optimise(cut.plant, rough, start, True, effort.rounds, effort.iterations)
        found.append(verify(cut, rough, plan, name))
        table[name] = (_planned(cut, start), _score(found[-1]))
        tick()
    # a plan that the replay could not hold, or whose motion is a little too large, may still be the best start
    found.sort(key=_promise, reverse=True)
    for one in found[: effort.finalists]:
        found += _polished(cut, one, True, effort, tick)
    return _best(cut, found, runs, True)._replace(starts=table)


def loosened(
    cut: Cut, smooth: Found, runs: Mapping[str, Record], effort: Effort = FULL, tick: Tick = lambda: None
) -> Found:
    """Improve on the best of constant power with a generator power that is free in each interval; else as there."""
    found = [smooth]
    if smooth.plan is not None:
        rough = problem_of(cut, ROUGH, MOTION - 0.02)
        # many more unknowns, which would rather live on the gaps than on the waves: close them firmly from the start
        plan = optimise(cut.plant, rough, smooth.plan, False, effort.rounds + 1, effort.iterations, rho=400.0)
        found.append(verify(cut, rough, plan, smooth.origin))
        tick()
        found += _polished(cut, found[-1], False, effort, tick)
    return _best(cut, found, runs, False)._replace(starts={})


def _polished(cut: Cut, found: Found, smooth: bool, effort: Effort, tick: Tick) -> list[Found]:
    """Go on with the fine model, and move the motion limit of the plan until the true motion fits."""
    assert found.plan is not None
    limit, plan, out = MOTION - 0.02, found.plan, []
    for _ in range(effort.repairs + 1):
        problem = problem_of(cut, SUBSTEPS, limit)
        plan = optimise(cut.plant, problem, plan, smooth, 2, effort.polish, rho=400.0)
        out.append(verify(cut, problem, plan, found.origin))
        if out[-1].values["locked"]:
            limit += 0.8 * (MOTION - 0.003 - max(out[-1].values["phi1_p98"], out[-1].values["phi3_p98"]))
            limit = min(max(limit, 0.2), MOTION + 0.03)
        tick()
    return out


def _best(cut: Cut, found: list[Found], runs: Mapping[str, Record], smooth: bool) -> Found:
    """Best of the plans and, where a law did better, its own run."""
    for name, record in runs.items():
        counted = cut.counted(record)
        own = Found(cut.worth(counted), counted, f"{name} itself", math.nan, {})
        if not smooth or own.values["power_cv"] < STEADY:
            found = [*found, own]
    kept = [one for one in found if math.isfinite(_score(one))]
    if not kept:
        problem = "nothing found keeps the lock and the motion limit in this window"
        raise InputError("seeds", cut.waves.seed, problem, "Choose another seed, or a lower Hs")
    return max(kept, key=_score)


def ticks(runs: int, effort: Effort) -> int:
    """Number of stages of `best_found`."""
    return 1 + effort.beams * (1 + effort.each) + runs + effort.finalists * (effort.repairs + 1)


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
    k, waves, actuators = cut.plant.coefficients, cut.waves, cut.settings.actuators
    flat = np.ascontiguousarray(waves.moments.T).ravel()
    y = np.zeros(rows(k))
    states, controls = np.zeros((plan.cc.size + 1, y.size)), np.zeros((plan.cc.size, 2))
    y[: cut.start.size] = cut.start
    states[0] = y
    period, tracker = actuators.period, Tracker(cut.plant, w, plan)
    for i in range(plan.cc.size):
        if i % RETURN == 0:
            way_back = tracker.back(i, reduced(y[: cut.start.size]))
        cc = float(way_back[i % RETURN])
        cg = min(plan.power[i] / max(y[OMEGA_RATE] ** 2, 1.0), actuators.cg_max)
        controls[i] = cc, cg
        steps = 2 * steps_for(period, cut.settings.dt, slip_rate(k, cc))  # twice: the coupling switches hard here
        y = hold_one(y, k, cc, cg, i * period, period, steps, flat, waves.dt)
        states[i + 1] = y
    return Record(states, controls, controls, period, 0)


def problem_of(cut: Cut, substeps: int, limit: float) -> Window:
    """Problem of a window and its tail, with a limit of the plan's motion [rad]."""
    priced = weights(cut.plant, PENALTY, limit, limit, 0.0, 1.0, 0.0, TERMINAL)
    return window(cut, priced, round((cut.duration + TAIL) / cut.settings.actuators.period), substeps)


def _plan_of(w: Window, record: Record) -> Plan:
    """What a law did, as a plan."""
    n = w.intervals
    power = record.controls[:n, 1] * record.states[:n, OMEGA_RATE] ** 2
    return Plan(record.controls[:n, 0].copy(), power, reduced(record.states[: n + 1, : w.start.size + 1]))


def _promise(found: Found) -> float:
    """What a plan may be worth once its motion is brought within the limit. [W]"""
    v = found.values
    harvest = v["harvest_w"] if v["locked"] else found.planned_w - 1.0
    return harvest - EXCESS * max(v["phi1_p98"] - MOTION, v["phi3_p98"] - MOTION, 0.0) * v["locked"]


def _score(found: Found) -> float:
    """Harvest, or NaN where the run broke a limit."""
    v = found.values
    kept = v["locked"] and v["phi1_p98"] <= MOTION and v["phi3_p98"] <= MOTION
    return v["harvest_w"] if kept else math.nan
