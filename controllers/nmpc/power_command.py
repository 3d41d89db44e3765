"""The slow power command: what the generator gives while the coupling does the work.

The flywheel stores minutes of output, so a constant power costs nothing; what the command must do is to keep the
flywheel at a speed from which both the gyroscopic moment and the slip can be had. A PI regulator on the flywheel speed
does that: its integral part is the mean power that the sea gives.
"""

from __future__ import annotations

from typing import NamedTuple


class PowerCommand(NamedTuple):
    """PI regulator of the flywheel speed, in power."""

    proportional: float  # [W/(rad/s)]
    integral: float  # [W/rad]
    cg_max: float  # [Nms]

    def step(self, error: float, speed: float, mean: float, period: float) -> tuple[float, float]:
        """Return power [W] and the new integral part [W].

        Parameters
        ----------
        error : float
            Flywheel speed less the wanted one. [rad/s]
        speed : float
            Flywheel speed. [rad/s]
        mean : float
            Integral part so far. [W]
        period : float
            Time since the last call. [s]
        """
        most = self.cg_max * speed * speed
        mean = min(max(mean + self.integral * period * error, 0.0), most)
        return min(max(mean + self.proportional * error, 0.0), most), mean
