"""What the planning law goes by, in groups: effort of the planner, preview, aims. Units stand beside each setting."""

from __future__ import annotations

import math
from typing import Any, Literal, NamedTuple, get_args

from gyroctl.controllers.nmpc.planner import FRESH, NEWTON
from gyroctl.errors import InputError
from gyroctl.nested import named
from gyroctl.waves.gauge import Gauge
from gyroctl.waves.gauge import check as check_gauge

Information = Literal["oracle", "forecast", "gauge", "sensors"]
LEVELS = get_args(Information)

SETTINGS = ("information", "horizon", "period", "effort", "probe", "command", "aims", "cc_max", "cg_max", "deadline")
"""Fields of the law that are checked, groups among them."""

POSITIVE = [
    "horizon",
    "iterations",
    "newton",
    "replan",
    "every",
    "rivals",
    "life",
    "period",
    "cc_max",
    "cg_max",
    "deadline",
    "flywheel",
    "power",
]
"""Settings that must be more than zero; the other numbers may be zero."""


class Effort(NamedTuple):
    """How a plan is made."""

    solver: str = "condensed"  # of quadratic programs: condensed, riccati, the baseline osqp; or descent, by gradients
    iterations: int = 1  # of the solver, per plan
    newton: int = NEWTON  # steps on a program in an iteration
    replan: int = 1  # samples from one plan to the next; the last one is followed in between
    every: int = 3  # every so many plans another one is begun elsewhere
    retries: int = 2  # iterations that it gets; none is begun with 0
    rivals: int = 1  # plans begun elsewhere that are worked on side by side
    varied: int = 0  # times that a plan is first replaced by the best of its variations, see `side_by_side.vary`
    life: int = 1  # times that each is worked on before it is begun anew: with more than one it goes along meanwhile


class Preview(NamedTuple):
    """What a probe tells of the moments, for the information "forecast"."""

    lead: float = 0.0  # how far ahead [s]
    noise: float = 0.0  # its error, as a part of the moments' standard deviation [-]


class Aims(NamedTuple):
    """What a plan weighs against the energy that it wins, see `problem`."""

    motion: float = 4000.0  # weight of motion beyond its limits [J/(rad^2 s)]
    limit1: float = 0.2479  # of |phi1| [rad]
    limit3: float = 0.25  # of |phi3| [rad]
    sure: float = 0.0  # more of |phi1| where nothing ahead is in doubt, see `sample.allowed` [rad]
    lock: float = 50.0  # weight of ring speed below its floor [J s/rad^2]
    floor: float = 1.57  # least ring speed [rad/s]
    traction: float = 0.0  # friction of the rolling contact that a plan counts on; with 0 it asks for none [-]
    ceiling: float = 100.0  # most that grip asks of the ring's speed [rad/s]
    doubt: float = 0.0  # deviations of the forecast that the ring leaves room for, see `sample.doubted` [-]
    turns: float = 28.69  # weight of missing turns [J/rad^2]
    reserve: float = 2.2  # mean ring speed that past and horizon together are to keep [rad/s]
    travel: float = 0.0  # weight of the coupling's changes [J/(Nms)^2]
    terminal: float = 0.6733  # share of the float's mechanical energy that counts at the end of the horizon [-]


def check(settings: dict[str, Any], gauge: Gauge) -> None:
    """Refuse settings that no plan can be made with.

    Raises
    ------
    InputError
        For a number, a level or a solver out of range; it names the setting.
    """
    check_gauge(gauge)
    found = {key: value for name, part in settings.items() for key, value in _numbers(name, part).items()}
    if found.pop("information") not in LEVELS:
        level = settings["information"]
        raise InputError("nmpc.information", level, "unknown level", f"Choose one of {', '.join(LEVELS)}")
    solver = found.pop("solver")
    if solver not in FRESH:
        raise InputError("nmpc.solver", solver, "unknown solver", f"Choose one of {', '.join(FRESH)}")
    if solver != "condensed" and found["varied"] > 0:
        mend = 'Leave it out, or choose the solver "condensed"'
        raise InputError("nmpc.varied", found["varied"], f'the solver "{solver}" varies no plans', mend)
    for name, value in found.items():
        least = "must be positive" if name in POSITIVE else "must not be negative"
        number = isinstance(value, int | float) and (math.isfinite(value) or (name == "deadline" and value > 0.0))
        if not number or value < 0.0 or (value == 0.0 and name in POSITIVE):
            raise InputError(f"nmpc.{name}", value, least, "Leave it out for the default")


def _numbers(name: str, part: Any) -> dict[str, Any]:
    return named(part) if hasattr(part, "_fields") else {name: part}
