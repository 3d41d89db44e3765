"""Table `price`: what real water takes of the planner's power, effect by effect, and what its choices win back."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gyroctl.errors import InputError
from gyroctl.reports.wording import number
from gyroctl.statistics import Estimate, holm, in_words, paired_difference
from gyroctl.studies.evaluation.cases import Case, Outcome, Runs, best_pair_of, check_any, common_seeds, run_case
from gyroctl.studies.evaluation.entrants import Entrant
from gyroctl.studies.evaluation.price_steps import Choice, choices, previews, waters
from gyroctl.studies.evaluation.real_water import LINEAR, Water
from gyroctl.studies.evaluation.request import Request
from gyroctl.studies.evaluation.rows import Row, row
from gyroctl.studies.evaluation.writing import cells, markdown_table, row_table, with_interval
from gyroctl.waves import SeaState

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SEEDS, DURATION = ("1:16",), 500.0
"""What the table takes where nothing else is asked for; length in s."""

WATER, LAW, TOLD = "what the water takes", "what the law wins back", "what is told of the waves"
"""Groups of the steps."""

LEVEL = 0.05
"""Of the tests of all steps together."""

CHANGE, SEEN, SMOOTHER = "more than before [W]", "in runs like those seen [W]", "CV more than before"
PHI1, BACK = "98 % of φ1 [rad]", "without reversal"
HEADINGS = ("step", "sets", "power [W]", CHANGE, SEEN, "p (Holm)", "CV", SMOOTHER, "locked", "in step", BACK, PHI1)

MEANT = (
    "Every step stands on all those before it, and is set against the one before on the same realisations, which are "
    "those of the linear plant. The interval of a change in power holds losses of lock too rare to be seen in so few "
    "runs; that in runs like those seen holds their scatter alone, as does that of CV. p-values are corrected by Holm "
    "over all steps. The order matters: an effect may cost more or less where others are there already."
)


class Line(NamedTuple):
    """A step: what it sets, how the law fares there, and the change against the step before."""

    group: str
    step: str
    sets: Mapping[str, Any]  # of the device, the actuators or the law
    row: Row
    without_reversal: int  # runs in which the axis never rolls backwards
    before: str = ""  # step that it is set against; none for the first
    change: Estimate | None = None  # mean power more than there, losses too rare to be seen included [W]
    seen: Estimate | None = None  # the same of runs like those seen [W]
    cv_change: Estimate | None = None  # CV more than there [1]
    p_value: float = np.nan  # of the change in power
    p_holm: float = np.nan  # corrected over all steps

    @property
    def words(self) -> str:
        """Whether the step is told from chance."""
        return "" if self.change is None else in_words(self.change, self.p_holm, ("wins", "takes"), LEVEL)

    def record(self) -> dict[str, Any]:
        """For the JSON file."""
        own = {name: getattr(self, name) for name in self._fields if name not in ("row", "sets", "p_value")}
        return {**vars(self.row), **own, "sets": dict(self.sets), "words": self.words}


class Stage(NamedTuple):
    """A step before its change is known."""

    group: str
    step: str
    sets: Mapping[str, Any]
    runs: Runs
    reference: Runs  # best constant pair of the linear device in the same case


def price_table(
    ask: Request, steps: Sequence[Water] | None = None, gamma: float = 5.0
) -> tuple[dict[str, Any], str, Figure]:
    """Run the planner on every step; returns content, markdown and figure as the other tables.

    Parameters
    ----------
    ask : Request
        Seeds, length, and the planner.
    steps : sequence of Water, optional
        Waters from the linear one to that in which the choices of the law are made; those of `price_steps` without.
    gamma : float
        Peak enhancement of the sea.
    """
    from gyroctl.studies.evaluation.draw_price import draw_price

    chain, sea = waters() if steps is None else tuple(steps), SeaState(gamma=gamma)
    wanted = choices(ask.planner, chain[-1].lag)
    told = previews(wanted[-1])
    plain = Entrant(ask.planner, ask.planner)
    pair = best_pair_of(Case(LINEAR, chain[0].plant(), sea, ask.settings), ask)
    stages: list[Stage] = []
    failed: dict[str, str] = {}
    for i, water in enumerate(chain):
        ask.say(f"price: {water.name} ({i + 1} of {len(chain)})")
        last = i + 1 == len(chain)
        laws = [choice.entrant(ask.planner) for choice in (*wanted, *told)] if last else []
        try:
            case = Case(water.name, water.plant(), sea, water.settings(ask.settings))
            outcome = run_case(case, [pair, plain, *laws], ask)
        except InputError as error:
            if i == 0 or last:  # the ends are what the others are told by
                raise
            failed[water.name] = str(error)
            continue
        failed |= outcome.failures
        new = _new(water, chain[i - 1] if i else None)
        stages += staged(outcome, [Choice(water.name, new, {})], WATER, ask.planner)
        if last:
            stages += staged(outcome, wanted, LAW) + staged(outcome, told, TOLD)
    check_any(stages, failed)
    lines, whole = lines_of(stages), totals(stages)
    records = [line.record() for line in lines]
    content = {"gamma": gamma, "pair": dict(pair.parameters), "steps": records, "totals": whole, "failed": failed}
    return content, _text(lines, whole), draw_price(records, ask.record())


def staged(outcome: Outcome, wanted: Sequence[Choice], group: str, law: str = "") -> list[Stage]:
    """Steps of a case that have runs: by their own names, or all of one law."""
    found = []
    for choice in wanted:
        runs = outcome.runs.get(law or choice.name)
        if runs is not None:
            found.append(Stage(group, choice.name, choice.new, runs, outcome.reference))
    return found


def lines_of(stages: Sequence[Stage]) -> list[Line]:
    """Every step against the one before it."""
    found: list[Line] = []
    for i, stage in enumerate(stages):
        back = stage.runs.values["reversals"] == 0.0  # a run without numbers is not one without reversal
        line = Line(stage.group, stage.step, stage.sets, row(stage.runs, stage.reference), int(back.sum()))
        found.append(line if i == 0 else _changed(line, stage, stages[i - 1]))
    corrected = holm([line.p_value for line in found])
    return [line._replace(p_holm=p) for line, p in zip(found, corrected, strict=True)]


def _changed(line: Line, now: Stage, before: Stage) -> Line:
    change, p_value = _more(now, before)
    seen, _ = _more(now, before, zero_if_lost=False)
    cv, _ = _more(now, before, "power_cv", zero_if_lost=False)
    return line._replace(before=before.step, change=change, seen=seen, cv_change=cv, p_value=p_value)


def _more(
    now: Stage, before: Stage, metric: str = "mean_power", *, zero_if_lost: bool = True
) -> tuple[Estimate, float]:
    """Paired difference of a metric between two steps, with its p-value."""
    seeds = common_seeds(now.runs, before.runs)
    own, other = now.runs.on(seeds, metric), before.runs.on(seeds, metric)
    return paired_difference(own, other, zero_if_lost=zero_if_lost)


def totals(stages: Sequence[Stage]) -> dict[str, dict[str, Any]]:
    """Each group as a whole, and what is missing to the linear plant at the end of the law's choices.

    Entries by group with ``from`` and ``to``, the steps at its ends, ``change`` and ``seen`` as in `Line` [W].
    """
    last = {stage.group: stage for stage in stages}
    first, found = stages[0], {}
    ends = [(WATER, first, last.get(WATER)), (LAW, last.get(WATER), last.get(LAW))]
    ends += [(TOLD, last.get(LAW), last.get(TOLD)), ("in all", first, last.get(LAW))]
    for name, begin, end in ends:
        if begin is not None and end is not None:
            change, seen = _more(end, begin)[0], _more(end, begin, zero_if_lost=False)[0]
            found[name] = {"from": begin.step, "to": end.step, "change": change, "seen": seen}
    return found


def _new(water: Water, before: Water | None) -> dict[str, Any]:
    """What a water has beyond the one before."""
    had, lag = ({}, 0.0) if before is None else (before.choices, before.lag)
    new = {key: value for key, value in water.choices.items() if key not in had or had[key] != value}
    return {**new, **({"actuators.cc_lag": water.lag} if water.lag != lag else {})}


def setting(sets: Mapping[str, Any]) -> str:
    """What a step sets, in a cell of a table."""
    told = [f"{key} = {value:g}" if isinstance(value, float) else f"{key} = {value}" for key, value in sets.items()]
    return ", ".join(told) or "nothing"


def _text(lines: Sequence[Line], whole: Mapping[str, Mapping[str, Any]]) -> str:
    parts = [MEANT]
    for group in (WATER, LAW, TOLD):
        some = [_cells(line) for line in lines if line.group == group]
        if some:
            parts.append(f"## {group.capitalize()}\n\n{row_table(HEADINGS, some, 2)}")
    ends = [
        (name, f"{one['from']} → {one['to']}", with_interval(one["change"]), with_interval(one["seen"]))
        for name, one in whole.items()
    ]
    table = markdown_table(("group", "from and to", "change [W]", SEEN), ends, 2)
    return "\n\n".join([*parts, f"## Each group as a whole\n\n{table}"])


def _cells(line: Line) -> dict[str, str]:
    own = {"step": line.step, "sets": setting(line.sets), BACK: f"{line.without_reversal}/{line.row.runs}"}
    own |= {CHANGE: _change(line.change), SEEN: _change(line.seen), SMOOTHER: _change(line.cv_change, 2)}
    own |= {PHI1: number(line.row.phi1_p98, 2), "p (Holm)": "" if line.change is None else number(line.p_holm, 2)}
    return {**cells(line.row), **own, "CV": with_interval(line.row.cv, 2)}


def _change(estimate: Estimate | None, digits: int = 3) -> str:
    return "" if estimate is None else with_interval(estimate, digits)
