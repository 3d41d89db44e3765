"""Constant coupling and generator gain: the paper's device, and the yardstick of every law."""

from __future__ import annotations

import math
from typing import Any, Literal, NamedTuple

from gyroctl.controllers.rule_based.shipped import shipped
from gyroctl.faces.law import law_face
from gyroctl.faces.show import shown


@shown(law_face)
class Constant(NamedTuple):
    """Hold both controls."""

    cc: float = 0.052  # [Nms]
    cg: float = 3.5e-4  # [Nms]
    period: float = 0.1  # [s]

    @property
    def information(self) -> Literal["none"]:
        """What the law looks at."""
        return "none"

    @property
    def sensors(self) -> tuple[str, ...]:
        """Channels of the measurement that its command goes by."""
        return ()

    def init(self) -> tuple[()]:
        """No state."""
        return ()

    def step(self, t: float, y: Any, state: tuple[()]) -> tuple[tuple[float, float], tuple[()]]:
        """Return the two constants."""
        return (self.cc, self.cg), state


def best_constant(gamma: float = 5.0) -> Constant:
    """Return the best constant pair found on the tuning seeds, by ``gyroctl tune constant``.

    Parameters
    ----------
    gamma : float
        Peak enhancement of the sea; the pair is that of the nearest tuned gamma (1, 5, 50) on a logarithmic scale. [-]

    Raises
    ------
    ValueError
        For a gamma that is not a positive number.
    """
    if not (math.isfinite(gamma) and gamma > 0.0):
        raise ValueError(f"gamma = {gamma} must be a positive number: give the peak enhancement of the sea")
    sets = shipped("constant")
    seas = {name: entry["found"]["seas"] for name, entry in sets.items()}
    tuned = {name: float(own[name]["sea"]["gamma"]) for name, own in seas.items() if name in own}  # not in real water
    nearest = min(tuned, key=lambda name: abs(math.log(tuned[name] / gamma)))
    return Constant(**sets[nearest]["parameters"])
