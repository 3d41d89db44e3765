"""Gain-scheduled laws from the linear models along the locked orbits."""
