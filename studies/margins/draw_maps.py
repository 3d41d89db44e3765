"""Pictures over parameters: lock map with power contours and sense of rotation, tongue, margin heat maps."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.froude import growth
from gyroctl.studies.margins.axes import axis, power_levels, ticks, watts
from gyroctl.studies.margins.borders import Border
from gyroctl.studies.margins.maps import GROWS, NONE, STABLE, OrbitMap
from gyroctl.studies.margins.request import Request
from gyroctl.studies.style import GRID, INK, MUTED, PAPER_COLOUR, label, sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NEIMARK_COLOUR = "#C77700"
STABLE_COLOUR, GROWS_COLOUR, LOST_COLOUR = "#D7E9F5", "#FBE3C2", "#F4F5F7"
SENSES = {1: "psi' > 0", -1: "psi' < 0"}


def orbit_map(asked: Request, found: OrbitMap, borders: tuple[Border, ...] = ()) -> Figure:
    """Draw where lock exists, where it is stable, and how much power it gives.

    Parameters
    ----------
    asked : Request
        The operating point, which is marked.
    found : OrbitMap
        Orbits on the grid, over controls or over waves.
    borders : tuple of Border
        Exact borders by continuation, drawn instead of those of the grid where there are any.
    """
    upwards = found.axes[0] == "cc"
    title, held = ("Lock map", asked.sea) if upwards else ("Tongue of lock", asked.controls)
    figure, (panel,) = sheet(1, 1, (8.6, 5.6), title, f"{held}; contours: mean power")
    length = asked.plant.parameters.length_scale
    xs, ys, scale = _scaled(found, length)
    panel.set_facecolor(LOST_COLOUR)
    known = np.isfinite(found.border)
    at, edge = xs[known], found.border[known] * scale
    panel.fill_between(at, ys[0] if upwards else ys[-1], edge, color=STABLE_COLOUR, lw=0)
    growth = np.where(found.code == NONE, np.nan, found.growth)
    if np.any(found.code == GROWS):
        # the orange area ends at the border of lock: beyond it the growth is carried on from the last orbit
        filled = _carried(growth, upwards)
        panel.contourf(xs, ys, filled, levels=[0.0, 1e9], colors=[GROWS_COLOUR], zorder=1.2)
        if not borders:
            panel.contour(xs, ys, filled, levels=[0.0], colors=[NEIMARK_COLOUR], linewidths=1.6, zorder=1.3)
        rim = 1.05 * ys[-1] if upwards else 0.95 * ys[0]
        panel.fill_between(at, edge, rim, color=LOST_COLOUR, lw=0, zorder=1.5)
    power = np.ma.masked_invalid(found.power)
    if power.count() and float(power.max()) > float(power.min()) * 1.2:
        levels = power_levels(length, float(power.min()), float(power.max()))
        lines = panel.contour(xs, ys, power, levels=levels, colors=[MUTED], linewidths=0.8)
        panel.clabel(lines, fmt=watts, fontsize=8)
    if not borders:
        panel.plot(at, edge, color=INK, lw=2.0)
    for border in borders:
        panel.plot(border.x, border.y * scale, color=INK if border.kind == "fold" else NEIMARK_COLOUR, lw=1.8)
    other = _other_sense(panel, found, scale, asked.sense)
    x, y = _mark(asked, found)
    panel.plot([x], [y], "*", color=PAPER_COLOUR, ms=14, mec="white")
    _axes(panel, found, ys, length)
    handles = [*_legend(asked.sense), *other, _line("asked for", PAPER_COLOUR, marker="*", ls="", ms=11)]
    panel.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0)
    return figure


def _legend(sense: int) -> list[Any]:
    from matplotlib.patches import Patch

    return [
        Patch(color=STABLE_COLOUR, label=f"stable lock, {SENSES[sense]}"),
        Patch(color=GROWS_COLOUR, label="lock, but an oscillation grows"),
        Patch(facecolor=LOST_COLOUR, edgecolor=GRID, label="no locked orbit"),
        _line("fold", INK, lw=2.0),
        _line("Neimark-Sacker", NEIMARK_COLOUR, lw=1.6),
    ]


def _line(words: str, colour: str, **look: Any) -> Any:
    from matplotlib.lines import Line2D

    return Line2D([], [], color=colour, label=words, **look)


def heat_maps(asked: Request, controls: OrbitMap, waves: OrbitMap, basin: NDArray[np.float64], period: float) -> Figure:
    """Draw margins over (cc, cg) above and over (wp, height) below; `basin` is over the grid of the controls."""
    note = (
        f"above: {asked.sea}; below: {asked.controls}; star: asked for; crosses: lock, but an oscillation grows; "
        "basin: 24 disturbances of half the largest size"
    )
    figure, axes = sheet(2, 3, (12.6, 7.6), "Margins over controls and over waves", note)
    length = asked.plant.parameters.length_scale
    loads = np.maximum(controls.second[:, None], 1e-9 * growth("Nms", length))
    rooms = _decibels(controls.border[None, :] / loads, controls)
    heights = _decibels(waves.second[:, None] / waves.border[None, :], waves)
    wave_period = np.broadcast_to(2.0 * math.pi / waves.first[None, :], waves.growth.shape)
    panels: tuple[tuple[OrbitMap, NDArray[np.float64], str, str], ...] = (
        (controls, _decay(controls, np.full(controls.growth.shape, period)), "Slowest mode falls by e in [s]", "log"),
        (controls, rooms, "cg headroom to the fold [dB]", "db"),
        (controls, basin, "Share that returns after a disturbance", "share"),
        (waves, _decay(waves, wave_period), "Slowest mode falls by e in [s]", "log"),
        (waves, heights, "Height headroom [dB]", "db"),
        (waves, np.degrees(np.where(waves.code == STABLE, waves.angle, np.nan)), "Load angle [deg]", "angle"),
    )
    for panel, (grid, values, title, kind) in zip(axes, panels, strict=True):
        _heat(figure, panel, grid, values, kind, length)
        panel.set_title(title)
        x, y = _mark(asked, grid)
        panel.plot([x], [y], "*", color=PAPER_COLOUR, ms=12, mec="white")
    return figure


def _heat(figure: Figure, panel: Any, grid: OrbitMap, values: NDArray[np.float64], kind: str, length: float) -> None:
    from matplotlib.colors import LogNorm, Normalize

    (xs, ys, _), time = _scaled(grid, length), growth("s", length)
    finite = values[np.isfinite(values)]
    norm: Any = Normalize(0.0, 1.0)
    if kind == "log" and finite.size:
        norm = LogNorm(max(float(finite.min()), 1.0 * time), min(float(finite.max()), 1e4 * time))
    elif kind == "db":
        norm = Normalize(0.0, 24.0)
    elif kind == "angle":
        norm = Normalize(-150.0, 0.0)
    panel.set_facecolor(LOST_COLOUR)
    colours = "viridis_r" if kind == "log" else "viridis"
    mesh = panel.pcolormesh(xs, ys, np.ma.masked_invalid(values), norm=norm, cmap=colours, shading="nearest")
    figure.colorbar(mesh, ax=panel, fraction=0.05, pad=0.02)
    for j, i in np.argwhere((grid.code == GROWS) & ~np.isfinite(values)):
        panel.plot([xs[i]], [ys[j]], "x", color=NEIMARK_COLOUR, ms=5)
    panel.grid(visible=False)
    _axes(panel, grid, ys, length)


def _decay(grid: OrbitMap, period: NDArray[np.float64]) -> NDArray[np.float64]:
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(grid.code == STABLE, -period / grid.growth, np.nan)


def _decibels(ratio: NDArray[np.float64], grid: OrbitMap) -> NDArray[np.float64]:
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(grid.code == STABLE, 20.0 * np.log10(ratio), np.nan)


def _scaled(found: OrbitMap, length: float) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    _, scale = axis(found.axes[1], length)
    return found.first, found.second * scale, scale


def _mark(asked: Request, found: OrbitMap) -> tuple[float, float]:
    """The operating point on the axes of a map."""
    pair = (asked.cc, asked.cg) if found.axes[0] == "cc" else (asked.wave.wp, asked.wave.height)
    return pair[0], pair[1] * axis(found.axes[1], asked.plant.parameters.length_scale)[1]


def _axes(panel: Any, found: OrbitMap, ys: NDArray[np.float64], length: float) -> None:
    label(panel, "", *(axis(name, length)[0] for name in found.axes))
    if found.axes[0] == "cc":
        panel.set_xscale("log")
        panel.set_xticks(*ticks("cc", length, found.first[0], found.first[-1]))
    else:
        panel.set_yscale("log")
        panel.set_yticks(*ticks("height", length, ys[0], ys[-1]))
    panel.minorticks_off()
    panel.set_xlim(found.first[0], found.first[-1])
    panel.set_ylim(ys[0], ys[-1])


def _carried(growth: NDArray[np.float64], upwards: bool) -> NDArray[np.float64]:
    """Fill what lies beyond the border with the value of the last orbit of the column."""
    filled = growth if upwards else growth[::-1]
    filled = filled.copy()
    for i in range(1, filled.shape[0]):
        filled[i] = np.where(np.isnan(filled[i]), filled[i - 1], filled[i])
    return filled if upwards else filled[::-1]


def _other_sense(panel: Any, found: OrbitMap, scale: float, sense: int) -> list[Any]:
    handles = []
    for exists, marker, words in ((1.0, "P", "locks too"), (0.0, "_", "does not lock")):
        rows = found.other_sense[found.other_sense[:, 2] == exists]
        if rows.size:
            panel.plot(rows[:, 0], rows[:, 1] * scale, marker, color=MUTED, ms=6, zorder=3)
            handles.append(_line(f"{SENSES[-sense]} {words}", MUTED, marker=marker, ls=""))
    return handles
