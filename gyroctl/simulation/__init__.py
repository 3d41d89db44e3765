"""Simulation: lock, metrics, trajectories and the compiled ensemble.

The names stand in ``__init__.pyi`` and are loaded when they are first used: a page that shows results takes figures
from this room, and not what computes them.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
