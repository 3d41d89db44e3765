"""Blocks of the page on the bound: what was found in each sea, and what the search leaves open."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import chain
from typing import Any

from gyroctl.reports.wording import number, percent
from result_blocks.source import ROOT, caption, failures, pair, result, states, table

SEAS = ("bound_gamma1", "bound_gamma5", "bound_gamma50")


def _part(share: float) -> str:
    return f"{100.0 * share:.0f} %"


def kept_seas() -> list[str]:
    """Those of the seas whose windows were run; where none was, the first is what is missing."""
    return [name for name in SEAS if (ROOT / f"docs/results/{name}.json").is_file()] or [SEAS[0]]


def _not_run() -> str:
    """The other seas, in a sentence."""
    missing = [name for name in SEAS if name not in kept_seas()]
    told = ", ".join(f"`python docs/run_results.py {name}`" for name in missing)
    return f" Not run yet: {told}." if missing else ""


HEADS = (
    *("gamma", "what", "harvest", "of the best found", "lowest window", "generated, stored [W]", "CV", "turns kept"),
    *("slips per 1000 waves", "largest φ1, φ3 [rad]", "beyond 0.3 rad", "locked, within the motion limit", "windows"),
)


def best() -> str:
    """Best found, cap and laws in each sea."""
    asked = result(kept_seas()[0])
    told = (
        f"Windows of {asked['request']['duration_s']:g} s; seeds {states(asked['seed_states'])}. {_MEANT}"
        + " ".join(
            f"Gamma {result(name)['request']['gamma']:g}: {failures(result(name)).lower()}" for name in kept_seas()
        )
        + _not_run()
    )
    return "\n\n".join([_rows(kept_seas()), told, caption(*kept_seas())])


_MEANT = (
    "Stored is the change of the flywheel's energy. In step is not judged within so short a window: turns kept and "
    "slips stand in its place. "
)


def realistic() -> str:
    """Best found and laws in the realistic plant, with the limits and the yardstick that stands for a cap."""
    name = "bound_realistic"
    found = result(name)
    asked, limits = found["request"], found["summary"]["motion_limits_rad"]
    ranges = ", ".join(
        f"{part} {' to '.join(f'{end:.2f}' for end in sorted(set(limits[part])))} rad" for part in limits
    )
    origins = ", ".join(f"`{window['best']['origin']}`" for window in found["windows"])
    gaps = [
        f"{100.0 * (w['best']['planned_w'] / w['best']['harvest_w'] - 1.0):+.1f} %"
        for w in found["windows"]
        if w["best"]["planned_w"]
    ]
    planned = f" What their model had promised differs from it by {', '.join(gaps)}." if gaps else ""
    told = (
        f"`{asked['device']}`, coupling lag {1e3 * asked['lag_s']:g} ms. Windows of {asked['duration_s']:g} s; seeds "
        f"{states(found['seed_states'])}. Limits of the 98 % motion: {ranges}. The best of each window began from "
        f"{origins}.{planned} {_MEANT}{failures(found)}"
    )
    return "\n\n".join([_rows([name]), told, caption(name)])


def _rows(names: Sequence[str]) -> str:
    """Table of the best found, of what it takes beside the cap, and of the laws."""
    lines = []
    for name in names:
        found = result(name)
        gamma, count = f"{found['request']['gamma']:g}", len(found["windows"])
        top = found["summary"]["bounds"]["smooth"]
        taken, cap, whose = top["absorbed_w"], found["summary"]["cap_w"], "cap"
        if cap is None:  # none is known beyond the linear plant
            cap, whose = found["summary"]["linear_cap_w"], "linear float's cap, no limit here,"
        lines.append([gamma, "best found", f"{number(top['harvest_w'])} W", "", "", *_measures(top), "", f"{count}"])
        head = [
            gamma,
            "taken from the float, slip included",
            f"{number(taken)} W",
            f"{_part(taken / cap)} of the {whose.partition(',')[0]}",
        ]
        lines.append([*head, f"{whose} {number(cap)} W", *[""] * 7, f"{count}"])
        for law, run in found["summary"]["laws"].items():
            share, lowest = _part(run["fraction"]["smooth"]), _part(run["fraction_lowest"]["smooth"])
            held = f"{run['locked']}, {run['within_motion_limit']} of {run['runs']}"
            harvest = f"{number(run['harvest_w'])} W"
            lines.append([gamma, f"`{law}`", harvest, share, lowest, *_measures(run), held, f"{run['runs']}"])
    return table(HEADS, lines, 2)


def _measures(run: Mapping[str, Any]) -> list[str]:
    return [
        f"{number(run['generated_w'])}, {number(run['flywheel_w'], 2)}",
        number(run["power_cv"], 2),
        number(run["turns_kept"]),
        number(run["cycle_slips"], 2),
        pair(run["phi1_max"], run["phi3_max"]),
        percent(100.0 * run["outside_share"]),
    ]


def open_questions() -> str:
    """How far apart the starts end, where the best come from, how the plan and its replay differ."""
    windows = list(chain.from_iterable(result(name)["windows"] for name in kept_seas()))
    ends = [
        [start["after_w"] for start in w["best"]["starts"].values() if start["after_w"] is not None] for w in windows
    ]
    wide = max((end for end in ends if end), key=lambda end: max(end) - min(end))
    origins: dict[str, int] = {}
    for window in windows:
        origins[window["best"]["origin"]] = origins.get(window["best"]["origin"], 0) + 1
    from_ = ", ".join(f"{n} from `{name}`" for name, n in sorted(origins.items(), key=lambda item: -item[1]))
    shares = [window["best"]["absorbed_w"] / window["cap_w"] for window in windows]
    gaps = [100.0 * (w["best"]["planned_w"] / w["best"]["harvest_w"] - 1.0) for w in windows if w["best"]["planned_w"]]
    momenta = [window["momentum_max_nms"] for window in windows]
    planned = (
        f" What the model had promised differs from what the plant then gave by {min(gaps):+.1f} to {max(gaps):+.1f} %."
        if gaps
        else ""
    )
    return (
        f"Windows: {len(windows)}. The best found takes {_part(min(shares))} to {_part(max(shares))} of the cap, "
        f"at a momentum of {number(min(momenta))} to {number(max(momenta))} Nms; it began {from_}. The starts of one "
        f"window end as far apart as {number(min(wide))} and {number(max(wide))} W.{planned}\n\n{caption(*kept_seas())}"
    )


def _ends(starts: Mapping[str, Any]) -> list[float]:
    """Harvest to which each start led, of those that led to one. [W]"""
    return [start["after_w"] for start in starts.values() if start["after_w"] is not None]


BLOCKS: Mapping[str, Callable[[], str]] = {"bound": best, "bound-open": open_questions, "bound-realistic": realistic}
