"""The whole outer surface of a float in panels, wet and dry, and the hinge it turns about.

Axes and origin are those of `geometry`: x along the paper's x3, y from the hinge to the float, z up, the origin on the
mean water level plumb below the centre of the float, to which the elevation of the waves is referred. Everything is
given at rest.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.geometry import Geometry, Statics, statics

Floats = NDArray[np.float64]

SIZE_MAX = 1e4
"""Farthest corner of a float. [m]"""

AROUND, ALONG = 32, 16
"""Panels around the capsule and from a pole to the end of its hemisphere; with four rings of the cylinder, 1152."""


class Patches(NamedTuple):
    """What integrals over the surface need of each panel; vectors point from the hinge."""

    centres: Floats
    """(n, 3) [m]"""
    normals: Floats
    """Outward unit normals times area, (n, 3). [m^2]"""
    spread: Floats
    """Second moments of the panel about its centre over its area, (n, 3, 3). [m^2]"""


@dataclass(frozen=True, eq=False)
class Hull:
    """Closed surface of a float at rest.

    Parameters
    ----------
    vertices : ndarray (n, 3)
        Corners of the panels. [m]
    faces : ndarray (m, 4) of int
        Corners of each panel, counter-clockwise seen from the water; a triangle repeats one.
    hinge : ndarray (3,)
        Position of the hinge; its x is 0. [m]
    inclination : float
        Angle of the lever below the horizontal, from the hinge down to the float. [deg]

    Raises
    ------
    InputError
        When the panels do not enclose a volume, or the hinge is no place to turn about.
    """

    vertices: Floats
    faces: NDArray[np.int64]
    hinge: Floats
    inclination: float

    def __post_init__(self) -> None:
        """Refuse what encloses no volume; panels that all face inwards are turned."""
        mend = "Give the whole float, closed above the water too, as a mesh that Capytaine reads"
        shapes = self.vertices.ndim == self.faces.ndim == 2 and self.vertices.shape[1:] == (3,)
        if not shapes or self.faces.shape[1:] != (4,) or not np.all(np.isfinite(self.vertices)):
            raise InputError("hull", self.faces.shape, "must be panels of four corners in three coordinates", mend)
        if not self.faces.size or self.faces.min() < 0 or self.faces.max() >= len(self.vertices):
            raise InputError("hull", len(self.vertices), "has panels with corners that it does not hold", mend)
        if np.max(np.abs(self.vertices)) > SIZE_MAX or not abs(self.inclination) <= 90.0:
            problem = f"reaches beyond {SIZE_MAX:g} m, or its lever beyond the vertical"
            raise InputError("hull", float(np.max(np.abs(self.vertices))), problem, "Give metres and degrees")
        if self.hinge.shape != (3,) or not np.all(np.isfinite(self.hinge)) or abs(self.hinge[0]) > 1e-9:
            problem = "must be three coordinates in the plane x = 0"
            raise InputError("hull.hinge", self.hinge, problem, "Give it from the water level below the float's centre")
        if not self.reach > 0.0:
            mend_hinge = "Give y of the hinge negative: y points from the hinge to the float"
            raise InputError("hull.hinge", self.hinge, "must lie on the side y < 0 of the float", mend_hinge)
        area = self.patches.normals
        gap, whole = float(np.abs(area.sum(axis=0)).max()), float(np.linalg.norm(area, axis=1).sum())
        if gap > 1e-3 * whole or abs(self.volume) < 1e-9:
            raise InputError("hull", gap, "is not closed: the areas of its panels do not add up to zero", mend)
        if self.volume < 0.0:
            object.__setattr__(self, "faces", np.ascontiguousarray(self.faces[:, ::-1]))
            self.__dict__.pop("patches"), self.__dict__.pop("volume")

    @property
    def reach(self) -> float:
        """Horizontal distance from the hinge to the centre of the float, l = (a + b) cos(inclination). [m]"""
        return float(-self.hinge[1])

    @cached_property
    def patches(self) -> Patches:
        """Centres, normals and spreads of the panels."""
        return _patches(self.vertices[self.faces] - self.hinge)

    @cached_property
    def volume(self) -> float:
        """Enclosed volume. [m^3]"""
        return float(np.sum(self.patches.centres * self.patches.normals) / 3.0)


def _patches(corners: Floats) -> Patches:
    """Patches of quadrilaterals (n, 4, 3), each as the two triangles it is made of."""
    triangles = np.stack([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]], axis=1)  # (n, 2, 3, 3)
    edges = triangles[:, :, 1:] - triangles[:, :, :1]
    vector = 0.5 * np.cross(edges[:, :, 0], edges[:, :, 1])
    area = np.linalg.norm(vector, axis=-1)
    total = np.maximum(area.sum(axis=1), 1e-300)
    middles = triangles.mean(axis=2)
    centres = np.einsum("nt,ntk->nk", area, middles) / total[:, None]
    normals = vector.sum(axis=1)
    # a triangle's second moment about a point: a twelfth of its corners' and three quarters of its middle's
    off = triangles - centres[:, None, None]
    middle = middles - centres[:, None]
    second = np.einsum("ntci,ntcj->ntij", off, off) / 12.0 + 0.75 * np.einsum("nti,ntj->ntij", middle, middle)
    spread = np.einsum("nt,ntij->nij", area, second) / total[:, None, None]
    return Patches(centres, normals, spread)


def capsule(geometry: Geometry, rest: Statics | None = None, around: int = AROUND, along: int = ALONG) -> Hull:
    """Panels of the two hemispheres and the cylinder between them, axis along the lever.

    The corners stand as far outside the true surface as flat panels between them need to enclose its volume, so that
    volumes and stiffness converge twice as fast.

    Parameters
    ----------
    geometry : Geometry
        The float.
    rest : Statics, optional
        Its rest position; computed where it is not given.
    around, along : int
        Panels around the axis, and from a pole to the end of its hemisphere.

    Returns
    -------
    Hull
    """
    rest = rest or statics(geometry)
    radius, half = geometry.diameter / 2.0, geometry.cylinder / 2.0
    rings = max(1, round(geometry.cylinder / (radius * np.pi / (2 * along)))) if half > 0.0 else 0
    polar = np.linspace(0.0, np.pi / 2.0, along + 1)
    ends = [(-half - radius * np.cos(a), radius * np.sin(a)) for a in polar]
    ends += [(-half + 2.0 * half * i / rings, radius) for i in range(1, rings)]
    first = polar[1:] if rings == 0 else polar
    ends += [(half + radius * np.sin(a), radius * np.cos(a)) for a in first]
    s, r = np.array(ends).T
    turn = 2.0 * np.pi * np.arange(around) / around
    axis = geometry.axis
    normal = np.array([0.0, -axis[2], axis[1]])
    ring = np.cos(turn)[:, None] * np.array([1.0, 0.0, 0.0]) + np.sin(turn)[:, None] * normal
    points = s[:, None, None] * axis + r[:, None, None] * ring
    rows = np.arange(len(s) * around).reshape(len(s), around)
    after = np.roll(rows, -1, axis=1)
    faces = np.stack([rows[:-1], rows[1:], after[1:], after[:-1]], axis=-1).reshape(-1, 4)
    centre = np.array([0.0, 0.0, rest.height])
    plain = Hull(points.reshape(-1, 3) + centre, faces, geometry.hinge(rest.height), geometry.inclination)
    exact = np.pi * radius**2 * (2.0 * half) + 4.0 / 3.0 * np.pi * radius**3
    larger = (exact / plain.volume) ** (1.0 / 3.0)
    return replace(plain, vertices=np.ascontiguousarray(points.reshape(-1, 3) * larger + centre))


def read_hull(path: Path | str, hinge: tuple[float, float], inclination: float = 0.0) -> Hull:
    """Read a mesh of the whole float from a file that Capytaine can read (extra `bem`).

    Parameters
    ----------
    path : Path or str
        Mesh in metres at rest, in the axes of this package.
    hinge : pair of float
        y and z of the hinge. [m]
    inclination : float
        Angle of the lever below the horizontal. [deg]

    Returns
    -------
    Hull

    Raises
    ------
    InputError
        When the file is missing or unreadable, Capytaine is not installed, or the mesh is not closed.
    """
    file = Path(path)
    if not file.is_file():
        raise InputError("hull", str(path), "there is no such file", "Check the path of the mesh")
    try:
        import capytaine
    except ImportError as error:
        raise InputError("hull", "capytaine", "is not installed", "Run: pip install 'gyroctl[bem]'") from error
    try:
        mesh: Any = capytaine.load_mesh(str(file))
        mesh = mesh.merged() if callable(getattr(mesh, "merged", None)) else mesh
        vertices, faces = np.array(mesh.vertices, dtype=np.float64), np.array(mesh.faces, dtype=np.int64)
    except Exception as error:  # readers of many formats raise whatever they like
        mend = "Give a format that Capytaine reads, for example .gdf, .stl or .dat"
        raise InputError("hull", str(path), f"cannot be read as a mesh ({error})", mend) from error
    return Hull(vertices, faces, np.array([0.0, *hinge]), inclination)
