"""The unit of frequency of a float: what makes bands, weights and checks independent of its size.

Under Froude scaling all frequencies go as sqrt(g / L), and added moments of inertia as rho L^5. The length of a table
is therefore taken from its added inertia at infinite frequency, which every table has: L^5 = (Jh1 + Jh3) / rho. Bands
are known in rad/s for the shipped float, and turn with the ratio of the two units for any other one.
"""

from __future__ import annotations

import math

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.database import shipped
from gyroctl.hydrodynamics.table import Hydrodynamics


def length(hydro: Hydrodynamics) -> float:
    """Return the length of a float by its added inertia. [m]

    Parameters
    ----------
    hydro : Hydrodynamics
        Any table.

    Raises
    ------
    InputError
        When the added inertia at infinite frequency is not that of a body.
    """
    inertia = float(hydro.added_mass_inf[0] + hydro.added_mass_inf[1])
    if not inertia > 0.0:
        problem = "is not the added inertia of a body, which is positive"
        mend = "Give the rows of infinite frequency, or a table that reaches higher"
        raise InputError("hydrodynamics.added_mass_inf", inertia, problem, mend)
    return math.pow(inertia / hydro.rho, 0.2)


def natural(hydro: Hydrodynamics) -> float:
    """Return the unit of frequency of a float, sqrt(g / L). [rad/s]"""
    return math.sqrt(hydro.g / length(hydro))


def frequency_ratio(hydro: Hydrodynamics) -> float:
    """Return how a frequency of the shipped float turns into that of another one, 1 for the shipped table itself. [-]

    Parameters
    ----------
    hydro : Hydrodynamics
        Any table; enlarged by the factor s in its lengths (Froude), the ratio is 1 / sqrt(s).
    """
    return natural(hydro) / natural(shipped())


def damping_ratio(hydro: Hydrodynamics) -> float:
    """Return how a damping of rotation [Nms/rad] turns: as rho L^5 sqrt(g / L), 1 for the shipped table itself. [-]"""
    own, ours = hydro, shipped()
    inertia = (own.rho * length(own) ** 5) / (ours.rho * length(ours) ** 5)
    return inertia * frequency_ratio(hydro)
