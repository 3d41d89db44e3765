"""Wave moments on the two rotations at any frequency and heading, interpolated from the database."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyroctl.errors import InputError
from gyroctl.faces.device import excitation_face
from gyroctl.faces.show import shown
from gyroctl.hydrodynamics.interpolation import spline
from gyroctl.hydrodynamics.table import Hydrodynamics

Phase = Literal["complex", "magnitude"]

WIDEST = 60.0
"""Widest gap between headings that is interpolated across: the shipped table, thinned out to it, is right within 5 %
of its largest moment. [deg]"""


@shown(excitation_face)
@dataclass(frozen=True)
class ExcitationTable:
    """Interpolated excitation, a callable object.

    Parameters
    ----------
    omega : ndarray (n,)
        Tabulated frequencies. [rad/s]
    headings : ndarray (n_heading,)
        Tabulated headings. [deg]
    values : complex ndarray (2, n_heading, n)
        He_1 and He_3, time factor exp(+i w t), elevation at the centre of the float. [Nm/m]
    phase : {"complex", "magnitude"}
        "complex" keeps the phases; "magnitude" drops them, as (42)-(43) of the paper do, so that both moments are in
        phase with the elevation.

    Raises
    ------
    InputError
        Field ``excitation.phase``: neither "complex" nor "magnitude".
    """

    omega: NDArray[np.float64]
    headings: NDArray[np.float64]
    values: NDArray[np.complex128]
    phase: Phase = "complex"

    def __post_init__(self) -> None:
        """Refuse an unknown phase."""
        if self.phase not in ("complex", "magnitude"):
            problem = "is neither 'complex' nor 'magnitude'"
            raise InputError("excitation.phase", self.phase, problem, "Choose one of the two")

    @cached_property
    def sha256(self) -> str:
        """Hash of the table and of the treatment of the phase."""
        digest = hashlib.sha256(self.phase.encode())
        for values in (self.omega, self.headings, self.values):
            digest.update(np.ascontiguousarray(values).tobytes())
        return digest.hexdigest()

    def __call__(self, omega: ArrayLike, heading: float = 0.0) -> NDArray[np.complex128]:
        """Wave moments per wave amplitude.

        Parameters
        ----------
        omega : array_like (n,)
            Frequencies; outside the table the moments are 0. [rad/s]
        heading : float
            Direction the waves travel to. [deg]

        Returns
        -------
        complex ndarray (2, n)
            He_1 and He_3. [Nm/m]

        Raises
        ------
        InputError
            When the heading lies outside the table.
        """
        w = np.atleast_1d(np.asarray(omega, dtype=np.float64))
        along = self._at_heading(heading)
        inside = (w >= self.omega[0]) & (w <= self.omega[-1])
        out = np.zeros((2, len(w)), dtype=np.complex128)
        out[:, inside] = spline(self.omega, along, w[inside])
        return np.abs(out).astype(np.complex128) if self.phase == "magnitude" else out

    def _at_heading(self, heading: float) -> NDArray[np.complex128]:
        """Moments at one heading and all tabulated frequencies. (2, n)."""
        knots, values = self.headings, self.values
        if not np.isfinite(heading):
            raise InputError("sea.heading", heading, "is not a number", "Give the heading in degrees")
        gaps = np.diff(knots, append=knots[0] + 360.0)
        wide = np.flatnonzero(gaps > WIDEST + 1e-6)
        if not len(wide) and len(knots) > 3:  # the full circle: close it smoothly
            knots = np.concatenate([knots[-3:] - 360.0, knots, knots[:4] + 360.0])
            values = np.concatenate([values[:, -3:], values, values[:, :4]], axis=1)
        elif len(wide):  # the arc that begins beyond the last gap before this heading
            first = self._arc(heading, wide)
            start, end = first
            turns = np.arange(start, end + 1)
            knots = knots[turns % len(knots)] + 360.0 * (turns // len(knots))
            values = values[:, turns % values.shape[1]]
        turn = knots[0] + (heading - knots[0]) % 360.0  # the same direction, at or above the first knot
        if turn > knots[-1] + 1e-5:  # a rounding below the first knot
            turn -= 360.0
        at = np.array([min(max(turn, float(knots[0])), float(knots[-1]))])
        return np.asarray(spline(knots, np.swapaxes(values, 1, 2), at)[..., 0], dtype=np.complex128)

    def _arc(self, heading: float, wide: NDArray[np.int64]) -> tuple[int, int]:
        """First and last position of the stretch of headings that holds this one, the last beyond the end of a turn."""
        knots, count = self.headings, len(self.headings)
        for before, after in zip(np.roll(wide, 1), wide, strict=True):
            start = (int(before) + 1) % count
            end = start + (int(after) - start) % count
            reach = (knots[end % count] - knots[start]) % 360.0
            if (heading - knots[start] + 1e-6) % 360.0 <= reach + 2e-6:
                return start, end
        if len(wide) == 1 and wide[0] == count - 1:
            problem = f"lies outside the tabulated headings {knots[0]:g} to {knots[-1]:g} deg"
        else:
            beyond = (heading - knots[0]) % 360.0
            k = int(np.searchsorted(knots - knots[0], beyond)) - 1
            low, high = knots[k], knots[(k + 1) % count]
            apart = (high - low) % 360.0
            problem = f"lies between the tabulated headings {low:g} and {high:g} deg, {apart:g} deg apart"
        mend = "Choose a tabulated heading or build a database with more of them"
        raise InputError("sea.heading", heading, problem, mend)


def excitation_table(hydro: Hydrodynamics, phase: Phase = "complex") -> ExcitationTable:
    """Return the excitation of a database as a callable table.

    Parameters
    ----------
    hydro : Hydrodynamics
        The database.
    phase : {"complex", "magnitude"}
        Whether the phases are kept, see `ExcitationTable`.

    Returns
    -------
    ExcitationTable
        He_1, He_3 at any frequency and heading. [Nm/m]

    Raises
    ------
    InputError
        Field ``excitation.phase``.
    """
    return ExcitationTable(hydro.omega, hydro.headings, hydro.excitation, phase)
