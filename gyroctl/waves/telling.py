"""A sea told in a line."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from gyroctl.waves.directional import DirectionalSpectrum
from gyroctl.waves.tabulated import TabulatedSpectrum

if TYPE_CHECKING:
    from gyroctl.waves import Sea


def in_a_line(sea: Sea) -> str:
    """Height, peak and heading of a sea; of a spectrum that was measured its energy period and energy too."""
    more = ""
    if isinstance(sea, TabulatedSpectrum | DirectionalSpectrum):
        more = f", Te {sea.te:.4g} s, m0 {sea.moment(0):.4g} m^2"
    if isinstance(sea, DirectionalSpectrum):
        more += f", spread {sea.spread:.3g} deg"
    period = 2.0 * math.pi / sea.wp
    return f"Hs {sea.hs:.4g} m, Tp {period:.4g} s ({sea.wp:.4g} rad/s), heading {sea.heading:g} deg{more}"
