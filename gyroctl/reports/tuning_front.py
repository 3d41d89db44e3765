"""The picture of a tuning: every point that was run, power against power CV, one panel for each sea."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyroctl.reports.picture import STYLE
from gyroctl.reports.theme import HUES, LIGHT, REFERENCE_GREY, WARNING
from gyroctl.writing import written_whole

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from gyroctl.tuning.pareto_front import FrontRow


def write_tuning_front(
    rows: Sequence[FrontRow], path: Path, title: str = "", limits: Mapping[str, float] | None = None
) -> Path:
    """Draw the archive of a tuning.

    Parameters
    ----------
    rows : sequence of FrontRow
        What was run.
    path : Path
        Image file; the ending chooses the format.
    title : str
        Above the picture.
    limits : mapping, optional
        Limit of the power CV by sea.
    """
    import matplotlib

    matplotlib.use("agg")
    import matplotlib.pyplot as plt

    seas = list(dict.fromkeys(row.sea for row in rows))
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(
            1, len(seas), figsize=(max(4.3 * len(seas), 5.6), 4.1), squeeze=False, layout="constrained"
        )
        for ax, sea in zip(axes[0], seas, strict=True):
            _panel(ax, [row for row in rows if row.sea == sea], (limits or {}).get(sea))
            ax.set_title(sea)
            ax.set_xlabel("power CV [1]")
        axes[0][0].set_ylabel("mean power [W]")
        handles, labels = axes[0][0].get_legend_handles_labels()
        figure.legend(
            handles, labels, loc="outside lower center", ncols=min(5, 2 * len(seas)), frameon=False, fontsize=9
        )
        if title:
            figure.suptitle(title, x=0.01, ha="left", color=LIGHT.muted)
        with written_whole(path) as part:
            figure.savefig(part, dpi=150)
        plt.close(figure)
    return path


def _panel(ax: Axes, rows: Sequence[FrontRow], limit: float | None) -> None:
    def xy(chosen: Sequence[FrontRow]) -> tuple[Any, Any]:
        return [row.power_cv for row in chosen], [row.mean_power for row in chosen]

    search = [row for row in rows if row.stage == "search"]
    held, lost = [row for row in search if row.locked >= 1.0], [row for row in search if row.locked < 1.0]
    front = sorted((row for row in held if row.front), key=lambda row: row.power_cv)
    confirmed = [row for row in rows if row.stage == "confirm"]
    ax.scatter(*xy(lost), s=7, color=WARNING, alpha=0.25, linewidths=0, label="run, a lock lost")
    ax.scatter(*xy(held), s=7, color=REFERENCE_GREY, alpha=0.5, linewidths=0, label="run, all locked")
    ax.plot(*xy(front), color=REFERENCE_GREY, lw=1.0, ls=":", label="front of the search (few runs)")
    ax.scatter(
        *xy(confirmed),
        s=34,
        facecolors="white",
        edgecolors=HUES[0],
        linewidths=1.4,
        zorder=3,
        label="confirmed on all seeds",
    )
    ax.scatter(*xy([row for row in confirmed if row.chosen]), s=110, marker="*", color=HUES[1], zorder=4, label="ships")
    shown = [row for row in rows if row.locked >= 0.5] or rows
    ax.set_xlim(0.0, 1.08 * max(sorted(row.power_cv for row in shown)[int(0.95 * (len(shown) - 1))], limit or 0.0))
    ax.set_ylim(0.0, 1.1 * max(row.mean_power for row in shown))
    if limit is not None:
        ax.axvline(limit, color=LIGHT.muted, lw=0.9, ls="--")
        ax.annotate("limit", (limit, 0.0), xytext=(3, 4), textcoords="offset points", color=LIGHT.muted, fontsize=8)
