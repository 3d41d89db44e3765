"""Linear Froude-Krylov moments from the panels of a float, and how they part an excitation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gyroctl.hydrodynamics.dispersion import wavenumber
from gyroctl.hydrodynamics.panels import Hull
from gyroctl.hydrodynamics.table import Complexes, Floats, Hydrodynamics


def froude_krylov(
    hull: Hull, omega: Floats, headings: Floats, depth: float, rho: float = 1000.0, g: float = 9.81
) -> Complexes:
    """Moments of the pressure of undisturbed waves on the surface that is wetted at rest.

    Parameters
    ----------
    hull : Hull
        Panels and hinge. A panel that the water cuts counts by its wetted share.
    omega : ndarray (n,)
        Frequencies. [rad/s]
    headings : ndarray (m,)
        Directions the waves travel to. [deg]
    depth : float
        Water depth, ``inf`` for deep water. [m]
    rho, g : float
        Density of the water [kg/m^3] and gravity [m/s^2].

    Returns
    -------
    complex ndarray (2, m, n)
        [Nm/m], time factor exp(+i w t), elevation below the centre of the float.
    """
    centres, normals, spread = hull.patches
    place = centres + hull.hinge
    half = np.sqrt(3.0 * spread[:, 2, 2] + 1e-12)
    wet = np.clip((half - place[:, 2]) / (2.0 * half), 0.0, 1.0)
    below = wet > 0.0
    turning = (np.cross(centres, normals) * wet[:, None])[below]
    weight = rho * g * np.stack([turning[:, 2], -turning[:, 0]])
    x, y, z = place[below].T
    z = np.minimum(z, 0.0)
    angle = np.deg2rad(np.asarray(headings, dtype=np.float64))
    out = np.empty((2, len(angle), len(omega)), dtype=np.complex128)
    for i, k in enumerate(wavenumber(omega, depth, g)):
        echo = np.exp(-2.0 * k * depth)  # 0 in deep water
        decay = (np.exp(k * z) + echo * np.exp(-k * z)) / (1.0 + echo)
        phase = np.exp(-1j * k * (np.cos(angle)[:, None] * x + np.sin(angle)[:, None] * y))
        out[:, :, i] = weight @ (decay * phase).T
    return out


def panel_stiffness(hull: Hull, rho: float = 1000.0, g: float = 9.81) -> float:
    """Buoyancy stiffness of phi3 from the panels at rest, without the gravity term. [Nm/rad]

    The linear water level y (a rotation by 1 rad about the hinge) on the wetted panels, and the buoyancy itself as it
    turns with them.
    """
    centres, normals, spread = hull.patches
    height = centres[:, 2] + hull.hinge[2]
    half = np.sqrt(3.0 * spread[:, 2, 2] + 1e-12)
    wet = np.clip((half - height) / (2.0 * half), 0.0, 1.0)
    return float(-rho * g * np.sum(wet * centres[:, 1] * np.cross(centres, normals)[:, 0]))


def completed(hydro: Hydrodynamics, hull: Hull | None = None) -> Hydrodynamics:
    """Return the table with the hull, and with the two parts of its excitation wherever they follow from what is there.

    Parameters
    ----------
    hydro : Hydrodynamics
        A table, with or without the parts.
    hull : Hull, optional
        Surface of the float; without it, the one of the table.
    """
    hull = hull or hydro.hull
    undisturbed, scattered = hydro.froude_krylov, hydro.diffraction
    if undisturbed is None and scattered is not None:
        undisturbed = hydro.excitation - scattered
    if undisturbed is None and hull is not None:
        undisturbed = froude_krylov(hull, hydro.omega, hydro.headings, hydro.depth, hydro.rho, hydro.g)
    if scattered is None and undisturbed is not None:
        scattered = hydro.excitation - undisturbed
    return replace(hydro, hull=hull, froude_krylov=undisturbed, diffraction=scattered)
