"""Orbits and margins of a law in the loop."""
