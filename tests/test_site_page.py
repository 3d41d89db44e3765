"""The page of a site from a site.json that is made up: what it shows, and that its colours can be read."""

from __future__ import annotations

import json
import re

import pytest

from gyroctl.reports.theme import DARK, LIGHT
from gyroctl.studies.site.page import page_again, render, shade
from gyroctl.studies.site.words import table

LAWS = {"coupling": 3.0, "site_constant": 1.5, "best_constant": 2.0}
HEIGHTS, PERIODS = (0.1, 0.2, 0.3), (1.5, 2.0, 2.5)


def estimate(value: float) -> dict:
    return {"value": value, "low": 0.8 * value, "high": 1.2 * value, "note": ""}


def site_content() -> dict:
    """Content of a site.json: nine sea states, one of them without lock, three laws."""
    cells = []
    for i, hs in enumerate(HEIGHTS):
        for j, period in enumerate(PERIODS):
            stands = i == j == 0
            part = 0.0 if stands else (i + j) / 4.0
            laws = {
                name: {
                    **{key: estimate(part * best) for key in ("power", "power_at_site", "capture_width")},
                    **{key: estimate(part) for key in ("lock", "in_step")},
                    **dict.fromkeys(("capture_ratio", "reversing", "reversals", "over_motion"), 0.1 * part),
                    "failed": 0,
                }
                for name, best in LAWS.items()
            }
            cells.append(
                {
                    "name": f"Hs {hs:g} m, Tp {period:g} s",
                    "hs_m": hs,
                    "period_s": period,
                    "tp_s": period,
                    "hours": 900.0,
                    "share": 900.0 / 8766.0,
                    "flux_w_per_m": 40.0 * hs,
                    "state": "no lock" if stands else "run",
                    "why": "no locked orbit to begin on" if stands else "",
                    "plant_sea": {"hs_m": hs, "tp_s": period, "wp_rad_s": 6.28 / period, "gamma": 1.0},
                    "pair": None if stands else {"cc": 0.05, "cg": 3e-4},
                    "laws": laws,
                }
            )
    parts = {
        name: {"sea_states": count, "hours": 900.0 * count, "share": 0.1 * count, "energy_share": 0.1 * count}
        for name, count in {"run": 8, "no lock": 1, "calm": 0, "left out": 0, "rare": 0}.items()
    }
    annual = {
        name: {
            **{key: estimate(5.0 * best) for key in ("energy", "energy_of_plant", "ratio_to_site", "ratio_to_seas")},
            **{key: estimate(900.0) for key in ("out_of_step", "out_of_lock", "reversing")},
            **dict.fromkeys(("energy_if_lost", "mean_power", "capture_ratio", "reversals", "over_motion"), best),
            "failed": 0,
        }
        for name, best in LAWS.items()
    }
    return {
        "study": "site",
        "gyroctl_version": "0.2.0",
        "commit": "",
        "versions": {"numpy": "2.0"},
        "platform": "Linux",
        "command": "gyroctl site table.csv",
        "date": "2026-03-02",
        "request": {
            "table": "table.csv",
            "laws": ["coupling"],
            "scale": 1.0,
            "depth_m": 0.7,
            "gamma": 1.0,
            "seeds": [1, 2],
            "duration_s": 200.0,
            "pair_budget_s": 150000.0,
            "rarest": 0.0,
            "motion_limit_rad": 0.35,
            "seed_states": {"spent": [1, 2]},
        },
        "device": {"name": "zhang2017 corrected", "width_m": 0.63, "depth_m": 0.7, "width_at_site_m": 0.63},
        "scatter": {
            "layout": "matrix",
            "period": "Tp",
            "occurrence": "hours",
            "sum": 8100.0,
            "notes": ["the table sums to 8100 of 8766 hours"],
        },
        "laws": {name: {"sees": "sensors", "words": "", "parameters": {"cc": 0.12}} for name in LAWS},
        "resource": {
            "mean_flux_w_per_m": 42.0,
            "energy_kwh_per_m": 275.0,
            "not_in_the_table_share": 0.08,
            "parts": parts,
        },
        "annual": annual,
        "cells": cells,
        "states": {"run": "simulated", "no lock": "the device stands still"},
        "remarks": ["1 sea state without a locked orbit"],
        "failed": {},
        "seconds": 3.0,
    }


def site_in(folder):
    """Site study in a folder."""
    folder.mkdir(parents=True)
    (folder / "site.json").write_text(json.dumps(site_content()))
    return folder


def test_each_sea_state_has_its_number_in_the_table_of_each_law(tmp_path):
    text = page_again(site_in(tmp_path / "s"), tmp_path).read_text(encoding="utf-8")
    grids = re.findall(r'<table class="grid">.*?</table>', text, re.S)
    assert len(grids) == 4 * len(LAWS)
    most = re.findall(r'title="Hs 0.3 m, Tp 2.5 s: ([\d.]+)', grids[0])
    assert [float(value) for value in most] == [LAWS["coupling"]]
    assert all(grid.count("<td") == len(HEIGHTS) * len(PERIODS) for grid in grids)


def test_headline_says_why_a_number_has_no_interval():
    content, why = site_content(), "no interval: the reference cannot be told from zero"
    content["annual"]["coupling"]["ratio_to_site"] = {"value": 5.08, "low": None, "high": None, "note": why}
    assert f"5.08 ({why}) times what the best" in render(content)
    assert all(why not in line for line in table(content))


def luminance(rgb: list[float]) -> float:
    """Relative luminance, WCAG 2."""
    parts = [value / 255.0 for value in rgb]
    linear = [p / 12.92 if p <= 0.03928 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def hexadecimal(colour: str) -> list[float]:
    return [float(int(colour[k : k + 2], 16)) for k in (1, 3, 5)]


@pytest.mark.parametrize("theme", [LIGHT, DARK], ids=["light", "dark"])
@pytest.mark.parametrize("warns", [False, True])
def test_numbers_can_be_read_on_every_colour_of_a_matrix(theme, warns):
    for value in [k / 50.0 for k in range(51)]:
        *rgb, share = map(float, re.findall(r"[\d.]+", shade(value, 1.0, warns)))
        below = [share * a + (1.0 - share) * b for a, b in zip(rgb, hexadecimal(theme.card), strict=True)]
        low, high = sorted((luminance(below), luminance(hexadecimal(theme.ink))))
        assert (high + 0.05) / (low + 0.05) >= 4.5
