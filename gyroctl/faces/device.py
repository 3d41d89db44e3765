"""Faces of the device and its hydrodynamics: plant, parameters, excitation, table."""

from __future__ import annotations

import math
from dataclasses import fields
from typing import Any

import numpy as np

from gyroctl.faces.show import Face, number
from gyroctl.faces.svg import curves

NAMED = ("connection", "position", "wetted", "contact")
"""Choices that every plant tells."""

MASSES = (("a", "m"), ("b", "m"), ("c", "m"), ("d", "m"), ("r1", "m"), ("r2", "m"), ("m1", "kg"), ("m4", "kg"))
OMEGA = "frequency [rad/s]"


def plant_face(plant: Any) -> Face:
    """Tell a plant: name, model, choices; pictured by what the waves do to it."""
    p = plant.parameters
    orders = " and ".join(f"({len(r.p) - 1}, {len(r.q)})" for r in plant.radiation)
    facts = [
        ("states", str(len(plant.labels))),
        ("water", f"{plant.depth:g} m deep" if math.isfinite(plant.depth) else "deep"),
        ("hinge damping", f"d1 {p.d1:g}, d3 {p.d3:g} Nms/rad"),
        *((name, str(getattr(p, name))) for name in NAMED),
        ("radiation of order", orders),
        ("gear ratio", number(p.N)),
    ]
    facts += [("drag coefficient", number(p.drag))] if p.drag else []
    facts += [("length over that of Table 1", number(p.length_scale))] if p.length_scale != 1.0 else []
    return Face(f"Plant {plant.name}", facts, lambda: _moments(plant.excitation))


def parameters_face(p: Any) -> Face:
    """Tell the numbers of a device: the leading ones, and what is not the default."""
    facts = [(name, number(getattr(p, name), unit)) for name, unit in MASSES]
    changed = [f for f in fields(p) if getattr(p, f.name) != f.default and f.name not in dict(MASSES)]
    facts += [(f.name, _plain(getattr(p, f.name))) for f in changed]
    return Face("Parameters" if changed else "Parameters of Table 1", facts)


def excitation_face(excitation: Any) -> Face:
    """Tell an excitation table."""
    omega, headings = excitation.omega, excitation.headings
    facts = [
        ("frequencies", f"{omega.size} from {omega[0]:g} to {omega[-1]:g} rad/s"),
        ("headings", f"{headings.size} from {headings[0]:g} to {headings[-1]:g} deg"),
        ("phase", str(excitation.phase)),
        ("hash", excitation.sha256[:12]),
    ]
    return Face("Excitation", facts, lambda: _moments(excitation))


def hydrodynamics_face(table: Any) -> Face:
    """Tell a hydrodynamic table; pictured by its radiation damping."""
    omega, depth = table.omega, float(table.depth)
    facts = [
        ("frequencies", f"{omega.size} from {omega[0]:g} to {omega[-1]:g} rad/s"),
        ("headings", f"{table.headings.size} from {table.headings[0]:g} to {table.headings[-1]:g} deg"),
        ("water", f"{depth:g} m deep" if math.isfinite(depth) else "deep"),
        ("k3", number(table.stiffness, "Nm/rad")),
        ("added inertia at infinity", ", ".join(number(v) for v in table.added_mass_inf) + " kg m^2"),
        ("fits", ", ".join(map(str, table.fits)) or "none"),
        ("float", "with its hull" if table.hull is not None else "without its hull"),
    ]
    rows = {"phi1": table.damping[0], "phi3": table.damping[1]}
    return Face("Hydrodynamics", facts, lambda: curves(omega, rows, OMEGA, "radiation damping [Nms/rad]"))


def _moments(excitation: Any) -> str:
    omega = np.linspace(float(excitation.omega[0]), float(excitation.omega[-1]), 160)
    he = np.abs(excitation(omega))
    return curves(omega, {"|He1|": he[0], "|He3|": he[1]}, OMEGA, "moment [Nm/m]")


def _plain(value: Any) -> str:
    return number(value) if isinstance(value, int | float) and not isinstance(value, bool) else str(value)
