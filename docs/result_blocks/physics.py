"""Blocks from the tables of the laws in real water and of its price; and the former in full, as a page."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from gyroctl.reports.wording import number, percent
from gyroctl.studies.evaluation.price import HEADINGS as PRICE
from gyroctl.studies.evaluation.price import MEANT, setting
from result_blocks.source import FULL, Row, caption, failures, full, law, ranged, result, seen, states, table

GLANCE = "mean power [W] / CV / runs that held lock / 98 % of φ1 [rad]"


def physics() -> str:
    """Power, smoothness, lock and motion in each water, with the order of the laws."""
    found = result("physics")
    cases = _by_law(found)
    laws = list(cases["linear"])
    lines = [
        [name, *(_glance(rows.get(one)) for one in laws), found["orders"][name]["words"]]
        for name, rows in cases.items()
    ]
    return "\n\n".join(
        [
            *found["sentences"],
            table(("case", *(f"`{one}`" for one in laws), "order"), lines, 1),
            f"In each cell {GLANCE}; `>` stands between laws that can be told apart, `≈` between others. Intervals, "
            "generated and stored part, reversals, traction and the share of the time beyond what the model can say: "
            f"[real water in full](RESULTS/physics.md). {_runs(found)}",
            caption("physics"),
        ]
    )


def physics_page() -> str:
    """Every row of every case."""
    found, text = result("physics"), ["# Real water in full"]
    pair = found["pair"]
    text.append(
        f"{_runs(found)} `best_constant` is cc {number(pair['cc'])}, cg {number(pair['cg'])} Nms in every case, "
        "the pair that was searched for the linear plant."
    )
    more = ("of its linear power", "less linear [W]", "reversals a run", "traction 99 %", "beyond validity")
    for name, rows in _by_law(found).items():
        lines = [[law(row), seen(row), *_further(row), *full(row)] for row in rows.values()]
        text += [f"## {name}", _told(found["waters"][name]), table(("law", "sees", *more, *FULL), lines, 2)]
        text.append(f"Order: {found['orders'][name]['words']}.")
    return "\n\n".join([*text, caption("physics")])


STEPS = "*From step to step: what an effect of the water takes of the power, and what a choice of the law wins back.*"
"""Caption of the waterfall."""


def price() -> str:
    """What the water takes and what the law wins back, step by step."""
    found, text = result("price"), ["![The price list of real water](price.png)", STEPS]
    for group in dict.fromkeys(step["group"] for step in found["steps"]):
        rows = [_step(step) for step in found["steps"] if step["group"] == group]
        text += [f"**{group.capitalize()}**", table(PRICE, rows, 2)]
    whole = [
        [name, f"{one['from']} → {one['to']}", ranged(one["change"]), ranged(one["seen"])]
        for name, one in found["totals"].items()
    ]
    text.append(table(("group", "from and to", *PRICE[3:5]), whole, 2))
    seeds = states(found["seed_states"])
    text.append(f"{MEANT} Runs of {found['request']['duration_s']:g} s; seeds {seeds}. {failures(found)}")
    return "\n\n".join([*text, caption("price")])


def _step(step: Row) -> list[str]:
    told = "" if step["change"] is None else number(step["p_holm"], 2)
    changes = [ranged(step["change"]), ranged(step["seen"]), told]
    return [
        *(step["step"], f"`{setting(step['sets'])}`", ranged(step["power"]), *changes),
        *(ranged(step["cv"], 2), ranged(step["cv_change"], 2)),
        *(f"{step[count]} of {step['runs']}" for count in ("locked", "in_step", "without_reversal")),
        number(step["phi1_p98"], 2),
    ]


def _by_law(found: Mapping[str, Any]) -> dict[str, dict[str, Row]]:
    return {name: {row["law"]: row for row in rows} for name, rows in found["cases"].items()}


def _runs(found: Mapping[str, Any]) -> str:
    rows = found["cases"]["linear"]
    counts = ", ".join(f"`{row['law']}` {row['runs']}" for row in rows)
    seeds = states(found["seed_states"])
    return f"Runs of {found['request']['duration_s']:g} s: {counts}; seeds {seeds}. {failures(found)}"


def _glance(row: Row | None) -> str:
    if row is None:
        return "failed"
    told = (number(row["power"]["value"]), number(row["cv"]["value"], 2), f"{row['locked']} of {row['runs']}")
    return " / ".join((*told, number(row["phi1_p98"], 2)))


def _further(row: Row) -> list[str]:
    """Change against the linear plant, and what the runs rest on."""
    changes = [ranged(row["of_linear"]), ranged(row["less_linear"])]
    return [
        *changes,
        number(row["reversals"], 2),
        number(row["traction_p99"], 2),
        percent(100.0 * row["beyond_validity"]),
    ]


def _told(water: Mapping[str, Any]) -> str:
    """Settings of a case."""
    told = [f"`{name} = {value}`" for name, value in water["choices"].items()]
    told += [f"`actuators.cc_lag = {water['lag_s']:g}`"] if water["lag_s"] else []
    return ", ".join(told) or "Nothing beyond the linear model."


BLOCKS: Mapping[str, Callable[[], str]] = {"physics": physics, "price": price}

PAGES: Mapping[str, Callable[[], str]] = {"docs/results/physics.md": physics_page}
"""Pages that are written whole."""
