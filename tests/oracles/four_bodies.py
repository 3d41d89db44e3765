"""The four bodies of the device, each by its mass, inertia, centre and angular velocity.

Axes: e1, e2, e3 move with the lever, e2 along it from the hinge to the float. The ring carries that
frame turned by psi about e2; r1 = cos(psi) e1 - sin(psi) e3 is the direction of the spin axis.

Generalised speeds: w1, w2, w3 (angular velocity of the lever along e1, e2, e3), psi_rate (ring relative to the lever)
and omega_rate (flywheel relative to the ring). The hinge holds w2 = 0. The spin axis rolls without slip on the track of
the lever: relative to the ring it turns about r1 at N psi_rate.
"""

from __future__ import annotations

from typing import NamedTuple

import sympy as sp

w1, w2, w3, psi_rate, omega_rate = SPEEDS = sp.symbols("w1 w2 w3 psi_rate omega_rate", real=True)
w1_dot, w2_dot, w3_dot, psi_acc, omega_acc = ACCELERATIONS = sp.symbols(
    "w1_dot w2_dot w3_dot psi_acc omega_acc", real=True
)
psi = sp.Symbol("psi", real=True)
a, b, N = sp.symbols("a b N", positive=True)
m1, m2, m3, m4, J11, J22, J13, J14 = sp.symbols("m1 m2 m3 m4 J11 J22 J13 J14", positive=True)
axial_1 = sp.Symbol("axial_1", positive=True)
"""Inertia of the float about the lever, which Table 1 does not give: it must drop out, the lever has no such rate."""

E1, E2, E3 = sp.Matrix([1, 0, 0]), sp.Matrix([0, 1, 0]), sp.Matrix([0, 0, 1])
R1 = sp.cos(psi) * E1 - sp.sin(psi) * E3
LEVER_RATE = w1 * E1 + w2 * E2 + w3 * E3


class Body(NamedTuple):
    """A body of revolution.

    Attributes
    ----------
    name : str
        What it is.
    mass, axial, diametral : sympy.Expr
        Mass [kg] and moments of inertia about its axis and across it [kg m^2].
    axis : sympy.Matrix
        Unit vector of its axis, components along e1, e2, e3.
    centre : sympy.Matrix
        Centre of mass from the hinge [m].
    rate : sympy.Matrix
        Angular velocity in space [rad/s].
    """

    name: str
    mass: sp.Expr
    axial: sp.Expr
    diametral: sp.Expr
    axis: sp.Matrix
    centre: sp.Matrix
    rate: sp.Matrix

    @property
    def velocity(self) -> sp.Matrix:
        """Velocity of the centre in space [m/s]."""
        return LEVER_RATE.cross(self.centre)

    @property
    def momentum(self) -> sp.Matrix:
        """Angular momentum about the centre [Nms]."""
        along = self.rate.dot(self.axis)
        return self.diametral * self.rate + (self.axial - self.diametral) * along * self.axis

    @property
    def kinetic_energy(self) -> sp.Expr:
        """Kinetic energy [J]."""
        return self.mass * self.velocity.dot(self.velocity) / 2 + self.momentum.dot(self.rate) / 2


def four_bodies() -> tuple[Body, Body, Body, Body]:
    """Return float, ring, spin axis and flywheel.

    The float is at the distance a from the hinge, the three others at a + b. Thin discs have half their axial inertia
    across. Table 1 gives J11 across the lever, the others about the body's axis; that the spin axis, too, counts as a
    disc is how (16) reads.
    """
    far = (a + b) * E2
    ring_rate = LEVER_RATE + psi_rate * E2
    return (
        Body("float", m1, axial_1, J11, E2, a * E2, LEVER_RATE),
        Body("ring", m2, J22, J22 / 2, E2, far, ring_rate),
        Body("spin axis", m3, J13, J13 / 2, R1, far, ring_rate + N * psi_rate * R1),
        Body("flywheel", m4, J14, J14 / 2, R1, far, ring_rate + omega_rate * R1),
    )
