"""Figure 13: the narrow-banded sea, gamma 50.

The paper's captions were not available: the content follows its statements that the best pair gives 3.5 W at cg
7.5e-4, and that a larger cc loses lock earlier.
"""

from __future__ import annotations

from gyroctl.studies.paper.drawing import Drawing
from gyroctl.studies.paper.ensembles import Setup
from gyroctl.studies.paper.lock_curves import lock_curves


def draw(setup: Setup) -> Drawing:
    """Draw the figure."""
    return lock_curves(setup, 13, 50.0, {7.5e-4: "the best pair, cc 0.052,"})
