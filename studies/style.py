"""One look for all figures of the studies, that of `gyroctl.plots.style`; how they are written."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyroctl.palette import GAMMA_COLOURS, GRID, INK, MUTED, REFERENCE_GREY, WARNING, law_styles
from gyroctl.plots.style import AXIS, BAND_COLOUR, band, label, listed, percent, sheet, styled
from gyroctl.version import VERSION
from gyroctl.writing import written_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = [  # the look as well, for the files of the studies
    "AXIS",
    "BAND_COLOUR",
    "DENSE",
    "FORMATS",
    "GAMMA_COLOURS",
    "GRID",
    "INK",
    "MUTED",
    "ON_COLOUR",
    "PAPER_COLOUR",
    "RING_SPEED",
    "band",
    "colour_of",
    "label",
    "listed",
    "percent",
    "save",
    "sea_name",
    "sheet",
    "styled",
    "written",
]

ON_COLOUR = "#10161C"
"""Text and lines on a coloured area: unlike `INK` they stay dark where the page is dark."""

RING_SPEED = "ψ\N{PRIME} [rad/s]"
"""Axis label."""

PAPER_COLOUR = WARNING
"""What the paper states."""

FORMATS = ("png", "svg", "pdf")
"""What every figure is written as: to look at, for pages, for print."""

DENSE = 10_000
"""Points from which a line is a picture in SVG and PDF: as a path it would take megabytes."""


def sea_name(gamma: float) -> str:
    """Name of a sea in titles and legends; the letter is spelt out because the linter takes it for a y."""
    return f"\N{GREEK SMALL LETTER GAMMA} = {gamma:g}"


def colour_of(case: str) -> str:
    """Colour of a case of the margin pictures: that of its law where it is named ``law NAME``, else the grey."""
    name = case.removeprefix("law ")
    return law_styles([name])[name].colour if name != case else REFERENCE_GREY


def save(figure: Figure, path: Path) -> Path:
    """Write a figure in all `FORMATS`, each whole or not at all, with the version that drew it.

    Text stays text in SVG, and fonts are embedded in PDF. Lines of more than `DENSE` points are pictures in both.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        Drawn by a study.
    path : Path
        Name of the PNG; the others have its name with their own ending.

    Returns
    -------
    Path
        That of the PNG; all are those of `written`.
    """
    for axes in figure.axes:
        for line in axes.lines:
            line.set_rasterized(bool(line.get_rasterized()) or len(line.get_xdata()) > DENSE)  # type: ignore[arg-type]
    told = f"gyroctl {VERSION}"
    metadata: dict[str, dict[str, Any]] = {
        "png": {"Software": told},
        "svg": {"Creator": told, "Date": None},  # without dates the same figure is the same file
        "pdf": {"Creator": told, "CreationDate": None},
    }
    for form, file in zip(FORMATS, written(path), strict=True):
        with written_whole(file) as part:
            figure.savefig(part, format=form, metadata=metadata[form])
    return path


def written(path: Path) -> list[Path]:
    """Files that `save` writes for a PNG of that name, the PNG first."""
    return [path.with_suffix(f".{form}") for form in FORMATS]
