"""What of a report is kept in docs/results: the figures that the pages show and how they were made, one row a line."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

RESULTS = Path(__file__).parent / "results"

MADE = ("gyroctl_version", "commit", "command", "date", "platform", "versions", "seconds", "failed")
"""Of every report."""

ROW = (
    *("law", "kind", "information", "preview", "tuning", "seeds", "seed_states", "runs", "failed", "locked", "in_step"),
    *("pair_in_step", "turns_kept", "cycle_slips", "power", "generated_w", "stored_w", "cv", "ratio", "of_nominal"),
    *("phi1_p98", "phi3_p98", "phi1_max", "phi3_max", "over_limit", "outside_share", "verdict", "limits_missed"),
    *("lock", "of_linear", "less_linear", "forward", "reversals", "traction_p99", "beyond_validity"),
)
"""Of a law in a case of an evaluation."""

DIGITS = 6
"""Significant digits that are kept."""


def kept(name: str, report: Mapping[str, Any]) -> dict[str, Any]:
    """Figures of the report `name` that the pages show, and all of `MADE` that it has.

    Raises
    ------
    ValueError
        For a report that does not say its command: it was not made by one.
    """
    if not report.get("command"):
        raise ValueError(f"{name} does not say by which command it was made: run the command, not its function")
    made = {key: report[key] for key in MADE if key in report}
    content = KEEPERS[name.partition("_")[0]](report)
    return dict(rounded({**made, **content}))


def write_kept(name: str, content: Mapping[str, Any], folder: Path = RESULTS) -> Path:
    """Write NAME.json, a row of a table on one line, so that a change of a figure is a change of its line."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.json"
    path.write_text(_lines(content) + "\n", encoding="utf-8", newline="\n")
    return path


def rounded(value: Any) -> Any:
    """Cut every number to `DIGITS` significant digits."""
    if isinstance(value, float):
        return float(f"{value:.{DIGITS}g}")
    if isinstance(value, Mapping):
        return {key: rounded(entry) for key, entry in value.items()}
    return [rounded(entry) for entry in value] if isinstance(value, list) else value


def _lines(value: Any, depth: int = 0) -> str:
    """JSON whose tables and lists of rows have a line for each entry; what is below stands on that line."""
    flat = json.dumps(value, ensure_ascii=False, allow_nan=False)
    if depth > 3 or len(flat) < 100 or not isinstance(value, dict | list) or _is_row(value) or _is_plain(value):
        return flat
    indent, end = " " * (depth + 1), " " * depth
    if isinstance(value, dict):
        inside = [f"{json.dumps(key, ensure_ascii=False)}: {_lines(entry, depth + 1)}" for key, entry in value.items()]
        return "{\n" + ",\n".join(indent + line for line in inside) + f"\n{end}}}"
    return "[\n" + ",\n".join(indent + _lines(entry, depth + 1) for entry in value) + f"\n{end}]"


def _is_row(value: Any) -> bool:
    return isinstance(value, dict) and "law" in value and "runs" in value


def _is_plain(value: Any) -> bool:
    return isinstance(value, list) and not any(isinstance(entry, dict | list) for entry in value)


def _only(table: Mapping[str, Any], names: Sequence[str]) -> dict[str, Any]:
    return {name: table[name] for name in names if name in table}


def _asked(report: Mapping[str, Any]) -> dict[str, Any]:
    """Duration, and seeds by the ledger: first and last of a row of them, not each."""
    asked = _only(report["request"], ("duration_s", "seeds", "own_seeds", "gamma", "hs", "wp", "laws"))
    return {"request": asked, "seed_states": report["request"]["seed_states"]}


def _seas(report: Mapping[str, Any]) -> dict[str, Any]:
    seas = {sea: [_only(row, ROW) for row in rows] for sea, rows in report["seas"].items()}
    return {**_asked(report), "seas": seas, "bars": [_only(b, _BAR) for b in report["bars"]]}


_BAR = ("name", "gamma", "kind", "information", "power", "ratio", "cv", "one_set", "met", "law", "missed")


def _offdesign(report: Mapping[str, Any]) -> dict[str, Any]:
    cases = [
        {
            **_only(case, ("group", "name")),
            "pair": _only(case["pair"], ("cc", "cg", "met", "motion_waived")),
            "laws": [_only(row, ROW) for row in case["laws"]],
        }
        for case in report["cases"]
    ]
    return {**_asked(report), "cases": cases, "never_worse": report["never_worse"]}


def _robustness(report: Mapping[str, Any]) -> dict[str, Any]:
    cases = {case: [_only(row, ROW) for row in rows] for case, rows in report["cases"].items()}
    return {**_asked(report), "gamma": report["gamma"], "cases": cases}


def _information(report: Mapping[str, Any]) -> dict[str, Any]:
    levels = {level: _only(row, ROW) for level, row in report["levels"].items()}
    told = _only(report, ("gamma", "water", "differences"))
    return {**_asked(report), **told, "levels": levels}


def _gauge(report: Mapping[str, Any]) -> dict[str, Any]:
    own = ("level", "of_oracle", "error")
    cases = {
        case: [{**_only(line, own), **_only(line, ROW)} for line in lines] for case, lines in report["cases"].items()
    }
    return {**_asked(report), **_only(report, ("gamma", "gauge", "judged", "bar")), "cases": cases}


def _real(report: Mapping[str, Any]) -> dict[str, Any]:
    own = (
        "difference",
        "forward",
        "single",
        "over",
        "phi1_less",
        "turns",
        "slips",
        "reversals",
        "phi1",
        "phi3",
        "beyond",
    )
    seas = {sea: [{**_only(line, ROW), **_only(line, own)} for line in lines] for sea, lines in report["seas"].items()}
    told = _only(report, ("water", "pairs", "sets", "targets"))
    return {**_asked(report), **told, "seas": seas}


def _physics(report: Mapping[str, Any]) -> dict[str, Any]:
    cases = {case: [_only(row, ROW) for row in rows] for case, rows in report["cases"].items()}
    orders = {case: _only(order, ("words", "holding")) for case, order in report["orders"].items()}
    told = {**_only(report, ("gamma", "pair", "waters")), "sentences": report["answer"]["sentences"]}
    return {**_asked(report), **told, "orders": orders, "cases": cases}


def _price(report: Mapping[str, Any]) -> dict[str, Any]:
    own = ("group", "step", "sets", "before", "change", "seen", "cv_change", "p_holm", "words", "without_reversal")
    steps = [{**_only(step, own), **_only(step, ROW)} for step in report["steps"]]
    return {**_asked(report), **_only(report, ("gamma", "pair", "totals")), "steps": steps}


def _bound(report: Mapping[str, Any]) -> dict[str, Any]:
    windows = [
        {
            **_only(window, ("seed", "cap_w", "linear_cap_w", "motion_limits_rad", "momentum_max_nms")),
            "best": _only(window["bounds"]["smooth"], ("harvest_w", "absorbed_w", "planned_w", "origin", "starts")),
            "laws": {
                law: _only(run, ("harvest_w", "locked", "turns_kept", "within_motion_limit", "fraction"))
                for law, run in window["laws"].items()
            },
        }
        for window in report["windows"]
    ]
    asked = _asked(report)
    asked["request"] |= _only(report["request"], ("device", "lag_s", "motion_limit_rad"))
    return {**asked, "windows": windows, "summary": report["summary"]}


def _margins(report: Mapping[str, Any]) -> dict[str, Any]:
    if "water" in report:
        return {"request": report["request"], "water": report["water"]}
    orbit = _only(report["orbit"], ("status", "advice", "power_w", "load_angle_rad", "lock_share", "period_s", "modes"))
    orbit["modes"] = orbit["modes"][:2]
    found = {"request": report["request"], "orbit": orbit}
    for whose in ("constant_controls", "law"):
        if whose in report:
            found[whose] = dict(report[whose])
    if "linear" in found.get("law", {}):
        found["law"]["linear"] = _only(found["law"]["linear"], ("status", "reason", "channels"))
    return found


def _all(report: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in report.items() if key not in MADE}


KEEPERS: Mapping[str, Callable[[Mapping[str, Any]], dict[str, Any]]] = {
    "seas": _seas,
    "offdesign": _offdesign,
    "robustness": _robustness,
    "faults": _robustness,
    "information": _information,
    "gauge": _gauge,
    "real": _real,
    "physics": _physics,
    "price": _price,
    "bound": _bound,
    "margins": _margins,
    "statements": _all,
    "hydro": _all,
    "startup": _all,
    "forecast": _all,
    "connection": _all,
}
"""By the first word of the name."""
