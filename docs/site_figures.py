"""The look of the figures that are drawn when the site is built: that of the studies."""

from __future__ import annotations

from typing import Any

import matplotlib as mpl

from gyroctl.studies.style import styled


def look(gallery: dict[str, Any], page: str) -> None:
    """Set matplotlib to the studies' look before a page draws."""
    with styled():
        chosen = {name: value for name, value in mpl.rcParams.items() if name != "backend"}
    mpl.rcParams.update(chosen)
