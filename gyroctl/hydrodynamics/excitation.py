"""Wave moments on the two rotations at any frequency and heading, interpolated from the database."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.interpolation import spline
from gyroctl.hydrodynamics.table import Hydrodynamics

Phase = Literal["complex", "magnitude"]


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
        step = 360.0 / len(knots)
        if len(knots) > 2 and np.allclose(np.diff(knots), step, atol=1e-6):  # the full circle: close it smoothly
            knots = np.concatenate([knots[-3:] - 360.0, knots, knots[:4] + 360.0])
            values = np.concatenate([values[:, -3:], values, values[:, :4]], axis=1)
        if not np.isfinite(heading):
            raise InputError("sea.heading", heading, "is not a number", "Give the heading in degrees")
        turn = knots[0] + (heading - knots[0]) % 360.0  # the same direction, at or above the first knot
        if turn > knots[-1] + 1e-9:
            problem = f"lies outside the tabulated headings {knots[0]:g} to {knots[-1]:g} deg"
            mend = "Choose a tabulated heading or build a database with more of them"
            raise InputError("sea.heading", heading, problem, mend)
        at = np.array([min(turn, float(knots[-1]))])
        return np.asarray(spline(knots, np.swapaxes(values, 1, 2), at)[..., 0], dtype=np.complex128)


def excitation_table(hydro: Hydrodynamics, phase: Phase = "complex") -> ExcitationTable:
    """Return the excitation of a database as a callable table."""
    return ExcitationTable(hydro.omega, hydro.headings, hydro.excitation, phase)
