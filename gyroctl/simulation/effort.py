"""What a law asks of its actuators: mean, travel, share of the time on the move and at the ends of the stroke."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

UNITS = {
    f"{control}_{what}": unit
    for control in ("cc", "cg")
    for what, unit in (("mean", "Nms"), ("travel", "Nms/s"), ("moving", "1"), ("at_limit", "1"), ("at_zero", "1"))
}
"""Names of what is told of each control, and units; Nms/s is written as the rate that it is."""

SMALL = 1e-3
"""Part of the stroke up to which a control counts as where it was, or as at the end of its stroke. [1]"""


def effort(controls: ArrayLike, limits: tuple[float, float], period: float) -> dict[str, float]:
    """Use of the controls of a run.

    Parameters
    ----------
    controls : array_like, (n, 2)
        cc, cg as they act from each sample on. [Nms]
    limits : tuple of float
        Upper limits of both; what is NaN is taken from the largest value. [Nms]
    period : float
        Spacing of the samples. [s]

    Returns
    -------
    dict
        By the names of `UNITS`: the mean; the sum of all changes over the time; the share of the samples that change by
        more than `SMALL` of the stroke; the share of those at the upper limit, and at zero, to within `SMALL` of it.
    """
    values: NDArray[np.float64] = np.asarray(controls, dtype=np.float64)
    found: dict[str, float] = {}
    for control, course, limit in zip(("cc", "cg"), values.T, limits, strict=True):
        stroke = limit if math.isfinite(limit) else float(np.max(np.abs(course), initial=0.0)) or 1.0
        steps = np.abs(np.diff(course))
        near = SMALL * stroke
        found |= {
            f"{control}_mean": float(np.mean(course)),
            f"{control}_travel": float(np.sum(steps)) / max(steps.size * period, period),
            f"{control}_moving": float(np.mean(steps > near)) if steps.size else 0.0,
            f"{control}_at_limit": float(np.mean(course >= stroke - near)),
            f"{control}_at_zero": float(np.mean(np.abs(course) <= near)),
        }
    return found
