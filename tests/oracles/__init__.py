"""Independent oracles of the equations of motion: a symbolic derivation and a rigid-body engine.

Neither reads the text of the plant's equations. `four_bodies` and `derivations` start from the inertia, the centre and
the angular velocity of each body; `engine` hands the same four bodies to MuJoCo. `generic_plant` holds what the tests
read off any plant through its public `derivative` alone.
"""

from __future__ import annotations

from oracles.derivations import Derivation, derive
from oracles.engine import Engine, Flight, Forcing, free_flight
from oracles.four_bodies import Body, four_bodies
from oracles.generic_plant import (
    RadiationRealisation,
    jacobian,
    radiation_realisation,
    random_states,
    runge_kutta,
    table_1,
)

__all__ = [
    "Body",
    "Derivation",
    "Engine",
    "Flight",
    "Forcing",
    "RadiationRealisation",
    "derive",
    "four_bodies",
    "free_flight",
    "jacobian",
    "radiation_realisation",
    "random_states",
    "runge_kutta",
    "table_1",
]
