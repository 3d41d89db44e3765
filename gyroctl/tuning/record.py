"""On what a law was tuned, and how a set of its parameters was found: what ships beside the numbers."""

from __future__ import annotations

import datetime
import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from gyroctl.devices.identity import identity
from gyroctl.plant import Plant
from gyroctl.statistics import wilson
from gyroctl.tuning.goal import Goal
from gyroctl.tuning.stages import Means, Seen
from gyroctl.tuning.task import Task, TuningSea
from gyroctl.tuning.waters import LINEAR, Circumstances
from gyroctl.version import VERSION


def record(
    best: Seen, goals: Mapping[str, Goal], seas: Mapping[str, TuningSea], task: Task, found: Mapping[str, Any]
) -> dict[str, Any]:
    """One set as it ships."""
    return {
        "parameters": best.parameters,
        "goal": {
            name: {key: limit for key, limit in asdict(goals[name]).items() if np.isfinite(limit)} for name in seas
        },
        "met": {name: goals[name].met(best.means[name]) for name in seas},
        "result": {name: result(best.means[name], task.seeds.count) for name in seas},
        "found": dict(found),
    }


def result(means: Means, runs: int) -> dict[str, Any]:
    """Means as they ship, with the Wilson interval of the lock probability."""
    share = wilson(round(means["locked"] * runs), runs)
    rounded = {name: float(f"{value:.4g}") for name, value in means.items() if name != "short_reserve"}
    return {**rounded, "runs": runs, "locked_ci95": [round(share.low, 4), round(share.high, 4)]}


def provenance(task: Task, on: Circumstances) -> dict[str, Any]:
    """Circumstances of a tuning: date, version, seeds, rule, seas, start, plant, water with the coupling's lag [s]."""
    return {
        "date": datetime.date.today().isoformat(),
        "version": VERSION,
        "seeds": {"first": task.seeds.span[0], "last": task.seeds.span[-1]},
        "method": task.method,
        "rule": " ".join((Goal.score.__doc__ or "").split()),
        "seas": {name: asdict(sea) for name, sea in task.seas.items()},
        "start": {knob.name: knob.start for knob in task.knobs},
        "plant": on.plant.name,
        "plant_sha256": plant_hash(on.plant),
        "hydrodynamics_sha256": on.plant.excitation.sha256,
        "device_sha256": identity(on.plant),
        **({} if task.water == LINEAR else {"water": task.water, "cc_lag": on.settings.actuators.cc_lag}),
    }


def plant_hash(plant: Plant) -> str:
    """SHA-256 of every number of the plant's equations, and of its length where that is not Table 1's."""
    own = asdict(plant.parameters)
    if plant.parameters.length_scale == 1.0:
        del own["length_scale"]
    return hashlib.sha256(json.dumps([plant.coefficients, own, *plant.water]).encode()).hexdigest()
