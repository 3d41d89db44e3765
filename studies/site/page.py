"""The page of a site: one HTML file that works without a network, from the content of site.json alone."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gyroctl.errors import InputError
from gyroctl.palette import law_styles
from gyroctl.reading import read_json
from gyroctl.reports import page
from gyroctl.statistics import Estimate
from gyroctl.studies.site.draw import strongest
from gyroctl.studies.site.words import sentences
from gyroctl.writing import write_text

MEND = "Give the folder that gyroctl site wrote"

GRIDS = (
    ("power_at_site", "Power"),
    ("lock", "Probability of lock"),
    ("in_step", "Probability to be in step"),
    ("capture_width", "Capture width"),
)
"""Matrices of a law: name and heading."""

FULL = 0.6
"""Strength of the colour of the greatest value. [1]"""


def write_page(content: Mapping[str, Any], path: Path) -> Path:
    """Write the page whole or not at all."""
    return write_text(path, render(content))


def page_again(folder: Path, out: Path) -> Path:
    """Make the page again from the site.json of a folder.

    Raises
    ------
    InputError
        Field ``results``, for a site.json that is none.
    """
    path = folder / "site.json"
    content = read_json("results", path, MEND)
    try:
        return write_page(content, out / "site.html")
    except (AttributeError, IndexError, KeyError, TypeError, ValueError) as error:
        problem = f"is not what a site study writes ({type(error).__name__}: {error})"
        raise InputError("results", str(path), problem, MEND) from error


def render(content: Mapping[str, Any]) -> str:
    """HTML text of the page; equal content gives equal text."""
    laws = strongest(content, len(content["annual"]))
    cells = content["cells"]
    powers = [one["power_at_site"]["value"] or 0.0 for cell in cells for one in cell["laws"].values()]
    widths = [one["capture_width"]["value"] or 0.0 for cell in cells for one in cell["laws"].values()]
    energies = [one["energy"]["value"] or 0.0 for one in content["annual"].values()]
    units = {
        "power_at_site": ("kW", 1e-3) if max(powers, default=0.0) >= 1e3 else ("W", 1.0),
        "lock": ("1", 1.0),
        "in_step": ("1", 1.0),
        "capture_width": ("m", 1.0),
        "energy": ("MWh", 1e-3) if max(energies, default=0.0) >= 1e4 else ("kWh", 1.0),
    }
    most = {"power_at_site": max(powers, default=1.0), "capture_width": max(widths, default=1.0)}
    values = {
        "content": content,
        "request": content["request"],
        "laws": laws,
        "styles": law_styles(laws, "best_constant"),
        "heights": sorted({cell["hs_m"] for cell in cells}, reverse=True),
        "periods": sorted({cell["period_s"] for cell in cells}),
        "at": {(cell["hs_m"], cell["period_s"]): cell for cell in cells},
        "grids": GRIDS,
        "units": units,
        "most": {**most, "lock": 1.0, "in_step": 1.0},
        "sentences": sentences(content, units["energy"]),
        "apart": [cell for cell in cells if cell["state"] not in ("run",)],
    }
    return page.render("site.html.j2", values, {"estimate": estimate, "shade": shade})


def estimate(told: Mapping[str, Any], factor: float = 1.0) -> Estimate:
    """Return a number with its interval as the JSON file holds it, in another unit."""
    value, low, high = (
        float("nan") if told[part] is None else told[part] * factor for part in ("value", "low", "high")
    )
    return Estimate(value, low, high, told.get("note", ""))


def shade(value: float | None, most: float, warns: bool = False) -> str:
    """Colour behind a number: the stronger the greater; where it `warns`, small ones are warm."""
    if value is None or not most > 0.0:
        return "transparent"
    part = min(1.0, max(0.0, value / most))
    if warns:
        return (
            f"rgba(18, 98, 110, {FULL * part:.3f})" if part >= 0.9 else f"rgba(181, 71, 47, {FULL * (1.0 - part):.3f})"
        )
    return f"rgba(0, 114, 178, {FULL * part:.3f})"
