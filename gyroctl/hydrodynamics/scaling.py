"""A hydrodynamic table at another size, by Froude's law: the same float in the same water, all lengths multiplied."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from gyroctl.froude import growth
from gyroctl.hydrodynamics.panels import Hull
from gyroctl.hydrodynamics.reduced import ReducedSurface
from gyroctl.hydrodynamics.table import Coefficients, Hydrodynamics


def scaled(hydro: Hydrodynamics, length: float) -> Hydrodynamics:
    """Return a table whose lengths, the depth of the water included, are `length` times those of `hydro`.

    Parameters
    ----------
    hydro : Hydrodynamics
        The table.
    length : float
        Factor on all lengths. [-]

    Returns
    -------
    Hydrodynamics
        Of the same headings, density and gravity; frequencies, added inertia, damping, moments, stiffness, hull, fits
        of the radiation and of the wetted surface by the powers of their units.
    """
    moment, rate = growth("Nm/m", length), growth("rad/s", length)
    parts: dict[str, Any] = {}
    for name in ("froude_krylov", "diffraction"):
        values = getattr(hydro, name)
        parts[name] = None if values is None else values * moment
    return replace(
        hydro,
        omega=hydro.omega * rate,
        added_mass=hydro.added_mass * growth("kg m^2", length),
        damping=hydro.damping * growth("Nms/rad", length),
        added_mass_inf=hydro.added_mass_inf * growth("kg m^2", length),
        excitation=hydro.excitation * moment,
        stiffness=hydro.stiffness * growth("Nm/rad", length),
        depth=hydro.depth * length,
        fits={name: (_fit(one, length), _fit(three, length)) for name, (one, three) in hydro.fits.items()},
        provenance={**hydro.provenance, "froude_length": length},
        hull=None if hydro.hull is None else scaled_hull(hydro.hull, length),
        wetted=scaled_fit(hydro.wetted, length),
        **parts,
    )


def scaled_hull(hull: Hull, length: float) -> Hull:
    """Hull at another size."""
    return replace(hull, vertices=hull.vertices * length, hinge=hull.hinge * length)


def scaled_fit(fit: ReducedSurface | None, length: float) -> ReducedSurface | None:
    """Polynomials of a wetted surface at another size: in angles they stay what they are."""
    if fit is None:
        return None
    rate, stiffness = growth("rad/s", length), fit.stiffness * growth("Nm/rad", length)
    return fit._replace(stiffness=stiffness, hs=fit.hs * length, wp=fit.wp * rate)


def _fit(fit: Coefficients, length: float) -> Coefficients:
    p, q = scaled_fraction(np.asarray(fit[0], float), np.asarray(fit[1], float), length)
    return p, q


def scaled_fraction(p: Any, q: Any, length: float) -> tuple[Any, Any]:
    """Coefficients of a radiation function P(s)/Q(s) at another size.

    Parameters
    ----------
    p : (m + 1,) array
        Numerator, highest power first. [Nms/rad over powers of s]
    q : (n,) array
        Denominator without its leading one. [powers of 1/s]
    length : float
        Factor on all lengths. [-]
    """
    rate, damping = growth("rad/s", length), growth("Nms/rad", length)
    order = np.arange(1, len(q) + 1, dtype=np.float64)
    lowest = order[-1] - np.arange(len(p) - 1, -1, -1)  # a numerator of order n would have no power left
    return p * damping * rate**lowest, q * rate**order
