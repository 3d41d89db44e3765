"""Linear models about the locked orbit: periodic, lifted, averaged, harmonic; their norms and Riccati equations."""

from gyroctl.linearisation.locked_orbit import PeriodicOrbit, lock_orbit
from gyroctl.linearisation.model import PeriodicModel, linearise

__all__ = ["PeriodicModel", "PeriodicOrbit", "linearise", "lock_orbit"]
