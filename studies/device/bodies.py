"""Whether the masses and inertias of a device can be those of bodies that fit into its float."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from gyroctl.plant import Parameters, Plant

FLYWHEEL, RING = "J14 and m4", "J22 and m2"


class Finding(NamedTuple):
    """One line of a check."""

    name: str
    found: str
    passed: bool = True
    mend: str = ""


def bodies(plant: Plant) -> list[Finding]:
    """Judge each body: a radius of gyration within what holds it, the triangle of inertias, and what floats."""
    p = plant.parameters
    return [
        _fits("flywheel", "J14", "m4", p.J14, p.m4, p.r2, "the ring's radius r2"),
        _fits("ring", "J22", "m2", p.J22, p.m2, 0.5 * p.d, "half the diameter d of the float"),
        _fits("spin axis", "J13", "m3", p.J13, p.m3, p.r2, "the ring's radius r2"),
        _fits("float and lever", "J11", "m1", p.J11, p.m1, p.a + p.b + 0.5 * (p.c + p.d), "the device's length"),
        _ring_in_float(p),
        *_triangles(p),
        *_floats(plant),
    ]


def gyration(inertia: float, mass: float) -> float:
    """Radius of gyration of a body. [m]"""
    return math.sqrt(inertia / mass)


def _fits(body: str, inertia: str, mass: str, J: float, m: float, room: float, where: str) -> Finding:
    radius = gyration(J, m)
    found = f"radius of gyration {radius:.3g} m, {where} is {room:.3g} m"
    mend = f"Lower {inertia} to {m * room**2:.3g} kg m^2 or raise {mass}: no body has its mass outside itself"
    return Finding(f"{body} ({inertia}, {mass})", found, radius <= room, mend)


def _ring_in_float(p: Parameters) -> Finding:
    found = f"r2 = {p.r2:.3g} m in a float of diameter {p.d:.3g} m"
    return Finding("ring within the float", found, p.r2 < 0.5 * p.d, "Make the ring smaller or the float larger")


def _triangles(p: Parameters) -> list[Finding]:
    """No principal inertia of a body is above the sum of the other two.

    (16) takes J11 across the lever for both axes, and ring, axis and flywheel as discs, each with half of its own
    inertia across. A float that holds them turns about the lever with no less than they do: what turns about the lever
    must stay below twice what the float has across it. And a flywheel that lies within the ring cannot have more about
    the lever than the whole.
    """
    along, across = p.lever_inertia, 2.0 * p.J11
    share = 0.5 * p.J14 / p.J11
    return [
        Finding(
            "triangle of inertias",
            f"ring, axis and flywheel have {along:.3g} kg m^2 about the lever; twice J11, across it, is {across:.4g}",
            along <= across,
            "Lower J22, J13 or J14, or raise J11",
        ),
        Finding(
            "flywheel against the float",
            f"across the lever the flywheel has {share:.2%} of J11",
            share <= 1.0,
            "Raise J11 or lower J14: the float turns with the flywheel in it",
        ),
    ]


def _floats(plant: Plant) -> list[Finding]:
    """Whether the float, all of it under water, carries the moment of the weights about the hinge."""
    geometry: Any = plant.geometry
    if geometry is None:
        return []
    p = plant.parameters
    weights = p.m1 * p.a + (p.m2 + p.m3 + p.m4) * (p.a + p.b)
    carried = geometry.rho * geometry.hull.volume * (p.a + p.b)
    return [
        Finding(
            "float carries the device",
            f"weights take {weights / carried:.0%} of what the hull carries when it is all under water",
            weights < carried,
            "Lower the masses, or give the hydrodynamics of a larger float",
        )
    ]
