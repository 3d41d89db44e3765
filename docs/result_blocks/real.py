"""Blocks from the table of the laws in real water: all of it, its targets, and the laws beside their linear figures."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from gyroctl.reports.wording import number
from gyroctl.studies.evaluation.real import TARGET_HEADINGS, VERDICTS, in_words, pair_in_words, verdict_in_words
from result_blocks.source import Row, caption, failures, held, law, ranged, realisations, result, seen, states, table

PAIR = "best_constant"

OWN = {
    "without a reversal": "forward",
    "9 W at CV 0.25": "single",
    "turns kept": "turns",
    "slips per 1000 waves": "slips",
    "98 % of φ1 [rad]": "phi1",
    "less the pair's [rad]": "phi1_less",
    "98 % of φ3 [rad]": "phi3",
}
"""Headings of what the table has of its own, and where it is kept."""


LATER = ("real_coupling", "real_lmi", "real_nmpc")
"""Reports of laws that were changed after all were judged together, by a new set or a new forecast, on realisations of
their own."""

BEST = ("real_coupling", "real_nmpc")
"""Those of them whose law the targets are asked of."""


def of_sea(sea: str, name: str = "real") -> str:
    """Every law of a result in a sea of real water."""
    found = result(name)
    lines = [
        [
            law(row),
            seen(row),
            set_of(found, sea, row),
            ranged(row["power"]),
            ranged(row["ratio"]),
            ranged(row["difference"]),
            ranged(row["cv"], 2),
            held(row),
            *(ranged(row[name]) for name in OWN.values()),
            _percent(row["beyond"]),
            str(row["failed"]),
            realisations(row),
        ]
        for row in found["seas"][sea]
    ]
    heads = ("law", "sees", "set", "power [W]", "of the pair", "less the pair [W]", "CV", "locked, in step")
    text = table((*heads, *OWN, "% of the time beyond validity", "failed", "seeds"), lines, 3)
    return f"**Gamma {sea.removeprefix('gamma')}.** {pair_in_words(found['pairs'][sea])}\n\n{text}"


def real(name: str = "real") -> str:
    """All seas of a result."""
    found = result(name)
    asked = f"Runs of {found['request']['duration_s']:g} s; seeds {states(found['seed_states'])}. {failures(found)}"
    seas = [of_sea(sea, name) for sea in found["seas"]]
    return "\n\n".join([in_words(found["water"]), *seas, asked, caption(name)])


def targets() -> str:
    """Which targets are met, demand by demand; by a law that was judged again as it is since."""
    lines = [
        [
            f"{one['name']}: {one['verdict']}",
            f"gamma {one['gamma']:g}",
            f"`{one['law']}`" if one["law"] else "–",
            demand["measure"],
            demand["demand"],
            ranged(demand["found"]) if demand["found"] else "–",
            verdict_in_words(demand["verdict"], demand["sure"]),
        ]
        for one in _targets()
        for demand in one["demands"]
    ]
    return f"{table(TARGET_HEADINGS, lines, 5)}\n\n{VERDICTS}\n\n{caption('real', *BEST)}"


def _targets() -> list[Mapping[str, Any]]:
    later = {(one["name"], one["gamma"]): one for name in BEST for one in result(name)["targets"] if one["law"]}
    return [later.get((one["name"], one["gamma"]), one) for one in result("real")["targets"]]


def _anew(sea: str) -> dict[str, tuple[Mapping[str, Any], Row]]:
    """Laws that were judged again: the later report of each, and its row there."""
    reports = [result(name) for name in LATER]
    return {row["law"]: (report, row) for report in reports for row in report["seas"][sea] if row["law"] != PAIR}


def readme_real() -> str:
    """Laws in real water beside the linear plant, in the default sea; of a law judged again its later figures."""
    found, anew = result("real"), _anew("gamma5")
    linear = {row["law"]: row for row in result("seas")["seas"]["gamma5"]}
    rows = [anew.get(row["law"], (found, row)) for row in found["seas"]["gamma5"]]
    rows.sort(key=lambda of: -of[1]["power"]["value"])
    lines = [
        [
            law(row),
            set_of(report, "gamma5", row).partition(":")[0],
            number(linear[row["law"]]["power"]["value"]) if row["law"] in linear else "–",
            ranged(row["power"]),
            ranged(row["ratio"]),
            number(row["cv"]["value"], 2),
            held(row),
            number(row["forward"]["value"]),
            f"{number(row['phi1']['value'], 2)}, {number(row['phi3']['value'], 2)}",
        ]
        for report, row in rows
    ]
    heads = ("law", "set", "linear [W]", "real water [W]", "of the pair", "CV", "locked, in step")
    met = [one["verdict"] for one in _targets()]
    later = "; ".join(f"for `{name}` {states(report['seed_states'])}" for name, (report, _) in anew.items())
    return "\n\n".join(
        [
            table((*heads, "without a reversal", "98 % of φ1, φ3 [rad]"), lines, 2),
            f"The device: {found['water']['words']}. Runs of {found['request']['duration_s']:g} s; seeds "
            f"{states(found['seed_states'])}, {later}. Targets: "
            f"{met.count('met')} met, {met.count('not met')} not met, {met.count('open')} open "
            "([demand by demand](docs/evaluation.md#targets-in-real-water)).",
            caption("real", *LATER, "seas"),
        ]
    )


def set_of(found: Mapping[str, Any], sea: str, row: Row) -> str:
    """Which parameters a law has in a sea, in words; the pair has none but itself."""
    if row["law"] == PAIR:
        return "searched in real water"
    return str(found["sets"][sea][row["law"]]["words"])


def _percent(share: Mapping[str, Any]) -> str:
    whole = {name: None if share[name] is None else 100.0 * share[name] for name in ("value", "low", "high")}
    return ranged(whole, 2)


BLOCKS: Mapping[str, Callable[[], str]] = {
    "real": real,
    "real-targets": targets,
    **{name.replace("_", "-"): partial(real, name) for name in LATER},
    "laws-real": readme_real,
}
