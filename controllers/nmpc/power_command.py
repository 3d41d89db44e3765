"""The slow power command: what the generator gives while the coupling does the work.

The flywheel stores minutes of output, so a constant power costs nothing; what the command must do is to keep the
flywheel at a speed from which both the gyroscopic moment and the slip can be had. A PI regulator of the flywheel's
speed does that: its integral part is the mean power that the sea gives. Everything scales with that mean, so that the
same numbers serve low and high seas. The mean is learnt quickly at first, when nothing is known of the sea.

The speed of the flywheel is also the reserve of lock: in a lull the coupling drags the ring along at the flywheel's
speed over N. A flywheel that was drained over a minute or two is how lock is lost: it takes less from the waves too, so
it drains ever faster. Hence the guard: below `low` the power falls steeply.
"""

from __future__ import annotations

from typing import NamedTuple

from gyroctl.plant.compiled import inlined

LEAST = 0.1
"""Least mean power, from which it grows again. [W]"""

QUICK = 8.0
"""Most by which the mean is learnt more quickly at first. [-]"""


class PowerCommand(NamedTuple):
    """PI regulator of the flywheel's speed, in power relative to its mean."""

    flywheel: float = 71.65  # speed wanted, the same in every sea: one that follows the ring follows a stall [rad/s]
    proportional: float = 2.31  # part of the mean power by part of the wanted speed [-]
    integral: float = 0.006346  # of its change [1/s]
    settling: float = 1000.0  # for so long the mean is learnt more quickly [s]
    low: float = 0.907  # part of the wanted speed at which the guard begins [-]
    guard: float = 9.204  # its slope, on top of `proportional` [-]
    power: float = 14.0  # mean power at the start [W]

    def step(self, speed: float, mean: float, period: float, since: float, cg_max: float) -> tuple[float, float]:
        """Return power [W] and the new mean [W].

        Parameters
        ----------
        speed : float
            Flywheel speed. [rad/s]
        mean : float
            Mean power so far. [W]
        period : float
            Time since the last call. [s]
        since : float
            Time since the first call. [s]
        cg_max : float
            Limit of the generator gain. [Nms]
        """
        return commanded(self, speed, mean, period, since, cg_max)


@inlined
def commanded(
    law: PowerCommand, speed: float, mean: float, period: float, since: float, cg_max: float
) -> tuple[float, float]:
    """Return power and new mean [W], see `PowerCommand.step`."""
    most = cg_max * speed * speed
    part = speed / law.flywheel
    learning = law.integral * min(max(law.settling / max(since, period), 1.0), QUICK)
    mean = min(max(mean * (1.0 + learning * period * (part - 1.0)), LEAST), most)
    share = 1.0 + law.proportional * (part - 1.0) + law.guard * min(part - law.low, 0.0)
    return min(max(mean * share, 0.0), most), mean
