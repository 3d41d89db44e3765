"""The picture of a site: power and probability of lock in every sea state, for every law."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.palette import LOCK_SCALE
from gyroctl.reports.wording import number
from gyroctl.studies.style import MUTED, ON_COLOUR, label, sheet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST = 8
"""Laws that are drawn: those of most energy."""

NUMBERS = 400
"""Sea states up to which a number stands in each."""


def draw(content: Mapping[str, Any]) -> Figure:
    """Draw the matrices: a row for each law, power on the left, lock on the right."""
    from matplotlib.colors import LinearSegmentedColormap

    laws = strongest(content)
    heights, periods = sorted({c["hs_m"] for c in content["cells"]}), sorted({c["period_s"] for c in content["cells"]})
    wide = max(4.2, 1.2 + 0.62 * len(periods))
    tall = max(2.2, 1.2 + 0.3 * len(heights))
    request = content["request"]
    note = (
        f"{request['table'] or 'table'}; {content['device']['name']}; scale {request['scale']:g}; "
        f"{len(request['seeds'])} realisations of {request['duration_s']:g} s in every sea state; JONSWAP, peak "
        f"enhancement {request['gamma']:g}. Crossed out: no locked orbit. Empty: not run, or never there."
    )
    figure, axes = sheet(len(laws), 2, (2.0 * wide, tall * len(laws) + 0.9), "Power and lock at the site", note)
    scales = LinearSegmentedColormap.from_list("lock", [(at, colour) for at, colour in LOCK_SCALE])
    powers = {law: matrix(content, law, "power_at_site") for law in laws}
    most = max((float(np.nanmax(p)) for p in powers.values() if np.isfinite(p).any()), default=1.0) or 1.0
    unit, by = ("kW", 1e3) if most >= 1e3 else ("W", 1.0)
    for row, law in enumerate(laws):
        left, right = axes[2 * row], axes[2 * row + 1]
        _heat(left, powers[law] / by, heights, periods, "Blues", most / by)
        _heat(right, matrix(content, law, "lock"), heights, periods, scales, 1.0)
        for one in (left, right):
            _cross(one, content, heights, periods)
        kind = content["scatter"]["period"]
        label(left, f"{law}: power [{unit}]", f"{kind} [s]", "Hs [m]")
        label(right, f"{law}: probability of lock", f"{kind} [s]", "Hs [m]")
    return figure


def strongest(content: Mapping[str, Any], most: int = MOST) -> list[str]:
    """Laws by their energy, the greatest first."""
    by_energy = sorted(content["annual"], key=lambda law: -(content["annual"][law]["energy"]["value"] or 0.0))
    return by_energy[:most]


def matrix(content: Mapping[str, Any], law: str, name: str) -> NDArray[np.float64]:
    """Values of a number in the sea states, (heights, periods); NaN where there is none."""
    heights, periods = sorted({c["hs_m"] for c in content["cells"]}), sorted({c["period_s"] for c in content["cells"]})
    found = np.full((len(heights), len(periods)), np.nan)
    for cell in content["cells"]:
        value = cell["laws"].get(law, {}).get(name)
        value = value["value"] if isinstance(value, Mapping) else value
        if value is not None:
            found[heights.index(cell["hs_m"]), periods.index(cell["period_s"])] = value
    return found


def _heat(
    axes: Axes, values: NDArray[np.float64], heights: Sequence[float], periods: Sequence[float], scale: Any, most: float
) -> None:
    axes.imshow(np.ma.masked_invalid(values), origin="lower", aspect="auto", cmap=scale, vmin=0.0, vmax=1.25 * most)
    if scale != "Blues":
        axes.images[0].set_clim(0.0, 1.0)
    axes.set_xticks(range(len(periods)), [f"{period:.4g}" for period in periods], fontsize=8)
    axes.set_yticks(range(len(heights)), [f"{height:.3g}" for height in heights], fontsize=8)
    axes.grid(visible=False)
    if values.size > NUMBERS:
        return
    for (row, column), value in np.ndenumerate(values):
        if np.isfinite(value):
            dark = value > 0.75 * most if scale == "Blues" else value < 0.25 or value > 0.9
            axes.text(
                column,
                row,
                number(value, 2),
                ha="center",
                va="center",
                fontsize=7,
                color="white" if dark else ON_COLOUR,
            )


def _cross(axes: Axes, content: Mapping[str, Any], heights: Sequence[float], periods: Sequence[float]) -> None:
    still = [cell for cell in content["cells"] if cell["state"] == "no lock"]
    across = [periods.index(cell["period_s"]) for cell in still]
    up = [heights.index(cell["hs_m"]) for cell in still]
    axes.plot(across, up, "x", color=MUTED, markersize=9, markeredgewidth=0.8, alpha=0.6)
