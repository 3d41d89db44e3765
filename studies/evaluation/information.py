"""Tables `information` and `information_real`: what it is worth to know the waves ahead, in which water."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

from gyroctl.reports.layout import REFERENCE
from gyroctl.reports.wording import number
from gyroctl.statistics import holm, in_words, paired_difference
from gyroctl.studies.evaluation.cases import Case, Outcome, best_pair_of, common_seeds, run_case
from gyroctl.studies.evaluation.entrants import Entrant, parse, reference
from gyroctl.studies.evaluation.real_water import LINEAR, WATERS, Water
from gyroctl.studies.evaluation.request import Request
from gyroctl.studies.evaluation.rows import rows
from gyroctl.studies.evaluation.targets import limits_in_words, limits_missed
from gyroctl.studies.evaluation.writing import MEASURED, cells, markdown_table, row_table, with_interval
from gyroctl.waves import SeaState

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LEADS = (4, 2, 1, 0)
"""How far ahead the probe tells the moments. [s]"""

GAUGE_AT = 10.0
"""Distance of the gauge up-wave, in real water. [m]"""

LEVEL = 0.05
"""Of the tests of all steps together."""


SEEDS, DURATION = ("1:8",), 500.0
"""What the table in real water takes where nothing else is asked for; length in s."""

REALISTIC = WATERS[-1]

IN_WATER = (
    "In real water, with a coupling that lags: the planner plans with that water and is told of the lag. No law at all "
    "is the pair that was searched for the linear device: it is not the best pair here."
)


def levels(planner: str, water: Water = WATERS[0]) -> dict[str, Entrant]:
    """Levels of information, the most first: the same law with the same parameters, and no law at all.

    In real water a gauge up-wave stands before the sensors alone, and the design model is that of the water.
    """
    found = {"oracle": "oracle"} | {f"forecast {lead} s": f"forecast,lead={lead}" for lead in LEADS}
    design = ""
    if water.name != LINEAR:
        found |= {f"gauge at {GAUGE_AT:g} m": f"gauge,distance={GAUGE_AT:g}"}
        design = f",plant=realistic,lag={water.lag:g}"
    found |= {"sensors": "sensors"}
    laws = {name: parse(f"{planner}[information={text}{design}]")[0] for name, text in found.items()}
    return {**laws, "none": reference()}


def information_table(ask: Request, gamma: float = 5.0, water: Water = WATERS[0]) -> tuple[dict[str, Any], str, Figure]:
    """Run the planner on each level in a water; returns content, markdown and figure as the other tables."""
    from gyroctl.studies.evaluation.draw import draw_information

    ask.say(f"information: {water.name}")
    wanted, sea = levels(ask.planner, water), SeaState(gamma=gamma)
    case = Case("information", water.plant(), sea, water.settings(ask.settings))
    wanted["none"] = best_pair_of(Case("information", WATERS[0].plant(), sea, ask.settings), ask)
    outcome = run_case(case, wanted.values(), ask)
    by_law = rows(outcome)
    found = {name: by_law[entrant.label] for name, entrant in wanted.items() if entrant.label in by_law}
    steps = prices(outcome, {name: row.law for name, row in found.items()})
    content = {
        "gamma": gamma,
        "water": {"choices": dict(water.choices), "lag_s": water.lag},
        "levels": {name: {**vars(row), "limits_missed": limits_missed(row)} for name, row in found.items()},
        "differences": steps,
        "failed": dict(outcome.failed),
    }
    lines = [{**cells(row), "information": name, "limits": limits_in_words(row)} for name, row in found.items()]
    table = row_table(("information", "power [W]", "of best constant", *MEASURED, "limits"), lines)
    worth = [
        (s["less"], s["more"], with_interval(s["difference"]), str(s["pairs"]), number(s["p_holm"], 2), s["words"])
        for s in steps
    ]
    headings = ("less information", "more information", "worth [W]", "pairs", "p (Holm)", "in words")
    differences = markdown_table(headings, worth, 2)
    told = "" if water.name == LINEAR else f"{IN_WATER}\n\n"
    text = f"{told}{table}\n\n## Worth of information, paired on the same realisations\n\n{differences}"
    title = "The price of information" + ("" if water.name == LINEAR else " in real water")
    return content, text, draw_information(found, ask.record(), title)


def prices(outcome: Outcome, labels: dict[str, str]) -> list[dict[str, Any]]:
    """Paired differences in mean power: each level against the next lower one, and against none; Holm over all."""
    names = list(labels)
    pairs = list(pairwise(names))
    pairs += [(name, names[-1]) for name in names[:-2] if labels[names[-1]] == REFERENCE]
    steps: list[dict[str, Any]] = []
    for more, less in pairs:
        first, second = outcome.runs[labels[more]], outcome.runs[labels[less]]
        seeds = common_seeds(first, second)
        estimate, p = paired_difference(first.on(seeds, "mean_power"), second.on(seeds, "mean_power"))
        steps.append({"more": more, "less": less, "difference": estimate, "pairs": len(seeds), "p": p})
    for step, corrected in zip(steps, holm([step["p"] for step in steps]), strict=True):
        words = in_words(step["difference"], corrected, ("worth it", "harmful"), LEVEL)
        step |= {"p_holm": corrected, "words": words}
    return steps
