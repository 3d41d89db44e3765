"""Equations of motion of the four bodies, derived three ways.

`virtual_power` (Jourdain, Kane) is the reference: for every body, the rate of its momenta in space times the partial
velocities. `boltzmann_hamel` gets the same from the kinetic energy with quasi-coordinates. `lagrange` takes w1 and w3
for derivatives of angles, as the paper does. All return four expressions, linear in the accelerations: inertia forces
along (w1, w3, psi_rate, omega_rate), to be balanced by the applied ones.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from oracles.four_bodies import (
    ACCELERATIONS,
    J11,
    J13,
    J14,
    J22,
    LEVER_RATE,
    R1,
    SPEEDS,
    N,
    a,
    b,
    four_bodies,
    m1,
    m2,
    m3,
    m4,
    omega_acc,
    omega_rate,
    psi,
    psi_acc,
    psi_rate,
    w1,
    w1_dot,
    w2,
    w2_dot,
    w3,
    w3_dot,
)

FREE_SPEEDS = (w1, w3, psi_rate, omega_rate)
FREE_ACCELERATIONS = (w1_dot, w3_dot, psi_acc, omega_acc)
NO_TWIST = {w2: 0, w2_dot: 0}
PARAMETERS = (a, b, N, m1, m2, m3, m4, J11, J22, J13, J14)
cc, cg = sp.symbols("cc cg", real=True)


def time_derivative(value: Any) -> Any:
    """Differentiate a scalar or the components of a vector along the motion."""
    rate = value.diff(psi) * psi_rate
    for speed, acceleration in zip(SPEEDS, ACCELERATIONS, strict=True):
        rate += value.diff(speed) * acceleration
    return rate


def space_derivative(vector: sp.Matrix) -> sp.Matrix:
    """Differentiate a vector given along e1, e2, e3 in space: these axes turn with the lever."""
    return time_derivative(vector) + LEVER_RATE.cross(vector)


def virtual_power() -> list[sp.Expr]:
    """Return the inertia forces by the principle of virtual power, body by body."""
    forces = []
    for speed in FREE_SPEEDS:
        force = sp.Integer(0)
        for body in four_bodies():
            force += body.mass * space_derivative(body.velocity).dot(body.velocity.diff(speed))
            force += space_derivative(body.momentum).dot(body.rate.diff(speed))
        forces.append(sp.expand(force.subs(NO_TWIST)))
    return forces


def kinetic_energy() -> sp.Expr:
    """Return the kinetic energy of the four bodies with all five speeds [J]."""
    return sp.expand(sum(body.kinetic_energy for body in four_bodies()))


def boltzmann_hamel() -> list[sp.Expr]:
    """Return the inertia forces from the kinetic energy: Lagrange's terms, and w x dT/dw for the lever."""
    energy = kinetic_energy()
    lever = LEVER_RATE.cross(sp.Matrix([energy.diff(speed) for speed in (w1, w2, w3)]))
    extra = {w1: lever[0], w3: lever[2]}
    return [
        sp.expand((term + extra.get(speed, sp.Integer(0))).subs(NO_TWIST))
        for speed, term in zip(FREE_SPEEDS, _lagrange_terms(energy), strict=True)
    ]


def lagrange() -> list[sp.Expr]:
    """Return the inertia forces as if w1 and w3 were derivatives of angles (trap 3b: this loses a term)."""
    return [sp.expand(term) for term in _lagrange_terms(kinetic_energy().subs(w2, 0))]


def _lagrange_terms(energy: sp.Expr) -> list[sp.Expr]:
    coordinate_forces = {psi_rate: energy.diff(psi)}
    return [time_derivative(energy.diff(speed)) - coordinate_forces.get(speed, 0) for speed in FREE_SPEEDS]


def applied_forces(*, generator_reaction: bool) -> list[sp.Expr]:
    """Return the generalised forces of the coupling and the generator, from the torque pairs on the bodies.

    The coupling acts between spin axis and flywheel, the generator between ring and flywheel, both about the spin axis.
    With `generator_reaction` the torque on the ring does its work on the lever once more, as the brackets of (22)-(23)
    have it.
    """
    _, ring, axis, flywheel = four_bodies()
    coupling, generator = cc * (omega_rate - N * psi_rate) * R1, cg * omega_rate * R1
    pairs = [(axis, coupling), (flywheel, -coupling), (ring, generator), (flywheel, -generator)]
    forces = []
    for speed in FREE_SPEEDS:
        force = sum((torque.dot(body.rate.diff(speed)) for body, torque in pairs), sp.Integer(0))
        if generator_reaction and speed in (w1, w3):
            force += generator.dot(ring.rate.diff(speed))
        forces.append(sp.expand(force))
    return forces


class Derivation(NamedTuple):
    """Numeric form of one derivation.

    Attributes
    ----------
    mass_matrix : callable
        (psi, speeds, parameters) -> (4, 4), without the added inertia [kg m^2].
    bias : callable
        (psi, speeds, parameters) -> (4,), the inertia forces at zero acceleration [Nm].
    applied : callable
        (psi, speeds, parameters, cc, cg) -> (4,), the forces of coupling and generator [Nm].
    energy : callable
        (psi, speeds, parameters) -> kinetic energy [J]; complex arguments allowed.
    """

    mass_matrix: Callable[..., NDArray[np.float64]]
    bias: Callable[..., NDArray[np.float64]]
    applied: Callable[..., NDArray[np.float64]]
    energy: Callable[..., Any]

    def accelerations(
        self,
        psi: float,
        speeds: NDArray[np.float64],
        parameters: NDArray[np.float64],
        u: tuple[float, float],
        moments: NDArray[np.float64],
        added: NDArray[np.float64],
    ) -> NDArray[np.float64]:
        """Return phi1'', phi3'', psi'', omega'' [rad/s^2].

        Parameters
        ----------
        psi : float
            Ring angle. [rad]
        speeds : ndarray, shape (4,)
            phi1', phi3', psi', omega'. [rad/s]
        parameters : ndarray, shape (11,)
            As `table_1` returns them.
        u : tuple of float
            cc, cg. [Nms]
        moments, added : ndarray, shape (2,)
            Moment on the lever about e1 and e3 but that of the added inertia [Nm], and the added inertia [kg m^2].
        """
        mass = self.mass_matrix(psi, speeds, parameters) + np.diag([*added, 0.0, 0.0])
        force = self.applied(psi, speeds, parameters, *u) - self.bias(psi, speeds, parameters)
        force[:2] += moments
        return np.asarray(np.linalg.solve(mass, force), dtype=np.float64)


@cache
def derive(*, lever_gyroscopic: bool = True, generator_reaction: bool = False) -> Derivation:
    """Derive the equations and compile them to NumPy.

    Parameters
    ----------
    lever_gyroscopic : bool
        True: `virtual_power`, the right one. False: `lagrange`, what the paper has.
    generator_reaction : bool
        True adds the bracketed reaction of the paper.
    """
    forces = sp.Matrix(virtual_power() if lever_gyroscopic else lagrange())
    at_rest = dict.fromkeys(FREE_ACCELERATIONS, 0)
    arguments = (psi, FREE_SPEEDS, PARAMETERS)
    mass = sp.lambdify(arguments, forces.jacobian(FREE_ACCELERATIONS), "numpy")
    bias = sp.lambdify(arguments, list(forces.subs(at_rest)), "numpy")
    applied = sp.lambdify((*arguments, cc, cg), applied_forces(generator_reaction=generator_reaction), "numpy")
    return Derivation(
        mass_matrix=lambda *values: np.asarray(mass(*values), dtype=np.float64),
        bias=lambda *values: np.asarray(bias(*values), dtype=np.float64),
        applied=lambda *values: np.asarray(applied(*values), dtype=np.float64),
        energy=sp.lambdify(arguments, kinetic_energy().subs(w2, 0), "numpy"),
    )
