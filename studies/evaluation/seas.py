"""Table `seas`: every law in the three seas, against the bars."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from gyroctl.devices import zhang2017
from gyroctl.errors import InputError
from gyroctl.reports.wording import number
from gyroctl.studies.evaluation.cases import Case, Outcome, best_pair_of, check_any, run_case
from gyroctl.studies.evaluation.entrants import Entrant, parse, with_sets
from gyroctl.studies.evaluation.request import Request
from gyroctl.studies.evaluation.rows import Row, rows
from gyroctl.studies.evaluation.targets import (
    LOCKED,
    MOTION,
    Bar,
    answers,
    bars_for,
    limits_in_words,
    limits_missed,
    nearest_missed,
    one_set_laws,
)
from gyroctl.studies.evaluation.writing import COST, MEASURED, cells, markdown_table, row_table
from gyroctl.waves import SeaState

if TYPE_CHECKING:
    from matplotlib.figure import Figure

GAMMAS = (1.0, 5.0, 50.0)

HEADINGS = ("law", "sees", "power [W]", "of best constant", *MEASURED, *COST, "bars")


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

    def case_of(gamma: float) -> Case:
        return Case(sea_name(gamma), zhang2017(), SeaState(gamma=gamma), ask.settings)

    def taking_part(case: Case, gamma: float) -> list[Entrant]:
        return [best_pair_of(case, ask), *with_sets(_entrants(ask), f"gamma{gamma:g}")]

    outcomes, failed = in_each_sea("seas", ask, gammas, case_of, taking_part)
    tables = {
        gamma: sorted(rows(outcome).values(), key=lambda row: -row.power.value) for gamma, outcome in outcomes.items()
    }
    verdicts, served = answers(tables), one_set_laws(tables)
    content = {
        "seas": {f"gamma{gamma:g}": [_record(gamma, row) for row in table] for gamma, table in tables.items()},
        "limits": {"motion_rad": MOTION, "locked": LOCKED, "within_motion": LOCKED},
        "bars": [{**vars(v.bar), "met": v.met, "law": v.law, "missed": v.missed} for v in verdicts],
        "one_set_for_all_seas": {law: {"met": not missed, "missed": missed} for law, missed in served.items()},
        "failed": failed,
    }
    parts = []
    for gamma, table in tables.items():
        lines = [{**cells(row), "bars": bar_words(gamma, row)} for row in table]
        parts.append(f"## gamma {gamma:g}\n\n{row_table(HEADINGS, lines, 2)}")
    demands = [
        (v.bar.name, f"gamma {v.bar.gamma:g}", _demand(v.bar), _yes(v.met), v.law or "–", _all(v.missed))
        for v in verdicts
    ]
    headings = ("bar", "sea", "demand", "met", "by, or nearest", "missed")
    parts += [
        f"## Bars\n\n{markdown_table(headings, demands, 6)}",
        f"Every bar also asks for a 98 % motion of at most {MOTION:g} rad and for lock, each in at least "
        f"{100 * LOCKED:g} % of the realisations, and that the law is in step with the waves in no fewer of them than "
        "the best constant pair of the sea, but for chance. The word met goes by the numbers in the table, not by the "
        "ends of their intervals.",
    ]
    if served:
        answered = [(law, _yes(not missed), _all(missed)) for law, missed in served.items()]
        table_of_sets = markdown_table(("law", "met in all", "missed"), answered, 3)
        parts.append(f"## One set of parameters for all seas\n\n{table_of_sets}")
    return content, "\n\n".join(parts), draw_seas(tables, ask.record())


def sea_name(gamma: float) -> str:
    """Name of a case, by which seeds may be given: ``@gamma 5=1:8``."""
    return f"gamma {gamma:g}"


def asked_for(ask: Request, gammas: Sequence[float]) -> list[float]:
    """Peak enhancements of the cases that are asked for, all where none is named.

    Raises
    ------
    InputError
        Field ``only``, for a case that the table does not have.
    """
    names = {sea_name(gamma): gamma for gamma in gammas}
    for name in ask.only:
        if name not in names:
            raise InputError("only", name, "is no case of this table", f"Name of {', '.join(names)}")
    return [gamma for name, gamma in names.items() if not ask.only or name in ask.only]


def in_each_sea(
    table: str,
    ask: Request,
    gammas: Sequence[float],
    case_of: Callable[[float], Case],
    taking_part: Callable[[Case, float], list[Entrant]],
) -> tuple[dict[float, Outcome], dict[str, str]]:
    """Run a case for each peak enhancement, with the reference and the laws that take part in it.

    Returns
    -------
    outcomes : dict
        By peak enhancement.
    failed : dict
        What was not run, and why.

    Raises
    ------
    InputError
        Where every case failed.
    """
    outcomes: dict[float, Outcome] = {}
    failed: dict[str, str] = {}
    for gamma in asked_for(ask, gammas):
        case = case_of(gamma)
        ask.say(f"{table}: {case.name}")
        try:
            outcomes[gamma] = run_case(case, taking_part(case, gamma), ask)
        except InputError as error:
            failed[case.name] = str(error)
            continue
        failed |= outcomes[gamma].failures
    check_any(outcomes, failed)
    return outcomes, failed


def bar_words(gamma: float, row: Row) -> str:
    """Say of a row which bars of its kind it meets; where it meets none, what it misses of the nearest."""
    bars = bars_for(gamma, row)
    met = [bar.name for bar in bars if not bar.missed(row)]
    if met:
        return "met: " + "; ".join(met)
    if bars:
        bar, missed = nearest_missed(bars, row)
        return f"not met: {missed} ({bar.name})"
    return f"no bar; limits {limits_in_words(row)}"


def _entrants(ask: Request) -> list[Entrant]:
    """The laws asked for; by default also the planner with a perfect preview, for which there is a bar."""
    found = list(ask.entrants)
    if "laws" not in ask.given and any(entrant.name == ask.planner for entrant in found):
        found += parse(f"{ask.planner}[information=oracle]")
    return found


def _record(gamma: float, row: Row) -> dict[str, Any]:
    missed = {bar.name: bar.missed(row) for bar in bars_for(gamma, row)}
    bars = {name: {"met": not missing, "missed": missing} for name, missing in missed.items()}
    return {**vars(row), "bars": bars, "limits_missed": limits_missed(row)}


def _yes(met: bool) -> str:
    return "yes" if met else "no"


def _all(missed: Sequence[str]) -> str:
    return "; ".join(missed) or "nothing"


def _demand(bar: Bar) -> str:
    parts = [
        f">= {number(bar.power)} W" if bar.power else "",
        f">= {number(bar.ratio)} x constant" if bar.ratio else "",
        f"CV <= {bar.cv:g}" if bar.cv < 10.0 else "",
    ]
    return ", ".join(part for part in parts if part)
