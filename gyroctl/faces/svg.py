"""Small pictures as inline SVG: curves, bars, the unit circle, a block with its signals.

Text and axes take the colour of the page, so that they are seen on light and dark ones. Nothing is fetched.
"""

from __future__ import annotations

import html
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gyroctl.errors import visible

WIDTH, HEIGHT = 300, 130
"""Size of a picture. [px]"""

LEFT, RIGHT, TOP, BOTTOM = 46, 8, 16, 30
"""Margins around the axes. [px]"""

POINTS = 240
"""Points of a curve: of a longer one the least and the greatest of each bucket are drawn."""

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7")
"""Of curves that are no laws."""


def picture(inside: Sequence[str], told: str, width: int = WIDTH, height: int = HEIGHT) -> str:
    """Put parts into a picture that says in words what it shows."""
    words = html.escape(visible(told))
    look = f"color:inherit;font:11px sans-serif;max-width:{width}px;overflow:visible"
    return (
        f'<svg role="img" aria-label="{words}" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
        f'style="{look}"><title>{words}</title>{"".join(inside)}</svg>'
    )


def curves(x: ArrayLike, rows: Mapping[str, ArrayLike], x_title: str, y_title: str, colours: Any = COLOURS) -> str:
    """Draw curves over one axis.

    Parameters
    ----------
    x : (n,) array
        Where they are known.
    rows : mapping of str to (n,) array
        Curves by name; what is not finite is left out.
    x_title, y_title : str
        Quantities with their units.
    colours : sequence of str
        One a curve.
    """
    at = np.asarray(x, dtype=np.float64)
    values = {name: np.asarray(row, dtype=np.float64) for name, row in rows.items()}
    good = [row[np.isfinite(row)] for row in values.values()]
    low = min((float(row.min()) for row in good if row.size), default=0.0)
    high = max((float(row.max()) for row in good if row.size), default=1.0)
    low, high = (min(low, 0.0) if low < 0.3 * high else low, high if high > low else low + 1.0)
    first, last = (float(at[0]), float(at[-1])) if at.size > 1 else (0.0, 1.0)
    parts = _axes(first, last, low, high, x_title, y_title)
    for i, (name, row) in enumerate(values.items()):
        colour = colours[i % len(colours)]
        px, py = _few(_across(at, first, last), _up(row, low, high))
        points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(px, py, strict=True))
        parts.append(f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="1.4"/>')
        if len(values) > 1:
            parts.append(_text(WIDTH - RIGHT - 62 * (len(values) - i) + 62, 11, name, "end", colour))
    return picture(parts, f"{', '.join(values)}: {y_title} over {x_title}")


def bars(rows: Mapping[str, float], title: str, colours: Sequence[str]) -> str:
    """Draw a bar for each name, its value beside it."""
    most = max((abs(value) for value in rows.values() if math.isfinite(value)), default=1.0) or 1.0
    step, parts = 15, []
    for i, (name, value) in enumerate(rows.items()):
        y, size = 18 + step * i, 120.0 * max(value, 0.0) / most if math.isfinite(value) else 0.0
        short = name if len(name) <= 18 else f"{name[:17]}…"
        parts.append(_text(112, y + 9, short, "end"))
        parts.append(f'<rect x="118" y="{y}" width="{size:.1f}" height="10" fill="{colours[i % len(colours)]}"/>')
        parts.append(_text(122 + size, y + 9, f"{value:.3g}" if math.isfinite(value) else "none", "start"))
    parts.append(_text(118, 11, title, "start"))
    told = f"{title}: " + ", ".join(f"{name} {value:.3g}" for name, value in rows.items())
    return picture(parts, told, WIDTH, 24 + step * len(rows))


def circle(points: ArrayLike, told: str) -> str:
    """Draw complex numbers in the unit circle."""
    size, middle, radius = 130, 65.0, 52.0
    parts = [
        f'<circle cx="{middle}" cy="{middle}" r="{radius}" fill="none" stroke="currentColor" opacity=".5"/>',
        f'<path d="M{middle - 60} {middle}H{middle + 60}M{middle} {middle - 60}V{middle + 60}" stroke="currentColor" '
        'opacity=".2"/>',
    ]
    for value in np.atleast_1d(np.asarray(points, dtype=np.complex128)):
        if np.isfinite(value) and abs(value) < 1.15:
            x, y = middle + radius * value.real, middle - radius * value.imag
            colour = COLOURS[0] if abs(value) < 1.0 else COLOURS[1]
            parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{colour}"/>')
    return picture(parts, told, size, size)


def block(name: str, reads: Sequence[str], gives: Sequence[str], told: str) -> str:
    """Draw a box with what goes in on its left and what comes out on its right."""
    height = max(64, 16 * max(len(reads), len(gives), 1) + 14)
    middle = height / 2.0
    short = name if len(name) <= 18 else f"{name[:17]}…"
    parts = [
        f'<rect x="104" y="4" width="112" height="{height - 8}" rx="5" fill="none" stroke="{COLOURS[0]}"/>',
        _text(160, middle + 4, short, "middle"),
    ]
    for x, names, anchor, begin in ((78, reads, "end", 82), (242, gives, "start", 218)):
        for i, each in enumerate(names):
            y = middle + 16.0 * (i - 0.5 * (len(names) - 1))
            parts.append(_text(x, y + 4, each, anchor))
            parts.append(f'<path d="M{begin} {y:.1f}h14m-4 -3l4 3l-4 3" fill="none" stroke="currentColor"/>')
    return picture(parts, told, 300, int(height))


def _axes(first: float, last: float, low: float, high: float, x_title: str, y_title: str) -> list[str]:
    foot, top = HEIGHT - BOTTOM, TOP
    return [
        f'<path d="M{LEFT} {top}V{foot}H{WIDTH - RIGHT}" fill="none" stroke="currentColor" opacity=".5"/>',
        _text(LEFT - 4, top + 8, f"{high:.3g}", "end"),
        _text(LEFT - 4, foot, f"{low:.3g}", "end"),
        _text(LEFT, foot + 12, f"{first:.3g}", "middle"),
        _text(WIDTH - RIGHT, foot + 12, f"{last:.3g}", "end"),
        _text((LEFT + WIDTH - RIGHT) / 2, foot + 24, x_title, "middle"),
        _text(2, 11, y_title, "start"),
    ]


def _across(x: Any, first: float, last: float) -> Any:
    return LEFT + (x - first) / ((last - first) or 1.0) * (WIDTH - LEFT - RIGHT)


def _up(y: Any, low: float, high: float) -> Any:
    return HEIGHT - BOTTOM - (y - low) / ((high - low) or 1.0) * (HEIGHT - TOP - BOTTOM)


def _few(x: Any, y: Any) -> tuple[Any, Any]:
    """Drop what is not finite, and of what is too long all but the least and the greatest of each bucket."""
    good = np.isfinite(x) & np.isfinite(y)
    x, y = x[good], y[good]
    if x.size <= POINTS:
        return x, y
    kept: set[int] = {0, x.size - 1}
    for part in np.array_split(np.arange(x.size), POINTS // 2):
        kept |= {int(part[np.argmin(y[part])]), int(part[np.argmax(y[part])])}
    order = sorted(kept)
    return x[order], y[order]


def _text(x: float, y: float, text: str, anchor: str, colour: str = "currentColor") -> str:
    words = html.escape(visible(text))
    return f'<text x="{x:.0f}" y="{y:.0f}" text-anchor="{anchor}" fill="{colour}">{words}</text>'
