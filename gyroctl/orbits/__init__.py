"""The locked orbits of the device: search, multipliers, modes, continuation, bifurcations, where lock exists."""

from gyroctl.orbits.bifurcation import BifurcationCurve, curve
from gyroctl.orbits.continuation import Branch, SpecialPoint, continue_orbit
from gyroctl.orbits.lock_map import LockMap, critical_damping, lock_map, tongue
from gyroctl.orbits.modes import Mode, find_modes
from gyroctl.orbits.monodromy import monodromy
from gyroctl.orbits.nearest_orbit import find_orbit
from gyroctl.orbits.orbit import Orbit
from gyroctl.orbits.pseudo_arclength import Palc
from gyroctl.orbits.search import search_orbit

__all__ = [
    "BifurcationCurve",
    "Branch",
    "LockMap",
    "Mode",
    "Orbit",
    "Palc",
    "SpecialPoint",
    "continue_orbit",
    "critical_damping",
    "curve",
    "find_modes",
    "find_orbit",
    "lock_map",
    "monodromy",
    "search_orbit",
    "tongue",
]
