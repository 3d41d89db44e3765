"""A device of another length: a window is searched on its model at the size of Table 1 and told in its own units.

The search has scales, prices and steps in the units of Table 1; by Froude's law what is best there is best here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from gyroctl.devices.scaling import at_model_size
from gyroctl.errors import InputError
from gyroctl.froude import growth
from gyroctl.plant import Plant
from gyroctl.studies.bound.cut import SETTINGS, Cut, check_duration, cut
from gyroctl.waves import SeaState
from gyroctl.waves.physical import check_sea

WATTS: tuple[str, ...] = (
    "harvest_w",
    "mean_power",
    "generated_w",
    "flywheel_w",
    "stored_w",
    "slip_loss_w",
    "wave_input_w",
)
WATTS += ("absorbed_w", "planned_w", "before_w", "after_w", "cap_w", "linear_cap_w")
UNITS = {**dict.fromkeys(WATTS, "W"), "momentum_max_nms": "Nms", "flywheel_max": "rad/s"}
"""Units of the numbers of a window that have one; the others are angles, shares and counts."""


def model_cut(plant: Plant, sea: SeaState, seed: int, duration: float, lag: float | None, motion: float | None) -> Cut:
    """Cut a window of a device's sea out of that of its model; arguments and errors as of `cut`, in its own units."""
    length, time = plant.parameters.length_scale, plant.parameters.time_scale
    if length == 1.0:
        return cut(plant, sea, seed, duration, lag, motion)
    check_duration(plant, duration)
    check_sea(plant, sea)
    small = SeaState(sea.hs / length, sea.wp * time, sea.gamma, sea.heading)
    samples = math.ceil(duration / time / SETTINGS.actuators.period - 1e-9)
    whole = round(samples * SETTINGS.actuators.period, 9)
    try:
        return cut(at_model_size(plant), small, seed, whole, None if lag is None else lag / time, motion)
    except InputError as error:
        value = sea.hs if error.field == "hs" else error.value
        raise InputError(error.field, value, error.problem, error.mend) from None


def in_own_units(told: Any, length: float) -> Any:
    """Numbers of a window of the model in the units of a device `length` times as long."""
    if length == 1.0 or not isinstance(told, Mapping):
        return told
    return {key: _grown(key, value, length) for key, value in told.items()}


def _grown(key: str, value: Any, length: float) -> Any:
    if key in UNITS and isinstance(value, float):
        return value * growth(UNITS[key], length)
    return in_own_units(value, length)
