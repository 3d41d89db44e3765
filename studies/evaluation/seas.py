"""Table `seas`: every law in the three seas, against the bars."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from gyroctl.devices import zhang2017
from gyroctl.reports.wording import number
from gyroctl.studies.evaluation.cases import Case, run_case
from gyroctl.studies.evaluation.entrants import Entrant, parse, reference, with_sets
from gyroctl.studies.evaluation.request import Request
from gyroctl.studies.evaluation.rows import Row, rows
from gyroctl.studies.evaluation.targets import BARS, LOCKED, MOTION, answers, limits_missed, one_set_laws
from gyroctl.studies.evaluation.writing import markdown_table, with_interval
from gyroctl.waves import SeaState

if TYPE_CHECKING:
    from matplotlib.figure import Figure

GAMMAS = (1.0, 5.0, 50.0)

HEADINGS = (
    "law",
    "sees",
    "power [W]",
    "of best constant",
    "CV",
    "locked",
    "P(lock)",
    "φ1, φ3 98 % [rad]",
    "runs over it",
    "slips /1000",
    "slip loss [W]",
    "saturated",
    "step [ms]",
    "fallbacks",
    "late",
    "bars",
)


def seas_table(ask: Request, gammas: Sequence[float] = GAMMAS) -> tuple[dict[str, Any], str, Figure]:
    """Run the laws in each sea: with the one set of parameters for all seas, and with the set of the sea.

    Returns
    -------
    content : dict
        For the JSON file.
    text : str
        Markdown.
    figure : Figure
    """
    from gyroctl.studies.evaluation.draw import draw_seas

    tables: dict[float, list[Row]] = {}
    failed: dict[str, str] = {}
    for gamma in gammas:
        ask.say(f"seas: gamma {gamma:g}")
        case = Case(f"gamma {gamma:g}", zhang2017(), SeaState(gamma=gamma), ask.settings)
        outcome = run_case(case, [reference(gamma), *with_sets(_entrants(ask), f"gamma{gamma:g}")], ask)
        tables[gamma] = sorted(rows(outcome), key=lambda row: -row.power.value)
        failed |= {f"gamma {gamma:g}, {law}": why for law, why in outcome.failed.items()}
    verdicts, served = answers(tables), one_set_laws(tables)
    content = {
        "seas": {f"gamma{gamma:g}": [_record(gamma, row) for row in table] for gamma, table in tables.items()},
        "limits": {"motion_rad": MOTION, "locked": LOCKED},
        "bars": [{**vars(v.bar), "met": v.met, "law": v.law, "missed": v.missed} for v in verdicts],
        "one_set_for_all_seas": {law: {"met": not missed, "missed": missed} for law, missed in served.items()},
        "failed": failed,
    }
    parts = []
    for gamma, table in tables.items():
        parts.append(f"## gamma {gamma:g}\n\n" + markdown_table(HEADINGS, [_line(gamma, row) for row in table], 2))
    parts.append(
        "## Bars\n\n"
        + markdown_table(
            ("bar", "sea", "demand", "met", "by, or nearest", "missed"),
            [
                (
                    v.bar.name,
                    f"gamma {v.bar.gamma:g}",
                    _demand(v.bar),
                    "yes" if v.met else "no",
                    v.law or "–",
                    "; ".join(v.missed) or "nothing",
                )
                for v in verdicts
            ],
            6,
        )
    )
    parts.append(
        f"Every bar also asks for a 98 % motion of at most {MOTION:g} rad and lock in at least {100 * LOCKED:g} % of "
        "the realisations. The word met goes by the numbers in the table, not by the ends of their intervals."
    )
    if served:
        lines = [(law, "yes" if not missed else "no", "; ".join(missed) or "nothing") for law, missed in served.items()]
        parts.append(
            "## One set of parameters for all seas\n\n" + markdown_table(("law", "met in all", "missed"), lines, 3)
        )
    return content, "\n\n".join(parts), draw_seas(tables, ask.record())


def bar_words(gamma: float, row: Row) -> str:
    """Say of a row which bars of its kind it meets; where it meets none, what it misses of the nearest."""
    bars = [bar for bar in BARS if bar.gamma == gamma and bar.concerns(row)]
    met = [bar.name for bar in bars if not bar.missed(row)]
    if met:
        return "met: " + "; ".join(met)
    if bars:
        nearest = min(bars, key=lambda bar: bar.shortfall(row))
        return f"not met: {', '.join(nearest.missed(row))} ({nearest.name})"
    missing = limits_missed(row)
    return "no bar; limits " + (f"not kept: {', '.join(missing)}" if missing else "kept")


def _entrants(ask: Request) -> list[Entrant]:
    """The laws asked for; by default also the planner with a perfect preview, for which there is a bar."""
    found = list(ask.entrants)
    if not ask.named and any(entrant.name == ask.planner for entrant in found):
        found += parse(f"{ask.planner}[information=oracle]")
    return found


def _record(gamma: float, row: Row) -> dict[str, Any]:
    bars = {
        bar.name: {"met": not bar.missed(row), "missed": bar.missed(row)}
        for bar in BARS
        if bar.gamma == gamma and bar.concerns(row)
    }
    return {
        **{name: getattr(row, name) for name in row.__dataclass_fields__},
        "bars": bars,
        "limits_missed": limits_missed(row),
    }


def _line(gamma: float, row: Row) -> tuple[str, ...]:
    return (
        row.law,
        row.information,
        with_interval(row.power),
        with_interval(row.ratio),
        number(row.cv.value, 2),
        f"{row.locked}/{row.runs}",
        f"{row.lock.low:.3f}–{row.lock.high:.3f}",
        f"{number(row.phi1_p98, 2)}, {number(row.phi3_p98, 2)}",
        f"{row.over_limit}",
        number(row.cycle_slips, 2),
        number(row.slip_loss_w, 2),
        number(row.saturations, 2),
        f"{_time(row.step_ms_median)}, {_time(row.step_ms_p99)}",
        str(row.fallbacks),
        str(row.deadline_misses),
        bar_words(gamma, row),
    )


def _time(milliseconds: float) -> str:
    return "< 0.01" if milliseconds < 0.01 else number(milliseconds, 2)


def _demand(bar: Any) -> str:
    parts = [
        f">= {number(bar.power)} W" if bar.power else "",
        f">= {number(bar.ratio)} x constant" if bar.ratio else "",
        f"CV <= {bar.cv:g}" if bar.cv < 10.0 else "",
    ]
    return ", ".join(part for part in parts if part)
