"""Panels: axes with lines, areas and marks, written as SVG at once.

A page has a handful of these for every law. Through a plotting library each takes a tenth of a second, most of it for
ticks that are objects; what they show is a line, an area and a mark.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.names import in_markup

Floats = NDArray[np.float64]

TICK, PAD = 3.5, 6.5
"""Length of a tick, and from it to the number below the axis: clear of the lowest number of the other. [px]"""

APART = (52.0, 22.0)
"""Least way from tick to tick, across and up. [px]"""

STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)
"""Ticks are multiples of these and of a power of ten."""

UP_TO_ONE = 1.0 / 0.9
"""What the way from 0 to 1 takes of an axis that is logarithmic beyond 1. [decades]"""

DASHES = {"solid": "", "dash": ' stroke-dasharray="4.8 2.2"'}


class Scale(NamedTuple):
    """One direction of a panel.

    Parameters
    ----------
    low, high : float
        Its ends; above 0 where it is logarithmic.
    label : str
        What it is, with its unit; empty where another panel says it.
    kind : {"linear", "log", "log beyond 1"}
        How values become places.
    ticks : sequence of float, optional
        Where its numbers stand; by default a few round ones.
    """

    low: float
    high: float
    label: str
    kind: Literal["linear", "log", "log beyond 1"] = "linear"
    ticks: tuple[float, ...] = ()

    def share(self, values: Floats) -> Floats:
        """Place of values on the way from the low end to the high one, those beyond an end at it. [1]"""
        inside = np.clip(values, self.low, self.high)
        low, high, at = (self._even(np.asarray(one, np.float64)) for one in (self.low, self.high, inside))
        return (at - low) / ((high - low) or 1.0)  # type: ignore[no-any-return]

    def _even(self, values: Floats) -> Floats:
        if self.kind == "linear":
            return values
        if self.kind == "log":
            return np.log10(values)
        return np.where(values > 1.0, UP_TO_ONE + np.log10(np.maximum(values, 1.0)), UP_TO_ONE * values)

    def marked(self, most: int) -> tuple[tuple[float, ...], list[str]]:
        """Values with a tick, where there is room for `most` steps, and the numbers that stand there."""
        if self.kind == "linear" and not self.ticks:
            ticks = round_numbers(self.low, self.high, most)
            return ticks, in_digits(ticks)
        ticks = self.ticks or tuple(decades(self.low, self.high, most))
        return ticks, [f"{tick:g}".replace("-", "\N{MINUS SIGN}") for tick in ticks]


class Line(NamedTuple):
    """A line with gaps where a value is not finite; with `area` the surface between it and its two ends."""

    x: Floats
    y: Floats
    colour: str
    width: float = 1.5
    kind: str = "solid"
    area: bool = False


class Mark(NamedTuple):
    """A straight line from end to end of the panel, at one value of the horizontal axis, or if `level` of the other."""

    at: float
    colour: str
    width: float = 1.2
    kind: str = "dash"
    level: bool = False


class Panel(NamedTuple):
    """Axes and what is drawn on them, the first lowest; the title stands above."""

    x: Scale
    y: Scale
    drawn: Sequence[Line | Mark]
    title: str = ""


class Panels(NamedTuple):
    """Panels below one another on a sheet of some width, with margins; type is the size of the letters. [px]"""

    panels: Sequence[Panel]
    width: float
    type: float
    height: float  # of each
    left: float
    right: float
    top: float
    down: float  # between two
    bottom: float


def decades(low: float, high: float, most: int) -> list[float]:
    """Powers of ten from `low` to `high`, at most so many, evenly in their exponents."""
    first, last = math.ceil(math.log10(low) - 1e-9), math.floor(math.log10(high) + 1e-9)
    step = max(1, math.ceil((last - first + 1) / most))
    return [10.0**k for k in range(first, last + 1, step)]


def round_numbers(low: float, high: float, most: int) -> tuple[float, ...]:
    """Round numbers from `low` to `high`, with at most `most` steps on the way."""
    span = high - low
    if not span > 0.0:
        return (low,)
    power = 10.0 ** math.floor(math.log10(span / most))
    step = next(power * factor for factor in STEPS if power * factor * most >= span * (1.0 - 1e-9))
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return tuple(k * step for k in range(first, last + 1))


def in_digits(ticks: Sequence[float]) -> list[str]:
    """Numbers of ticks, all with as many decimals as one of them needs."""
    widest = max((abs(tick) for tick in ticks), default=1.0) or 1.0
    need = next((k for k in range(9) if all(abs(round(tick, k) - tick) < 1e-9 * widest for tick in ticks)), 9)
    return [f"{tick + 0.0:.{need}f}".replace("-", "\N{MINUS SIGN}") for tick in ticks]


def stairs(counts: Floats, edges: Floats) -> tuple[Floats, Floats]:
    """Corners of the stairs over the edges, from zero to zero."""
    return np.repeat(edges, 2), np.concatenate([[0.0], np.repeat(counts, 2), [0.0]])


def held(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Corners of a line that stays at each value until the next."""
    return np.repeat(x, 2)[1:], np.repeat(y, 2)[:-1]


def as_markup(sheet: Panels, alt: str) -> str:
    """SVG element of panels; equal panels give equal text.

    Parameters
    ----------
    sheet : Panels
        What is drawn.
    alt : str
        The picture in words.

    Returns
    -------
    str
        Element that takes the width which it is given, in the colours of the page.
    """
    count = len(sheet.panels)
    height = sheet.top + count * sheet.height + (count - 1) * sheet.down + sheet.bottom
    parts = [
        _one(panel, sheet, sheet.top + k * (sheet.height + sheet.down), k == count - 1)
        for k, panel in enumerate(sheet.panels)
    ]
    return (
        f'<svg class="drawn" role="img" aria-label="{in_markup(alt)}" viewBox="0 0 {sheet.width:g} {height:g}" '
        f'width="{sheet.width:g}" height="{height:g}">{"".join(parts)}</svg>'
    )


def _one(panel: Panel, sheet: Panels, top: float, lowest: bool) -> str:
    """One panel, from `top` on; the lowest alone has numbers below it."""
    left, right, bottom = sheet.left, sheet.width - sheet.right, top + sheet.height
    size, small = sheet.type, sheet.type - 0.5

    def across(values: Floats) -> Floats:
        return left + (right - left) * panel.x.share(values)

    def up(values: Floats) -> Floats:
        return bottom - sheet.height * panel.y.share(values)

    ticks_x, numbers_x = panel.x.marked(max(2, int((right - left) / APART[0])))
    ticks_y, numbers_y = panel.y.marked(max(2, int(sheet.height / APART[1])))
    at_x, at_y = across(np.array(ticks_x)), up(np.array(ticks_y))
    whole = [f"M{_px(at)} {_px(top)}V{_px(bottom)}" for at in at_x]
    whole += [f"M{_px(left)} {_px(at)}H{_px(right)}" for at in at_y]
    ends = [f"M{_px(left)} {_px(top)}V{_px(bottom)}H{_px(right)}"]
    ends += [f"M{_px(at)} {_px(bottom)}v{TICK}" for at in at_x] + [f"M{_px(left)} {_px(at)}h-{TICK}" for at in at_y]
    lines = list[str]()
    for one in panel.drawn:
        if isinstance(one, Line):
            lines += [_stroke(_path(x, y), one) for x, y in _pieces(across(one.x), up(one.y))]
        elif one.level:
            lines.append(_stroke(f"M{_px(left)} {_px(float(up(np.array(one.at))))}H{_px(right)}", one))
        else:
            lines.append(_stroke(f"M{_px(float(across(np.array(one.at))))} {_px(top)}V{_px(bottom)}", one))
    below = bottom + TICK + PAD + 0.73 * small
    beside = left - TICK - 4.0
    words = [_text(beside, at + 0.36 * small, n, "end") for at, n in zip(at_y, numbers_y, strict=True)]
    words += [_text(at, below, n) for at, n in zip(at_x, numbers_x, strict=True)] if lowest else []
    named = []
    if lowest and panel.x.label:
        named.append(_text(0.5 * (left + right), below + 0.42 * small + 0.9 * size, in_markup(panel.x.label)))
    if panel.y.label:
        turned = f"translate({_px(0.95 * size)} {_px(0.5 * (top + bottom))}) rotate(-90)"
        named.append(f'<g transform="{turned}">{_text(0.0, 0.0, in_markup(panel.y.label))}</g>')
    if panel.title:
        title = _text(left, top - 7.0, in_markup(panel.title), "start")
        named.append(f'<g style="fill:var(--ink)">{title}</g>')
    return (
        f'<g fill="none" stroke-width="1"><path d="{"".join(whole)}" style="stroke:var(--grid)"/>{"".join(lines)}'
        f'<path d="{"".join(ends)}" style="stroke:var(--axis);stroke-width:.8"/></g>'
        f'<g style="fill:var(--muted);font-size:{small:g}px" text-anchor="middle">{"".join(words)}'
        f'<g style="font-size:{size:g}px">{"".join(named)}</g></g>'
    )


def _pieces(x: Floats, y: Floats) -> list[tuple[Floats, Floats]]:
    """Stretches of finite points, each of two or more."""
    known = np.concatenate([[0], np.isfinite(x) & np.isfinite(y), [0]]).astype(np.int8)
    edges = np.flatnonzero(np.diff(known))
    return [(x[a:b], y[a:b]) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a > 1]


def _path(x: Floats, y: Floats) -> str:
    """Path through points to the tenth of a pixel, without those at which nothing turns."""
    points = np.round(np.stack([x, y], axis=1), 1)
    points = points[np.concatenate([[True], np.any(np.diff(points, axis=0) != 0.0, axis=1)])]
    if len(points) > 2:
        ahead, behind = np.diff(points, axis=0)[1:], np.diff(points, axis=0)[:-1]
        turns = np.abs(ahead[:, 0] * behind[:, 1] - ahead[:, 1] * behind[:, 0]) > 1e-6
        turns |= (ahead * behind).sum(axis=1) < 0.0  # there and back along one line
        points = points[np.concatenate([[True], turns, [True]])]
    return "M" + "L".join(f"{_px(a)} {_px(b)}" for a, b in points.tolist())


def _stroke(path: str, one: Line | Mark) -> str:
    if isinstance(one, Line) and one.area:
        return f'<path d="{path}z" style="fill:{one.colour}"/>'
    return f'<path d="{path}" style="stroke:{one.colour};stroke-width:{one.width:g}"{DASHES[one.kind]}/>'


def _text(x: float, y: float, words: str, anchor: str = "") -> str:
    turn = f' text-anchor="{anchor}"' if anchor else ""
    return f'<text x="{_px(x)}" y="{_px(y)}"{turn}>{words}</text>'


def _px(value: float) -> str:
    return f"{round(float(value), 1) + 0.0:g}"
