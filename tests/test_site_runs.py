"""A site from its table to its files: against the sum by hand, resumed to the bit, in both layouts."""

from __future__ import annotations

import csv
import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from command_line import Run

import gyroctl as gy
from gyroctl.engine.state import state
from gyroctl.engine.store import stored
from gyroctl.harness.yardstick import Yardstick
from gyroctl.studies.site import read_scatter, report, site_report, site_request
from gyroctl.studies.site.scatter import YEAR

LIST = "Hs [m],Tp [s],hours\n2.0,8.4,4000\n3.0,8.4,2000\n3.0,9.4,0\n12.0,6.0,100\n0.2,5.0,1000\n"
MATRIX = "Hs [m] \\ Tp [s] \\ hours,5,6,8.4,9.4\n12,0,100,0,0\n3,0,0,2000,0\n2,0,0,4000,0\n0.2,1000,0,0,0\n"
SITE, SEAS = Yardstick(0.07, 3e-4, True, "for the site"), Yardstick(0.06, 4e-4, True, "for a sea state")

SCALE, SEEDS, DURATION = 20.0, (1, 2, 3, 4), 130.0


@pytest.fixture
def known_pairs(monkeypatch):
    """Pairs as if they had been searched: that takes longer than all the rest."""

    def pairs(ask, cells):
        return {cell.name: SEAS for cell in cells}, SITE

    monkeypatch.setattr(report, "_pairs", pairs)


def asked(device: gy.Plant, folder: Path, text: str = LIST, **other):
    path = folder.parent / f"{folder.name}.csv"
    path.write_text(text)
    laws = {"coupling": gy.law("coupling"), "=load()": gy.law("load_angle")}
    given = {"scale": SCALE, "seeds": ("1:4",), "duration": DURATION, "table": "table.csv", "workers": 2, "quiet": True}
    return site_request(read_scatter(path), folder, laws, plant=device, **(given | other))


def content(folder: Path) -> dict:
    found = json.loads((folder / "site.json").read_text())
    return {name: value for name, value in found.items() if name not in ("seconds", "date", "command", "scatter")}


def by_hand(device: gy.Plant, law: gy.Law) -> list[np.ndarray]:
    """Mean power of every realisation in both sea states that are run, by the comparison of laws."""
    found = []
    for hs in (2.0, 3.0):
        sea = gy.SeaState(hs / SCALE, 2.0 * math.pi / 8.4 * math.sqrt(SCALE), 1.0)
        waves = [gy.realise(device, sea, seed, DURATION) for seed in SEEDS]
        ds = gy.compare(device, {"law": law}, waves, tuning_seeds=(), quiet=True)
        found.append(ds.mean_power.values[0])
    return found


@pytest.mark.slow
def test_a_year_is_the_sum_of_its_sea_states_resumed_to_the_bit_in_both_layouts(
    device, tmp_path, known_pairs, run: Run
):
    one = tmp_path / "list"
    found = site_report(asked(device, one))
    low, high = by_hand(device, gy.law("coupling"))
    energy = found["annual"]["coupling"]["energy"]
    of_plant = (4000.0 * low.mean() + 2000.0 * high.mean()) / 1e3
    assert found["annual"]["coupling"]["energy_of_plant"]["value"] == pytest.approx(of_plant, rel=1e-12)
    assert energy["value"] == pytest.approx(of_plant * SCALE**3.5, rel=1e-12)
    sums = (4000.0 * low + 2000.0 * high) / 1e3 * SCALE**3.5
    assert energy["low"] < sums.mean() < energy["high"]
    states = {cell["name"]: cell["state"] for cell in found["cells"]}
    assert sorted(states.values()) == ["left out", "no lock", "run", "run"]  # none that never occurs
    parts = found["resource"]["parts"]
    assert parts["left out"]["hours"] == pytest.approx(100.0) and parts["no lock"]["hours"] == pytest.approx(1000.0)
    assert found["annual"]["coupling"]["out_of_step"]["value"] >= 1000.0
    assert found["resource"]["not_in_the_table_share"] == pytest.approx(1.0 - 7100.0 / YEAR)

    runs = stored(one / "runs")
    assert len(runs) == 2 * 4 * len(SEEDS)  # sea states, laws with both pairs
    before = content(one)
    for path in runs[::5]:
        path.unlink()
    kept = {path: path.stat().st_mtime_ns for path in stored(one / "runs")}
    site_report(asked(device, one, workers=1))
    assert content(one) == before and len(stored(one / "runs")) == len(runs)
    assert all(path.stat().st_mtime_ns == when for path, when in kept.items())
    assert state(one / "runs").left == 0 and state(one / "runs").failed == 0

    other = tmp_path / "matrix"
    (other / "runs").mkdir(parents=True)
    for path in stored(one / "runs"):  # sea states are known by what they are, not by their table
        (other / "runs" / path.name).write_bytes(path.read_bytes())
    site_report(asked(device, other, MATRIX))
    assert content(other) == before
    check_files(one)
    code, out, _ = run("status", one)
    assert code == 0 and json.loads(out)["running"] is False


def check_files(folder: Path) -> None:
    """What is written holds what was found, and no formula."""
    found = content(folder)
    with (folder / "annual.csv").open(newline="") as stream:
        rows = {row["law"]: row for row in csv.DictReader(stream)}
    assert set(rows) == {"coupling", "'=load()", "site_constant", "best_constant"}
    assert float(rows["coupling"]["annual energy [kWh]"]) == found["annual"]["coupling"]["energy"]["value"]
    with (folder / "cells.csv").open(newline="") as stream:
        cells = list(csv.DictReader(stream))
    counted = [row for row in cells if row["state"] == "run" and row["law"] == "coupling"]
    assert sum(float(row["occurrence [h/a]"]) * float(row["power [W]"]) for row in counted) / 1e3 == pytest.approx(
        found["annual"]["coupling"]["energy"]["value"], rel=1e-12
    )
    assert len([row for row in cells if row["state"] == "left out"]) == 1
    page = (folder / "site.html").read_text()
    assert "<script" not in page and not re.search(r"""(?:src|href)\s*=\s*["']?(?:https?:)?//""", page)
    assert "=load()" in page and "width=device-width" in page and page.count('class="scroll"') >= page.count("<table")
    assert (folder / "site.png").stat().st_size > 10_000


def test_no_sea_state_that_can_be_run_is_an_error_of_one_line(device, tmp_path, known_pairs):
    with pytest.raises(gy.InputError) as caught:
        site_report(asked(device, tmp_path / "out", "hs,tp,hours\n12,6,100\n0.2,5,1000\n"))
    assert caught.value.field == "scatter" and not (tmp_path / "out").exists()


@pytest.mark.slow
def test_pairs_are_searched_and_the_command_writes_all(tmp_path, run: Run):
    table = tmp_path / "table.csv"
    table.write_text(LIST)
    line = ["site", str(table), "--scale", "20", "--seeds", "1:4", "--duration", "130", "--budget", "1.6e5"]
    code, out, errors = run(*line, "--laws", "coupling", "--out", str(tmp_path / "out"))
    assert code == 0, errors
    found = json.loads(out)
    assert {"coupling", "site_constant", "best_constant"} == set(found["annual"])
    pairs = [cell["pair"] for cell in found["cells"] if cell["state"] == "run"]
    assert all(pair["cc_nms"] > 0.0 and pair["cg_nms"] > 0.0 for pair in pairs)
    command = " ".join([*line, "--laws", "coupling"])
    code, out, errors = run("verify", tmp_path / "out", "--count", "3", "--seed", "1", "--command", command)
    assert code == 0 and json.loads(out)["same"] == 3, errors
