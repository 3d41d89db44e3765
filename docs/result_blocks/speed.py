"""Blocks and pictures of the page of the benchmarks."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from gyroctl.reports.wording import number
from result_blocks.source import of_file, read, table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BESIDE = {"runs": "runs", "lanes": "loops side by side", "states": "states", "horizon": "horizon [s]", "cores": "cores"}
"""Panels of the picture, and what grows."""


def integrators() -> str:
    """The plant by other integrators."""
    found = read("benchmarks/integrators.json")
    lines = [
        [
            one["name"].replace("gyroctl", "`gyroctl`"),
            number(one["us_per_simulated_second"], 3),
            number(one["times_of_one_run"], 3),
            "as above" if one["error"] is None else f"{one['error']:.1e}",
            "–" if one["tolerance"] is None else f"{one['tolerance']:.0e}",
        ]
        for one in found["peers"]
    ]
    heads = ("integrator", "a simulated second and run [µs]", "times", "error after 200 s", "tolerance")
    made = of_file("benchmarks/integrators.json", "python benchmarks/integrators.py", found["machine"])
    return f"{table(heads, lines)}\n\n{made}"


def asked() -> str:
    """Every figure that is asked for, and whether it is met."""
    found = read("benchmarks/all.json")
    lines = [
        [
            one["figure"],
            f"{number(one['value'], 3)} {one['unit']}".strip() if one["value"] is not None else "not measured",
            f"{one['asked']} {one['bar']:g}",
            "" if one["value"] is None else "met" if one["met"] else "**not met**",
        ]
        for one in found["figures"]
    ]
    lanes = read("benchmarks/lanes.json")
    shares = [lanes[f"share of the most, {kind}"] for kind in ("with ledger", "without ledger")]
    rate = lanes["ensemble of 256 runs, waves included, dt .01, with ledger [simulated s / s]"]
    told = (
        f"The ensemble makes {rate / 1000:.0f} thousand simulated seconds per second on one core, "
        f"{100 * shares[0]:.0f} % of the peak ({100 * shares[1]:.0f} % without the ledger)."
    )
    made = of_file("benchmarks/all.json", "python benchmarks/all.py --against OLDER_TREE", found["machine"])
    return f"{table(('figure', 'measured', 'asked', ''), lines)}\n\n{told}\n\n{made}"


def cores() -> str:
    """Closed loops of the planning law on all cores, and what they are worth beside those before."""
    found = read("benchmarks/nmpc_cores.json")
    rows = (
        ("mean power [W]", "mean_power"),
        ("CV of the power", "power_cv"),
        ("locked", "locked"),
        ("turns kept", "turns_kept"),
    )
    lines = []
    for title, name in rows:
        mean, low, high = found[f"{name}_more"]
        change = f"{number(mean, 2)} ({number(low, 2)} to {number(high, 2)})"
        lines.append([title, number(found[f"older_{name}"], 4), number(found[name], 4), change])
    heads = (f"{found['runs']} runs of {found['length_s']:g} s", "before", "now", "paired difference")
    told = (
        f"On all cores {number(found['simulated_s_per_s'], 3)} simulated seconds per second, "
        f"{number(found['times_as_fast'], 3)} times as fast as before. "
        "Whether a run was in step is not judged here, where no constant pair runs beside it: the turns kept tell."
    )
    made = of_file(
        "benchmarks/nmpc_cores.json", "python benchmarks/nmpc_cores.py --against OLDER_TREE", found["machine"]
    )
    return f"{told}\n\n{table(heads, lines)}\n\n{made}"


def growth() -> str:
    """What made the picture."""
    found = read("benchmarks/growth.json")
    made = of_file("benchmarks/growth.json", "python benchmarks/growth.py", found["machine"])
    words = (
        "How cost grows: an ensemble with the runs in it, closed loops with the lanes that are filled, a run with the "
        "states of the plant, the planning law with its horizon, an ensemble with the cores"
    )
    told = "*Every axis begins at nothing: a flat line costs no more as its abscissa grows.*"
    return f"![{words}](growth.png)\n\n{told}\n\n{made}"


def draw_growth() -> Figure:
    """Five panels, each from nothing on: what is cheap looks cheap."""
    from gyroctl.studies.style import BAND_COLOUR, INK, label, sheet

    found = read("benchmarks/growth.json")
    note = f"Processor time, over cores time of the wall, the least of several goes ({found['machine']})"
    figure, axes = sheet(2, 3, (10.5, 6.4), "How cost grows", note)
    shown: Mapping[str, tuple[str, str, str, str]] = {
        "runs": ("runs", "us_per_simulated_second", "Runs of an ensemble", "a simulated second of one [µs]"),
        "lanes": ("lanes", "of_a_run_alone", "Closed loops in lanes", "one, relative to a run alone"),
        "states": ("states", "us_per_simulated_second", "States of the plant", "a simulated second [µs]"),
        "horizon": ("horizon_s", "median_ms", "Planning law", "a sample, median and 99 % [ms]"),
        "cores": ("cores", "times_as_fast", "Cores", "times as fast as one"),
    }
    for axis, (name, (x, y, title, what)) in zip(axes, shown.items(), strict=False):
        rows = found[name]
        at = [row[x] for row in rows]
        axis.plot(at, [row[y] for row in rows], "o-", color=BAND_COLOUR, ms=3.5)
        if name == "horizon":
            axis.plot(at, [row["p99_ms"] for row in rows], "o--", color=INK, ms=3, lw=1)
        if name == "runs":
            axis.set_xscale("log", base=2)
        if name in ("runs", "cores"):
            axis.set_xticks(at, [f"{one:g}" for one in at])
        if name == "lanes":
            axis.set_xticks(at[::3], [f"{one:g}" for one in at[::3]])
        axis.set_ylim(0.0, 1.1 * max(row.get("p99_ms", row[y]) for row in rows))
        label(axis, title, BESIDE[name], what)
    for axis in axes[len(shown) :]:
        axis.set_visible(False)
    return figure


BLOCKS: Mapping[str, Callable[[], str]] = {"integrators": integrators, "growth": growth, "asked": asked, "cores": cores}
