"""What was found in one window: the bounds, the laws' runs, the cap."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from gyroctl.simulation.metrics import Record
from gyroctl.studies.bound.cap import absorbed
from gyroctl.studies.bound.cut import Cut
from gyroctl.studies.bound.search import MOTION, Found

SHOWN = (
    "harvest_w",
    "mean_power",
    "flywheel_w",
    "stored_w",
    "power_cv",
    "phi1_p98",
    "phi3_p98",
    "slip_loss_w",
    "wave_input_w",
    "cycle_slips",
    "flywheel_max",
)


@dataclass(frozen=True)
class Window:
    """What was found in one window.

    Parameters
    ----------
    cut : Cut
        The window.
    bounds : mapping of str to Found
        By `NAMES`.
    laws : mapping of str to Record
        Runs of the laws.
    momentum : float
        Largest angular momentum in any of these runs. [Nms]
    cap_w : float
        No law with no more than that can take more from the float. [W]
    """

    cut: Cut
    bounds: Mapping[str, Found]
    laws: Mapping[str, Record]
    momentum: float
    cap_w: float

    def record(self) -> dict[str, Any]:
        """Numbers for JSON."""
        plant = self.cut.plant
        content: dict[str, Any] = {
            "seed": self.cut.waves.seed,
            "sha256": self.cut.sha256,
            "cap_w": self.cap_w,
            "momentum_max_nms": self.momentum,
            "bounds": {},
            "laws": {},
        }
        for name, found in self.bounds.items():
            content["bounds"][name] = {
                **_shown(found.values),
                "absorbed_w": absorbed(plant, found.record),
                "planned_w": found.planned_w,
                "origin": found.origin,
                "starts": {start: {"before_w": pair[0], "after_w": pair[1]} for start, pair in found.starts.items()},
            }
        for name, run in self.laws.items():
            values = self.cut.worth(run)
            content["laws"][name] = {
                **_shown(values),
                "absorbed_w": absorbed(plant, run),
                "locked": bool(values["locked"]),
                "within_motion_limit": max(values["phi1_p98"], values["phi3_p98"]) <= MOTION,
                "fraction": {
                    bound: values["harvest_w"] / found.values["harvest_w"] for bound, found in self.bounds.items()
                },
            }
        return content


def _shown(values: Mapping[str, float]) -> dict[str, float]:
    return {key: values[key] for key in SHOWN}
