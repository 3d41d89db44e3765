"""What a control engineer asks about one law: use of its actuators, load angle, load share, spectrum of the power."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.reports import layout
from gyroctl.reports.canvas import TILE, Room, panels
from gyroctl.reports.evaluation import Evaluation, LawResult
from gyroctl.reports.panel import Line, Mark, Panel, Scale, as_markup, stairs
from gyroctl.reports.theme import REFERENCE_GREY, WARNING, law_styles
from gyroctl.reports.wording import number, percent
from gyroctl.statistics import finite_mean

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

OFTEN = 0.2
"""Share of the time above 1 from which it is said what a load share above 1 means. [1]"""

SEGMENTS = 8
"""Pieces of the record over which a spectrum is a mean, about."""


class Use(NamedTuple):
    """How a law uses one of its controls."""

    name: str
    mean: float  # [Nms]
    duty: float  # its mean as a part of the stroke [1]
    travel: float  # whole strokes a minute [1/min]
    moving: float  # share of the samples at which it changes [1]
    at_limit: float  # share of the time at the upper limit [1]
    at_zero: float  # share of the time at zero [1]


class Tile(NamedTuple):
    """A small picture of a law."""

    title: str
    picture: str  # SVG


class Section(NamedTuple):
    """All that stands in the section of a law."""

    law: LawResult
    rows: list[Use]
    load_words: str
    tiles: list[Tile]
    seconds: float  # of the realisation that the pictures are of [s]


class Sample(NamedTuple):
    """Evenly spaced part of the example realisation after the start, of one law."""

    period: float  # [s]
    series: dict[str, Floats]  # by name, each (n,)
    wp: float  # of the sea, NaN where the file does not say [rad/s]
    limits: dict[str, float]  # upper ends of cc and cg, NaN likewise [Nms]


def sections(ds: xr.Dataset, evaluation: Evaluation, laws: tuple[LawResult, ...]) -> list[Section]:
    """Section of each of these laws."""
    found = []
    for law in laws:
        sample = _sample(ds, law.name)
        tiles = _tiles(ds, evaluation, law, sample) if sample is not None else []
        seconds = sample.period * sample.series["power"].size if sample is not None else 0.0
        found.append(Section(law, _uses(ds, law.name, sample), _load_words(ds, law, sample), tiles, seconds))
    return found


def use_words(ds: xr.Dataset) -> str:
    """Say of which runs the use of the actuators is, and what its columns mean."""
    runs = "of all runs" if "cc_travel" in ds.variables else "of the example realisation alone"
    return (
        f"Use of the actuators is {runs}, after the start. A stroke is the way from zero to the upper limit; travel "
        "counts the way to and fro, in whole strokes a minute; a control moves at a sample where it changes by more "
        "than a thousandth of its stroke."
    )


def _sample(ds: xr.Dataset, name: str) -> Sample | None:
    if not layout.has_examples(ds):
        return None
    time = np.asarray(ds["time"].values, dtype=np.float64)
    if time.size < 16:
        return None
    steps = np.diff(time)
    period = float(steps.min())
    scored = time >= float(ds.attrs.get("blend", 0.0)) if ds.attrs.get("start") != "rest" else time >= 0.0
    even = np.concatenate([np.isclose(steps, period, rtol=1e-3), [True]])  # a long run is thinned beside its middle
    kept = _longest(scored & even)
    series = {
        signal: np.asarray(ds[f"example_{signal}"].sel(law=name).values, np.float64)[kept] for signal in _known(ds)
    }
    if kept.stop - kept.start < 16 or not np.isfinite(series["power"]).all():
        return None
    sea, actuators = (layout.experiment(ds).get(part) for part in ("sea", "actuators"))
    wp = ds.attrs.get("wp", sea.get("wp") if isinstance(sea, dict) else math.nan)
    told = actuators if isinstance(actuators, dict) else {}
    limits = {name: _number(told.get(f"{name}_max")) for name in ("cc", "cg")}
    return Sample(period, series, _number(wp), limits)


def _known(ds: xr.Dataset) -> list[str]:
    extra = [name for name in layout.FURTHER_EXAMPLES if f"example_{name}" in ds.variables]
    return [*layout.EXAMPLES, *extra]


def _number(value: object) -> float:
    told = np.asarray(value).tolist()
    return float(told) if isinstance(told, int | float) and not isinstance(told, bool) else math.nan


def _longest(inside: NDArray[np.bool_]) -> slice:
    """Longest stretch without a gap."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], inside.astype(np.int8), [0]])))
    begins, ends = edges[::2], edges[1::2]
    if not begins.size:
        return slice(0, 0)
    k = int(np.argmax(ends - begins))
    return slice(int(begins[k]), int(ends[k]))


def _uses(ds: xr.Dataset, name: str, sample: Sample | None) -> list[Use]:
    from gyroctl.simulation.effort import effort  # its room loads SciPy

    limits = sample.limits if sample is not None else dict.fromkeys(("cc", "cg"), math.nan)
    if "cc_travel" in ds.variables:
        row = {str(v): finite_mean(ds[v].sel(law=name).values) for v in ds.data_vars if str(v)[:3] in ("cc_", "cg_")}
    elif sample is not None:
        controls = np.stack([sample.series["cc"], sample.series["cg"]], axis=-1)
        row = effort(controls, (limits["cc"], limits["cg"]), sample.period)
    else:
        return []
    return [
        Use(
            control,
            row[f"{control}_mean"],
            row[f"{control}_mean"] / limits[control],
            60.0 * row[f"{control}_travel"] / limits[control],
            row[f"{control}_moving"],
            row[f"{control}_at_limit"],
            row[f"{control}_at_zero"],
        )
        for control in ("cc", "cg")
    ]


def _load_words(ds: xr.Dataset, law: LawResult, sample: Sample | None) -> str:
    """Say how much of the lock capacity the load takes, and what it means where that is more than all of it."""
    if sample is None:
        return ""
    share = sample.series["load_share"]
    share = share[np.isfinite(share)]
    above = float(np.mean(share > 1.0)) if share.size else 0.0
    middle = number(float(np.median(share)), 2) if share.size else "–"
    said = f"Load share: median {middle}, above 1 for {percent(100.0 * above)} of the time."
    if above < OFTEN:
        return said
    held = ""
    if law.in_step is not None:
        held = (
            f" Whether it goes well shows in the turns: {number(law.turns_kept)} of them kept and "
            f"{number(law.cycle_slips, 2)} slips per 1000 waves."
        )
    return (
        f"{said} That is no overload in itself. The share compares the load with what would hold a steady lock on the "
        "mean of the last wave: above 1 on average, the ring falls out of step. A law that plans takes more than "
        "that while the flywheel and the next waves allow it, lets the ring lag within the turn, and gives back before "
        f"a turn is lost; so a large part of the time above 1 is normal for it.{held}"
    )


def _tiles(ds: xr.Dataset, evaluation: Evaluation, law: LawResult, sample: Sample) -> list[Tile]:
    colour = law_styles(layout.names(ds), evaluation.reference)[law.name].colour
    pictures: dict[str, Callable[[Sample, str, str], str]] = {
        "Distribution of the power": power_distribution,
        "Spectrum of the power": power_spectrum,
        "Where the controls stand": positions,
        "Load share": load_share,
    }
    if "load_angle" in sample.series:
        pictures["Load angle"] = load_angle
    return [Tile(title, draw(sample, law.name, colour)) for title, draw in pictures.items()]


def power_distribution(sample: Sample, name: str, colour: str) -> str:
    """Share of the time [1] by electrical power [W], with the mean and the 98 % quantile."""
    power = sample.series["power"]
    edges = np.histogram_bin_edges(power, 40)
    mean, high = float(power.mean()), float(np.quantile(power, 0.98))
    return _panel(
        _wide(edges[0], edges[-1], "Electrical power [W]: mean —, 98 % - -"),
        [_histogram(power, edges, colour), Mark(mean, REFERENCE_GREY, 1.4, "solid"), Mark(high, REFERENCE_GREY, 1.4)],
        f"Power of {name}: mean {number(mean)} W, 98 % of the time below {number(high)} W.",
    )


def power_spectrum(sample: Sample, name: str, colour: str) -> str:
    """Spectral density of the electrical power [W^2/Hz] by frequency [Hz], its peak wave frequency marked."""
    from scipy.signal import welch

    power = sample.series["power"]
    length = max(16, min(power.size, 2 * power.size // (SEGMENTS + 1)))
    frequency, density = welch(power, 1.0 / sample.period, nperseg=length)
    frequency, density = frequency[1:], np.maximum(density[1:], 1e-12)  # what does not move is the mean
    inside = frequency <= 2.0 * max(1.0, 1.0 if math.isnan(sample.wp) else sample.wp / math.pi)
    shown = density[inside] if inside.any() else density
    drawn: list[Line | Mark] = [Line(frequency[inside], density[inside], colour, 1.2)] if inside.any() else []
    drawn += [Mark(sample.wp / (2.0 * math.pi), REFERENCE_GREY, 1.0)] if math.isfinite(sample.wp) else []
    most = float(frequency[inside][-1]) if inside.any() else 1.0
    return _panel(
        Scale(0.0, most, "Frequency [Hz]: peak of the waves - -"),
        drawn,
        f"Spectrum of the power of {name}: most of it at {number(float(frequency[np.argmax(density)]), 2)} Hz.",
        Scale(0.5 * float(shown.min()), 2.0 * float(shown.max()), "Density [W²/Hz]", "log"),
    )


def positions(sample: Sample, name: str, colour: str) -> str:
    """Share of the time [1] by the position of cc and cg in their stroke [1]."""
    drawn, said, low = list[Line | Mark](), [], 0.0
    for control, look, kind in (("cc", colour, "solid"), ("cg", REFERENCE_GREY, "dash")):
        values, limit = sample.series[control], sample.limits[control]
        limit = limit if math.isfinite(limit) else float(values.max()) or 1.0
        begin = min(0.0, float(values.min()) / limit)
        counts, edges = np.histogram(np.clip(values / limit, -1.0, 1.0), 40, (begin, 1.0))
        drawn.append(Line(*stairs(counts / values.size, edges), look, kind=kind))
        said.append(f"{control} in the middle at {number(float(np.median(values)) / limit, 2)} of its stroke")
        low = min(low, begin)
    across = _wide(low, 1.0, "Position in the stroke [1]: cc —, cg - -")
    return _panel(across, drawn, f"Controls of {name}: {' and '.join(said)}.")


def load_share(sample: Sample, name: str, colour: str) -> str:
    """Share of the time [1] in which the load share is above a value [1], all values of it."""
    share = np.sort(sample.series["load_share"][np.isfinite(sample.series["load_share"])])
    drawn = list[Line | Mark]()
    if share.size:
        left = 1.0 - np.arange(share.size + 1) / share.size
        drawn.append(Line(np.repeat(share, 2), np.repeat(left, 2)[1:-1], colour))
    drawn.append(Mark(1.0, WARNING))
    above, most = (float(np.mean(share > 1.0)), float(share[-1])) if share.size else (0.0, 0.0)
    least = max(1e-3, 0.8 * float(share[0])) if share.size else 0.1
    return _panel(
        Scale(least, max(1.2 * most, 1.2), "Load share [1]: lock capacity - -", "log"),
        drawn,
        f"Load share of {name}: above 1 for {percent(100.0 * above)} of the time, {number(most, 2)} at most.",
        Scale(0.0, 1.02, "Time above it [1]"),
    )


def load_angle(sample: Sample, name: str, colour: str) -> str:
    """Share of the time [1] by load angle [deg]; a steady lock pulls out at about -90 or beyond."""
    angle = np.degrees(sample.series["load_angle"])
    angle = angle[np.isfinite(angle)]
    middle = number(float(np.median(angle)), 2) if angle.size else "–"
    beyond = percent(100.0 * float(np.mean(np.abs(angle) > 90.0))) if angle.size else "–"
    whole = (-180.0, -90.0, 0.0, 90.0, 180.0)
    return _panel(
        Scale(-180.0, 180.0, "Load angle [deg]: pull-out of a steady lock - -", ticks=whole),
        [_histogram(angle, np.linspace(-180.0, 180.0, 49), colour), Mark(-90.0, WARNING)],
        f"Load angle of {name}: median {middle} degrees, beyond ±90 for {beyond} of the time.",
    )


_ROOM = Room(left=58.0, right=14.0, top=8.0, bottom=43.0)

_HEIGHT = 130.0
"""Of the axes of a small picture. [px]"""


def _histogram(values: Floats, edges: Floats, colour: str) -> Line:
    """Share of the values between the edges, as one area."""
    counts, _ = np.histogram(values, edges)
    return Line(*stairs(counts / max(values.size, 1), edges), colour, area=True)


def _wide(low: float, high: float, label: str) -> Scale:
    """Scale with some room at both ends."""
    room = 0.05 * (high - low)
    return Scale(float(low - room), float(high + room), label)


def _panel(x: Scale, drawn: list[Line | Mark], alt: str, y: Scale | None = None) -> str:
    """Small picture, by default of shares of the time from zero to the largest."""
    if y is None:
        most = max((float(one.y.max()) for one in drawn if isinstance(one, Line)), default=0.0)
        y = Scale(0.0, 1.05 * most or 1.0, "Share of time [1]")
    return as_markup(panels(TILE, _HEIGHT, [Panel(x, y, drawn)], _ROOM), alt)
