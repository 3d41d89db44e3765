"""Tables `robustness` and `faults`: the laws on devices that differ from their design, the latter in real water."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any

from gyroctl.devices import zhang2017
from gyroctl.errors import InputError
from gyroctl.plant import Plant
from gyroctl.statistics import Estimate, lock_probability, paired_ratio
from gyroctl.studies.evaluation.cases import Case, Outcome, best_pair_of, common_seeds, run_case
from gyroctl.studies.evaluation.entrants import Entrant
from gyroctl.studies.evaluation.faults import faults
from gyroctl.studies.evaluation.perturbed_devices import NOMINAL, Truth, truths
from gyroctl.studies.evaluation.request import Request
from gyroctl.studies.evaluation.rows import Row, rows
from gyroctl.studies.evaluation.targets import missed_by_limit
from gyroctl.studies.evaluation.writing import (
    LOCK,
    OUTSIDE,
    PARTS,
    PHI,
    cells,
    markdown_table,
    row_table,
    with_interval,
)
from gyroctl.waves import SeaState

if TYPE_CHECKING:
    from matplotlib.figure import Figure

IN_WATER = (
    "Every case stands on the realistic device with a coupling that lags by 20 ms. The laws stay as they are; of a "
    "case they know nothing but a delay, where the case says that they are told. `best_constant` is the pair that was "
    "searched for the linear device."
)
OWN = "of its nominal power"
UNCHANGED = (
    "`best_constant` is the pair that was searched for the nominal device. Like the laws it stays as it is on the "
    "others: it is not the best pair of those."
)
FORWARD = "without a reversal"
"""Share of the runs in which the axis never rolls backwards; told where its contact is one of friction."""

HEADINGS = ("case", *LOCK, "power [W]", OWN, "of best constant", *PARTS, "CV", PHI, "runs over it", *OUTSIDE, "limits")


def robustness_table(ask: Request, gamma: float = 5.0) -> tuple[dict[str, Any], str, Figure]:
    """Run every law on every truth; returns content, markdown and figure as the other tables."""
    title = "Laws on devices that differ from their design"
    return _table(ask, gamma, truths(ask.settings), UNCHANGED, title, rolling=False)


def faults_table(
    ask: Request, gamma: float = 5.0, cases: Sequence[Truth] | None = None
) -> tuple[dict[str, Any], str, Figure]:
    """Run every law in real water, with each fault, on each device and in each sea of `faults`, or of other cases."""
    chosen = faults(ask.settings, gamma, ask.duration) if cases is None else cases
    return _table(ask, gamma, chosen, IN_WATER, "Faults and other devices in real water", rolling=True)


def _table(
    ask: Request, gamma: float, cases: Sequence[Truth], words: str, title: str, *, rolling: bool
) -> tuple[dict[str, Any], str, Figure]:
    from gyroctl.studies.evaluation.draw import draw_robustness

    found: dict[str, Outcome] = {}
    failed: dict[str, str] = {}
    sea = SeaState(gamma=gamma)
    nominal = best_pair_of(Case(NOMINAL, zhang2017(), sea, ask.settings), ask)
    for i, truth in enumerate(cases):
        ask.say(f"{truth.name} ({i + 1} of {len(cases)})")
        case = Case(truth.name, truth.plant, truth.sea or sea, truth.settings)
        try:
            found[truth.name] = run_case(case, [nominal, *(told(one, truth) for one in ask.entrants)], ask)
        except InputError as error:
            if truth.name == NOMINAL:  # all others are told relative to it
                raise
            failed[truth.name] = str(error)
    tables = {name: rows(outcome) for name, outcome in found.items()}
    kept = {name: kept_power(outcome, found[NOMINAL]) for name, outcome in found.items()}
    forward = {name: forward_runs(outcome) if rolling else {} for name, outcome in found.items()}
    laws = list(tables[NOMINAL])
    content = {
        "gamma": gamma,
        "design": _device(cases[0].plant),
        "truths": {
            truth.name: {
                **_device(truth.plant),
                "sensors": truth.settings.sensors,
                "actuators": truth.settings.actuators,
                "sea": None if truth.sea is None else {"kind": type(truth.sea).__name__, **asdict(truth.sea)},
                "told": dict(truth.told),
            }
            for truth in cases
        },
        "cases": {
            name: [
                {**vars(row), "of_nominal": kept[name].get(law), "forward": forward[name].get(law)}
                for law, row in table.items()
            ]
            for name, table in tables.items()
        },
        "failed": failed | {what: why for outcome in found.values() for what, why in outcome.failures.items()},
    }
    locked = [(name, *(_locked(table.get(law)) for law in laws), _counts(table)) for name, table in tables.items()]
    parts = [words, "## Locked runs\n\n" + markdown_table(("case", *laws, "runs"), locked)]
    headings = (*HEADINGS[:-1], FORWARD, HEADINGS[-1]) if rolling else HEADINGS
    for law in laws:
        lines = [
            _line(name, table[law], kept[name].get(law), forward[name].get(law))
            for name, table in tables.items()
            if law in table
        ]
        parts.append(f"## {law}\n\n{row_table(headings, lines)}")
    return content, "\n\n".join(parts), draw_robustness(tables, kept, ask.record(), title)


def told(entrant: Entrant, truth: Truth) -> Entrant:
    """Law as it takes part in a case: with what the case tells it, where it has such parameters."""
    if not truth.told:
        return entrant
    built = entrant.build()
    own = {name: value for name, value in truth.told.items() if hasattr(built, name)}
    return replace(entrant, parameters={**entrant.parameters, **own})


def kept_power(outcome: Outcome, nominal: Outcome) -> dict[str, Estimate]:
    """Mean power of each law over its own on the nominal device, on the same seeds."""
    kept = {}
    for law, runs in outcome.runs.items():
        if law in nominal.runs:
            seeds = common_seeds(runs, nominal.runs[law])
            kept[law] = paired_ratio(runs.on(seeds, "mean_power"), nominal.runs[law].on(seeds, "mean_power"))
    return kept


def forward_runs(outcome: Outcome) -> dict[str, Estimate]:
    """Share of the runs of each law without a reversal of the axis; a run without numbers counts as one with it."""
    return {law: lock_probability(runs.values["reversals"] == 0.0) for law, runs in outcome.runs.items()}


def _locked(row: Row | None) -> str:
    return "failed" if row is None else f"{row.locked}/{row.runs}"


def _counts(table: Mapping[str, Row]) -> str:
    return ", ".join(str(runs) for runs in sorted({row.runs for row in table.values()}))


def _device(plant: Plant) -> dict[str, Any]:
    constants = {name: value for name, value in plant.coefficients._asdict().items() if value is not None}
    return {"coefficients": constants, "excitation_sha256": plant.excitation.sha256, "water": plant.water}


def _line(name: str, row: Row, kept: Estimate | None, forward: Estimate | None) -> dict[str, str]:
    missed = [limit for limit in missed_by_limit(row) if limit != "power"]
    told = {OWN: kept, FORWARD: forward}
    found = {heading: with_interval(one) if one is not None else "" for heading, one in told.items()}
    return {**cells(row), **found, "case": name, "limits": f"not kept: {' and '.join(missed)}" if missed else "kept"}
