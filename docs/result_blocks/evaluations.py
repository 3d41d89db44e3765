"""Blocks from the tables off the design, of information and of other devices; and these tables in full, as pages."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from gyroctl.reports.wording import number
from gyroctl.studies.evaluation.gauge import in_words
from result_blocks.source import (
    FULL,
    Row,
    caption,
    failures,
    full,
    largest,
    law,
    law_table,
    outside,
    ranged,
    result,
    seen,
    states,
    table,
)

PAIR = "best_constant"


def _seeds(found: Mapping[str, Any], rows: list[Row]) -> str:
    asked = found["request"]
    counts = sorted({(row["runs"], row["law"]) for row in rows if row["law"] != PAIR}, reverse=True)
    most = counts[0][0] if counts else 0
    fewer = "".join(f", `{name}` {runs}" for runs, name in counts if runs != most)
    return (
        f"Runs of {asked['duration_s']:g} s, {most} for each law{fewer}; seeds {states(found['seed_states'])}. "
        f"Failed runs: {sum(row['failed'] for row in rows)}. {failures(found)}"
    )


def _cell(row: Row | None, head: str) -> str:
    """Power, lock and step where not whole, and how far out of the model."""
    if row is None:
        return ""
    forward = row.get("forward")  # where the contact of the axis is one of friction
    back = f"; {round(row['runs'] * (1.0 - forward['value']))} with a reversal" if forward else ""
    return f"{head}; {row['locked']}, {row['in_step']} of {row['runs']}{back}; {outside(row)}"


def _back(rows: Sequence[Row]) -> str:
    return ", runs in which the axis rolled backwards" if any(row.get("forward") for row in rows) else ""


def offdesign() -> str:
    """Power over that of the pair of each sea."""
    found = result("offdesign")
    cases = [(f"{case['group']} {case['name']}", {row["law"]: row for row in case["laws"]}) for case in found["cases"]]
    laws = list(dict.fromkeys(name for _, rows in cases for name in rows if name != PAIR))
    lines = []
    for name, rows in cases:
        cells = [_cell(rows.get(one), f"{number(rows[one]['ratio']['value'])}x" if one in rows else "") for one in laws]
        lines.append([name, _cell(rows[PAIR], f"{number(rows[PAIR]['power']['value'])} W"), *cells])
    answers = [
        [
            f"`{one}`",
            judged["answer"],
            f"{number(judged['least_ratio'])}x ({judged['least_ratio_at']})",
            "; ".join(judged["worse"]) or "none",
        ]
        for one, judged in found["never_worse"].items()
    ]
    every = [row for _, rows in cases for row in rows.values()]
    worst = max(every, key=largest)
    return "\n\n".join(
        [
            table(("sea", "constant pair", *(f"`{one}`" for one in laws)), lines, 1),
            "In each cell the mean power, as a multiple of that of the best constant pair of that sea; runs that held "
            "lock and runs in step; share of the time beyond 0.3 rad. Turns kept, slips, stored power and largest "
            f"motion of every row: [off the design in full](RESULTS/offdesign.md). The largest |φ| is "
            f"{number(largest(worst), 2)} rad (`{worst['law']}`). {_seeds(found, every)}",
            table(("law", "never worse?", "least ratio", "worse in"), answers, 4),
            caption("offdesign"),
        ]
    )


def devices(name: str) -> str:
    """Power on each device, or with each fault: of the results `robustness` and `faults`."""
    found = result(name)
    cases = {case: {row["law"]: row for row in rows} for case, rows in found["cases"].items()}
    laws = list(dict.fromkeys(one for rows in cases.values() for one in rows))
    lines = [
        [
            case,
            *(_cell(rows.get(one), f"{number(rows[one]['power']['value'])} W" if one in rows else "") for one in laws),
        ]
        for case, rows in cases.items()
    ]
    every = [row for rows in cases.values() for row in rows.values()]
    worst = max(every, key=largest)
    return "\n\n".join(
        [
            table(("case", *(f"`{one}`" for one in laws)), lines, 1),
            f"In each cell the mean power, runs that held lock and runs in step{_back(every)}, share of the time "
            f"beyond 0.3 rad. The rest of every row: [in full](RESULTS/{name}.md). The largest |φ| is "
            f"{number(largest(worst), 2)} rad (`{worst['law']}`). {_seeds(found, every)}",
            caption(name),
        ]
    )


def information(kept: str) -> str:
    """Levels of information, and what each is worth."""
    found = result(kept)
    levels = [[name, *full(row)] for name, row in found["levels"].items()]
    worth = [
        [step["less"], step["more"], f"{ranged(step['difference'])} W", str(step["pairs"]), step["words"]]
        for step in found["differences"]
    ]
    return "\n\n".join(
        [
            table(("information", *FULL), levels),
            table(("less", "more", "worth", "pairs", "in words"), worth, 5),
            f"Runs of {found['request']['duration_s']:g} s. {failures(found)}",
            caption(kept),
        ]
    )


def gauge() -> str:
    """What a wave gauge up-wave is worth, by its distance."""
    found, text = result("gauge"), []
    for case, lines in found["cases"].items():
        errors = list(dict.fromkeys(name for line in lines for name in line["error"]))
        rows = [
            [
                line["level"],
                *full(line),
                ranged(line["of_oracle"]) if line["of_oracle"] else "",
                ranged(line["reversals"]),
                *(f"{number(line['error'][name], 2)}" if name in line["error"] else "" for name in errors),
            ]
            for line in lines
        ]
        heads = ("information", *FULL, "of perfect preview", "reversals", *errors)
        text += [f"**{case}**", table(heads, rows)]
    text.append("![What a wave gauge up-wave is worth](gauge.png)")
    text.append("*Power and its smoothness by what is known of the waves, from the sensors alone to perfect preview.*")
    text += [f"{in_words(found)} Runs of {found['request']['duration_s']:g} s. {failures(found)}", caption("gauge")]
    return "\n\n".join(text)


def offdesign_page() -> str:
    """Every row off the design."""
    found, text = result("offdesign"), ["# Off the design in full"]
    text.append(
        f"Seeds {states(found['seed_states'])}; runs of {found['request']['duration_s']:g} s. {failures(found)}"
    )
    for case in found["cases"]:
        best = case["pair"]
        remark = "; no pair keeps the motion limit, this is the best without it" if best.get("motion_waived") else ""
        text.append(f"## {case['group']} {case['name']}")
        text.append(f"Best constant pair: cc {number(best['cc'])}, cg {number(best['cg'])} Nms{remark}.")
        text.append(law_table(case["laws"]))
    return "\n\n".join([*text, caption("offdesign")])


def devices_page(name: str, title: str) -> str:
    """Every row on other devices, or with each fault."""
    found, text = result(name), [f"# {title}"]
    text.append(
        f"Seeds {states(found['seed_states'])}; runs of {found['request']['duration_s']:g} s. {failures(found)}"
    )
    for case, rows in found["cases"].items():
        back = {"without a reversal": [ranged(row["forward"]) for row in rows]} if rows[0].get("forward") else {}
        lines = [
            [law(row), seen(row), ranged(row.get("of_nominal")), *full(row), *(own[i] for own in back.values())]
            for i, row in enumerate(rows)
        ]
        text += [f"## {case}", table(("law", "sees", "of its nominal power", *FULL, *back), lines, 2)]
    return "\n\n".join([*text, caption(name)])


BLOCKS: Mapping[str, Callable[[], str]] = {
    "offdesign": offdesign,
    "robustness": partial(devices, "robustness"),
    "faults": partial(devices, "faults"),
    "faults-coupling": partial(devices, "faults_coupling"),
    "information": partial(information, "information"),
    "information-real": partial(information, "information_real"),
    "gauge": gauge,
}

PAGES: Mapping[str, Callable[[], str]] = {
    "docs/results/offdesign.md": offdesign_page,
    "docs/results/robustness.md": partial(devices_page, "robustness", "Other devices in full"),
    "docs/results/faults.md": partial(devices_page, "faults", "Faults in real water in full"),
    "docs/results/faults_coupling.md": partial(
        devices_page, "faults_coupling", "Faults in real water in full, a simple law"
    ),
}
"""Pages that are written whole."""
