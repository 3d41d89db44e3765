"""Search for the best plan of a window, from several starts, each verified by the plant's own kernel."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gyroctl.controllers.nmpc import full_horizon
from gyroctl.controllers.nmpc.full_horizon import Plan, Window, beam, optimise, receding, reduced, tracking_gains, window
from gyroctl.controllers.nmpc.problem import weights
from gyroctl.plant.equations import OMEGA_RATE
from gyroctl.plant.kernel import hold_one, rows, slip_rate, steps_for
from gyroctl.simulation.metrics import Record
from gyroctl.studies.bound.cut import TAIL, Cut

MOTION = 0.35
"""Limit of the 98 % motion. [rad]"""

PENALTY = 2000.0
"""Weight of motion beyond the limit of a plan. [J/(rad^2 s)]"""

TERMINAL = 0.3
"""Share of the float's energy that counts at the end of the plan, in the tail. [-]"""

BEAMS = ((12.0, 50), (8.0, 40))
"""Beam searches for starts: generator power to begin with [W], control intervals between two choices."""


@dataclass(frozen=True)
class Effort:
    """How hard to search.

    Parameters
    ----------
    rounds, iterations : int
        Of `optimise`, per start.
    beams, width : int
        Beam searches and their width.
    each : int
        Plans of each beam that are optimised.
    polish : int
        Iterations per round with the fine model, on the best.
    repairs : int
        Times that the motion limit of the plan is moved until the true 98 % motion fits.
    """

    rounds: int = 3
    iterations: int = 700
    beams: int = 2
    width: int = 5
    each: int = 2
    polish: int = 250
    repairs: int = 2


@dataclass(frozen=True)
class Found:
    """Best plan of a window.

    Parameters
    ----------
    values : mapping
        Metrics of the run through the true plant, see `Cut.worth`.
    record : Record
        That run.
    origin : str
        Start from which it was found.
    planned_w : float
        Harvest that the model promised. [W]
    starts : mapping
        Harvest from each start, before and after; NaN where the run broke a limit. [W]
    plan : Plan, optional
        None where a law's own run was the best.
    """

    values: Mapping[str, float]
    record: Record
    origin: str
    planned_w: float
    starts: Mapping[str, tuple[float, float]]
    plan: Plan | None = field(default=None, repr=False)


def best_found(
    cut: Cut, smooth: bool = True, runs: Mapping[str, Record] | None = None, effort: Effort | None = None,
    tick: Callable[[], None] | None = None,
) -> Found:  # fmt: skip
    """Search a window.

    Parameters
    ----------
    cut : Cut
        The window.
    smooth : bool
        Constant generator power, or one that is free in each interval.
    runs : mapping of str to Record, optional
        Runs of laws through the whole window and its tail: further starts, and further candidates.
    effort : Effort, optional
        How hard to search.
    tick : callable, optional
        Called `ticks` times.

    Raises
    ------
    RuntimeError
        Where no plan keeps lock and limits.
    """
    effort, count = effort or Effort(), tick or (lambda: None)
    rough, fine = (_window(cut, substeps, MOTION - 0.02) for substeps in (2, full_horizon.SUBSTEPS))
    starts: dict[str, Plan] = {"receding horizon": receding(cut.plant, rough, BEAMS[0][0])}
    for power, piece in BEAMS[: effort.beams]:
        plans = beam(cut.plant, rough, power, width=effort.width, piece=piece)
        for index, plan in enumerate(plans[:: max(len(plans) // effort.each, 1)][: effort.each]):
            starts[f"beam from {power:g} W, {index + 1}"] = plan
        count()
    for name, record in (runs or {}).items():
        starts[name] = _plan_of(fine, record)
    best: Found | None = None
    table: dict[str, tuple[float, float]] = {}
    for name, start in starts.items():
        before = verify(cut, rough, start, name)
        plan = optimise(cut.plant, rough, start, smooth, effort.rounds, effort.iterations)
        after = verify(cut, rough, plan, name)
        table[name] = (_score(before), _score(after))
        if best is None or _rank(after) > _rank(best):
            best = after
        if not smooth and _rank(before) > _rank(best):
            best = before
        count()
    assert best is not None and best.plan is not None
    limit, plan = MOTION - 0.02, best.plan
    for repair in range(effort.repairs + 1):
        problem = _window(cut, full_horizon.SUBSTEPS, limit)
        plan = optimise(cut.plant, problem, plan, smooth, 2, effort.polish, rho=400.0)
        polished = verify(cut, problem, plan, best.origin)
        if _rank(polished) > _rank(best):
            best = polished
        limit += 0.8 * (MOTION - 0.003 - max(polished.values["phi1_p98"], polished.values["phi3_p98"]))
        limit = min(max(limit, 0.2), MOTION + 0.03)
        count()
    for name, record in (runs or {}).items():  # a law that does better is itself the best found
        counted = cut.counted(record)
        own = Found(cut.worth(counted), counted, f"{name} itself", math.nan, {})
        steady = own.values["power_cv"] < 0.02
        if (steady or not smooth) and _rank(own) > _rank(best):
            best = own
    if not math.isfinite(_score(best)):
        raise RuntimeError("no plan of this window keeps lock and motion limit")
    return dataclasses.replace(best, starts=table)


def ticks(runs: int, effort: Effort | None = None) -> int:
    """Number of stages of `best_found`."""
    effort = effort or Effort()
    return 1 + effort.beams * (1 + effort.each) + runs + effort.repairs + 1


def verify(cut: Cut, w: Window, plan: Plan, origin: str) -> Found:
    """Follow a plan with the plant's kernel, held to its path by the coupling alone; the generator power is as planned."""
    gains = tracking_gains(cut.plant, w, plan)
    record = cut.counted(_follow(cut, w, plan, gains))
    J4, n = cut.plant.parameters.J4, cut.intervals
    speed = plan.states[:, full_horizon.FLYWHEEL]
    planned = float(plan.power[:n].mean()) + 0.5 * J4 * float(speed[n] ** 2 - speed[0] ** 2) / cut.duration
    return Found(cut.worth(record), record, origin, planned, {}, plan)


def _follow(cut: Cut, w: Window, plan: Plan, gains: NDArray[np.float64]) -> Record:
    k, waves, actuators = cut.plant.coefficients, cut.waves, cut.settings.actuators
    flat = np.ascontiguousarray(waves.moments.T).ravel()
    y = np.zeros(rows(k))
    states, controls = np.zeros((plan.cc.size + 1, y.size)), np.zeros((plan.cc.size, 2))
    y[: cut.start.size] = cut.start
    states[0] = y
    period = actuators.period
    for i in range(plan.cc.size):
        away = reduced(y[: cut.start.size]) - plan.states[i]
        cc = min(max(plan.cc[i] - float(gains[i] @ away), 0.0), w.cc_max)
        cg = min(plan.power[i] / max(y[OMEGA_RATE] ** 2, 1.0), actuators.cg_max)
        controls[i] = cc, cg
        # twice the steps that the slip asks for: the coupling switches hard here
        y = hold_one(y, k, cc, cg, i * period, period, 2 * steps_for(period, cut.settings.dt, slip_rate(k, cc)), flat,
                     waves.dt)  # fmt: skip
        states[i + 1] = y
    return Record(states, controls, controls, period, 0)


def _window(cut: Cut, substeps: int, limit: float) -> Window:
    actuators = cut.settings.actuators
    speed = cut.plant.parameters.N * cut.waves.sea.wp
    return window(
        cut.plant, cut.start, cut.waves.moments, cut.waves.dt, round((cut.duration + TAIL) / actuators.period),
        weights(cut.plant, PENALTY, limit, limit, 0.0, 1.0, 0.0, TERMINAL), actuators.period, substeps=substeps,
        cc_max=actuators.cc_max, power_max=0.7 * actuators.cg_max * speed**2,
    )  # fmt: skip


def _plan_of(w: Window, record: Record) -> Plan:
    """What a law did, as a plan."""
    n = w.intervals
    power = record.controls[:n, 1] * record.states[:n, OMEGA_RATE] ** 2
    return Plan(record.controls[:n, 0].copy(), power, reduced(record.states[: n + 1, : w.start.size + 1]), math.nan)


def _score(found: Found) -> float:
    """Harvest, or NaN where the run broke a limit."""
    v = found.values
    kept = v["locked"] and v["phi1_p98"] <= MOTION and v["phi3_p98"] <= MOTION
    return v["harvest_w"] if kept else math.nan


def _rank(found: Found) -> tuple[bool, bool, float]:
    v = found.values
    return bool(v["locked"]), math.isfinite(_score(found)), v["harvest_w"]
