"""From the point that results are about to the hinge, and from their origin of waves to the float's centre.

Moments about the hinge H are M_H = M_P + (P - H) x F, and a body that turns about H moves P: added mass, damping and
restoring transform as T A T', the excitation as T F. A wave that is referred to the float's centre C instead of O has
its amplitude turned by exp(-i k.(C - O)), so that moments per amplitude turn by exp(+i k.(C - O)), time factor
exp(+i w t).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.dispersion import wavenumber
from gyroctl.hydrodynamics.site import NAMES, Site
from gyroctl.hydrodynamics.table import Complexes, Floats

NEAR = 1e-6
"""Two points closer than this are one. [m]"""

HINGE = "Give the hinge with --hinge Y Z, from the float's centre, and --centre X Y where the centre is not 0 0"


class Told(NamedTuple):
    """What a file tells of places, in the coordinates of its run."""

    points: dict[int, tuple[float, float, float]]
    """Point that each rotational mode is about; empty where nothing is told. [m]"""
    origin: tuple[float, float] = (0.0, 0.0)
    """Where the elevation is referred to. [m]"""
    where: str = "the file"


@dataclass(frozen=True)
class Frame:
    """How modes of a run make up our two rotations.

    Parameters
    ----------
    wanted : tuple of int
        Modes of the run that take part.
    turn : ndarray (2, n)
        Our rotations from them.
    shift : tuple of 2 float
        From the origin of the waves to the float's centre. [m]
    words : str
        What was moved.
    """

    wanted: tuple[int, ...]
    turn: Floats
    shift: tuple[float, float]
    words: str

    @property
    def moved(self) -> bool:
        """Whether other modes than our two rotations take part."""
        return len(self.wanted) > 2

    def matrix(self, values: Floats) -> Floats:
        """Turn matrices (..., n, n) into (..., 2, 2)."""
        return np.asarray(self.turn @ values @ self.turn.T, dtype=np.float64)

    def moments(self, values: Complexes, omega: Floats, headings: Floats, depth: float, g: float) -> Complexes:
        """Turn forces (n, n_heading, n_omega) into moments (2, n_heading, n_omega) about the hinge."""
        out = np.asarray(np.einsum("jm,mho->jho", self.turn, values), dtype=np.complex128)
        if self.shift == (0.0, 0.0):
            return out
        angle = np.deg2rad(headings)
        along = self.shift[0] * np.cos(angle) + self.shift[1] * np.sin(angle)
        return np.asarray(out * np.exp(1j * along[:, None] * wavenumber(omega, depth, g)), dtype=np.complex128)


def framed(site: Site, told: Told) -> Frame:
    """Return how the results of a run become ours.

    Raises
    ------
    InputError
        Where the results are about another point and nobody says where the hinge is.
    """
    modes = site.chosen
    cx, cy = site.centre or (0.0, 0.0)
    shift = (cx - told.origin[0], cy - told.origin[1])
    shift = (0.0, 0.0) if max(map(abs, shift)) <= NEAR else shift
    hinge = None if site.hinge is None else np.array([cx, cy + site.hinge[0], site.hinge[1]])
    rows, words = [], []
    for name, mode in zip(("phi1", "phi3"), modes, strict=True):
        row, axis = np.zeros(6), abs(mode) - 1
        point = _point(site, told, abs(mode))
        offset = np.zeros(3)
        if point is None:
            words.append(f"{name}: no point told, taken for the hinge")
        elif hinge is not None:
            offset = np.array(point) - hinge
        elif max(map(abs, point)) > NEAR:
            problem = "is what the moments are about, and nobody says whether that is the hinge"
            raise InputError(f"{told.where}: point", tuple(map(float, point)), problem, HINGE)
        else:
            words.append(f"{name}: about the origin of the run, taken for the hinge")
        if axis < 6:
            row[axis] = 1.0
        if np.max(np.abs(offset)) > NEAR:
            if not 3 <= axis <= 5:
                problem = "is no rotation, and cannot be moved to the hinge"
                raise InputError("hydro.modes", mode, problem, "Give results about the hinge")
            first, second = (axis - 2) % 3, (axis - 1) % 3  # of x: y and z, in turn
            row[second], row[first] = offset[first], -offset[second]
            words.append(f"{name}: moved to the hinge by ({', '.join(f'{-v:.4g}' for v in offset)}) m")
        elif point is not None and hinge is not None:
            words.append(f"{name}: about the hinge")
        rows.append(np.sign(mode) * row)
    if shift != (0.0, 0.0):
        words.append(f"waves referred to the float's centre, ({shift[0]:.4g}, {shift[1]:.4g}) m from their origin")
    turn = np.array(rows)
    if max(map(abs, modes)) > 6 and np.count_nonzero(turn) > 1:
        raise InputError("hydro.modes", modes, "cannot both be moved to the hinge", "Give results about the hinge")
    if max(map(abs, modes)) > 6 or np.count_nonzero(turn) == 2:
        return Frame(
            (abs(modes[0]), abs(modes[1])), np.diag(np.sign(modes).astype(np.float64)), shift, "; ".join(words)
        )
    used = [m for m in range(6) if np.any(turn[:, m]) or m + 1 in map(abs, modes)]
    return Frame(tuple(m + 1 for m in used), turn[:, used], shift, "; ".join(words))


def _point(site: Site, told: Told, mode: int) -> tuple[float, float, float] | None:
    """Point that a mode is about, by the file or by the option."""
    point = told.points.get(mode)
    if (
        point is not None
        and site.about is not None
        and max(abs(a - b) for a, b in zip(point, site.about, strict=True)) > NEAR
    ):
        problem = f"differs from {tuple(map(float, point))}, which {told.where} tells"
        raise InputError("hydro.about", site.about, problem, "Leave the option out, or mend the file")
    return point or site.about


def named(modes: tuple[int, ...]) -> str:
    """Modes in words."""
    return ", ".join(f"{m} ({NAMES[m - 1]})" if 1 <= m <= 6 else str(m) for m in map(abs, modes))
