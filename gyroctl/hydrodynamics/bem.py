"""The Capytaine script that makes the database from the geometry (the extra `bem`; a run of gyroctl never needs it).

Four traps of Capytaine 3.0.0 shape it: the indirect method converges far more slowly than the direct one on this
float; the default Prony decomposition refuses or spoils kh < 0.13; even the Fortran one loses the added mass of phi3
(not the damping) below kh of about 0.17; and the finite-depth damping of phi3 turns rough above 12 rad/s. So: direct
method, Fortran decomposition, added mass from Kramers-Kronig at the lowest frequencies, infinite depth above 12
rad/s, joined continuously.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, replace
from datetime import UTC, datetime
from importlib.metadata import version
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

from gyroctl.errors import InputError
from gyroctl.hydrodynamics import mesh
from gyroctl.hydrodynamics.database import load, save
from gyroctl.hydrodynamics.geometry import VARIANTS, Geometry, Statics, statics
from gyroctl.hydrodynamics.joining import JOINT, SHALLOWEST, Table, frequency_ratio, joined
from gyroctl.hydrodynamics.keeping import with_bits_of
from gyroctl.hydrodynamics.panels import capsule
from gyroctl.hydrodynamics.radiation import PAPER_FIT, fit_all
from gyroctl.hydrodynamics.table import DOFS, Complexes, Floats, Hydrodynamics, coupling, diagonal

Progress = Callable[[int, int], None]

#: 74 frequencies, closest where the device works. [rad/s], shipped float; others turn as `joining.frequency_ratio`.
OMEGA: Floats = np.round(
    np.concatenate([np.arange(0.20, 6.0, 0.15), np.arange(6.0, 12.0, 0.25), np.arange(12.0, 16.01, 0.40)]), 2
)
#: Full circle, so that every heading of the sea is covered. [deg]
HEADINGS: Floats = np.arange(0.0, 360.0, 15.0)
Panels = tuple[int, int, int]
#: Panels around half the waterline, down the hull and across the lid: 952 wetted ones at finite depth, where twice as
#: many move nothing below 8 rad/s by more than 0.3 %; 1920 in infinite depth, where they are cheap and the waves short
#: (at 16 rad/s Haskind's relation for phi3 is off by 2 % with them, by 5 % with 952).
PANELS: tuple[Panels, Panels] = ((28, 17, 7), (40, 24, 10))


def build(
    out: Path | str,
    variant: str = "inclined",
    progress: Progress | None = None,
    omega: Floats = OMEGA,
    headings: Floats = HEADINGS,
    panels: tuple[Panels, Panels] = PANELS,
    keep: Path | str | None = None,
) -> Path:
    """Compute the database of one reading of the geometry and write it, radiation fits included.

    Parameters
    ----------
    out : Path or str
        NetCDF file to write.
    variant : str
        "inclined" (reproduces Table 1; the shipped one), "horizontal" or "deep".
    progress : callable, optional
        Called as ``progress(done, total)`` after each solved frequency.
    omega : ndarray (n,)
        Frequencies. [rad/s]
    headings : ndarray (n_heading,)
        Directions the waves travel to. [deg]
    panels : pair of tuples of int
        Panels around half the waterline, down the hull and across the lid, at finite and at infinite depth.
    keep : Path or str, optional
        Former database whose bits are kept, where it agrees to rounding; see `keeping`.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        When Capytaine 3 is not installed, the variant is unknown, or the former database has other results.
    """
    former = None if keep is None else load(keep)
    if variant not in VARIANTS:
        raise InputError("hydro.variant", variant, f"is not one of {', '.join(VARIANTS)}", "Choose one of these")
    hydro = solve(VARIANTS[variant], progress, omega, headings, panels)
    fits = fit_all(hydro)
    if variant == "inclined":
        fits["paper"] = PAPER_FIT
    told = f"gyroctl hydro build --variant {variant}"
    whole = replace(hydro, fits=fits, provenance={**hydro.provenance, "variant": variant, "command": told})
    if former is not None:
        bits = f"of the table of {former.provenance.get('created', 'unknown date')}, equal to rounding"
        whole = with_bits_of(former, whole)
        whole = replace(whole, provenance={**whole.provenance, "command": f"{told} --keep FILE", "bits": bits})
    return save(whole, out)


def solve(
    geometry: Geometry,
    progress: Progress | None = None,
    omega: Floats = OMEGA,
    headings: Floats = HEADINGS,
    panels: tuple[Panels, Panels] = PANELS,
) -> Hydrodynamics:
    """Compute the hydrodynamics of a float on a lever; parameters as in `build`."""
    cpt = _capytaine()
    rest = statics(geometry)
    ratio = frequency_ratio(geometry)
    joint = JOINT * ratio
    omega = np.asarray(OMEGA * ratio if omega is OMEGA else omega, dtype=np.float64)
    if np.any(omega <= 0.0) or np.any(np.diff(omega) <= 0.0):
        raise InputError("omega", len(omega), "must be increasing positive frequencies", "Sort them, in rad/s")
    shallow = np.isfinite(geometry.depth)
    finite = omega[omega <= joint * (1.0 + 1e-9)] if shallow else np.empty(0)
    if len(finite) and finite[-1] < omega[-1] and finite[-1] < joint * (1.0 - 1e-9):
        raise InputError("omega", omega[-1], f"the table must contain the joint at {joint:g} rad/s", "Add it")
    infinite = omega[omega >= joint * (1.0 - 1e-9)] if shallow else omega
    total, done = len(finite) + len(infinite), count(1)

    def advance() -> None:
        if progress is not None:
            progress(next(done), total)

    with _quiet():
        coarse, fine = (_body(cpt, geometry, rest, n) for n in panels)
        near = _solve(cpt, coarse, geometry, geometry.depth, finite, headings, advance)
        deep = _solve(cpt, fine, geometry, float("inf"), infinite, headings, advance)
        deep_inf = _infinite_frequency(cpt, fine, geometry) if len(deep.omega) else None
    raw = near if len(near.omega) else deep
    table, a_inf = joined(near, deep, deep_inf, geometry)
    return Hydrodynamics(
        omega=table.omega,
        added_mass=diagonal(table.added_mass),
        damping=diagonal(table.damping),
        added_mass_inf=a_inf,
        excitation=_by_rotation(table.excitation),
        headings=np.asarray(headings, dtype=np.float64),
        stiffness=rest.k3,
        depth=geometry.depth,
        rho=geometry.rho,
        g=geometry.g,
        coupling=coupling(raw.added_mass, raw.damping),
        provenance=_provenance(geometry, rest, [coarse.mesh.nb_faces, fine.mesh.nb_faces], deep_inf),
        froude_krylov=_by_rotation(table.froude_krylov),
        diffraction=_by_rotation(table.diffraction),
        hull=capsule(geometry, rest),
    )


def _by_rotation(moments: Complexes) -> Complexes:
    """From (n, n_heading, 2) to (2, n_heading, n)."""
    return np.ascontiguousarray(np.transpose(moments, (2, 1, 0)))


def _capytaine() -> Any:
    """Return the capytaine module, or say how to get it."""
    try:
        import capytaine
    except ImportError as error:
        raise InputError("hydro build", "capytaine", "is not installed", "Run: pip install 'gyroctl[bem]'") from error
    found = version("capytaine")
    if int(found.split(".")[0]) < 3:
        raise InputError("hydro build", f"capytaine {found}", "is too old", "Run: pip install 'capytaine>=3'")
    return capytaine


@contextmanager
def _quiet() -> Iterator[None]:
    """Hold back Capytaine's warnings that are known here: quadrilaterals on a curved hull, and panels at 16 rad/s."""
    log = logging.getLogger("capytaine")
    level = log.level
    log.setLevel(logging.ERROR)
    try:
        yield
    finally:
        log.setLevel(level)


def _body(cpt: Any, geometry: Geometry, rest: Statics, panels: Panels) -> Any:
    """Half hull and half lid, mirrored, turning about the two axes through the hinge."""
    around, down, across = panels
    halves = [mesh.hull(geometry, rest.height, around, down), mesh.lid(geometry, rest.height, around, across)]
    wetted, lid = (cpt.ReflectionSymmetricMesh(cpt.Mesh(h.vertices, h.faces), plane="yOz") for h in halves)
    hinge = geometry.hinge(rest.height)
    axes = {"phi1": np.array([0.0, 0.0, -1.0]), "phi3": np.array([1.0, 0.0, 0.0])}  # x1 points down
    dofs = {name: np.cross(axis, wetted.faces_centers - hinge) for name, axis in axes.items()}
    return cpt.FloatingBody(mesh=wetted, lid_mesh=lid, dofs=dofs, name="float")


def _solve(
    cpt: Any, body: Any, geometry: Geometry, depth: float, omega: Floats, headings: Floats, advance: Callable[[], None]
) -> Table:
    """Radiation and diffraction at each frequency; the matrices of one frequency serve all its problems."""
    green = cpt.Delhommeau(finite_depth_prony_decomposition_method="fortran")
    solver = cpt.BEMSolver(method="direct", green_function=green)
    n = len(omega)
    added, damping = np.zeros((n, 2, 2)), np.zeros((n, 2, 2))
    force, undisturbed, scattered = np.zeros((3, n, len(headings), 2), dtype=np.complex128)
    for i, w in enumerate(omega):
        common = {"body": body, "omega": float(w), "water_depth": depth, "rho": geometry.rho, "g": geometry.g}
        for k, dof in enumerate(DOFS):
            result = solver.solve(cpt.RadiationProblem(**common, radiating_dof=dof), keep_details=False)
            added[i, :, k] = [result.added_masses[d] for d in DOFS]
            damping[i, :, k] = [result.radiation_dampings[d] for d in DOFS]
        for k, heading in enumerate(headings):
            problem = cpt.DiffractionProblem(**common, wave_direction=float(np.deg2rad(heading)))
            forces = cpt.bem.airy_waves.froude_krylov_force(problem)
            result = solver.solve(problem, keep_details=False)
            force[i, k] = [np.conj(forces[d] + result.forces[d]) for d in DOFS]  # exp(-i w t) to exp(+i w t)
            undisturbed[i, k] = [np.conj(forces[d]) for d in DOFS]
            scattered[i, k] = [np.conj(result.forces[d]) for d in DOFS]
        advance()
    return Table(np.asarray(omega, dtype=np.float64), added, damping, force, undisturbed, scattered)


def _infinite_frequency(cpt: Any, body: Any, geometry: Geometry) -> Floats:
    """Return A_inf (2,) of infinite depth, solved directly (at finite depth Capytaine 3.0.0 gets it wrong)."""
    solver = cpt.BEMSolver(method="direct", green_function=cpt.Delhommeau())
    problems = [cpt.RadiationProblem(body=body, omega=np.inf, radiating_dof=d, rho=geometry.rho) for d in DOFS]
    return np.array([solver.solve(p, keep_details=False).added_masses[p.radiating_dof] for p in problems])


def _provenance(geometry: Geometry, rest: Statics, panels: list[int], deep_inf: Floats | None) -> dict[str, Any]:
    """Return what was computed, with what, when."""
    beyond = JOINT * frequency_ratio(geometry)
    joined_at = f"infinite depth above {beyond:g} rad/s, joined continuously; added mass from Kramers-Kronig "
    finite = np.isfinite(geometry.depth)
    return {
        "title": "Hydrodynamics of the float of Zhang et al. (2017), Ocean Eng. 143, rebuilt from its geometry",
        "bem_solver": f"capytaine {version('capytaine')}, direct method, Fortran Prony decomposition",
        "created": datetime.now(UTC).strftime("%Y-%m-%d"),
        "wetted_panels": panels,
        "depth_rule": joined_at + f"where kh < {SHALLOWEST:g}" if finite else "infinite depth throughout",
        "geometry": {k: float(v) for k, v in asdict(geometry).items()},
        "float_centre_height_m": rest.height,
        "hinge_height_m": rest.hinge_height,
        "displaced_volume_m3": rest.volume,
        "deep_water_added_mass_inf": [] if deep_inf is None else [float(v) for v in deep_inf],
    }
