"""Figure 12: influence of the magnetic coupling and the generator gain at gamma 5.

The paper's captions were not available: the content follows its statements that cc 0.052 Nms holds at cg 3.5e-4 and
loses lock at 1e-3, and that a larger cc loses lock earlier.
"""

from __future__ import annotations

from gyroctl.studies.paper.drawing import Drawing
from gyroctl.studies.paper.ensembles import Setup
from gyroctl.studies.paper.lock_curves import lock_curves


def draw(setup: Setup) -> Drawing:
    """Draw the figure."""
    return lock_curves(setup, 12, 5.0, {3.5e-4: "cc 0.052 holds", 1e-3: "cc 0.052 is lost"})
