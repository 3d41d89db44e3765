"""The picture of a device: float, lever, ring and flywheel in their water, from the side."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from gyroctl.plant import Plant
from gyroctl.studies.device.bodies import gyration
from gyroctl.studies.style import INK, MUTED, label, sheet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INCLINATION, ABOVE = 10.0, 0.208
"""Lever below the horizontal [deg], and height of the hinge above the water at the size of Table 1 [m], where the
hydrodynamics hold no geometry."""

WATER, FLOAT, RING, WHEEL = "#B9D7EA", "#0072B2", "#B5472F", "#8C6BB1"


def draw(plant: Plant) -> Figure:
    """Draw the device from the side, to scale."""
    p, geometry = plant.parameters, plant.geometry
    hull: Any = None if geometry is None else geometry.hull
    slope = math.radians(INCLINATION if hull is None else hull.inclination)
    along = np.array([math.cos(slope), -math.sin(slope)])
    hinge = np.array([-(p.a + p.b) * along[0], ABOVE * p.length_scale])
    if hull is not None:
        hinge = np.array([hull.hinge[1], hull.hinge[2]])
    note = f"{plant.name}; ring and flywheel by r2 and by the radius of gyration; "
    note += "float as its hydrodynamics have it" if hull is not None else "float by c and d, its place assumed"
    figure, (axes,) = sheet(1, 1, (7.5, 4.5), "Geometry of the device", note)
    centre = hinge + (p.a + p.b) * along
    _water(axes, plant, hinge, p.d + p.c)
    axes.plot(*zip(hinge, centre, strict=True), color=INK, lw=2.5)
    axes.plot(*hinge, "o", color=INK)
    axes.annotate("hinge", (float(hinge[0]), float(hinge[1])), xytext=(4, 6), textcoords="offset points", color=MUTED)
    outline = _capsule(p.c, p.d, along, centre) if hull is None else _shadow(hull)
    axes.fill(*outline, facecolor="none", edgecolor=FLOAT, lw=1.8, label="float")
    for radius, colour, name in ((p.r2, RING, "ring"), (gyration(p.J14, p.m4), WHEEL, "flywheel")):
        turn = np.linspace(0.0, 2.0 * np.pi, 121)
        axes.plot(centre[0] + radius * np.cos(turn), centre[1] + radius * np.sin(turn), color=colour, label=name)
    axes.set_aspect("equal")
    axes.legend(loc="upper right")
    label(axes, "", "from the float, away from the hinge [m]", "above the mean water level [m]")
    return figure


def _water(axes: Axes, plant: Plant, hinge: Any, size: float) -> None:
    """Water from its mean level to the ground, or as deep as the picture goes."""
    left, right = hinge[0] - 0.5 * size, 1.5 * size
    deep = min(plant.depth, 2.0 * size)
    axes.fill_between([left, right], [-deep, -deep], [0.0, 0.0], color=WATER, alpha=0.5, linewidth=0)
    axes.axhline(0.0, color=FLOAT, lw=0.8)
    if deep == plant.depth:
        axes.axhline(-deep, color=INK, lw=2.0)
        axes.annotate("ground", (left, -deep), xytext=(4, 4), textcoords="offset points", color=MUTED)
    axes.set_xlim(left, right)


def _capsule(c: float, d: float, along: Any, centre: Any) -> tuple[Any, Any]:
    """Outline of two half circles of diameter `d`, `c` apart along the lever."""
    turn = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 61)
    right = np.stack([0.5 * c + 0.5 * d * np.cos(turn), 0.5 * d * np.sin(turn)])
    x, y = np.concatenate([right, -right], axis=1)
    across = np.array([-along[1], along[0]])
    points = centre[:, None] + along[:, None] * x + across[:, None] * y
    return points[0], points[1]


def _shadow(hull: Any) -> tuple[Any, Any]:
    """Outline of a hull seen along the paper's axis x3."""
    from scipy.spatial import ConvexHull

    points = hull.vertices[:, 1:]
    order = ConvexHull(points).vertices
    return points[order, 0], points[order, 1]
