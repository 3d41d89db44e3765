"""The laws by rules as they ship, by name."""

from __future__ import annotations

from typing import Any

from gyroctl.controllers.rule_based import Coupling, LoadAngle, Stabiliser, Threshold, Tracking

LAWS: dict[str, Any] = {
    "threshold": Threshold(),
    "load_angle": LoadAngle(),
    "stabiliser": Stabiliser(),
    "tracking": Tracking(),
    "coupling": Coupling(),
}
