"""Table `offdesign`: other heights, other frequencies, a frequency that drifts; the laws stay as they are."""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any, NamedTuple

from gyroctl.devices import zhang2017
from gyroctl.engine.steps import Steps
from gyroctl.errors import InputError
from gyroctl.plant import Plant
from gyroctl.reports.layout import REFERENCE
from gyroctl.reports.wording import number
from gyroctl.studies.evaluation.cases import Case, check_any, run_case
from gyroctl.studies.evaluation.entrants import pair
from gyroctl.studies.evaluation.request import PAIRS, Request
from gyroctl.studies.evaluation.rows import Row, rows
from gyroctl.studies.evaluation.targets import limits_missed
from gyroctl.studies.evaluation.writing import MEASURED, cells, markdown_table, row_table
from gyroctl.tuning.best_pair import BestPair, best_pair
from gyroctl.tuning.goal import Goal
from gyroctl.waves import DriftingSea, Sea, SeaState
from gyroctl.writing import plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HEIGHTS = (0.15, 0.2, 0.283, 0.45, 0.6)
FREQUENCIES = (2.7, 2.9, 3.4, 3.6)
DRIFT = (2.8, 3.5)

TUNING_SEEDS = range(100000, 100064)
"""On which the best constant pair of each sea is found, as every law is tuned on such seeds."""


SEARCHING = ("gyroctl.tuning.best_pair",)
"""Module that finds it."""

HEADINGS = ("law", "power [W]", "of best constant", "less best constant [W]", "verdict", *MEASURED)


class OffSea(NamedTuple):
    """A sea off the design: the group it is drawn in, its name there, and the sea."""

    group: str
    name: str
    sea: Sea


Search = Callable[[Plant, Sea, Request], dict[str, Any]]


def off_seas(duration: float) -> tuple[OffSea, ...]:
    """All seas of the table; the drift takes the length of the run."""
    heights = [OffSea("significant height", f"{hs:g} m", SeaState(hs=hs)) for hs in HEIGHTS]
    peaks = [OffSea("peak frequency", f"{wp:g} rad/s", SeaState(wp=wp)) for wp in FREQUENCIES]
    over = max(duration, 100.0 * (DRIFT[1] - DRIFT[0]) / 0.1)
    drifts = [
        OffSea("drifting peak", f"{first:g} to {last:g}", DriftingSea(wp=first, wp_end=last, over=over))
        for first, last in (DRIFT, DRIFT[::-1])
    ]
    return (*heights, *peaks, *drifts)


def found_pair(plant: Plant, sea: Sea, ask: Request) -> dict[str, Any]:
    """Best constant pair of a sea: as stored, or searched with the budget that is asked for, and stored.

    In high seas no pair keeps the limit of motion, since the float rides the waves whatever is asked of the ring. There
    a pair that avoids motion would be a weak yardstick, so the search is made again without that limit.
    """
    content = {
        "coefficients": plain(plant.coefficients),
        "excitation": plant.excitation.sha256,
        "water": plant.water,
        **_sea(sea),
        "settings": plain(ask.settings),
        "budget": ask.budget,
        "seeds": list(TUNING_SEEDS),
        "goal": {**plain(Goal()), "motion_may_be_waived": True},
    }
    key = hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
    steps = Steps(ask.out / PAIRS, key, SEARCHING, (), f"constant pair of {sea}")
    return dict(plain({**steps("search", lambda: _searched(plant, sea, ask)), **content}))


def _searched(plant: Plant, sea: Sea, ask: Request) -> dict[str, Any]:
    goal = Goal()
    best = _best(plant, sea, ask, goal)
    waived = not best.met and max(best.means["phi1_p98"], best.means["phi3_p98"]) > goal.motion
    if waived:
        best = _best(plant, sea, ask, replace(goal, motion=math.inf))
    chosen = {"cc": best.cc, "cg": best.cg, "means": best.means, "met": best.met}
    return {**chosen, "motion_waived": waived, "spent_s": best.spent}


def _best(plant: Plant, sea: Sea, ask: Request, goal: Goal) -> BestPair:
    workers = ask.workers or os.cpu_count() or 1
    return best_pair(plant, sea, ask.budget, TUNING_SEEDS, goal, ask.settings, workers, quiet=ask.quiet)


def offdesign_table(
    ask: Request, seas: Sequence[OffSea] | None = None, search: Search = found_pair
) -> tuple[dict[str, Any], str, Figure]:
    """Run every law in every sea beside the best constant pair of that sea.

    Parameters
    ----------
    ask : Request
        Laws, seeds, length.
    seas : sequence of OffSea, optional
        Other seas than `off_seas`.
    search : callable
        Finds the best constant pair of a sea.
    """
    from gyroctl.studies.evaluation.draw import draw_offdesign

    wanted = off_seas(ask.duration) if seas is None else seas
    groups: dict[str, list[tuple[str, dict[str, Row]]]] = {}
    cases: list[dict[str, Any]] = []
    failed: dict[str, str] = {}
    parts = []
    for i, off in enumerate(wanted):
        ask.say(f"offdesign: {off.group} {off.name} ({i + 1} of {len(wanted)})")
        title = f"{off.group} {off.name}"
        try:
            best = search(zhang2017(), off.sea, ask)
            case = Case(title, zhang2017(), off.sea, ask.settings)
            outcome = run_case(case, [pair(best["cc"], best["cg"]), *ask.entrants], ask)
        except InputError as error:  # a sea in which no lock begins tells something too
            failed[title] = str(error)
            continue
        failed |= outcome.failures
        table = rows(outcome)
        groups.setdefault(off.group, []).append((off.name, table))
        laws = [
            {**vars(row), "verdict": sea_verdict(row), "limits_missed": limits_missed(row)} for row in table.values()
        ]
        cases.append({"group": off.group, "name": off.name, **_sea(off.sea), "pair": best, "laws": laws})
        parts.append(_section(title, best, table))
    check_any(groups, failed)
    summary = never_worse(groups)
    content = {"cases": cases, "never_worse": summary, "failed": failed}
    answers = [
        (
            law,
            judged["answer"],
            f"{number(judged['least_ratio'])} ({judged['least_ratio_at']})",
            "; ".join(judged["worse"]) or "none",
            "; ".join(judged["lost"]) or "none",
        )
        for law, judged in summary.items()
    ]
    table_of_answers = markdown_table(("law", "answer", "least ratio", "worse in", "lock lost in"), answers, 2)
    parts.insert(0, f"## Never worse than the best constant pair?\n\n{table_of_answers}")
    return content, "\n\n".join(parts), draw_offdesign(groups, ask.record())


def never_worse(groups: dict[str, list[tuple[str, dict[str, Row]]]]) -> dict[str, dict[str, Any]]:
    """Verdict on each law over all seas.

    Worse in a sea is a mean power below that of the best constant pair there: surely so where the interval of the
    paired difference lies below zero, else within what chance explains.
    """
    met: dict[str, dict[str, tuple[Row, Row]]] = {}
    for group, seas in groups.items():
        for name, table in seas:
            for law, row in table.items():
                if law != REFERENCE:
                    met.setdefault(law, {})[f"{group} {name}"] = row, table[REFERENCE]
    return {law: _judged(seas) for law, seas in met.items()}


def _judged(seas: dict[str, tuple[Row, Row]]) -> dict[str, Any]:
    """Verdict on a law from its row and that of the constant pair in each sea."""
    worse, surely_worse, lost = [], [], []
    for at, (row, constant) in seas.items():
        word = sea_verdict(row)
        if word != "not worse":
            worse.append(f"{at} ({number(row.difference.value, 2)} W, {word})")
        if word == "worse":
            surely_worse.append(at)
        if row.locked < row.runs:
            lost.append(f"{at} {_lost(row)} (constant {_lost(constant)})")
    ratios = [(row.ratio.value, at) for at, (row, _) in seas.items() if row.ratio.value < math.inf]
    least, least_at = min(ratios, key=lambda ratio: ratio[0], default=(math.inf, ""))
    answer = "worse" if surely_worse else "not distinguishable where worse" if worse else "never worse"
    return {
        "answer": answer,
        "least_ratio": least,
        "least_ratio_at": least_at,
        "worse": worse,
        "surely_worse": surely_worse,
        "lost": lost,
    }


def _lost(row: Row) -> str:
    return f"{row.runs - row.locked}/{row.runs}"


def sea_verdict(row: Row) -> str:
    """Say whether a law is worse than the constant pair of a sea: not worse, worse, or not distinguishable from it."""
    if row.difference.value >= 0.0:
        return "not worse"
    return "worse" if row.difference.high < 0.0 else "not distinguishable"


def _sea(sea: Sea) -> dict[str, Any]:
    return {"kind": type(sea).__name__, "sea": asdict(sea)}


def _section(title: str, best: dict[str, Any], table: dict[str, Row]) -> str:
    strongest = sorted(table.values(), key=lambda row: -row.power.value)
    verdicts = {row.law: sea_verdict(row) for row in strongest if row.law != REFERENCE}
    lines = [{**cells(row), "verdict": verdicts.get(row.law, "")} for row in strongest]
    words = f"Best constant pair of this sea: cc {best['cc']:.3g}, cg {best['cg']:.3g} Nms"
    if best.get("motion_waived"):
        words += ". No pair keeps the motion limit here; this is the best without it"
    words += "." if best.get("met", True) else "; none holds lock in 99 % of the tuning seeds, this one comes nearest."
    return f"## {title}\n\n{words}\n\n{row_table(HEADINGS, lines)}"
