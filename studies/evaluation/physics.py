"""Table `physics`: the laws in real water, and whether their order is still that of the linear plant."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from gyroctl.errors import InputError
from gyroctl.reports.layout import REFERENCE
from gyroctl.reports.wording import number, percent
from gyroctl.studies.evaluation.cases import Case, Outcome, best_pair_of, run_case
from gyroctl.studies.evaluation.order import changes, holding, lost_lock, order
from gyroctl.studies.evaluation.physics_answer import Judged, answer, in_sentences
from gyroctl.studies.evaluation.physics_cells import Cell, table_of
from gyroctl.studies.evaluation.real_water import LINEAR, WATERS, Water, in_words
from gyroctl.studies.evaluation.request import Request
from gyroctl.studies.evaluation.writing import LOCK, PARTS, PHI, cells, markdown_table, row_table, with_interval
from gyroctl.waves import SeaState

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LAWS, SEEDS, DURATION = "nmpc,coupling,load_angle", ("1:16", "nmpc=1:8"), 600.0
"""What the table takes where nothing else is asked for; lengths in s."""

OF_LINEAR, LESS = "of its linear power", "less linear [W]"
CARD = ("reversals", "traction 99 %", "beyond validity")
HEADINGS = ("case", *LOCK, "power [W]", OF_LINEAR, LESS, "of best constant", *PARTS, "CV", PHI, *CARD)

UNCHANGED = (
    "The laws stay as they ship and plan with the linear device. `best_constant` is the pair that was searched for the "
    "linear plant, the same in every case: it is not the best pair of the others. Lock, reversals and traction are "
    "means over the runs; traction is the friction coefficient that rolling needs in 99 % of the time."
)


def physics_table(
    ask: Request, waters: Sequence[Water] = WATERS, gamma: float = 5.0
) -> tuple[dict[str, Any], str, Figure]:
    """Run every law in every water; returns content, markdown and figure as the other tables.

    Parameters
    ----------
    ask : Request
        Laws, seeds, length.
    waters : sequence of Water
        The cases, the linear one first.
    gamma : float
        Peak enhancement of the sea.
    """
    from gyroctl.studies.evaluation.draw_physics import draw_physics

    sea = SeaState(gamma=gamma)
    pair = best_pair_of(Case(LINEAR, waters[0].plant(), sea, ask.settings), ask)
    found: dict[str, Outcome] = {}
    failed: dict[str, str] = {}
    begin = time.monotonic()
    for i, water in enumerate(waters):
        ask.say(f"physics: {water.name} ({i + 1} of {len(waters)}{_left(time.monotonic() - begin, i, len(waters))})")
        try:
            case = Case(water.name, water.plant(), sea, water.settings(ask.settings))
            found[water.name] = run_case(case, [pair, *ask.entrants], ask)
        except InputError as error:
            if water.name == LINEAR:  # all others are told relative to it
                raise
            failed[water.name] = str(error)
    linear = found[LINEAR]
    tables = {name: _in_order(table_of(outcome, linear), ask) for name, outcome in found.items()}
    judged = {water.name: judge(water, found[water.name], linear) for water in waters if water.name in found}
    answered = answer(judged)
    content = {
        "gamma": gamma,
        "pair": dict(pair.parameters),
        "waters": {
            water.name: {"choices": dict(water.choices), "lag_s": water.lag, "single": water.single} for water in waters
        },
        "cases": {name: [cell.record() for cell in table.values()] for name, table in tables.items()},
        "orders": {name: one.record() for name, one in judged.items()},
        "answer": {**answered, "sentences": in_sentences(answered)},
        "failed": failed | {what: why for outcome in found.values() for what, why in outcome.failures.items()},
    }
    return content, _text(waters, tables, judged, answered), draw_physics(tables, ask.record())


def _in_order(table: Mapping[str, Cell], ask: Request) -> dict[str, Cell]:
    """Laws as they were asked for, the reference last."""
    asked = [entrant.label for entrant in ask.entrants]
    return {law: table[law] for law in [*asked, REFERENCE] if law in table}


def _left(spent: float, done: int, cases: int) -> str:
    """Time left by the mean of the cases that are done, where it is worth a word."""
    left = spent / done * (cases - done) / 60.0 if done else 0.0
    return f", about {left:.0f} min left" if left > 1.0 else ""


def judge(water: Water, outcome: Outcome, linear: Outcome) -> Judged:
    """Order and lock in a case against the linear plant."""
    here, before, held = order(outcome.runs), order(linear.runs), holding(outcome.runs)
    return Judged(
        water, here, tuple(held), tuple(changes(before, here, held)), tuple(lost_lock(linear.runs, outcome.runs))
    )


def _text(
    waters: Sequence[Water],
    tables: Mapping[str, Mapping[str, Cell]],
    judged: Mapping[str, Judged],
    answered: Mapping[str, Any],
) -> str:
    laws = list(tables[LINEAR])
    said = "\n\n".join(in_sentences(answered))
    glance = [
        (name, *(_glance(table.get(law)) for law in laws), judged[name].order.words) for name, table in tables.items()
    ]
    parts = [
        UNCHANGED,
        f"## Does the order of the laws change, and which choice turns it?\n\n{said}",
        "## At a glance\n\nMean power [W] / CV / runs that held lock / 98 % of φ1 [rad]; in the order `>` stands "
        "between neighbours that can be told apart (paired, Holm over all pairs of the case), `≈` between others.\n\n"
        + markdown_table(("case", *laws, "order"), glance),
    ]
    for law in laws:
        lines = [_line(name, table[law]) for name, table in tables.items() if law in table]
        parts.append(f"## {law}\n\n{row_table(HEADINGS, lines)}")
    cases = [(water.name, in_words(water)) for water in waters]
    parts.append("## The cases\n\n" + markdown_table(("case", "beyond the linear model"), cases, 2))
    return "\n\n".join(parts)


def _glance(cell: Cell | None) -> str:
    if cell is None:
        return "failed"
    row = cell.row
    told = (number(row.power.value), number(row.cv.value, 2), f"{row.locked} of {row.runs}", number(row.phi1_p98, 2))
    return " / ".join(told)


def _line(name: str, cell: Cell) -> dict[str, str]:
    return {
        **cells(cell.row),
        "case": name,
        OF_LINEAR: with_interval(cell.of_linear),
        LESS: with_interval(cell.less_linear),
        "reversals": number(cell.reversals, 2),
        "traction 99 %": number(cell.traction_p99, 2),
        "beyond validity": percent(100.0 * cell.beyond_validity),
    }
