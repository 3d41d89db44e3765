"""What was found in one window, the bounds, the laws' runs, the cap; and the means over several windows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gyroctl.simulation.metrics import Record
from gyroctl.studies.bound.cap import absorbed
from gyroctl.studies.bound.cut import Cut
from gyroctl.studies.bound.search import Found, beyond_linear

POWERS = ("harvest_w", "mean_power", "generated_w", "flywheel_w", "stored_w")
SHOWN = (*POWERS, "power_cv", "phi1_p98", "phi3_p98", "slip_loss_w", "wave_input_w", "cycle_slips", "flywheel_max")
STEP = ("turns_kept", "outside_share", "phi1_max", "phi3_max")
"""Metrics of a run that are written."""

MEANS = ("harvest_w", "generated_w", "flywheel_w", "power_cv", "phi1_p98", "cycle_slips", "turns_kept", "outside_share")
"""Those of which the summary has the mean over the windows."""


@dataclass(frozen=True)
class Outcome:
    """What was found in one window."""

    cut: Cut
    bounds: Mapping[str, Found]  # "smooth", and "free" where it was asked for
    laws: Mapping[str, Record]  # their runs
    momentum: float  # largest angular momentum in any of these runs [Nms]
    cap_w: float  # no law with no more than that can take more from the float, where that is linear [W]

    def record(self) -> dict[str, Any]:
        """Numbers for JSON."""
        return {
            "seed": self.cut.waves.seed,
            "sha256": self.cut.sha256,
            **self.caps(),
            "motion_limits_rad": self.cut.motion._asdict(),
            "momentum_max_nms": self.momentum,
            "bounds": {name: self._of_bound(found) for name, found in self.bounds.items()},
            "laws": {name: self._of_law(run) for name, run in self.laws.items()},
        }

    def caps(self) -> dict[str, float | None]:
        """The cap, and by what name: beyond the linear plant none is known, and that of the linear one stands beside.

        Its proof needs a float whose answer is linear, in moments that do not depend on where it is.
        """
        linear = not beyond_linear(self.cut.plant)
        return {"cap_w": self.cap_w if linear else None, "linear_cap_w": None if linear else self.cap_w}

    def _of_bound(self, found: Found) -> dict[str, Any]:
        return {
            **{key: found.values[key] for key in (*SHOWN, *STEP)},
            "absorbed_w": absorbed(self.cut.plant, found.record),
            "planned_w": found.planned_w,
            "origin": found.origin,
            "starts": {start: {"before_w": pair[0], "after_w": pair[1]} for start, pair in found.starts.items()},
        }

    def _of_law(self, run: Record) -> dict[str, Any]:
        values = self.cut.worth(run)
        harvest = values["harvest_w"]
        return {
            **{key: values[key] for key in (*SHOWN, *STEP)},
            "absorbed_w": absorbed(self.cut.plant, run),
            "locked": bool(values["locked"]),
            "within_motion_limit": self.cut.motion.room(values) >= 0.0,
            "fraction": {bound: harvest / found.values["harvest_w"] for bound, found in self.bounds.items()},
        }


def summary(windows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Means over the records of windows; fractions are those of the means."""
    bounds = {}
    for name in windows[0]["bounds"]:
        found = [w["bounds"][name] for w in windows]
        bounds[name] = {key: _mean(found, key) for key in (*MEANS, "absorbed_w")} | _largest(found)
    laws = {}
    for name in windows[0]["laws"]:
        runs = [w["laws"][name] for w in windows]
        means = {key: _mean(runs, key) for key in MEANS} | _largest(runs)
        laws[name] = {
            **means,
            "locked": sum(run["locked"] for run in runs),
            "within_motion_limit": sum(run["within_motion_limit"] for run in runs),
            "runs": len(runs),
            "fraction": {bound: means["harvest_w"] / bounds[bound]["harvest_w"] for bound in bounds},
            "fraction_lowest": {bound: min(run["fraction"][bound] for run in runs) for bound in bounds},
        }
    caps = {name: None if windows[0][name] is None else _mean(windows, name) for name in ("cap_w", "linear_cap_w")}
    limits = {
        name: [min(column), max(column)]
        for name in ("phi1", "phi3")
        for column in [[w["motion_limits_rad"][name] for w in windows]]
    }
    return {**caps, "motion_limits_rad": limits, "bounds": bounds, "laws": laws}


def _largest(rows: Sequence[Mapping[str, Any]]) -> dict[str, float]:
    return {key: float(np.max([row[key] for row in rows])) for key in ("phi1_max", "phi3_max")}


def _mean(rows: Sequence[Mapping[str, Any]], key: str) -> float:
    return float(np.mean([row[key] for row in rows]))
