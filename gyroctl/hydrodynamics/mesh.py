"""Panels of the wetted float, graded towards the waterline, and of its internal lid."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.hydrodynamics.geometry import Geometry


class Panels(NamedTuple):
    """Quadrilaterals of one half of the body, x >= 0 (the other half is its mirror image)."""

    vertices: NDArray[np.float64]
    """(n_vertices, 3) [m]"""
    faces: NDArray[np.int64]
    """(n_faces, 4) indices; a triangle repeats one."""


def _distance_along(geometry: Geometry, height: float, rays: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distance from the origin (inside the float) to its surface along unit `rays` (n, 3)."""
    radius, half, axis = geometry.diameter / 2.0, geometry.cylinder / 2.0, geometry.axis
    centre = np.array([0.0, 0.0, height])
    best = np.zeros(len(rays))
    with np.errstate(invalid="ignore", divide="ignore"):
        for end in (-half, half):  # the two hemispheres
            offset = centre + end * axis
            b = rays @ offset
            best = np.fmax(best, b + np.sqrt(b**2 - offset @ offset + radius**2))
        # the cylinder between them; a convex body is left through the farthest of its parts
        across, side = rays - np.outer(rays @ axis, axis), centre - (centre @ axis) * axis
        a, b = np.sum(across**2, axis=1), across @ side
        t = (b + np.sqrt(b**2 - a * (side @ side - radius**2))) / a
        inside = np.abs(rays @ axis * t - centre @ axis) <= half
    return np.where(inside, np.fmax(best, t), best)


def _grid(points: NDArray[np.float64]) -> Panels:
    """Panels of a structured grid of points (rows, columns, 3)."""
    rows, columns, _ = points.shape
    index = np.arange(rows * columns).reshape(rows, columns)
    faces = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(-1, 4)
    return Panels(points.reshape(-1, 3), faces)


def hull(geometry: Geometry, height: float, around: int = 28, down: int = 17, grading: float = 1.8) -> Panels:
    """Wetted half of the float.

    Parameters
    ----------
    geometry : Geometry
        The float.
    height : float
        Centre of the float above the mean water level. [m]
    around, down : int
        Panels around half the waterline and from the waterline to the lowest point; 28 and 17 give 952 in all.
    grading : float
        Exponent that gathers the panels at the waterline, where the potential varies fastest; 1 spaces them evenly.

    Returns
    -------
    Panels
        Normals point into the water.
    """
    azimuth = np.linspace(-np.pi / 2.0, np.pi / 2.0, around + 1)
    dip = np.pi / 2.0 * np.linspace(0.0, 1.0, down + 1) ** grading
    d, a = np.meshgrid(dip, azimuth, indexing="ij")
    rays = np.stack([np.cos(d) * np.cos(a), np.cos(d) * np.sin(a), -np.sin(d)], axis=-1)
    rays[:, [0, -1], 0] = 0.0  # on the plane of symmetry exactly
    rays[-1] = (0.0, 0.0, -1.0)
    distance = _distance_along(geometry, height, rays.reshape(-1, 3)).reshape(d.shape)
    return _grid(rays * distance[..., None])


def lid(geometry: Geometry, height: float, around: int = 28, across: int = 7) -> Panels:
    """Half of the waterplane inside the float: it removes the irregular frequencies (from about 9 rad/s here)."""
    azimuth = np.linspace(-np.pi / 2.0, np.pi / 2.0, around + 1)
    rays = np.stack([np.cos(azimuth), np.sin(azimuth), 0.0 * azimuth], axis=-1)
    rays[[0, -1], 0] = 0.0
    rim = rays * _distance_along(geometry, height, rays)[:, None]
    inwards = np.linspace(1.0, 0.0, across + 1)  # from the rim: normals down, as on the hull
    return _grid(inwards[:, None, None] * rim)
