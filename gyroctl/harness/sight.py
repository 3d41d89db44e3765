"""What a law can see, which decides among whom it is judged: nothing, its sensors, a gauge, seconds of the waves, all.

A law with the information "gauge" describes the gauge, as a member ``gauge``. It is handed what was read of it by now.

A law with the information "forecast" declares how far ahead it is told the moments, as a member ``preview`` [s], and
how far it plans, as a member ``horizon`` [s]. It is handed a window that is open that far and no farther. One whose
preview covers its plan knows all that it can use, and is an oracle whatever it calls itself.
"""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol, runtime_checkable

from gyroctl.errors import NOT_GIVEN, InputError
from gyroctl.harness.protocol import Information, Law, Previewing, innermost
from gyroctl.plant import Plant
from gyroctl.waves import WaveRealisation
from gyroctl.waves.gauge import Gauge, GaugeShutter, measured
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


@runtime_checkable
class Gauged(Protocol):
    """A law that reads a gauge up-wave, for the information "gauge"."""

    @property
    def gauge(self) -> Gauge:
        """The gauge as it stands, and what the law believes of it."""
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
    if law.information in ("none", "sensors", "gauge"):
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


def informed(law: Law, waves: WaveRealisation, plant: Plant) -> tuple[Law, Shutter | GaugeShutter | None]:
    """Give a law what it may see of a realisation before a plant, and the shutter of its window where it has one.

    A law that goes by its sensors gets nothing, even where it has a method ``informed``.

    Raises
    ------
    InputError
        For a law that is to read a gauge and describes none, or waves that no gauge can measure.
    """
    if law.information in ("none", "sensors") or not isinstance(law, Previewing):
        return law, None
    if law.information == "gauge":
        inner = innermost(law)
        if not isinstance(inner, Gauged):
            mend = "Give it a member gauge, a gyroctl.waves.gauge.Gauge"
            raise InputError("laws.gauge", NOT_GIVEN, "a law that reads a gauge describes none", mend)
        record = GaugeShutter(measured(inner.gauge, waves, plant), inner.gauge.sampling, waves.duration)
        return law.informed(record.readings), record
    ahead = sight(law).preview
    if math.isinf(ahead):
        return law.informed(waves), None
    shutter = Shutter(waves, ahead)
    return law.informed(shutter.window), shutter
