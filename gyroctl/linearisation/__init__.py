"""Linearisation about the synchronized orbit: flow, locked orbits, their multipliers, modes and bifurcations."""

from gyroctl.linearisation.bifurcation import BifurcationCurve, curve
from gyroctl.linearisation.continuation import Branch, SpecialPoint, continue_orbit
from gyroctl.linearisation.lockmap import LockMap, critical_damping, lock_map, tongue
from gyroctl.linearisation.modes import Mode
from gyroctl.linearisation.monodromy import monodromy
from gyroctl.linearisation.orbit import PeriodicOrbit, lock_orbit
from gyroctl.linearisation.palc import Palc
from gyroctl.linearisation.periodic import PeriodicModel, linearise

__all__ = [
    "BifurcationCurve",
    "Branch",
    "LockMap",
    "Mode",
    "Palc",
    "PeriodicModel",
    "PeriodicOrbit",
    "SpecialPoint",
    "continue_orbit",
    "critical_damping",
    "curve",
    "linearise",
    "lock_map",
    "lock_orbit",
    "monodromy",
    "tongue",
]
