"""Real water: the device with what the linear model leaves out, one choice at a time and all together.

The laws stay as they are and plan with the linear device. Every case is a row of a table, no code.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

from gyroctl.devices import zhang2017
from gyroctl.harness.run import Settings
from gyroctl.plant import Plant

LINEAR = "linear"


class Water(NamedTuple):
    """A device as it is simulated, by what it has beyond the linear one."""

    name: str  # in the table
    choices: Mapping[str, Any]  # of `gyroctl.zhang2017`
    lag: float = 0.0  # time constant of the coupling [s]
    single: bool = True  # one choice alone; else several together

    def plant(self) -> Plant:
        """Build the device."""
        return zhang2017(**self.choices)

    def settings(self, given: Settings) -> Settings:
        """Sensors and actuators: those of the linear case, with the lag where there is one."""
        return replace(given, actuators=replace(given.actuators, cc_lag=self.lag)) if self.lag > 0.0 else given


MOVING: Mapping[str, Any] = {"position": "moving"}
SURFACE: Mapping[str, Any] = {**MOVING, "wetted": "surface"}
LOSSES: Mapping[str, Any] = {"bearing": 0.02, "windage": 9.1e-7, "rolling_resistance": 2e-5}
HALF_LOSSES: Mapping[str, Any] = {"bearing": 0.01, "windage": 9.1e-7, "rolling_resistance": 1e-5}

WATERS = (
    Water(LINEAR, {}),
    Water("drag 0.5", {"drag": 0.5}),
    Water("drag 1.0", {"drag": 1.0}),
    Water("moving position", MOVING),
    Water("moving, drag 0.5", {**MOVING, "drag": 0.5}, single=False),
    Water("reduced, drag 0.5", {"wetted": "reduced", "drag": 0.5}, single=False),
    Water("moving, reduced, drag 0.5", {**MOVING, "wetted": "reduced", "drag": 0.5}, single=False),
    Water("moving, surface", SURFACE, single=False),
    Water("moving, surface, drag 0.5", {**SURFACE, "drag": 0.5}, single=False),
    Water("friction 0.3", {"contact": "friction", "traction": 0.3}),
    Water("friction 0.6", {"contact": "friction", "traction": 0.6}),
    Water("losses", LOSSES),
    Water("lag 20 ms", {}, lag=0.02),
    Water("lag 50 ms", {}, lag=0.05),
    Water("lag 100 ms", {}, lag=0.1),
    Water("lag 200 ms", {}, lag=0.2),
    Water("torque falls at 20 rad/s", {"coupling_slip": 20.0}),
    Water("torque to 2 Nm", {"coupling_cap": 2.0}),
    Water(
        "all, without a cap",
        {**SURFACE, "drag": 0.5, "contact": "friction", "traction": 0.6, **HALF_LOSSES},
        lag=0.02,
        single=False,
    ),
    Water("all: realistic", {"variant": "realistic"}, lag=0.02, single=False),
)
"""Every case, the linear one first. "all" lags by 20 ms; without a cap it is "realistic" but for the cap of 2 Nm."""


REALISTIC = WATERS[-1]
"""All of it."""


def in_words(water: Water) -> str:
    """Say what a case is, setting by setting."""
    told = [f"{name} = {value}" for name, value in water.choices.items()]
    told += [f"actuators.cc_lag = {water.lag:g} s"] if water.lag > 0.0 else []
    return ", ".join(told) or "nothing beyond the linear model"
