"""What all foreign text formats share: what they leave out, and how scattered rows become a table."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.kramers_kronig import both_added_mass_inf
from gyroctl.hydrodynamics.table import FEWEST, SITE, Complexes, Floats, Hydrodynamics, coupling, diagonal
from gyroctl.reading import existing as existing_file
from gyroctl.reading import read_text

BOUNDS = {name: SITE[name] for name in ("rho", "g", "depth", "stiffness")} | {"length": (1e-6, 1e6)}
"""Least and largest values of a site."""


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

    def __post_init__(self) -> None:
        """Refuse numbers that no water, float or mode has."""
        for name, (low, high) in BOUNDS.items():
            value = getattr(self, name)
            if not low <= value <= high:
                problem = f"must be between {low:g} and {high:g}"
                raise InputError(f"hydro.{name}", value, problem, "Give it in SI units, as in the run of the results")
        if not all(1 <= abs(mode) <= 1000 for mode in self.modes) or abs(self.modes[0]) == abs(self.modes[1]):
            mend = "Number rigid modes from 1 for surge to 6 for yaw, negative where turned"
            raise InputError("hydro.modes", self.modes, "must be two different modes", mend)


MEND = "Check the path of the results"

TABLE_MAX = 1_000_000
"""Most pairs of frequency and heading: scattered rows of each would fill the memory."""

RESULTS_MAX = 16 << 20
"""Largest file of results: a hundred thousand rows. [bytes]"""


def existing(path: Path) -> Path:
    """Return the path of a file that exists."""
    return existing_file("path", path, MEND)


def lines_of(path: Path) -> list[str]:
    """Lines of a file of results, whose headings may be in the letters of another program."""
    return read_text("path", path, MEND, RESULTS_MAX, errors="replace").split("\n")


def mode_of(value: float) -> int:
    """Number of a mode as a row of results has it, 0 for what is no whole number."""
    return int(value) if abs(value) < 1e6 and value == int(value) else 0


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
    if len(omega) * max(len(headings), 1) > TABLE_MAX:
        problem, mend = f"has more than {TABLE_MAX} pairs of frequency and heading", "Leave some of them out"
        raise InputError(source, f"{len(omega)} and {len(headings)}", problem, mend)
    headings = headings[: len(headings) - int(len(headings) > 0 and np.isclose(np.ptp(headings), 360.0))]  # repeated
    excitation = _tabled(forces, omega, headings)
    part = None if undisturbed is None else _tabled(undisturbed, omega, headings)
    table = np.array([matrices[w] for w in omega]).reshape(-1, 2, 2, 2)
    own = np.arange(2)
    complete = np.isfinite(table[:, :, own, own]).all() and np.isfinite(excitation).all()
    complete = complete and (part is None or bool(np.isfinite(part).all()))
    if len(omega) < FEWEST or omega[0] <= 0.0 or not np.isfinite(omega[-1]):
        raise InputError(
            source, len(omega), f"must have at least {FEWEST} positive frequencies", "Compute more of them"
        )
    if not len(headings) or not complete:
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
        near = omega.searchsorted([w * (1.0 - 1e-6), w * (1.0 + 1e-6)])
        at = np.searchsorted(headings, beta)
        if near[0] < near[1] and at < len(headings) and headings[at] == beta:
            out[:, at, near[0]] = moment
    return out
