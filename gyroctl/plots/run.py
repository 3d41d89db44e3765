"""A run over time: waves, ring, float, controls, power."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gyroctl.errors import InputError
from gyroctl.palette import MUTED, law_styles
from gyroctl.plots.style import label, sheet, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PANELS = (
    ("waves", "elevation [m]", ("elevation",)),
    ("ring", "speed ψ\N{PRIME} [rad/s]", ("psi_rate",)),
    ("float", "angle [rad]", ("phi1", "phi3")),
    ("coupling", "cc [Nms]", ("cc",)),
    ("generator", "cg [Nms]", ("cg",)),
    ("power", "power [W]", ("power",)),
)
"""Title, axis and variables of each panel, from above to below."""

NAMES = {"phi1": "φ1", "phi3": "φ3"}
NEEDED = ("time", *(name for _, _, names in PANELS for name in names))


def run_figure(ds: Any, begin: float | None = None, end: float | None = None) -> Figure:
    """Draw a run.

    Parameters
    ----------
    ds : xarray.Dataset
        From `gyroctl.simulate`.
    begin, end : float, optional
        Times to draw; the whole run without. [s]

    Raises
    ------
    InputError
        For variables that are missing, or times without samples between them.
    """
    missing = [name for name in NEEDED if name not in ds.variables]
    if missing:
        mend = "Give the dataset of gyroctl.simulate with all its variables"
        raise InputError("dataset", missing[0], "is not in it", mend)
    time = np.asarray(ds["time"].values, dtype=np.float64)
    low = time[0] if begin is None else begin
    high = time[-1] if end is None else end
    part = (time >= low) & (time <= high)
    if np.count_nonzero(part) < 2:
        mend = f"Give times between {time[0]:g} and {time[-1]:g} s"
        raise InputError("begin", (begin, end), "no two samples lie there", mend)
    law = str(ds.attrs.get("law", "law"))
    look = law_styles([law])[law]
    hs, wp = (float(ds.attrs.get(name, np.nan)) for name in ("hs", "wp"))
    note = f"{ds.attrs.get('plant', '')}; Hs {hs:g} m, peak {wp:g} rad/s; seed {ds.attrs.get('seed', '')}"
    heights = [1.0, 1.0, 1.0, 0.8, 0.8, 1.0]
    with styled(formulas=False):
        title = f"Run of {law}"
        figure, axes = sheet(len(PANELS), 1, (9.0, 9.5), title, note, sharex=True, height_ratios=heights)
        for panel, (words, unit, names) in zip(axes, PANELS, strict=True):
            for i, name in enumerate(names):
                colour = MUTED if name == "elevation" or i else look.colour
                look_of: dict[str, Any] = {"color": colour, "lw": 1.1, "ls": ("-", "--")[i]}
                panel.plot(time[part], np.asarray(ds[name].values)[part], label=NAMES.get(name, name), **look_of)
            if len(names) > 1:
                panel.legend(loc="upper right", ncols=len(names))
            label(panel, words, "", unit)
        axes[-1].set_xlabel("time [s]")
    return figure
