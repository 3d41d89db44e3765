"""Numbers that can be run and are more often a slip of the unit: told before the runs, or refused; nothing else is."""

from __future__ import annotations

import json
import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from command_line import Run
from test_reports_synthetic import synthetic

import gyroctl as gy
from gyroctl.comparison.experiment import build_experiment, read_experiment
from gyroctl.devices.file import scaled_device, write_device
from gyroctl.harness.plausibility import check_lags, check_parts, cut_all_the_time, far_seas, is_far, remarks
from gyroctl.reports import evaluate, summarise, write_report
from gyroctl.studies.evaluation.entrants import parse
from gyroctl.studies.site import cells, read_scatter, report, site_request
from gyroctl.waves import Bichromatic, ElevationRecord, SpreadSea, TabulatedSpectrum, TwoPeaks

PLANT = gy.zhang2017()
ROOT = Path(__file__).parents[1]


def of(sea: Any, **laws: Any) -> list[str]:
    return remarks(PLANT, sea, laws, gy.Actuators())


def test_default_experiment_has_no_remark() -> None:
    assert read_experiment(None).remarks == []


@pytest.mark.parametrize("length", [0.2, 2.0, 20.0])
def test_device_of_another_length_has_no_remark(length: float, tmp_path: Path) -> None:
    write_device(tmp_path / "device.toml", scaled_device(first(tmp_path), length))
    setup = build_experiment(
        {"plant": {"device": "device.toml"}, "laws": {"constant": {}, "coupling": {}}}, False, tmp_path
    )
    assert setup.plant.parameters.length_scale == length
    assert setup.remarks == []
    slow = build_experiment(
        {"plant": {"device": "device.toml"}, "sea": {"wp": 0.3 / math.sqrt(length)}}, False, tmp_path
    )
    assert "sea.wp" in slow.remarks[0]


def first(folder: Path) -> Path:
    return write_device(folder / "first.toml", {"name": "mine"})


@pytest.mark.parametrize(
    "sea",
    [
        gy.SeaState(wp=1.6),
        gy.SeaState(wp=6.2),
        gy.SeaState(heading=3.0),
        gy.SeaState(heading=90.0),
        gy.SeaState(heading=3.2),
        gy.Regular(0.2, 3.14),
        gy.Regular(0.2, 2.5, heading=-30.0),
        Bichromatic((0.1, 0.1), (3.0, 3.3)),
        TwoPeaks(),
        SpreadSea(gy.SeaState(), "cos2s", 20.0),
    ],
)
def test_seas_that_may_be_meant_have_no_remark(sea: Any) -> None:
    assert of(sea, constant=gy.law("constant"), load_angle=gy.law("load_angle")) == []


@pytest.mark.parametrize(
    ("sea", "parts"),
    [
        (gy.SeaState(wp=0.5), ("sea.wp = 0.5 rad/s", "6.3 times below", "meant in Hz, give wp = 3.142")),
        (gy.SeaState(wp=0.9), ("Tp 6.98 s", "3.5 times below", "give wp = 5.655")),
        (gy.SeaState(hs=0.03, wp=12.0), ("3.8 times above", "rad/s, or the peak period as tp")),
        (SpreadSea(gy.SeaState(wp=0.5), "cos2s", 20.0), ("sea.wp = 0.5 rad/s", "Hz")),
        (gy.SeaState(heading=3.14), ("sea.heading = 3.14 is in degrees", "give heading = 180")),
        (gy.SeaState(heading=-1.571), ("sea.heading = -1.571", "give heading = -90")),
        (gy.Regular(0.2, 3.14, heading=6.28), ("give heading = 0",)),
    ],
)
def test_slips_of_a_sea_are_told(sea: Any, parts: tuple[str, ...]) -> None:
    (told,) = of(sea)
    for part in parts:
        assert part in told


def test_record_whose_times_are_ten_times_too_long_is_told() -> None:
    time = np.arange(0.0, 3000.0, 1.0)
    eta = 0.1 * np.cos(0.27 * time) + 0.05 * np.cos(0.25 * time)
    (told,) = of(ElevationRecord(time, eta))
    assert "times below" in told and "times or frequencies in the unit" in told and "scale" in told
    assert of(ElevationRecord(time / 10.0, eta)) == []
    omega = np.linspace(0.1, 1.0, 200)
    (told,) = of(TabulatedSpectrum(omega, 0.01 * np.exp(-(((omega - 0.4) / 0.05) ** 2))))
    assert "scale" in told


@pytest.mark.parametrize("sea", [gy.SeaState(wp=0.1), gy.SeaState(wp=17.0), gy.SeaState(hs=5.0, wp=1.0)])
def test_sea_that_a_run_refuses_itself_has_no_remark(sea: Any) -> None:
    assert of(sea) == []


@pytest.mark.parametrize(("name", "limit"), [("cc", 0.3), ("cg", 0.02)])
def test_constant_beyond_the_limit_is_told(name: str, limit: float) -> None:
    assert of(gy.SeaState(), mine=gy.law("constant", **{name: limit})) == []
    (told,) = of(gy.SeaState(), mine=gy.law("constant", **{name: 52.0}))
    assert told.startswith(f"laws.mine.{name} = 52 Nms is always cut to actuators.{name}_max = {limit:g} Nms")
    assert of(gy.SeaState(), other=SimpleNamespace(cc="a", cg=None)) == []


@pytest.mark.parametrize("name", ["cc_lag", "cg_lag"])
def test_lag_of_many_waves_is_refused_and_of_one_told(name: str) -> None:
    usual = gy.SeaState()
    with pytest.raises(gy.InputError, match="peak periods of the sea") as caught:
        build_experiment({"actuators": {name: 20}, "laws": {"constant": {}}})
    assert (caught.value.field, caught.value.value) == (f"actuators.{name}", 20)
    assert "20 ms are 0.02" in caught.value.mend
    check_lags(gy.Actuators(**{name: 20.0}), gy.SeaState(wp=0.5))
    (told,) = remarks(PLANT, usual, {}, gy.Actuators(**{name: 5.0}))
    assert f"actuators.{name} = 5 s" in told and "0.005" in told
    assert remarks(PLANT, usual, {}, gy.Actuators(**{name: 1.0})) == []


def test_gain_of_the_coupling_in_per_cent_is_refused() -> None:
    for gain in (98.0, 2.1):
        with pytest.raises(gy.InputError, match="out of bounds") as caught:
            gy.Actuators(cc_gain=gain)
        assert caught.value.field == "actuators.cc_gain"
    assert gy.Actuators(cc_gain=2.0).cc_gain == 2.0


@pytest.mark.parametrize(
    ("law", "key", "value", "mend"),
    [
        ("load_angle", "share", 30, "30 per cent are 0.3"),
        ("stabiliser", "share", -0.2, "Give 0 or more"),
        ("threshold", "eased", 15.0, "0.15"),
        ("coupling", "spared", 1.2, "0 to 1"),
    ],
)
def test_part_of_a_law_is_one(law: str, key: str, value: float, mend: str, run: Run) -> None:
    for refuse in (
        lambda: build_experiment({"laws": {law: {key: value}}}),
        lambda: build_experiment({"laws": {"supervisor": {"wraps": {"law": law, key: value}}}}),
        lambda: parse(f"{law}[{key}={value}]"),
    ):
        with pytest.raises(gy.InputError, match="is a part, and must be from 0 to 1") as caught:
            refuse()
        assert caught.value.field.endswith(f".{key}") and mend in caught.value.mend
    code, _, err = run("simulate", "--law", law, "--set", f"{key}={value}", "--out", "a.nc")
    assert code == 2 and f"laws.{law}.{key}" in err
    check_parts(law, {key: 1.0})
    check_parts("mine.py:Law", {key: value})
    assert getattr(gy.law(law, **{key: value}), key) == value  # a search may try what it likes


def test_part_is_named_as_the_law_is() -> None:
    with pytest.raises(gy.InputError) as caught:
        build_experiment({"laws": {"mine": {"law": "load_angle", "share": 30}}})
    assert caught.value.field == "laws.mine.share"


def test_commands_that_are_cut_all_the_time_are_told() -> None:
    assert cut_all_the_time("mine", 1000.0, 4000.0) == []
    assert cut_all_the_time("mine", math.nan, 4000.0) == []
    (told,) = cut_all_the_time("mine", 4000.0, 4000.0)
    assert told.startswith("laws.mine: in 4000 samples")


@pytest.mark.parametrize(
    ("table", "scale", "said"), [("north_sea", 16.0, 0), ("north_atlantic", 16.0, 0), ("north_atlantic", 4.0, 1)]
)
def test_site_at_another_scale_than_meant_is_told(
    table: str, scale: float, said: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cells, "locked_start", lambda *_: None)
    found = read_scatter(ROOT / "docs" / "examples" / f"scatter_{table}.csv")
    on = cells.Scaled(found.kind, 1.0, scale, math.inf, 600.0, 0.0)
    run = [cell for cell in (cells.cell_of(PLANT, one, on) for one in found.bins) if cell.sea is not None]
    told = far_seas(PLANT, [cell.sea for cell in run if cell.sea], [cell.bin.share for cell in run])
    assert len(told) == said and all("--scale" in one for one in told)
    assert far_seas(PLANT, [], []) == []
    assert is_far(PLANT, 0.5) and not is_far(PLANT, 3.0)
    ask = site_request(found, Path("out"), "coupling", plant=PLANT, scale=scale)
    assert set(told) <= set(report.remarks(ask, run, {})) and report._far(ask, run) == told


def test_report_and_summary_have_the_remarks(tmp_path: Path) -> None:
    ds = synthetic().assign_attrs(remarks='["sea.wp = <0.5> rad/s"]')
    write_report(ds, tmp_path / "report.html")
    assert "Note: sea.wp = &lt;0.5&gt; rad/s." in (tmp_path / "report.html").read_text()
    assert '"remarks": ["sea.wp = <0.5> rad/s"]' in json.dumps(summarise(ds, evaluate(ds)))


def test_commands_say_it_on_stderr(run: Run, tmp_path: Path) -> None:
    code, _, err = run("waves", "--wp", "0.5")
    assert code == 0 and err.count("Note: ") == 1 and "Note: sea.wp = 0.5 rad/s" in err
    assert "Note: " not in run("waves")[2]
    given = ("--law", "constant", "--set", "cc=52", "--duration", "150")
    _, _, err = run("simulate", *given, "--out", str(tmp_path / "a.nc"))
    assert err.count("Note: ") == 1 and "Note: laws.constant.cc = 52 Nms" in err


@pytest.mark.slow
def test_comparison_says_it_and_keeps_it(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "odd.toml"
    run_table = "[run]\nseeds = [1]\nduration = 400\n"
    file.write_text(f"[sea]\nheading = 3.14\n{run_table}[laws.mine]\nlaw = 'constant'\ncc = 52\n")
    code, _, err = run("compare", str(file), "--out", str(tmp_path / "out"), "--no-search")
    assert code == 0 and err.count("Note: ") == 2
    kept = json.loads((tmp_path / "out" / "summary.json").read_text())["remarks"]
    assert len(kept) == 2 and "sea.heading" in kept[0] and "laws.mine.cc" in kept[1]
    assert "is always cut to" in (tmp_path / "out" / "report.html").read_text()
