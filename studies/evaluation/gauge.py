"""Table `gauge`: what a wave gauge up-wave is worth, by its distance, beside the sensors alone and perfect preview."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from gyroctl.reports.layout import REFERENCE
from gyroctl.reports.wording import number
from gyroctl.statistics import Estimate, bootstrap_mean, paired_ratio
from gyroctl.studies.evaluation.cases import Case, Outcome, best_pair_of, common_seeds, run_case
from gyroctl.studies.evaluation.entrants import Entrant, parse
from gyroctl.studies.evaluation.foreseen import LEADS, forecast_error
from gyroctl.studies.evaluation.real_water import LINEAR, REALISTIC, WATERS, Water
from gyroctl.studies.evaluation.request import Request
from gyroctl.studies.evaluation.rows import Row, rows
from gyroctl.studies.evaluation.writing import LOCK, PHI, cells, row_table, with_interval
from gyroctl.waves import SeaState
from gyroctl.waves.gauge import Gauge

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from gyroctl.harness.protocol import Law

DISTANCES = (5.0, 10.0, 20.0)
"""Of the gauge from the float. [m]"""

BAR_AT, BAR = 10.0, 0.9
"""At this distance [m] the gauge is to give that part of the power with perfect preview. [1]"""

SEEDS, DURATION = ("1:8",), 600.0
"""What the table takes where nothing else is asked for; length in s."""

JUDGED_ON, JUDGED_FOR = 2, 300.0
"""Realisations on which the forecast is judged, and their length [s]: an error is a mean over many waves."""

SENSORS, ORACLE = "sensors", "perfect preview"
OF_ORACLE = "of perfect preview"
ERRORS = tuple(f"error of {moment} at {lead:g} s" for moment in ("Me1", "Me3") for lead in LEADS)
HEADINGS = ("information", "power [W]", OF_ORACLE, "CV", *LOCK, "reversals", PHI, *ERRORS)

WATER = (REALISTIC, WATERS[0])
"""Waters of the table: the realistic one, in which the gauge is judged, and the linear one beside it."""


class Line(NamedTuple):
    """A level of information in a water."""

    level: str
    row: Row
    reversals: Estimate  # of the rolling, a run
    of_oracle: Estimate | None  # mean power over that with perfect preview, on the same realisations [1]
    error: Mapping[str, float]  # of the forecast, by the headings of the table [1]

    def record(self) -> dict[str, Any]:
        """For the JSON file."""
        own = {name: getattr(self, name) for name in self._fields if name not in ("row", "error")}
        return {**vars(self.row), **own, "error": dict(self.error)}


def at_distance(distance: float) -> str:
    """Name of a level."""
    return f"gauge at {distance:g} m"


def levels(planner: str, water: Water) -> dict[str, Entrant]:
    """Levels of information, the least first: one law with the same parameters, its design model that of the water."""
    found = {SENSORS: "sensors"} | {at_distance(d): f"gauge,distance={d:g}" for d in DISTANCES} | {ORACLE: "oracle"}
    design = "" if water.name == LINEAR else ",plant=realistic"
    return {name: parse(f"{planner}[information={text}{design}]")[0] for name, text in found.items()}


def gauge_table(
    ask: Request, waters: Sequence[Water] = WATER, gamma: float = 5.0
) -> tuple[dict[str, Any], str, Figure]:
    """Run the planner on each level in each water; returns content, markdown and figure as the other tables."""
    from gyroctl.studies.evaluation.draw_gauge import draw_gauge

    sea, text = SeaState(gamma=gamma), []
    pair = best_pair_of(Case(LINEAR, WATERS[0].plant(), sea, ask.settings), ask)
    tables: dict[str, list[Line]] = {}
    failed: dict[str, str] = {}
    for water in waters:
        ask.say(f"gauge: {water.name}")
        case = Case(water.name, water.plant(), sea, water.settings(ask.settings))
        wanted = levels(ask.planner, water)
        outcome = run_case(case, [pair, *wanted.values()], ask)
        failed |= outcome.failures
        tables[water.name] = table_of(outcome, wanted, foreseen(case, wanted, ask))
        text.append(f"## {water.name}\n\n" + row_table(HEADINGS, [_cells(line) for line in tables[water.name]]))
    cases = {name: [line.record() for line in lines] for name, lines in tables.items()}
    content = {
        "gamma": gamma,
        "gauge": Gauge()._asdict(),
        "judged": {"seeds": list(_judged(ask)), "duration_s": _length(ask)},
        "cases": cases,
        "bar": {name: _bar(lines) for name, lines in tables.items()},
        "failed": failed,
    }
    return content, "\n\n".join([in_words(content), *text]), draw_gauge(cases, ask.record())


def table_of(outcome: Outcome, wanted: Mapping[str, Entrant], errors: Mapping[str, Mapping[str, float]]) -> list[Line]:
    """Lines of a water: no law at all first, then the levels that could be run."""
    by_law, best = rows(outcome), outcome.runs.get(wanted[ORACLE].label)
    labels = {"none": REFERENCE} | {name: entrant.label for name, entrant in wanted.items()}
    lines = []
    for name, law in labels.items():
        runs = outcome.runs.get(law)
        if runs is not None:
            part = None
            if best is not None and name != "none":
                seeds = common_seeds(runs, best)
                part = paired_ratio(runs.on(seeds, "mean_power"), best.on(seeds, "mean_power"))
            reversals = bootstrap_mean(runs.values["reversals"])
            lines.append(Line(name, by_law[law], reversals, part, errors.get(name, {})))
    return lines


def foreseen(case: Case, wanted: Mapping[str, Entrant], ask: Request) -> dict[str, dict[str, float]]:
    """Errors of the forecast by level, under the headings of the table."""
    found = {}
    for name, entrant in wanted.items():
        ask.say(f"gauge: forecast in {case.name}, {name}")
        law: Law = entrant.build()
        error = forecast_error(case, law, _judged(ask), _length(ask))
        found[name] = dict(zip(ERRORS, error.ravel().tolist(), strict=True))
    return found


def _judged(ask: Request) -> tuple[int, ...]:
    return tuple(ask.plan.common[:JUDGED_ON])


def _length(ask: Request) -> float:
    return min(JUDGED_FOR, ask.duration)


def _bar(lines: Sequence[Line]) -> dict[str, Any]:
    found = next((line.of_oracle for line in lines if line.level == at_distance(BAR_AT)), None)
    met = found is not None and found.value >= BAR
    return {"distance_m": BAR_AT, "asked": BAR, "found": found, "met": met}


def _cells(line: Line) -> dict[str, str]:
    errors = {name: number(line.error[name], 2) if name in line.error else "" for name in ERRORS}
    part = with_interval(line.of_oracle) if line.of_oracle is not None else ""
    own = {"information": line.level, OF_ORACLE: part, "reversals": with_interval(line.reversals, 2)}
    return {**cells(line.row), **own, **errors}


def in_words(content: Mapping[str, Any]) -> str:
    """What gauge it is, and what the errors are."""
    gauge, judged = content["gauge"], content["judged"]
    return (
        f"A reading every {gauge['sampling']:g} s, with white noise of {gauge['gauge_noise']:g} m and a drift of "
        f"{gauge['drift']:g} m that forgets itself in {gauge['drift_time']:g} s; the gauge stands "
        f"{gauge['misplaced']:g} m farther than the law believes. Reversals of the rolling are those of a run. "
        "Errors are mean square errors of what the planner foresees in its own closed loop over the variance of the "
        f"moment at rest, on {len(judged['seeds'])} realisations of {judged['duration_s']:g} s."
    )
