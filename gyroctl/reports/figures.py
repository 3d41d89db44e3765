"""Figures of the ensemble: one function a figure, each from the dataset, its evaluation and a paper to a drawing."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from gyroctl.reports import layout
from gyroctl.reports.canvas import Drawing, Key, Paper, Room, listed_rows, sheet
from gyroctl.reports.coinciding import groups
from gyroctl.reports.evaluation import Evaluation
from gyroctl.reports.theme import FLOWS, REFERENCE_GREY, WARNING, law_styles
from gyroctl.reports.verdict import judge
from gyroctl.reports.wording import listed, number, signed
from gyroctl.statistics import NOT_DISTINGUISHABLE, Estimate

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

MOST_PAIRS = 15
MOST_LINES = 64
CLEAR_BLUE = "#0072B2"
ROW = 28.0
"""Height of a row of a law. [px]"""


def power_per_realisation(ds: xr.Dataset, evaluation: Evaluation, paper: Paper) -> Drawing:
    """Mean power [W] of every run, lines joining the same realisation; runs that lost lock are red crosses."""
    laws, styles = evaluation.by_power, law_styles(layout.names(ds), evaluation.reference)
    names = [law.name for law in laws]
    ranked = ds.sel(law=names)
    power, locked = layout.values(ranked, "mean_power"), layout.values(ranked, "locked").astype(bool)
    shift = _spread(len(evaluation.seeds))
    figure, (axes,) = sheet(paper, [ROW * len(laws)], room=Room(left=paper.margin(names)))
    for column in range(min(shift.size, MOST_LINES)):
        axes.plot(power[:, column], np.arange(len(laws)) + shift[column], color=REFERENCE_GREY, lw=0.6, alpha=0.35)
    for index, law in enumerate(laws):
        at = index + shift
        axes.scatter(power[index][locked[index]], at[locked[index]], s=20, color=styles[law.name].colour, linewidths=0)
        lost = ~locked[index]
        axes.scatter(power[index][lost], at[lost], s=26, marker="x", color=WARNING, linewidths=1.5)
        _whisker(axes, law.power, index, REFERENCE_GREY, marker="|", size=13.0)
    listed_rows(axes, names, paper)
    axes.set_xlim(left=min(0.0, float(np.nanmin(power, initial=0.0))))
    axes.set_xlabel("Mean power of a run [W]")
    keys = [Key("mean and 95 % interval", REFERENCE_GREY, "bar")]
    keys += [] if locked.all() else [Key("lost lock", WARNING, "cross")]
    most = laws[0]
    alt = (
        f"Mean power of every run of {len(laws)} laws on {len(evaluation.seeds)} realisations, a row a law, most power "
        f"first: {most.name} with {number(most.power.value)} W on average, {laws[-1].name} last with "
        f"{number(laws[-1].power.value)} W."
    )
    return Drawing(figure, alt, tuple(keys))


def survival(ds: xr.Dataset, evaluation: Evaluation, paper: Paper) -> Drawing:
    """Kaplan-Meier probability that lock still holds [1] over time [s]; laws whose curves coincide share a line."""
    styles = law_styles(layout.names(ds), evaluation.reference)
    figure, (axes,) = sheet(paper, [230.0], room=Room(left=50.0))
    laws = evaluation.by_power
    banded, keys, said = _banded(evaluation), list[Key](), list[str]()
    curves = [np.concatenate([law.survival.time, law.survival.probability]) for law in laws]
    for group in groups(curves):
        first, style = laws[group[0]], styles[laws[group[0]].name]
        curve = first.survival
        known = np.isfinite(curve.low) & np.isfinite(curve.high)
        if known.any() and any(laws[k].name in banded for k in group):
            low, high = curve.low[known], curve.high[known]
            axes.fill_between(curve.time[known], low, high, step="post", color=style.colour, alpha=0.12, linewidth=0)
        dash = {"solid": "-", "dash": "--", "dot": ":"}[style.dash]
        axes.step(curve.time, curve.probability, where="post", lw=2.2, color=style.colour, ls=dash)
        held = {f"{laws[k].locked}/{laws[k].runs}" for k in group}
        named = "all laws" if len(group) == len(laws) > 1 else listed([laws[k].name for k in group])
        keys.append(Key(f"{named}: {' or '.join(sorted(held))} held lock", style.colour, style.dash))
        said.append(f"{named} {number(float(curve.probability[-1]), 2)}")
    axes.set_xlim(0.0, evaluation.duration)
    axes.set_ylim(-0.02, 1.04)
    axes.set_xlabel("Time [s]")
    axes.set_ylabel("P(lock still holds) [1]")
    alt = f"Probability that lock still holds over {evaluation.duration:g} s. In the end: {'; '.join(said)}."
    return Drawing(figure, alt, tuple(keys))


def motion(ds: xr.Dataset, evaluation: Evaluation, paper: Paper) -> Drawing:
    """98 % quantile of |phi1| and |phi3| [rad] of every run against the motion limit."""
    laws, styles = evaluation.by_power, law_styles(layout.names(ds), evaluation.reference)
    names, limit = [law.name for law in laws], evaluation.motion_limit
    room = Room(left=paper.margin(names), top=8.0, across=24.0)
    heights, columns = ([ROW * len(laws)] * 2, 1) if paper.narrow else ([ROW * len(laws)], 2)
    figure, panels = sheet(paper, heights, columns, room)
    titles = ("phi1_p98", "φ₁, horizontal"), ("phi3_p98", "φ₃, vertical")
    for axes, (variable, title) in zip(panels, titles, strict=True):
        values = layout.values(ds.sel(law=names), variable)
        for index, law in enumerate(laws):
            over, at = values[index] > limit, index + _spread(values.shape[1])
            axes.scatter(values[index][~over], at[~over], s=16, color=styles[law.name].colour, linewidths=0)
            axes.scatter(values[index][over], at[over], s=22, marker="x", color=WARNING, linewidths=1.4)
        axes.axvline(limit, color=WARNING, lw=1.3, ls="--")
        widest = max(float(np.nanmax(values, initial=0.0)), limit)
        axes.set_xlim(0.0, 1.08 * widest)
        axes.set_xlabel(f"{title}: 98 % of |angle| [rad]")
        listed_rows(axes, names, paper)
        if not paper.narrow and axes is not panels[0]:
            axes.tick_params(axis="y", labelleft=False)
    keys = (Key(f"limit {limit:g} rad", WARNING, "dash"), Key("a run beyond it", WARNING, "cross"))
    over = [f"{law.name} {law.over_limit} of {law.runs}" for law in laws if law.over_limit]
    alt = f"98 % of the motion of every run beside the limit of {limit:g} rad; beyond it: {listed(over)}."
    return Drawing(figure, alt, keys)


def paired_forest(ds: xr.Dataset, evaluation: Evaluation, paper: Paper) -> Drawing:
    """Paired differences in mean power [W] with 95 % intervals; grey where the two laws are not distinguishable."""
    drawn = {law.name for law in evaluation.laws}
    known = (d for d in evaluation.power_differences if drawn.issuperset((d.first, d.second)))
    pairs = [d for d in known if math.isfinite(d.estimate.value)]
    if len(pairs) > MOST_PAIRS:
        centre = evaluation.reference or evaluation.by_power[0].name
        pairs = [d for d in pairs if centre in (d.first, d.second)]
    pitch = 44.0 if paper.narrow else ROW
    names = [f"{paper.short(d.first)} − {paper.short(d.second)}" for d in pairs]
    margin = 12.0 if paper.narrow else max((paper.letters(name) for name in names), default=0.0) + 14.0
    room = Room(left=margin, right=14.0 if paper.narrow else 150.0)
    figure, (axes,) = sheet(paper, [pitch * max(len(pairs), 1)], room=room)
    axes.axvline(0.0, color=REFERENCE_GREY, lw=1.2)
    for row, pair in enumerate(pairs):
        apart = pair.words in ("more", "less")
        words = f"{signed(pair.estimate.value)} W" if apart else NOT_DISTINGUISHABLE
        words = words if math.isfinite(pair.p_holm) else "no interval"
        colour = CLEAR_BLUE if apart else REFERENCE_GREY
        _whisker(axes, pair.estimate, row + (0.22 if paper.narrow else 0.0), colour, "s", 6.5, filled=apart)
        beside = axes.get_yaxis_transform()
        if paper.narrow:
            axes.text(0.0, row - 0.22, f"{names[row]}: {words}", transform=beside, va="center", fontsize=paper.type - 1)
        else:
            axes.text(1.01, row, words, transform=beside, va="center", clip_on=False)
    listed_rows(axes, names, paper._replace(longest=99))
    if paper.narrow:
        axes.tick_params(axis="y", labelleft=False)
        axes.spines["left"].set_visible(False)
    axes.set_xlabel("Paired difference in mean power [W]")
    keys = (
        Key("distinguishable", CLEAR_BLUE, "box"),
        Key(f"{NOT_DISTINGUISHABLE}, or no interval", REFERENCE_GREY, "hole"),
    )
    told_apart = [d for d in pairs if d.words in ("more", "less")]
    alt = (
        f"Paired differences in mean power of {len(pairs)} pairs of laws with 95 % intervals; {len(told_apart)} are "
        f"distinguishable from none. The numbers stand in the table of all pairs below."
    )
    return Drawing(figure, alt, keys)


def energy(ds: xr.Dataset, evaluation: Evaluation, paper: Paper) -> Drawing:
    """Where the energy of the waves goes: mean power flows [W] stacked per law, wave input marked."""
    laws = evaluation.by_power
    names = [law.name for law in laws]
    figure, (axes,) = sheet(paper, [ROW * len(laws)], room=Room(left=paper.margin(names)))
    up, down = np.zeros(len(laws)), np.zeros(len(laws))
    for name, colour in FLOWS.items():
        flow = np.nan_to_num([law.flows[name] for law in laws])
        axes.barh(np.arange(len(laws)), flow, 0.56, left=np.where(flow >= 0.0, up, down), color=colour, linewidth=0)
        up, down = up + np.maximum(flow, 0.0), down + np.minimum(flow, 0.0)
    given = [law.wave_input_w for law in laws]
    axes.scatter(given, np.arange(len(laws)), marker="|", s=380, color=REFERENCE_GREY, linewidths=2.2)
    listed_rows(axes, names, paper)
    ends = [end for end in (*given, *up) if math.isfinite(end)]
    axes.set_xlim(1.1 * min(down) if min(down) < -0.1 else 0.0, 1.04 * max(ends, default=1.0) or 1.0)
    axes.set_xlabel("Mean power [W]")
    keys = [Key(name, colour, "box") for name, colour in FLOWS.items()]
    said = "; ".join(f"{law.name} {number(law.flows['generator'])} of {number(law.wave_input_w)} W" for law in laws)
    alt = f"Where the wave power of each law goes, stacked; the generator gets: {said}. The table below has each flow."
    return Drawing(figure, alt, (*keys, Key("wave input", REFERENCE_GREY, "bar")))


def _whisker(
    axes: Axes, estimate: Estimate, row: float, colour: str, marker: str, size: float, filled: bool = True
) -> None:
    """Mark an estimate in a row, with its interval where it has one."""
    if math.isfinite(estimate.low) and math.isfinite(estimate.high):
        axes.plot([estimate.low, estimate.high], [row, row], color=colour, lw=1.8, solid_capstyle="butt")
    if math.isfinite(estimate.value):
        face = colour if filled else "#FFFFFF"
        axes.plot([estimate.value], [row], marker=marker, ms=size, mew=1.8, color=colour, mfc=face, ls="none")


def _banded(evaluation: Evaluation) -> set[str]:
    """Laws with a survival band: with more than three laws only the reference and the best, or nothing is legible."""
    if len(evaluation.laws) <= 3:
        return {law.name for law in evaluation.laws}
    winner = judge(evaluation).winner or evaluation.by_power[0].name
    return {winner, evaluation.reference or winner}


def _spread(count: int) -> np.ndarray:
    """Sideways shifts that part equal values: a low-discrepancy sequence, so that the picture never changes."""
    return 0.36 * ((np.arange(count) * 0.6180339887498949) % 1.0 - 0.5) if count > 1 else np.zeros(1)
