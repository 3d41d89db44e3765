"""Figure 14: the broad-banded sea, gamma 1.

The paper's captions were not available: the content follows its statements that cc 0.052 Nms hardly holds at any cg,
while 0.104 and 0.156 hold up to cg 1.5e-4 and give 0.62 W.
"""

from __future__ import annotations

from gyroctl.studies.paper.drawing import Drawing
from gyroctl.studies.paper.ensembles import Setup
from gyroctl.studies.paper.lock_curves import lock_curves


def draw(setup: Setup) -> Drawing:
    """Draw the figure."""
    return lock_curves(setup, 14, 1.0, {1.5e-4: "cc 0.104 and 0.156 hold up to the line"})
