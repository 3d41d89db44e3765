"""Results as CSV: units in the headings, numbers to the last bit, and no text that a spreadsheet would run."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from test_reports_synthetic import synthetic
from test_site_page import site_in

import gyroctl as gy
from gyroctl.names import in_cell
from gyroctl.reports.export import export, tables, with_unit
from gyroctl.writing import write_json, write_rows

EVIL = ("=1+1", "+1+1", "-1+1", "@SUM(A1)", "\t=1", "\r=1", "\n=1", " =1+1", "＝1+1", "-2+3+cmd|' /C calc'!A0")


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8-sig") as stream:
        return list(csv.DictReader(stream))


@pytest.mark.parametrize("text", EVIL)
def test_no_text_is_a_formula(tmp_path, text):
    assert in_cell(text) == f"'{text}"
    path = write_rows(tmp_path / "a.csv", [["name", "value"], [text, 1.0]])
    with path.open(newline="") as stream:
        assert list(csv.reader(stream))[1] == [f"'{text}", "1.0"]


@pytest.mark.parametrize("value", [-1.5, "-1.5", "+2e-3", "coupling", "a=b", "", None, -3])
def test_numbers_and_plain_texts_stay_what_they_are(value):
    assert in_cell(value) == value


def test_every_run_of_a_comparison_comes_back_to_the_last_bit(tmp_path):
    ds = synthetic()
    names = [f"=law{i}" for i in range(ds.sizes["law"] - 1)]
    ds = ds.assign_coords(law=[*names, "best_constant"])
    (tmp_path / "results").mkdir()
    ds.to_netcdf(tmp_path / "results" / "results.nc", engine="h5netcdf")
    written = export(tmp_path / "results", tmp_path / "csv")
    assert [path.name for path in written] == ["runs.csv"]
    found = rows(written[0])
    assert len(found) == ds.sizes["law"] * ds.sizes["realisation"]
    power = np.array([float(row["mean_power [W]"]) for row in found]).reshape(ds.mean_power.shape)
    np.testing.assert_array_equal(power, ds.mean_power.transpose("law", "realisation").values)
    assert found[0]["law"] == "'=law0" and {int(row["seed"]) for row in found} == set(ds.realisation.values.tolist())
    lost = np.array([row["loss_time [s]"] for row in found]).reshape(ds.mean_power.shape)
    assert np.array_equal(lost == "", np.isnan(ds.loss_time.transpose("law", "realisation").values))


STUDY = {
    "table": "seas",
    "seas": {"gamma1": [{"law": "a", "power": {"value": 0.1 + 0.2, "low": 0.1, "high": None, "note": "x"}}],
             "gamma5": [{"law": "=b", "power": {"value": 1.0, "low": 0.5, "high": 2.0}, "generated_w": 3.0}]},
    "annual": {"a": {"energy_kwh": 1.5, "met": True}, "b": {"energy_kwh": 2.5, "met": False}},
    "request": {"seeds": [1, 2, 3], "scale": 20.0},
}  # fmt: skip


@pytest.mark.parametrize("bom", [False, True])
def test_tables_of_a_study_by_name_with_units(tmp_path, bom):
    write_json(tmp_path / "seas.json", STUDY)
    written = {path.name: path for path in export(tmp_path, bom=bom)}
    assert set(written) == {"seas.seas.csv", "seas.annual.csv", "seas.facts.csv"}
    seas = rows(written["seas.seas.csv"])
    assert [row["seas"] for row in seas] == ["gamma1", "gamma5"] and seas[1]["law"] == "'=b"
    assert float(seas[0]["power.value [W]"]) == 0.1 + 0.2 and seas[0]["power.high [W]"] == ""
    assert seas[0]["generated_w [W]"] == "" and seas[1]["generated_w [W]"] == "3.0"
    annual = rows(written["seas.annual.csv"])
    assert annual[0] == {"law": "a", "energy_kwh [kWh]": "1.5", "met": "TRUE"}
    facts = {row["name"]: row["value"] for row in rows(written["seas.facts.csv"])}
    assert facts["request.seeds"] == "1; 2; 3" and facts["request.scale"] == "20.0"
    assert written["seas.seas.csv"].read_bytes().startswith(b"\xef\xbb\xbf") == bom


def test_units_are_those_of_the_names():
    assert (
        with_unit("flux_w_per_m") == "flux_w_per_m [W/m]"
        and with_unit("laws.a.slip_loss_w") == "laws.a.slip_loss_w [W]"
    )
    assert with_unit("note") == "note" and with_unit("power.note") == "power.note"
    assert with_unit("phi1_p98") == "phi1_p98 [rad]"


def test_every_number_of_a_site_has_its_unit(tmp_path):
    """The same name is hours in the year and a share in a sea state."""
    site_in(tmp_path / "site")
    written = {path.name: path for path in export(tmp_path / "site")}
    year, cells = (set(rows(written[f"site.{name}.csv"])[0]) for name in ("annual", "cells"))
    assert {"energy.value [kWh]", "energy_of_plant.low [kWh]", "out_of_step.high [h]", "reversing.value [h]"} <= year
    assert {"laws.coupling.power_at_site.value [W]", "laws.coupling.capture_width.low [m]"} <= cells
    assert {"laws.coupling.reversing [1]", "laws.coupling.reversals [1/h]", "hs_m [m]", "pair.cc [Nms]"} <= cells
    texts = ("law", "name", "state", "why", "pair", "note")
    bare = {name for name in year | cells if not name.endswith("]") and name.split(".")[-1] not in texts}
    assert bare <= {"plant_sea.gamma"}


def test_groups_of_one_kind_only_are_a_table():
    found = tables({"mixed": {"a": {"x": 1}, "b": {"y": 2}}, "estimate": {"p": {"value": 1, "low": 0, "high": 2}}})
    assert set(found) == {"facts"} and len(found["facts"]) == 5


@pytest.mark.parametrize(
    "make",
    [
        lambda folder: None,
        lambda folder: (folder / "seas.json").write_text("[1, 2]"),
        lambda folder: (folder / "seas.json").write_text("{"),
        lambda folder: (folder / "results.nc").write_bytes(b"no"),
    ],
)
def test_what_holds_no_results_is_refused(tmp_path, make):
    make(tmp_path)
    with pytest.raises(gy.InputError):
        export(tmp_path)
    assert not (tmp_path / "csv").exists()


def test_names_from_outside_stay_in_the_folder(tmp_path):
    write_json(tmp_path / "a.json", {"../../up": [{"x": 1}], "..": [{"x": 2}], "CON": [{"x": 3}]})
    written = export(tmp_path)
    assert all(path.parent == tmp_path / "csv" for path in written) and len(written) == 3
    assert json.loads((tmp_path / "a.json").read_text())
