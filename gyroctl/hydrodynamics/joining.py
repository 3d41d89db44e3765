"""One table from finite depth at low frequencies and infinite depth at high ones."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gyroctl.hydrodynamics.dispersion import wavenumber
from gyroctl.hydrodynamics.geometry import Geometry
from gyroctl.hydrodynamics.kramers_kronig import both_added_mass_inf, dispersion
from gyroctl.hydrodynamics.table import Complexes, Floats

#: Finite depth up to here, infinite depth beyond. [rad/s], shipped float
JOINT = 12.0
#: Value of kh below which the added mass comes from Kramers-Kronig.
SHALLOWEST = 0.17


def frequency_ratio(geometry: Geometry) -> float:
    """Return how frequencies chosen for the shipped float turn for another size, as sqrt(g / diameter). [-]"""
    usual = Geometry()
    return math.sqrt(geometry.g / usual.g * (usual.diameter / geometry.diameter))


class Table(NamedTuple):
    """Raw results at some frequencies, time factor exp(+i w t)."""

    omega: Floats
    added_mass: Floats
    """(n, 2, 2) [kg m^2]"""
    damping: Floats
    """(n, 2, 2) [Nms/rad]"""
    excitation: Complexes
    """(n, n_heading, 2) [Nm/m]"""
    froude_krylov: Complexes
    """The part of the excitation that the undisturbed waves exert. (n, n_heading, 2) [Nm/m]"""
    diffraction: Complexes
    """The part that the float scatters. (n, n_heading, 2) [Nm/m]"""


def joined(near: Table, deep: Table, deep_inf: Floats | None, geometry: Geometry) -> tuple[Table, Floats]:
    """One table from finite depth up to the joint and infinite depth beyond, and its added mass at infinite frequency.

    At the joint the waves no longer feel the bottom but the near field does: the damping differs by a factor near one,
    the added mass by an amount that tends to its own limit like w^-2 (as Kramers-Kronig has it at high frequency).

    Parameters
    ----------
    near, deep : Table
        Results at finite and at infinite depth, both with the joint; either may be empty.
    deep_inf : ndarray (2,) or None
        Added mass at infinite frequency in infinite depth. [kg m^2]
    geometry : Geometry
        Depth and gravity of the site.

    Returns
    -------
    tuple of Table and ndarray (2,)
        The whole table and its added mass at infinite frequency. [kg m^2]
    """
    if not len(near.omega):
        return deep, both_added_mass_inf(deep.omega, deep.added_mass, deep.damping)
    if len(deep.omega) < 2 or deep_inf is None:
        return near, both_added_mass_inf(near.omega, near.added_mass, near.damping)
    omega = np.concatenate([near.omega, deep.omega[1:]])
    factor = np.diagonal(near.damping[-1]) / np.diagonal(deep.damping[0])
    empty = np.zeros((len(deep.omega) - 1, 2, 2))
    damping, added = np.concatenate([near.damping, empty]), np.concatenate([near.added_mass, empty])
    count = len(near.omega)
    fade = (deep.omega[0] / deep.omega[1:]) ** 2
    shallow = wavenumber(near.omega, geometry.depth, geometry.g) * geometry.depth < SHALLOWEST
    a_inf = []
    for j in range(2):
        damping[count:, j, j] = factor[j] * deep.damping[1:, j, j]
        spread = dispersion(omega, damping[:, j, j])
        estimates = (near.added_mass[:, j, j] - spread[:count])[~shallow]
        a_inf.append(float(np.median(estimates)))
        limit = a_inf[j] - deep_inf[j]
        step = near.added_mass[-1, j, j] - deep.added_mass[0, j, j]
        added[count:, j, j] = deep.added_mass[1:, j, j] + limit + (step - limit) * fade
        added[:count, j, j][shallow] = a_inf[j] + spread[:count][shallow]
    # one complex factor for all headings (some moments vanish by symmetry), and what it leaves over fades out
    here, there = deep.excitation[0], near.excitation[-1]
    turn = np.sum(np.conj(here) * there, axis=0) / np.sum(np.abs(here) ** 2, axis=0)
    beyond = deep.excitation[1:] * turn + (there - here * turn) * fade[:, None, None]
    # the undisturbed waves have forgotten the bottom there: what is left over is the finer mesh
    over = (near.froude_krylov[-1] - deep.froude_krylov[0]) * fade[:, None, None]
    undisturbed = deep.froude_krylov[1:] + over
    excitation, froude_krylov, diffraction = (
        np.concatenate(pair)
        for pair in (
            (near.excitation, beyond),
            (near.froude_krylov, undisturbed),
            (near.diffraction, beyond - undisturbed),
        )
    )
    return Table(omega, added, damping, excitation, froude_krylov, diffraction), np.array(a_inf)
