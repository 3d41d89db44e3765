"""The commands: what they write and print, and that it is what the library gives."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from command_line import SHORT, Run

import gyroctl as gy
from gyroctl.harness.law_parameters import GIVEN
from gyroctl.harness.registry import factory_of, registered, taken_by

LAW_KEYS = {
    "information",
    "mean_power_w",
    "mean_power_ci95",
    "power_cv",
    "p98_over_mean",
    "locked",
    "runs",
    "lock_probability_ci95",
    "mttl_s",
    "cycle_slips",
    "phi1_p98",
    "phi3_p98",
    "slip_loss_w",
    "ledger_residual",
    "step_ms_median",
    "step_ms_p99",
    "deadline_misses",
    "fallbacks",
    "ratio_to_best_constant",
    "ratio_ci95",
}


@pytest.fixture(scope="module")
def compared(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a short comparison."""
    folder = tmp_path_factory.mktemp("cli")
    (folder / "short.toml").write_text(SHORT)
    command = [sys.executable, "-m", "gyroctl", "compare", "short.toml", "--out", "out", "--workers", "1"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    (folder / "stdout.txt").write_text(done.stdout)
    return folder


# --- compare and report ------------------------------------------------------------------------------------------


def test_compare_writes_three_files_and_prints_the_table(compared: Path) -> None:
    out = compared / "out"
    assert {p.name for p in out.iterdir()} == {"results.nc", "summary.json", "report.html", "runs"}
    assert len(list((out / "runs").glob("*.run"))) == 6
    printed = (compared / "stdout.txt").read_text()
    assert "steady" in printed and "report.html" in printed


def test_summary_has_every_key_of_the_contract(compared: Path) -> None:
    summary = json.loads((compared / "out" / "summary.json").read_text())
    assert {"experiment", "realisations", "laws"} <= set(summary)
    plant, sea = gy.zhang2017(), gy.SeaState()
    assert [r["seed"] for r in summary["realisations"]] == [1, 2]
    for entry in summary["realisations"]:
        assert entry["sha256"] == gy.realise(plant, sea, entry["seed"], 200.0).blended(50.0).sha256
    assert set(summary["laws"]) == {"steady", "load_angle", "best_constant"}, "the baseline is always there"
    for law in summary["laws"].values():
        assert set(law) >= LAW_KEYS
        assert law["runs"] == 2 and law["ledger_residual"] < 1e-6
    assert summary["laws"]["load_angle"]["information"] == "sensors"
    assert summary["experiment"]["sea"]["gamma"] == 5.0
    assert summary["experiment"]["run"]["blend"] == 50.0


def test_results_are_those_of_the_library(compared: Path) -> None:
    import xarray as xr

    with xr.open_dataset(compared / "out" / "results.nc", engine="h5netcdf") as ds:
        laws = {"steady": gy.law("constant", cc=0.06)}
        waves = [gy.realise(gy.zhang2017(), gy.SeaState(), seed, 200.0) for seed in (1, 2)]
        ours = gy.compare(gy.zhang2017(), laws, waves, gy.Settings(blend=50.0), workers=1, quiet=True)
        np.testing.assert_array_equal(ds.mean_power.sel(law="steady"), ours.mean_power[0])
        np.testing.assert_array_equal(ds.example_phi1.sel(law="steady"), ours.example_phi1[0])


def test_report_is_rebuilt_from_the_netcdf_alone(compared: Path, tmp_path: Path, run: Run) -> None:
    alone = tmp_path / "alone"
    alone.mkdir()
    (alone / "results.nc").write_bytes((compared / "out" / "results.nc").read_bytes())
    code, out, err = run("report", alone)
    assert code == 0, err
    assert "steady" in out
    assert (alone / "summary.json").read_text() == (compared / "out" / "summary.json").read_text()
    assert "<html" in (alone / "report.html").read_text()[:500].lower()
    code, _, err = run("report", alone / "results.nc", "--out", tmp_path / "elsewhere")
    assert code == 0, err
    assert {p.name for p in (tmp_path / "elsewhere").iterdir()} == {"results.nc", "summary.json", "report.html"}


@pytest.mark.slow
def test_second_comparison_answers_from_the_stored_runs(
    compared: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    def never(item: object) -> None:
        raise AssertionError("computed again")

    before = json.loads((compared / "out" / "summary.json").read_text())
    monkeypatch.setattr("gyroctl.comparison.execution.perform", never)
    code, _, err = run("compare", compared / "short.toml", "--out", compared / "out", "--workers", 1)
    assert code == 0, err
    after = json.loads((compared / "out" / "summary.json").read_text())
    assert after["laws"] == before["laws"]


# --- simulate, laws, hydro ---------------------------------------------------------------------------------------


def test_simulate_writes_the_trajectory_of_the_library(tmp_path: Path, run: Run) -> None:
    import xarray as xr

    out = tmp_path / "run.nc"
    code, text, err = run(
        "simulate",
        "--law",
        "constant",
        "--set",
        "cc=0.06",
        "--set",
        "cg=4e-4",
        "--gamma",
        1,
        "--hs",
        0.2,
        "--seed",
        9,
        "--duration",
        120,
        "--blend",
        40,
        "--out",
        out,
    )
    assert code == 0, err
    assert "constant:" in text and "W mean power, kept lock" in text and str(out) in text
    plant = gy.zhang2017()
    waves = gy.realise(plant, gy.SeaState(hs=0.2, gamma=1.0), 9, 120.0)
    ours = gy.simulate(plant, gy.law("constant", cc=0.06, cg=4e-4), waves, gy.Settings(blend=40.0))
    with xr.open_dataset(out, engine="h5netcdf") as ds:
        for name in ("phi1", "psi", "omega_rate", "cg", "Me3", "energy_slip"):
            np.testing.assert_array_equal(ds[name], ours[name])
        assert ds.attrs["sha256"] == ours.attrs["sha256"]
    assert list(tmp_path.iterdir()) == [out]


def test_simulate_takes_a_law_from_a_users_file(tmp_path: Path, run: Run) -> None:
    file = tmp_path / "mine.py"
    file.write_text(
        "class Mine:\n"
        "    period, information = 0.1, 'none'\n"
        "    def init(self): return None\n"
        "    def step(self, t, y, state): return (0.052, 3.5e-4), None\n"
    )
    code, text, err = run(
        "simulate", "--law", f"{file}:Mine", "--duration", 60, "--blend", 20, "--out", tmp_path / "a.nc"
    )
    assert code == 0, err
    assert "kept lock" in text


def test_laws_are_listed_with_what_they_look_at(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    code, out, _ = run("laws")
    assert code == 0
    for word in ("constant", "best_constant", "load_angle", "coupling", "sensors", "none", "gyroctl laws show"):
        assert word in out
    lines = out.splitlines()
    assert len(lines) == len(registered()) + 3 and max(map(len, lines)) <= 80, "a law is one row"


def test_law_is_shown_with_values_units_and_sets(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    assert "0.052" in run("laws", "show", "constant")[1]
    code, out, _ = run("laws", "show", "coupling")
    assert code == 0 and "phi3_rate" in out and "Tuned sets: all, gamma1" in out
    rows = {line.split()[0]: line for line in out.splitlines() if line.strip()}
    assert {"through1", "bandwidth", "wp", "floor", "cc_max"} <= set(rows), "fields of groups by their own names"
    assert "0.12" in rows["cc_max"] and "[Nms]" in rows["cc_max"]
    assert run("laws", "show", "coupling", "--tuning", "gamma1")[1] != out
    assert "[rad/s]" in run("laws", "show", "scheduled_lqr")[1], "docstring of a function"
    for name in registered():
        code, out, why = run("laws", "show", name)
        shown = {line.split()[0] for line in out.splitlines() if line[:1].strip()}
        taken = {key for key, usual in taken_by(factory_of(name)).items() if not hasattr(usual, "_fields")} - {*GIVEN}
        assert code == 0 and taken <= shown, (name, why)
    assert run("laws", "show", "nosuch")[0] == 2


def test_hydro_check_of_the_shipped_database_holds(run: Run) -> None:
    code, out, err = run("hydro", "check")
    assert code == 0, out + err
    for word in ("k3", "Jh1", "Jh3", "Haskind", "passiv"):
        assert word.lower() in out.lower()


def test_help_names_every_command(run: Run) -> None:
    code, out, _ = run("--help")
    assert code == 0
    for command in ("compare", "simulate", "hydro", "reproduce", "report", "laws"):
        assert command in out
    assert run("compare", "--help")[0] == 0


def test_command_line_imports_nothing_heavy() -> None:
    """So that --help answers at once: numba, scipy and the rest are loaded by the commands that need them."""
    heavy = (
        "numba",
        "scipy",
        "xarray",
        "casadi",
        "control",
        "cvxpy",
        "plotly",
        "matplotlib",
        "capytaine",
        "pandas",
        "h5py",
    )
    code = f"import sys, gyroctl, gyroctl.cli; print([m for m in {heavy!r} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_form_of_an_answer_is_asked_for(run: Run, compared: Path) -> None:
    """A pipe gets JSON unless words are asked for, of every command that answers in both."""
    folder = compared / "out"
    plain, words = run("status", folder)[1], run("status", folder, "--words")[1]
    assert json.loads(plain)["lines"] and run("status", folder, "--json")[1] == plain
    assert "all is done" in words and not words.startswith("{")
    for command in ("margins", "lockmap", "bound", "site", "export", "status", "verify", "clean"):
        assert "--words" in run(command, "--help")[1], command
