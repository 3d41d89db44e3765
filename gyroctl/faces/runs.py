"""Faces of a run and of a comparison, from their datasets alone."""

from __future__ import annotations

from typing import Any

import numpy as np

from gyroctl.faces.show import Face, number
from gyroctl.faces.svg import bars, curves
from gyroctl.palette import law_styles

SHOWN = 12
"""Most laws of the picture."""


def trajectory_face(ds: Any) -> Face | None:
    """Tell a run; pictured by its power. None for what is left of one by a choice of variables."""
    if not {"power", "psi_rate", "phi1"} <= set(ds.variables) or ds["power"].dims != ("time",):
        return None
    time, told = np.asarray(ds["time"].values, dtype=np.float64), ds.attrs
    if time.size < 2:
        return None
    power = np.asarray(ds["power"].values, dtype=np.float64)
    law = str(told.get("law", "law"))
    facts = [
        ("of", f"{time[-1] - time[0]:g} s at {time[1] - time[0]:g} s"),
        ("seed", str(told.get("seed", ""))),
        ("sea", f"Hs {number(told.get('hs', np.nan), 'm')}, peak {number(told.get('wp', np.nan), 'rad/s')}"),
        ("mean power", number(power.mean(), "W")),
        ("mean ring speed", number(ds["psi_rate"].values.mean(), "rad/s")),
        ("98 % of phi1", number(np.quantile(np.abs(ds["phi1"].values), 0.98), "rad", 3)),
        ("plant", str(told.get("plant", ""))),
        ("variables", f"{len(ds.data_vars)}, all of them by .dataset"),
    ]
    colours = [law_styles([law])[law].colour]
    rows = {"power": power}
    return Face(f"Trajectory of {law}", facts, lambda: curves(time, rows, "time [s]", "power [W]", colours))


def comparison_face(ds: Any) -> Face | None:
    """Tell a comparison; pictured by the mean power of its laws. None for what is left by a choice of variables."""
    if not {"mean_power", "locked"} <= set(ds.variables) or ds["mean_power"].dims != ("law", "realisation"):
        return None
    laws = [str(name) for name in ds["law"].values]
    table = np.asarray(ds["mean_power"].values, dtype=np.float64)
    known = np.isfinite(table)
    power = [float(row[good].mean()) if good.any() else np.nan for row, good in zip(table, known, strict=True)]
    locked = np.asarray(ds["locked"].values, dtype=np.float64).mean(axis=1)
    order = sorted(range(len(laws)), key=lambda i: -power[i] if np.isfinite(power[i]) else np.inf)
    facts = [
        ("realisations", f"{ds.sizes['realisation']} of {number(ds.attrs.get('duration', np.nan), 's')}"),
        ("sea", f"Hs {number(ds.attrs.get('hs', np.nan), 'm')}, peak {number(ds.attrs.get('wp', np.nan), 'rad/s')}"),
        *((laws[i], f"{power[i]:.3g} W, {100 * locked[i]:.0f} % locked") for i in order[:SHOWN]),
        ("plant", str(ds.attrs.get("plant", ""))),
        ("variables", f"{len(ds.data_vars)}, all of them by .dataset"),
    ]
    rows = {laws[i]: power[i] for i in order[:SHOWN]}
    colours = [law_styles(laws)[name].colour for name in rows]
    return Face(f"Comparison of {len(laws)} laws", facts, lambda: bars(rows, "mean power [W]", colours))
