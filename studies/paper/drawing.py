"""What a figure of the paper hands back, picture and data, and how it writes its numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from numpy.typing import ArrayLike

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Table = Mapping[str, ArrayLike]
"""Columns of equal length by name; the name ends in the unit, as in power_w."""


class Drawing(NamedTuple):
    """A figure and its data."""

    figure: Figure
    tables: Mapping[str, Table]  # by suffix of the file name, "" for the main one


def columns(rows: Sequence[Mapping[str, Any]]) -> Table:
    """Turn rows of the same names into a table."""
    return {name: [row[name] for row in rows] for name in rows[0]}


def with_interval(name: str, stem: str, found: Any, unit: str = "") -> dict[str, float]:
    """Part of a row: a value, and the ends of its interval as STEM_low and STEM_high."""
    return dict(zip((name, f"{stem}_low{unit}", f"{stem}_high{unit}"), found[:3], strict=True))


def gain(value: float) -> str:
    """Write a generator gain as the paper does: 3.5e-4."""
    mantissa, exponent = f"{value:.3e}".split("e")
    return f"{float(mantissa):g}e{int(exponent)}"


def remark(axes: Axes, x: float, y: float, words: str, colour: str, **look: Any) -> None:
    """Write words into a panel at a share of its width and height."""
    axes.text(x, y, words, color=colour, transform=axes.transAxes, **look)
