"""The device of Zhang et al. (2017) with the shipped hydrodynamics, in the corrected form or as printed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from gyroctl.errors import InputError
from gyroctl.hydrodynamics import Hydrodynamics, excitation_table, load, shipped
from gyroctl.hydrodynamics.floating import floating
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
    "realistic": {
        "generator_reaction": False,
        "lever_gyroscopic": True,
        "d1": 2.0,
        "radiation": "accurate",
        "excitation_phase": "complex",
        "position": "moving",
        "wetted": "surface",
        "drag": 0.5,
        "contact": "friction",
        "traction": 0.6,
        "coupling_cap": 2.0,
        "bearing": 0.01,
        "windage": 9.1e-7,
        "rolling_resistance": 1e-5,
        "generator_efficiency": 1.0,
    },
}
"""The named choices of each variant. Two misprints are in neither, since the paper's own figures contradict them: the
sign of (28), with which radiation would feed the motion, and power as cg omega' instead of cg omega'^2."""


def zhang2017(
    variant: str = "corrected", hydrodynamics: Hydrodynamics | Path | str | None = None, **changes: Any
) -> Plant:
    """Build the plant of the paper.

    Parameters
    ----------
    variant : {"corrected", "paper", "realistic"}
        "corrected": complex excitation, no double generator reaction, lever term on, hinge damping d1 = 2 Nms/rad,
        radiation fit that is right at the frequency of the horizontal mode. "paper": everything as printed.
        "realistic": corrected, and what the linear model leaves out, with plausible values.
    hydrodynamics : Hydrodynamics or path, optional
        A database of one's own, see ``gyroctl hydro import``; k3, Jh1 and Jh3 are then taken from it. One without k3
        needs it among the changes.
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
    if not isinstance(variant, str) or variant not in VARIANTS:
        raise InputError("plant.variant", variant, "unknown variant", f"Choose one of {', '.join(VARIANTS)}")
    table = shipped()
    own: dict[str, Any] = {}
    if hydrodynamics is not None:
        table = hydrodynamics if isinstance(hydrodynamics, Hydrodynamics) else load(hydrodynamics)
        own = {"Jh1": float(table.added_mass_inf[0]), "Jh3": float(table.added_mass_inf[1])}
        if table.stiffness > 0.0:
            own["k3"] = float(table.stiffness)
        elif "k3" not in changes:
            problem = "is unknown to this hydrodynamic database, and that of Table 1 belongs to another float"
            raise InputError("plant.k3", 0.0, problem, "Import it with --stiffness, or give k3 of the device")
    choices = {**VARIANTS[variant], **own, **changes}
    radiation = choices.pop("radiation")
    phase = choices.pop("excitation_phase")
    told = _choices_in_words(variant, radiation, phase, hydrodynamics)
    if isinstance(radiation, str):
        if radiation not in table.fits:
            mend = f"Choose one of {', '.join(table.fits)}, or give a pair of Radiation"
            raise InputError("plant.radiation", radiation, "unknown radiation fit", mend)
        radiation = tuple(Radiation(tuple(p), tuple(q)) for p, q in table.fits[radiation])
    if phase not in ("complex", "magnitude"):
        raise InputError("plant.excitation_phase", phase, "unknown form", "Choose complex or magnitude")
    excitation = excitation_table(table, phase=phase)
    usual = {name: value for name, value in {**VARIANTS[variant], **own}.items() if name in choices}
    parameters = replace(Parameters(), **usual)
    name, geometry = ", ".join([f"zhang2017 {variant}", *told]), floating(table)
    plant = Plant(parameters, radiation, excitation, name, table.depth, geometry=geometry)
    return plant.replace(**choices)


def _choices_in_words(variant: str, radiation: Any, phase: str, hydrodynamics: Any) -> list[str]:
    """What was chosen beside the numbers, where the variant has it otherwise."""
    usual, words = VARIANTS[variant], []
    if radiation != usual["radiation"]:
        words.append(f"radiation = {radiation}" if isinstance(radiation, str) else "own radiation")
    if phase != usual["excitation_phase"]:
        words.append(f"excitation_phase = {phase}")
    if isinstance(hydrodynamics, Path | str):
        words.append(f"hydrodynamics of {Path(hydrodynamics).name}")
    elif hydrodynamics is not None:
        words.append("own hydrodynamics")
    return words
