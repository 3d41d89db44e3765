"""Linearisation about the synchronized orbit: flow and locked orbit with its Floquet multipliers."""

from gyroctl.linearisation.orbit import PeriodicOrbit, lock_orbit

__all__ = ["PeriodicOrbit", "lock_orbit"]
