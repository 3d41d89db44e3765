"""What all foreign text formats share: what they leave out, and how scattered rows become a table."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.kramers_kronig import both_added_mass_inf
from gyroctl.hydrodynamics.table import Complexes, Floats, Hydrodynamics, coupling, diagonal


@dataclass(frozen=True)
class Site:
    """What the text formats leave out.

    Parameters
    ----------
    rho, g : float
        Density of the water [kg/m^3] and gravity [m/s^2], as in the foreign run.
    depth : float
        Water depth, ``inf`` for deep water. [m]
    length : float
        WAMIT's length ULEN. [m]
    stiffness : float
        Buoyancy stiffness k3 of phi3. [Nm/rad]
    modes : tuple of int
        Mode numbers of phi1 and phi3; negative where the mode turns against ours.
    """

    rho: float = 1000.0
    g: float = 9.81
    depth: float = float("inf")
    length: float = 1.0
    stiffness: float = 0.0
    modes: tuple[int, int] = (-6, 4)


def existing(path: Path) -> Path:
    """Return the path of a file that exists."""
    if not path.is_file():
        raise InputError("path", str(path), "there is no such file", "Check the path of the results")
    return path


Matrices = dict[float, Floats]
"""Added mass and damping (2, 2, 2) at each frequency. [rad/s]"""

Forces = dict[tuple[float, float], Complexes]
"""Moments (2,) at each frequency [rad/s] and heading [deg]."""


def assembled(
    matrices: Matrices, forces: Forces, infinite: Floats, site: Site, source: str, undisturbed: Forces | None = None
) -> Hydrodynamics:
    """Put rows in any order onto one frequency axis, which all kinds of results must share.

    `undisturbed` are the Froude-Krylov moments, where the results hold them apart.
    """
    omega = np.array(sorted(matrices))
    headings = np.array(sorted({beta for _, beta in forces}))
    headings = headings[: len(headings) - int(len(headings) > 0 and np.isclose(np.ptp(headings), 360.0))]  # repeated
    excitation = _tabled(forces, omega, headings)
    part = None if undisturbed is None else _tabled(undisturbed, omega, headings)
    table = np.array([matrices[w] for w in omega]).reshape(-1, 2, 2, 2)
    own = np.arange(2)
    complete = np.isfinite(table[:, :, own, own]).all() and np.isfinite(excitation).all()
    complete = complete and (part is None or bool(np.isfinite(part).all()))
    if not len(omega) or not len(headings) or not complete:
        problem = "lacks values of these modes at some frequency or heading"
        mend = "Compute radiation and excitation at the same frequencies, or set the two modes"
        raise InputError(source, site.modes, problem, mend)
    table = np.nan_to_num(table)  # an absent coupling term is zero
    added, damping = table[:, 0], table[:, 1]
    at_infinity = np.diagonal(infinite)
    if not np.isfinite(at_infinity).all():
        at_infinity = both_added_mass_inf(omega, added, damping)
    return Hydrodynamics(
        omega=omega,
        added_mass=diagonal(added),
        damping=diagonal(damping),
        added_mass_inf=np.array(at_infinity),
        excitation=excitation,
        headings=headings,
        stiffness=site.stiffness,
        depth=site.depth,
        rho=site.rho,
        g=site.g,
        coupling=coupling(added, damping),
        provenance={"source": source},
        froude_krylov=part,
        diffraction=None if part is None else excitation - part,
    )


def _tabled(forces: Forces, omega: Floats, headings: Floats) -> Complexes:
    """Moments (2, heading, omega), nan where the results have none."""
    out = np.full((2, len(headings), len(omega)), np.nan + 0j)
    for (w, beta), moment in forces.items():
        near = np.flatnonzero(np.isclose(omega, w, rtol=1e-6))
        if len(near) and beta in headings:
            out[:, np.searchsorted(headings, beta), near[0]] = moment
    return out
