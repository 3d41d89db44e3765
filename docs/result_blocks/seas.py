"""Blocks from the table of the three seas: the laws on the first page, and all of it on the page of evaluation."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from gyroctl.reports.wording import number
from result_blocks.source import (
    Row,
    caption,
    failures,
    held,
    largest,
    law,
    law_table,
    outside,
    parts,
    result,
    seen,
    states,
    table,
)

IDEAS = {
    "nmpc": "plans the coupling 4 s ahead on forecast wave moments",
    "nmpc[information=oracle]": "the same, told the waves: what foresight is worth",
    "coupling": "the coupling works within the cycle, the generator slowly and smoothly",
    "load_angle": "the generator takes a share of the pull-out torque and damps the libration",
    "scheduled_lqr": "gains by periodic Riccati equations, scheduled on the sea",
    "tracking": "a phase-locked loop tells frequency and load angle",
    "stabiliser": "a power-system stabiliser against the libration",
    "scheduled_lmi": "one Lyapunov function over the schedule",
    "threshold": "two levels with hysteresis",
    "best_constant": "the best pair of each sea, searched with twice the default budget of a law's tuning",
}
"""Laws of the first page in a few words."""

SEA = {"gamma1": "gamma 1", "gamma5": "gamma 5", "gamma50": "gamma 50"}


def readme_laws() -> str:
    """Laws in the default sea."""
    rows = [row for row in result("seas")["seas"]["gamma5"] if row["law"] in IDEAS]
    lines = [
        [
            law(row),
            seen(row).replace("none", "nothing"),
            IDEAS[row["law"]],
            f"{number(row['power']['value'])} ({parts(row)})",
            number(row["cv"]["value"], 2),
            held(row),
            f"{number(row['turns_kept'])}, {number(row['cycle_slips'], 2)}",
            f"{number(largest(row), 2)}, {outside(row)}",
        ]
        for row in rows
    ]
    heads = ("law", "sees", "idea", "power [W] (generated, stored)", "CV", "locked, in step", "turns kept, slips")
    failed = sum(row["failed"] for row in rows)
    least, most = min(rows, key=lambda row: row["outside_share"]), max(rows, key=lambda row: row["outside_share"])
    worst = max(rows, key=largest)
    return "\n\n".join(
        [
            table((*heads, "largest \\|φ\\| [rad], beyond 0.3 rad"), lines, 3),
            f"Beyond 0.3 rad the small-angle model of the float no longer holds. The float is there for "
            f"{outside(least)} (`{least['law']}`) to {outside(most)} (`{most['law']}`) of the time; the largest |φ| "
            f"of any run is {number(largest(worst), 2)} rad (`{worst['law']}`).",
            f"Power is what was generated and the change of what flywheel and float store; slips are per 1000 waves. "
            f"Failed runs: {failed}. Runs of {result('seas')['request']['duration_s']:g} s; seeds "
            f"{seeds_in_words(rows)}.",
            caption("seas"),
        ]
    )


def seeds_in_words(rows: list[Row]) -> str:
    """Which laws met which seeds, and in which state those are."""
    groups: dict[str, list[str]] = {}
    for row in rows:
        told = ", ".join(state.replace("reserve", "in reserve until this run") for state in row["seed_states"])
        groups.setdefault(f"{row['seeds']} ({told})", []).append(row["law"])
    if len(groups) == 1:
        return next(iter(groups))
    return "; ".join(f"{seeds} for {', '.join(f'`{name}`' for name in laws)}" for seeds, laws in groups.items())


def readme_limits() -> str:
    """Which laws miss a limit in which sea, by name."""
    told = []
    for sea, rows in result("seas")["seas"].items():
        missing = [law(row) for row in rows if row["limits_missed"]]
        told.append(f"at {SEA[sea]} by {', '.join(missing) or 'none'}")
    where = "[which, and by how much](docs/evaluation.md#limits)"
    return f"A limit of motion, lock or step is missed {'; '.join(told)}: {where}.\n\n{caption('seas')}"


def missed_limits() -> str:
    """Laws that miss a limit in some sea, and what they miss."""
    lines = [
        [SEA[sea], law(row), "; ".join(row["limits_missed"])]
        for sea, rows in result("seas")["seas"].items()
        for row in rows
        if row["limits_missed"]
    ]
    return f"{table(('sea', 'law', 'missed'), lines, 3) if lines else 'No limit is missed.'}\n\n{caption('seas')}"


def of_sea(sea: str) -> str:
    """Every law in a sea."""
    found = result("seas")
    return f"{law_table(found['seas'][sea])}\n\n{failures(found)}\n\n{caption('seas')}"


def bars() -> str:
    """Which bars are met, and by which law."""
    lines = []
    for bar in result("seas")["bars"]:
        demand = [
            f"{bar['power']:g} W" if bar["power"] else "",
            f"{bar['ratio']:g} times the pair" if bar["ratio"] else "",
        ]
        demand.append(f"CV at most {bar['cv']:g}" if bar["cv"] is not None and bar["cv"] < 10.0 else "")
        missed = "; ".join(bar["missed"]) or "nothing"
        answer = [f"`{bar['law']}`" if bar["law"] else "–", "yes" if bar["met"] else "no", missed]
        lines.append([bar["name"], f"gamma {bar['gamma']:g}", ", ".join(part for part in demand if part), *answer])
    found = table(("bar", "sea", "demand", "law that meets it, or nearest", "met", "missed"), lines, 6)
    return f"{found}\n\nSeeds: {states(result('seas')['seed_states'])}.\n\n{caption('seas')}"


BLOCKS: Mapping[str, Callable[[], str]] = {
    "laws": readme_laws,
    "laws-limits": readme_limits,
    "limits": missed_limits,
    "bars": bars,
    **{f"seas-{sea}": partial(of_sea, sea) for sea in SEA},
}
