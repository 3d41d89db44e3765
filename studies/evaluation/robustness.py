"""Table `robustness`: the laws on devices that differ from their design."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from gyroctl.devices import zhang2017
from gyroctl.reports.wording import number
from gyroctl.statistics import Estimate, paired_ratio
from gyroctl.studies.evaluation.cases import Case, Outcome, common_seeds, run_case
from gyroctl.studies.evaluation.entrants import reference
from gyroctl.studies.evaluation.perturbed_devices import NOMINAL, truths
from gyroctl.studies.evaluation.request import Request
from gyroctl.studies.evaluation.rows import Row, rows
from gyroctl.studies.evaluation.targets import LOCKED, MOTION
from gyroctl.studies.evaluation.writing import markdown_table, with_interval
from gyroctl.waves import SeaState

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HEADINGS = (
    "case",
    "locked",
    "P(lock)",
    "power [W]",
    "of its nominal power",
    "of best constant",
    "CV",
    "φ1, φ3 98 % [rad]",
    "slips /1000",
    "limits",
)


def robustness_table(ask: Request, gamma: float = 5.0) -> tuple[dict[str, Any], str, Figure]:
    """Run every law on every truth; returns content, markdown and figure as the other tables."""
    from gyroctl.studies.evaluation.draw import draw_robustness

    found: dict[str, Outcome] = {}
    cases = truths(ask.settings)
    for i, truth in enumerate(cases):
        ask.say(f"robustness: {truth.name} ({i + 1} of {len(cases)})")
        case = Case(truth.name, truth.plant, SeaState(gamma=gamma), truth.settings)
        found[truth.name] = run_case(case, [reference(gamma), *ask.entrants], ask)
    tables = {name: {row.law: row for row in rows(outcome)} for name, outcome in found.items()}
    kept = {name: kept_power(outcome, found[NOMINAL]) for name, outcome in found.items()}
    laws = [law for law in tables[NOMINAL]]
    design = zhang2017()
    content = {
        "gamma": gamma,
        "design": {"coefficients": design.coefficients._asdict(), "excitation_sha256": design.excitation.sha256},
        "truths": {
            truth.name: {
                "coefficients": truth.plant.coefficients._asdict(),
                "excitation_sha256": truth.plant.excitation.sha256,
                "sensors": truth.settings.sensors,
                "actuators": truth.settings.actuators,
            }
            for truth in cases
        },
        "cases": {
            name: [
                {**{f: getattr(row, f) for f in row.__dataclass_fields__}, "of_nominal": kept[name].get(law)}
                for law, row in table.items()
            ]
            for name, table in tables.items()
        },
        "failed": {f"{name}, {law}": why for name, outcome in found.items() for law, why in outcome.failed.items()},
    }
    parts = [
        "## Locked runs\n\n"
        + markdown_table(
            ("case", *laws, "runs"),
            [(name, *(_locked(table.get(law)) for law in laws), _counts(table)) for name, table in tables.items()],
        )
    ]
    for law in laws:
        lines = [_line(name, table[law], kept[name].get(law)) for name, table in tables.items() if law in table]
        parts.append(f"## {law}\n\n" + markdown_table(HEADINGS, lines))
    return content, "\n\n".join(parts), draw_robustness(tables, kept, ask.record())


def kept_power(outcome: Outcome, nominal: Outcome) -> dict[str, Estimate]:
    """Mean power of each law over its own on the nominal device, on the same seeds."""
    kept = {}
    for law, runs in outcome.runs.items():
        if law in nominal.runs:
            seeds = common_seeds(runs, nominal.runs[law])
            kept[law] = paired_ratio(runs.on(seeds, "mean_power"), nominal.runs[law].on(seeds, "mean_power"))
    return kept


def _locked(row: Row | None) -> str:
    return "failed" if row is None else f"{row.locked}/{row.runs}"


def _counts(table: Mapping[str, Row]) -> str:
    return ", ".join(str(runs) for runs in sorted({row.runs for row in table.values()}))


def _line(name: str, row: Row, kept: Estimate | None) -> tuple[str, ...]:
    beyond = [
        text
        for text, bad in (("motion", not row.motion <= MOTION), ("lock", not row.locked >= LOCKED * row.runs))
        if bad
    ]
    return (
        name,
        f"{row.locked}/{row.runs}",
        f"{row.lock.low:.3f}–{row.lock.high:.3f}",
        with_interval(row.power),
        with_interval(kept) if kept is not None else "",
        with_interval(row.ratio),
        number(row.cv.value, 2),
        f"{number(row.phi1_p98, 2)}, {number(row.phi3_p98, 2)}",
        number(row.cycle_slips, 2),
        f"not kept: {' and '.join(beyond)}" if beyond else "kept",
    )
