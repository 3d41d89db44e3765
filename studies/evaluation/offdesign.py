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
from gyroctl.errors import InputError
from gyroctl.plant import Plant
from gyroctl.reports.layout import REFERENCE
from gyroctl.reports.wording import number
from gyroctl.studies.evaluation.cases import Case, run_case
from gyroctl.studies.evaluation.entrants import Entrant, pair
from gyroctl.studies.evaluation.request import PAIRS, Request
from gyroctl.studies.evaluation.rows import Row, rows
from gyroctl.studies.evaluation.targets import limits_missed
from gyroctl.studies.evaluation.writing import markdown_table, with_interval
from gyroctl.tuning.best_pair import BestPair, best_pair
from gyroctl.tuning.goal import Goal
from gyroctl.waves import DriftingSea, Sea, SeaState
from gyroctl.writing import plain, write_json

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HEIGHTS = (0.15, 0.2, 0.283, 0.45, 0.6)
FREQUENCIES = (2.7, 2.9, 3.4, 3.6)
DRIFT = (2.8, 3.5)

TUNING_SEEDS = range(100000, 100064)
"""On which the best constant pair of each sea is found, as every law is tuned on such seeds."""


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
    """Best constant pair of a sea: as stored, or searched with the budget that every law has, and stored.

    In high seas no pair keeps the limit of motion, since the float rides the waves whatever is asked of the ring. There
    a pair that avoids motion would be a weak yardstick, so the search is made again without that limit.
    """
    content = {
        "coefficients": plain(plant.coefficients),
        "excitation": plant.excitation.sha256,
        "kind": type(sea).__name__,
        "sea": asdict(sea),
        "settings": plain(ask.settings),
        "budget": ask.budget,
        "seeds": list(TUNING_SEEDS),
        "goal": {**plain(Goal()), "motion_may_be_waived": True},
    }
    key = hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
    path = ask.out / PAIRS / f"{key}.json"
    try:
        return dict(json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError):
        pass
    goal = Goal()
    best = _best(plant, sea, ask, goal)
    waived = not best.met and max(best.means["phi1_p98"], best.means["phi3_p98"]) > goal.motion
    if waived:
        best = _best(plant, sea, ask, replace(goal, motion=math.inf))
    found = {
        "cc": best.cc,
        "cg": best.cg,
        "means": best.means,
        "met": best.met,
        "motion_waived": waived,
        "spent_s": best.spent,
        **content,
    }
    write_json(path, found)
    return dict(plain(found))


def _best(plant: Plant, sea: Sea, ask: Request, goal: Goal) -> BestPair:
    return best_pair(
        plant, sea, ask.budget, TUNING_SEEDS, goal, ask.settings, ask.workers or os.cpu_count() or 1, quiet=ask.quiet
    )


def offdesign_table(
    ask: Request, seas: Sequence[OffSea] | None = None, search: Search = found_pair
) -> tuple[dict[str, Any], str, Figure]:
    """Run every law in every sea beside the best constant pair of that sea.

    Parameters
    ----------
    ask : Request
        Laws, seeds, length.
    seas : sequence of OffSea, optional
        Other seas than those of the issue.
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
            outcome = run_case(Case(title, zhang2017(), off.sea, ask.settings), _with_pair(ask, best), ask)
        except InputError as error:  # a sea in which no lock begins tells something too
            failed[title] = str(error)
            continue
        failed |= {f"{title}, {law}": why for law, why in outcome.failed.items()}
        table = {row.law: row for row in rows(outcome)}
        groups.setdefault(off.group, []).append((off.name, table))
        cases.append(
            {
                "group": off.group,
                "name": off.name,
                "kind": type(off.sea).__name__,
                "sea": asdict(off.sea),
                "pair": best,
                "laws": [_record(row) for row in table.values()],
            }
        )
        parts.append(_section(title, best, table))
    summary = never_worse(groups)
    content = {"cases": cases, "never_worse": summary, "failed": failed}
    head = "## Never worse than the best constant pair?\n\n" + markdown_table(
        ("law", "answer", "least ratio", "worse in", "lock lost in"),
        [
            (
                law,
                s["answer"],
                f"{number(s['least_ratio'])} ({s['least_ratio_at']})",
                "; ".join(s["worse"]) or "none",
                "; ".join(s["lost"]) or "none",
            )
            for law, s in summary.items()
        ],
        2,
    )
    return content, "\n\n".join([head, *parts]), draw_offdesign(groups, ask.record())


def never_worse(groups: dict[str, list[tuple[str, dict[str, Row]]]]) -> dict[str, dict[str, Any]]:
    """Verdict on each law over all seas.

    Worse in a sea is a mean power below that of the best constant pair there: surely so where the interval of the
    paired difference lies below zero, else within what chance explains.
    """
    found: dict[str, dict[str, Any]] = {}
    for group, seas in groups.items():
        for name, table in seas:
            for law, row in table.items():
                if law == REFERENCE:
                    continue
                at = f"{group} {name}"
                entry = found.setdefault(law, _unjudged())
                if row.ratio.value < entry["least_ratio"]:
                    entry |= {"least_ratio": row.ratio.value, "least_ratio_at": at}
                word = sea_verdict(row)
                if word != "not worse":
                    entry["worse"].append(f"{at} ({number(row.difference.value, 2)} W, {word})")
                    entry["surely_worse"] += [at] if word == "worse" else []
                if row.locked < row.runs:
                    reference = table[REFERENCE]
                    entry["lost"].append(
                        f"{at} {row.runs - row.locked}/{row.runs} (constant "
                        f"{reference.runs - reference.locked}/{reference.runs})"
                    )
    for entry in found.values():
        if entry["surely_worse"]:
            entry["answer"] = "worse"
        elif entry["worse"]:
            entry["answer"] = "not distinguishable where worse"
    return found


def _unjudged() -> dict[str, Any]:
    return {
        "answer": "never worse",
        "least_ratio": float("inf"),
        "least_ratio_at": "",
        "worse": [],
        "surely_worse": [],
        "lost": [],
    }


def sea_verdict(row: Row) -> str:
    """Say whether a law is worse than the constant pair of a sea: not worse, worse, or not distinguishable from it."""
    if row.difference.value >= 0.0:
        return "not worse"
    return "worse" if row.difference.high < 0.0 else "not distinguishable"


def _with_pair(ask: Request, best: dict[str, Any]) -> list[Entrant]:
    return [pair(best["cc"], best["cg"]), *ask.entrants]


def _record(row: Row) -> dict[str, Any]:
    return {
        **{f: getattr(row, f) for f in row.__dataclass_fields__},
        "verdict": sea_verdict(row),
        "limits_missed": limits_missed(row),
    }


def _section(title: str, best: dict[str, Any], table: dict[str, Row]) -> str:
    lines = [
        (
            row.law,
            with_interval(row.power),
            with_interval(row.ratio),
            with_interval(row.difference),
            "" if row.law == REFERENCE else sea_verdict(row),
            number(row.cv.value, 2),
            f"{row.locked}/{row.runs}",
            f"{row.lock.low:.3f}–{row.lock.high:.3f}",
            f"{number(row.phi1_p98, 2)}, {number(row.phi3_p98, 2)}",
            number(row.cycle_slips, 2),
        )
        for row in sorted(table.values(), key=lambda row: -row.power.value)
    ]
    headings = (
        "law",
        "power [W]",
        "of best constant",
        "less best constant [W]",
        "verdict",
        "CV",
        "locked",
        "P(lock)",
        "φ1, φ3 98 % [rad]",
        "slips /1000",
    )
    words = f"Best constant pair of this sea: cc {best['cc']:.3g}, cg {best['cg']:.3g} Nms"
    if best.get("motion_waived"):
        words += ". No pair keeps the motion limit here; this is the best without it"
    words += "." if best.get("met", True) else "; none holds lock in 99 % of the tuning seeds, this one comes nearest."
    return f"## {title}\n\n{words}\n\n" + markdown_table(headings, lines)
