"""What a law can see, which decides among whom it is judged: nothing, its sensors, some seconds of the waves, or all.

A law with the information "forecast" declares how far ahead it is told the moments, as a member ``preview`` [s], and
how far it plans, as a member ``horizon`` [s]. It is handed a window that is open that far and no farther. One whose
preview covers its plan knows all that it can use, and is an oracle whatever it calls itself.
"""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol, runtime_checkable

from gyroctl.errors import InputError
from gyroctl.harness.protocol import Information, Law, Previewing, innermost
from gyroctl.waves import WaveRealisation
from gyroctl.waves.window import Shutter

LONGEST_PLAN = 4.0
"""Preview with which a law knows all that a plan can use, however long it says that it plans: with a preview of 4 s
the planner harvests what it does with 8 s or with the whole sea. [s]"""


@runtime_checkable
class Foreseeing(Protocol):
    """A law that is told the moments some seconds ahead, for the information "forecast"."""

    @property
    def preview(self) -> float:
        """How far ahead it is told the moments. [s]"""
        ...


@runtime_checkable
class Planning(Protocol):
    """A law that plans, and says how far."""

    @property
    def horizon(self) -> float:
        """How far its plan goes. [s]"""
        ...


class Sight(NamedTuple):
    """Level of information at which a law is judged, and how far ahead it is told the waves. [s]"""

    level: Information
    preview: float


def sight(law: Law) -> Sight:
    """Tell what a law can see.

    Raises
    ------
    InputError
        For a preview that is no time.
    """
    if law.information in ("none", "sensors"):
        return Sight(law.information, 0.0)
    if law.information == "oracle":
        return Sight("oracle", math.inf)
    inner = innermost(law)
    if not isinstance(inner, Foreseeing):
        return Sight("oracle", math.inf)  # it says not how far it looks: it is handed the realisation itself
    preview = inner.preview
    number = isinstance(preview, float | int) and not isinstance(preview, bool)
    if not (number and preview >= 0.0):
        mend = "Give the seconds that it is told the moments ahead, 0 or more"
        raise InputError("laws.preview", preview, "must be a time", mend)
    plan = float(inner.horizon) if isinstance(inner, Planning) else 0.0
    covered = preview > 0.0 and preview >= min(plan, LONGEST_PLAN) - 1e-9
    return Sight("oracle" if covered else "forecast", float(preview))


def informed(law: Law, waves: WaveRealisation) -> tuple[Law, Shutter | None]:
    """Give a law what it may see of a realisation, and the shutter of its window where it has one.

    A law that goes by its sensors gets nothing, even where it has a method ``informed``.
    """
    if law.information in ("none", "sensors") or not isinstance(law, Previewing):
        return law, None
    ahead = sight(law).preview
    if math.isinf(ahead):
        return law.informed(waves), None
    shutter = Shutter(waves, ahead)
    return law.informed(shutter.window), shutter
