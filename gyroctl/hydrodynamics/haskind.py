"""Haskind's relation: radiation damping from the excitation over all headings.

    B_j(w) = k / (8 pi rho g c_g) * int_0^2pi |He_j(w, beta)|^2 dbeta

Damping and excitation come from different boundary-value problems, so their agreement tests both.
"""

from __future__ import annotations

import numpy as np

from gyroctl.hydrodynamics.dispersion import group_velocity, wavenumber
from gyroctl.hydrodynamics.table import Floats, Hydrodynamics

#: Errors are relative to the damping, or to this share of its largest value where it is smaller than that.
_CARRIED = 0.2


def haskind_damping(hydro: Hydrodynamics) -> Floats | None:
    """Damping of both rotations from the excitation.

    Parameters
    ----------
    hydro : Hydrodynamics
        A table whose headings cover the circle evenly. Half of it will not do: the inclined float answers waves from
        the hinge and waves to the hinge differently, by half in short waves.

    Returns
    -------
    ndarray (2, n) or None
        [Nms/rad]; None when the headings do not cover the circle.
    """
    power = np.abs(hydro.excitation) ** 2
    headings = hydro.headings
    step = 360.0 / len(headings)
    if len(headings) < 5 or not np.allclose(np.diff(headings), step, atol=1e-6):
        return None
    integral = np.deg2rad(step) * power.sum(axis=1)  # periodic: the trapezoid rule converges geometrically
    k = wavenumber(hydro.omega, hydro.depth, hydro.g)
    speed = group_velocity(hydro.omega, hydro.depth, hydro.g)
    return np.asarray(k / (8.0 * np.pi * hydro.rho * hydro.g * speed) * integral, dtype=np.float64)


def haskind_error(hydro: Hydrodynamics) -> Floats | None:
    """Return the largest departure of the damping from Haskind's relation, per rotation, (2,); None as above."""
    other = haskind_damping(hydro)
    if other is None:
        return None
    floor = _CARRIED * hydro.damping.max(axis=1, keepdims=True)
    error = np.abs(hydro.damping - other) / np.maximum(hydro.damping, floor)
    return np.asarray(error.max(axis=1), dtype=np.float64)
