"""One look of all figures that matplotlib draws: what an object draws of itself, and what the studies draw."""

from __future__ import annotations

import io
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from gyroctl.palette import GRID, INK, MUTED

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

AXIS = "#AEB6BF"

BAND_COLOUR = "#0072B2"

_STYLE: Any = {
    "font.family": "sans-serif",
    "font.sans-serif": ["Liberation Sans", "Arial", "Helvetica", "DejaVu Sans"],
    "font.size": 9.5,
    "mathtext.default": "regular",
    "text.color": INK,
    "axes.edgecolor": AXIS,
    "axes.labelcolor": MUTED,
    "axes.titlelocation": "left",
    "axes.titlesize": 10.5,
    "axes.titleweight": "bold",
    "axes.titlecolor": INK,
    "axes.titlepad": 8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": GRID,
    "grid.linewidth": 0.8,
    "lines.linewidth": 1.6,
    "xtick.color": AXIS,
    "ytick.color": AXIS,
    "xtick.labelcolor": MUTED,
    "ytick.labelcolor": MUTED,
    "legend.frameon": False,
    "legend.fontsize": 9,
    "savefig.dpi": 160,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "svg.fonttype": "none",  # text stays text
    "svg.hashsalt": "gyroctl",  # the same figure gives the same file
    "pdf.fonttype": 42,  # TrueType, embedded: text can be searched and edited
    "ps.fonttype": 42,
}


@contextmanager
def styled(formulas: bool = True) -> Iterator[None]:
    """Draw and save with the style of the study; the user's own settings stay as they are.

    Parameters
    ----------
    formulas : bool
        Whether text between dollar signs is a formula: not in a figure with names from outside.
    """
    import matplotlib as mpl

    with mpl.rc_context({**_STYLE, "text.parse_math": formulas}):
        yield


def sheet(
    rows: int, columns: int, size: tuple[float, float], title: str, note: str, **grid: Any
) -> tuple[Figure, list[Axes]]:
    """Make a figure with `rows` x `columns` axes, a title above and a note on the runs below.

    Parameters
    ----------
    rows, columns : int
        Grid of axes.
    size : tuple of float
        Width and height. [in]
    title, note : str
        One line; as many as it takes.
    **grid
        For `matplotlib.figure.Figure.subplots`, e.g. ``width_ratios``.
    """
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    spacing = ConstrainedLayoutEngine(w_pad=0.1, h_pad=0.1, wspace=0.02, hspace=0.03)
    figure = Figure(figsize=size, layout=spacing)  # no pyplot: no global state, no display
    FigureCanvasAgg(figure)
    figure._repr_png_ = partial(_png, figure, mpl.rcParams["text.parse_math"])  # type: ignore[attr-defined]  # a notebook shows it without pyplot
    figure.suptitle(title, x=0.008, ha="left", fontsize=13, fontweight="bold", color=INK)
    lines = textwrap.wrap(note, int(14.0 * size[0]))  # some 14 characters of this size to the inch
    figure.supxlabel("\n".join(lines), x=0.008, ha="left", fontsize=8.5, color=MUTED)
    axes = figure.subplots(rows, columns, squeeze=False, **grid)
    return figure, list(axes.ravel())


def _png(figure: Figure, formulas: bool) -> bytes:
    file = io.BytesIO()
    with styled(formulas):
        figure.savefig(file, format="png", dpi=100)
    return file.getvalue()


def label(axes: Axes, title: str, x: str, y: str) -> None:
    """Write the title and the axis labels."""
    axes.set_title(title)
    axes.set_xlabel(x)
    axes.set_ylabel(y)


def band(
    axes: Axes, x: ArrayLike, low: ArrayLike, high: ArrayLike, colour: str = BAND_COLOUR, alpha: float = 0.18
) -> None:
    """Shade an interval."""
    axes.fill_between(x, low, high, color=colour, alpha=alpha, linewidth=0)  # type: ignore[arg-type]


def listed(axes: Axes, names: Sequence[str], **look: Any) -> None:
    """Make the vertical axis a list of names, the first on top."""
    axes.set_yticks(range(len(names)), names, **look)
    axes.tick_params(axis="y", length=0)
    axes.invert_yaxis()
    axes.grid(axis="y", visible=False)


def percent(axes: Axes, ticks: Iterable[float] = (0.0, 0.25, 0.5, 0.75, 1.0)) -> None:
    """Make the vertical axis a share from 0 to 100 %."""
    axes.set_ylim(-0.03, 1.03)
    axes.set_yticks([*ticks], [f"{100 * tick:.0f} %" for tick in ticks])
