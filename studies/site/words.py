"""A site in sentences, for the page and the terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from gyroctl.harness.yardstick import BASELINE
from gyroctl.reports.wording import NOTHING, number
from gyroctl.studies.site.request import SITE_PAIR


def sentences(content: Mapping[str, Any], unit: tuple[str, float]) -> list[str]:
    """Say what the year gives; `unit` is that of the energy with its factor on kWh."""
    annual, resource, request = content["annual"], content["resource"], content["request"]
    tested = [law for law in annual if law not in (SITE_PAIR, BASELINE)]
    best = max(tested, key=lambda law: annual[law]["energy"]["value"] or 0.0)
    own, word, by = annual[best], unit[0], unit[1]
    at = f" at {number(request['scale'])} times the length" if request["scale"] != 1.0 else ""
    said = [
        f"{best} gives {_with(own['energy'], by)} {word} in a mean year{at}, {_with(own['ratio_to_site'])} times "
        f"what the best constant pair for the whole site gives, and {_with(own['ratio_to_seas'])} times the best pair "
        "of each sea state."
    ]
    parts = resource["parts"]
    there = sum(parts[state]["energy_share"] for state in ("run", "no lock", "calm"))
    said.append(
        f"The sums hold {number(100.0 * there)} % of the wave energy of the table "
        f"({number(resource['mean_flux_w_per_m'] / 1e3)} kW/m in the mean); in {number(parts['no lock']['hours'])} h "
        "of the year no lock begins, and the device gives nothing."
    )
    said.append(
        f"{best} is out of step in {_with(own['out_of_step'])} h of the sums, and rolls backwards in runs of "
        f"{_with(own['reversing'])} h."
    )
    return said


def table(content: Mapping[str, Any]) -> list[str]:
    """Lines of the table for a terminal."""
    annual = content["annual"]
    lines = [f"{'law':24} {'energy [kWh/a]':>28} {'of site pair':>22} {'out of step [h]':>16} {'reversing [h]':>14}"]
    for law, own in sorted(annual.items(), key=lambda item: -(item[1]["energy"]["value"] or 0.0)):
        lines.append(
            f"{law[:24]:24} {_with(own['energy'], whole=False):>28} {_with(own['ratio_to_site'], 1.0, 2, False):>22} "
            f"{number(_value(own['out_of_step'])):>16} {number(_value(own['reversing'])):>14}"
        )
    return lines


def remarks(content: Mapping[str, Any]) -> Sequence[str]:
    """What is to be known beside the numbers: of the table, then of the runs."""
    return [*content["scatter"]["notes"], *content["remarks"]]


def _value(told: Mapping[str, Any]) -> float | None:
    value: float | None = told["value"]
    return value


def _with(told: Mapping[str, Any], factor: float = 1.0, digits: int = 3, whole: bool = True) -> str:
    """Write a number with its interval, or `whole` with why there is none."""
    if told["value"] is None:
        return NOTHING
    value = number(told["value"] * factor, digits)
    if told["low"] is None or told["high"] is None:
        note = told.get("note", "") if whole else ""
        return f"{value} ({note})" if note else value
    return f"{value} ({number(told['low'] * factor, digits)} to {number(told['high'] * factor, digits)})"
