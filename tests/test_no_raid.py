"""Power won by draining a store is not counted as won: laws that raid flywheel and float beside the best constant pair."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.harness.run import Settings, lead_in, run_law
from gyroctl.simulation import evaluate

SEEDS = (1, 2, 3, 4)
BLEND = 100.0
GAIN = 1.01
"""Largest part of the pair's judged power that a raid may show. [-]"""


class Raid(NamedTuple):
    """The best constant pair, and other controls from `begin` to `end`."""

    begin: float  # [s]
    end: float  # [s]
    raid_cc: float  # [Nms]
    raid_cg: float  # [Nms]
    cc: float  # [Nms]
    cg: float  # [Nms]
    period: float = 0.1  # [s]

    @property
    def information(self) -> str:
        return "none"

    def init(self) -> float:
        return 0.0

    def step(self, t: float, y: Any, state: float) -> tuple[tuple[float, float], float]:
        if self.begin <= t < self.end:
            return (self.raid_cc, self.raid_cg), state
        return (self.cc, self.cg), state
