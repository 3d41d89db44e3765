"""The device of Zhang et al. (2017) with the shipped hydrodynamics, in the corrected form or as printed."""

from __future__ import annotations

from typing import Any

from gyroctl.errors import InputError
from gyroctl.hydrodynamics import excitation_table, shipped, shipped_fit
from gyroctl.plant import Parameters, Plant, Radiation

VARIANTS: dict[str, dict[str, Any]] = {
    "corrected": {
        "generator_reaction": False,
        "lever_gyroscopic": True,
        "d1": 2.0,
        "radiation": "accurate",
        "excitation_phase": "complex",
    },
    "paper": {
        "generator_reaction": True,
        "lever_gyroscopic": False,
        "d1": 0.0,
        "radiation": "paper",
        "excitation_phase": "magnitude",
    },
}
"""The named choices of each variant. Two misprints are in neither, since the paper's own figures contradict them: the
sign of (28), with which radiation would feed the motion, and power as cg omega' instead of cg omega'^2."""


def zhang2017(variant: str = "corrected", **changes: Any) -> Plant:
    """Build the plant of the paper.

    Parameters
    ----------
    variant : {"corrected", "paper"}
        "corrected": complex excitation, no double generator reaction, lever term on, hinge damping d1 = 2 Nms/rad,
        radiation fit that is right at the frequency of the horizontal mode. "paper": everything as printed.
    **changes
        Any single choice: a field of `Parameters`, ``radiation`` ("accurate", "paper", "fine", or a pair of
        `Radiation`) or ``excitation_phase`` ("complex", "magnitude").

    Returns
    -------
    Plant

    Raises
    ------
    InputError
        For an unknown variant or choice, or a value outside its range.
    """
    if variant not in VARIANTS:
        raise InputError("plant.variant", variant, "unknown variant", f"Choose one of {', '.join(VARIANTS)}")
    choices = {**VARIANTS[variant], **changes}
    radiation = choices.pop("radiation")
    phase = choices.pop("excitation_phase")
    if isinstance(radiation, str):
        if radiation not in ("accurate", "paper", "fine"):
            raise InputError("plant.radiation", radiation, "unknown radiation fit",
                             "Choose accurate, paper or fine, or give a pair of Radiation")  # fmt: skip
        first, third = shipped_fit(radiation)
        radiation = (Radiation(tuple(first.p), tuple(first.q)), Radiation(tuple(third.p), tuple(third.q)))
    if phase not in ("complex", "magnitude"):
        raise InputError("plant.excitation_phase", phase, "unknown form", "Choose complex or magnitude")
    hydrodynamics = shipped()
    excitation = excitation_table(hydrodynamics, phase=phase)
    plant = Plant(Parameters(), radiation, excitation, f"zhang2017 {variant}", hydrodynamics.depth)
    return plant.replace(**choices)
