"""What the rolling contact of the spin axis carries: the moment that presses it on its track, and the friction needed.

The equations take rolling as a constraint, theta' = N psi'. What keeps it is friction between the ends of the spin
axis and the track in the ring. The gyroscopic moment of axis and flywheel presses them on the track, once above and
once below (M3, about the ring's third axis), and the constraint asks for the torque lambda about the spin axis.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyroctl.plant.beyond import coupling_torque, lost
from gyroctl.plant.equations import OMEGA_RATE, PHI1_RATE, PHI3_RATE, PSI, PSI_RATE, Coefficients
from gyroctl.plant.friction import contact_of, pressing
from gyroctl.plant.plant import Plant


class ContactLoad(NamedTuple):
    """What the contact carries, each () or (batch,)."""

    M3: NDArray[np.float64]
    """Moment that presses the spin axis on the track, about the ring's third axis; negative while it rolls forwards on
    the side where it started. [Nm]"""
    torque: NDArray[np.float64]
    """Torque of the friction on the spin axis: lambda, and what rolling resistance there is. [Nm]"""
    traction: NDArray[np.float64]
    """Coefficient of friction that rolling needs, N |torque| / |M3|; infinite where nothing presses. Where the axis may
    slip, what it takes of the friction that there is. [-]"""


def contact_load(plant: Plant, x: ArrayLike, u: Any, moments: Any) -> ContactLoad:
    """Load of the rolling contact, from the balance of momentum of spin axis and flywheel.

    Parameters
    ----------
    plant : Plant
        The device.
    x : array_like, (n,) or (n, batch)
        State in the order of `plant.labels`. [rad, rad/s]
    u : (cc, cg)
        Controls, scalars or (batch,). [Nms]
    moments : (Me1, Me3) or (len(channels),)
        Wave moments [Nm], or all signals in the order of `plant.channels`; scalars or (batch,).

    Returns
    -------
    ContactLoad

    Raises
    ------
    InputError
        For a state of another shape.
    """
    state = np.asarray(x, float)
    return load_of(plant.coefficients, state, plant.derivative(state, u, moments), u)


def load_of(k: Coefficients, x: NDArray[np.float64], dx: NDArray[np.float64], u: Any) -> ContactLoad:
    """Load of the contact from the state (n, ...), its rate of change (n, ...) and the controls, see `contact_load`."""
    c, s = np.cos(x[PSI]), np.sin(x[PSI])
    v1, v3, w, W = x[PHI1_RATE], x[PHI3_RATE], x[PSI_RATE], x[OMEGA_RATE]
    a1, a3, aW = dx[PHI1_RATE], dx[PHI3_RATE], dx[OMEGA_RATE]
    slips = contact_of(k.beyond) is not None
    axis, rate = (x[-1], dx[-1]) if slips else (k.N * w, k.N * dx[PSI_RATE])  # of theta
    u1, u3 = c * v1 - s * v3, s * v1 + c * v3
    turning = c * a1 - s * a3 - w * u3  # rate of u1
    M3 = k.K * (s * a1 + c * a3) + pressing(k, u1, w, W, axis)
    bearing, windage, resistance = lost(k.beyond.losses if k.beyond else None, W, axis, M3)
    if slips or k.Gpo == 0.0:
        connection = coupling_torque(k.beyond, u[0], W - axis)
    else:  # geared: the flywheel's own balance says what takes it along
        connection = -k.J4 * (aW + turning) - u[1] * W - bearing - windage
    torque = 2.0 * k.J3 * (rate + turning) - connection + resistance
    with np.errstate(divide="ignore", invalid="ignore"):
        traction = np.where(torque == 0.0, 0.0, k.N * np.abs(torque) / np.abs(M3))
    return ContactLoad(M3, torque, traction)
