"""Table `real`: laws in real water, each with the set that it has for it, beside the best constant pair found there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from gyroctl.errors import InputError
from gyroctl.harness.registry import describe
from gyroctl.harness.yardstick import Yardstick
from gyroctl.reports.layout import REFERENCE
from gyroctl.reports.wording import number
from gyroctl.statistics import Estimate
from gyroctl.studies.evaluation.cases import Case
from gyroctl.studies.evaluation.entrants import Entrant, in_real_water, pair, set_in_words
from gyroctl.studies.evaluation.real_lines import Line, lines_of
from gyroctl.studies.evaluation.real_targets import OPEN, TARGETS, Answer, answers
from gyroctl.studies.evaluation.real_water import REALISTIC, Water
from gyroctl.studies.evaluation.real_water import in_words as water_in_words
from gyroctl.studies.evaluation.request import Request
from gyroctl.studies.evaluation.seas import GAMMAS, in_each_sea, sea_name
from gyroctl.studies.evaluation.writing import cells, markdown_table, row_table, with_interval
from gyroctl.tuning.yardstick import REAL_BUDGET, find_real_yardstick
from gyroctl.waves import SeaState

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LAWS = "nmpc,coupling,load_angle,scheduled_lqr,scheduled_lmi,tracking,stabiliser,threshold"
SEEDS, DURATION = ("1:8",), 1000.0
"""What the table takes where nothing else is asked for; length in s."""

OWN = {
    "no reversal": "forward",
    "single runs": "single",
    "turns": "turns",
    "slips per 1000 waves": "slips",
    "reversals a run": "reversals",
    "98 % of φ1 [rad]": "phi1",
    "less the pair's [rad]": "phi1_less",
    "98 % of φ3 [rad]": "phi3",
}
"""Headings and what stands below them, see `real_lines.Line`."""

BEYOND = "beyond validity [% of the time]"

HEADINGS = (
    *("law", "sees", "set", "power [W]", "of best constant", "less best constant [W]", "CV of power"),
    *("locked", "P(lock)", "in step", "P(in step)", *OWN, BEYOND),
)


def real_table(
    ask: Request, gammas: Sequence[float] = GAMMAS, water: Water = REALISTIC
) -> tuple[dict[str, Any], str, Figure]:
    """Run the laws in each sea of real water; returns content, markdown and figure as the other tables.

    Parameters
    ----------
    ask : Request
        Laws, seeds, length; the budget of a search where the pair of a sea is not known.
    gammas : sequence of float
        Peak enhancements of the seas.
    water : Water
        The device.
    """
    from gyroctl.studies.evaluation.draw_real import draw_real

    pairs: dict[float, Yardstick] = {}
    taken: dict[float, list[Entrant]] = {}

    def case_of(gamma: float) -> Case:
        return Case(sea_name(gamma), water.plant(), SeaState(gamma=gamma), water.settings(ask.settings))

    def taking_part(case: Case, gamma: float) -> list[Entrant]:
        budget = ask.budget if "budget" in ask.given else REAL_BUDGET
        pairs[gamma] = find_real_yardstick(SeaState(gamma=gamma), budget, ask.workers, ask.quiet, ask.say)
        taken[gamma] = in_real_water(ask.entrants, f"gamma{gamma:g}")
        return [pair(pairs[gamma].cc, pairs[gamma].cg), *taken[gamma]]

    outcomes, failed = in_each_sea("real", ask, gammas, case_of, taking_part)
    tables = {gamma: lines_of(outcome) for gamma, outcome in outcomes.items()}
    sets = {gamma: {one.label: set_of(one, gamma) for one in taken[gamma]} for gamma in tables}
    answered = answers({gamma: list(table.values()) for gamma, table in tables.items()})
    content: dict[str, Any] = {
        "water": {"choices": dict(water.choices), "lag_s": water.lag, "words": water_in_words(water)},
        "pairs": {_key(gamma): asdict(pairs[gamma]) for gamma in tables},
        "sets": {_key(gamma): own for gamma, own in sets.items()},
        "seas": {_key(gamma): [line.record() for line in table.values()] for gamma, table in tables.items()},
        "targets": [one.record() for one in answered],
        "failed": failed,
    }
    text = [in_words(content["water"])]
    for gamma, table in tables.items():
        lines = [_cells(line, sets[gamma]) for line in table.values()]
        text.append(f"## {sea_name(gamma)}\n\n{pair_in_words(content['pairs'][_key(gamma)])}")
        text.append(row_table(HEADINGS, lines, 3))
    text += ["## Targets", markdown_table(TARGET_HEADINGS, target_lines(answered), 4), VERDICTS]
    figure = draw_real({gamma: list(table.values()) for gamma, table in tables.items()}, TARGETS, ask.record())
    return content, "\n\n".join(text), figure


def set_of(entrant: Entrant, gamma: float) -> dict[str, Any]:
    """Which parameters a law has there, and what it holds for true of device and lag, where it holds anything."""
    try:
        told = describe(entrant.build())
    except InputError:  # it is told in the table why it could not be built
        told = {}
    believes: dict[str, Any] = {name: told[name] for name in ("plant", "lag") if name in told}
    return {"set": entrant.tuning, "words": set_in_words(entrant.tuning, f"gamma{gamma:g}"), **believes}


def in_words(water: Mapping[str, Any]) -> str:
    """What is simulated, and what the laws and the pair are."""
    return (
        f"The device: {water['words']}; the sea is the default one in each peak enhancement. A law has the set that it "
        "was tuned with in real water: for all seas, else for one sea alone; one that was never tuned there has its "
        "set of the linear plant. `best_constant` is the best pair of each sea, found in real water with the wetted "
        "surface as polynomials, within the goal of its task. Of the shares the intervals are Wilson's; a "
        "single run counts where it gives 9 W at a CV of at most 0.25."
    )


def pair_in_words(found: Mapping[str, Any]) -> str:
    """The pair of a sea, and how it was found."""
    return f"Best constant pair: cc {number(found['cc'])}, cg {number(found['cg'])} Nms; {found['words']}."


TARGET_HEADINGS = ("target", "sea", "by, or nearest", "measure", "demand", "found", "verdict")

VERDICTS = (
    "A target asks one law for all its demands at once. A verdict goes by the number in the table; where it is "
    "unsure, some values of the interval would have another one. Open is what was not run."
)


def verdict_in_words(verdict: str, sure: bool) -> str:
    """Say a verdict, and whether its interval leaves a doubt."""
    return verdict if sure or verdict == OPEN else f"{verdict} (unsure)"


def target_lines(answered: Sequence[Answer]) -> list[list[str]]:
    """Lines of the table of targets, one a demand."""
    return [
        [
            f"{one.target.name}: {one.verdict}",
            sea_name(one.target.gamma),
            one.law or "–",
            finding.demand.measure,
            finding.demand.words,
            with_interval(finding.found) if finding.found else "–",
            verdict_in_words(finding.verdict, finding.sure),
        ]
        for one in answered
        for finding in one.findings
    ]


def in_percent(share: Estimate) -> Estimate:
    """A share as a percentage."""
    return Estimate(100.0 * share.value, 100.0 * share.low, 100.0 * share.high, share.note)


def _key(gamma: float) -> str:
    return f"gamma{gamma:g}"


def _cells(line: Line, sets: Mapping[str, Mapping[str, Any]]) -> dict[str, str]:
    row, own = line.row, {heading: with_interval(getattr(line, name)) for heading, name in OWN.items()}
    return {
        **cells(row),
        **own,
        "set": "searched in real water" if row.law == REFERENCE else sets[row.law]["words"],
        "CV of power": with_interval(row.cv, 2),
        "P(in step)": f"{row.step.low:.3f}–{row.step.high:.3f}",
        BEYOND: with_interval(in_percent(line.beyond), 2),
    }
