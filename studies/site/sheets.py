"""The numbers of a site for spreadsheets: a row for each sea state and law, one for each law, and the matrices."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from gyroctl.writing import write_rows

CELLS = (
    ("power_at_site", "power [W]", 1.0),
    ("power", "power of the plant [W]", 1.0),
    ("lock", "probability of lock [1]", 1.0),
    ("in_step", "probability to be in step [1]", 1.0),
    ("capture_width", "capture width [m]", 1.0),
)
"""Numbers with intervals of a law in a sea state: name, heading, factor."""

MORE = (
    ("capture_ratio", "capture width ratio [1]"),
    ("reversing", "runs with a reversal [1]"),
    ("reversals", "reversals [1/h]"),
    ("over_motion", "runs over the motion limit [1]"),
    ("failed", "runs failed [1]"),
)

ANNUAL = (
    ("energy", "annual energy [kWh]"),
    ("energy_of_plant", "annual energy of the plant [kWh]"),
    ("ratio_to_site", "of the one pair for the site [1]"),
    ("ratio_to_seas", "of the best pair of each sea state [1]"),
    ("out_of_step", "out of step [h/a]"),
    ("out_of_lock", "out of lock [h/a]"),
    ("reversing", "in runs with a reversal [h/a]"),
)

ALONE = (
    ("energy_if_lost", "annual energy were a lost run worth nothing [kWh]"),
    ("mean_power", "mean power over the year [W]"),
    ("capture_ratio", "capture width ratio [1]"),
    ("reversals", "reversals [1/a]"),
    ("over_motion", "in runs over the motion limit [h/a]"),
    ("failed", "runs failed [1]"),
)

MATRICES = (("power_at_site", "power [W]"), ("lock", "probability of lock [1]"), ("capture_width", "capture width [m]"))

SEA = ("Hs [m]", "period [s]", "Tp [s]", "occurrence [h/a]", "wave power [W/m]", "state", "why")


def write_sheets(content: Mapping[str, Any], folder: Path) -> list[Path]:
    """Write ``cells.csv``, ``annual.csv`` and ``matrices.csv``; what is not known is an empty cell."""
    kind = content["scatter"]["period"]
    cells = write_rows(folder / "cells.csv", _cells(content))
    by_law = write_rows(folder / "annual.csv", _annual(content))
    matrices = write_rows(folder / "matrices.csv", _matrices(content, kind))
    return [cells, by_law, matrices]


def _cells(content: Mapping[str, Any]) -> Iterable[list[Any]]:
    sea = [content["scatter"]["period"] + " [s]" if name == "period [s]" else name for name in SEA]
    if content["scatter"]["period"] == "Tp":
        sea[1] = "Tp of the table [s]"
    yield [*sea, "law", *_spread(heading for _, heading, _ in CELLS), *(heading for _, heading in MORE)]
    for cell in content["cells"]:
        told = [cell[name] for name in ("hs_m", "period_s", "tp_s", "hours", "flux_w_per_m", "state", "why")]
        for law, own in cell["laws"].items():
            numbers = [_three(own[name]) for name, _, _ in CELLS]
            yield [*told, law, *(one for three in numbers for one in three), *(own[name] for name, _ in MORE)]
        if not cell["laws"]:
            yield [*told, "", *[None] * (3 * len(CELLS) + len(MORE))]


def _annual(content: Mapping[str, Any]) -> Iterable[list[Any]]:
    yield ["law", *_spread(heading for _, heading in ANNUAL), *(heading for _, heading in ALONE)]
    for law, own in content["annual"].items():
        numbers = [_three(own[name]) for name, _ in ANNUAL]
        yield [law, *(one for three in numbers for one in three), *(own[name] for name, _ in ALONE)]


def _matrices(content: Mapping[str, Any], kind: str) -> Iterable[list[Any]]:
    cells = content["cells"]
    periods = sorted({cell["period_s"] for cell in cells})
    heights = sorted({cell["hs_m"] for cell in cells})
    at = {(cell["hs_m"], cell["period_s"]): cell for cell in cells}
    yield ["law", "what", "Hs [m]", *(f"{kind} {period:g} s" for period in periods)]
    for hs in heights:
        hours = [at[hs, period]["hours"] if (hs, period) in at else None for period in periods]
        yield ["", "occurrence [h/a]", hs, *hours]
    for law in content["annual"]:
        for name, heading in MATRICES:
            for hs in heights:
                yield [law, heading, hs, *(_value(at.get((hs, period)), law, name) for period in periods)]


def _value(cell: Mapping[str, Any] | None, law: str, name: str) -> Any:
    return cell["laws"][law][name]["value"] if cell is not None and law in cell["laws"] else None


def _spread(headings: Iterable[str]) -> list[str]:
    """Headings of a number and of the ends of its interval."""
    found = []
    for heading in headings:
        name, _, unit = heading.rpartition(" [")
        found += [heading, f"{name}, low [{unit}", f"{name}, high [{unit}"]
    return found


def _three(estimate: Mapping[str, Any]) -> tuple[Any, Any, Any]:
    return estimate["value"], estimate["low"], estimate["high"]
