"""The command line: what it writes, and that every bad input ends with exit code 2, one line, and nothing written."""

from __future__ import annotations

import json
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.cli import main
from gyroctl.comparison.experiment import build_experiment, read_experiment
from gyroctl.harness.seed_ledger import all_tuning_seeds

SHORT = """
[run]
duration = 200
blend = 50
seeds = [1, 2]

[laws.steady]
law = "constant"
cc = 0.06

[laws.load_angle]
"""

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

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """Call the command line in this process: exit code, stdout, stderr."""

    def call(*arguments: object) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["gyroctl", *map(str, arguments)])
        code = 0
        try:
            main()
        except SystemExit as stop:
            code = stop.code if isinstance(stop.code, int) else 1 if stop.code else 0
        caught = capsys.readouterr()
        return code, caught.out, caught.err

    return call


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
    assert len(list((out / "runs").glob("*.npz"))) == 6
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
    monkeypatch.setenv("COLUMNS", "200")
    code, out, _ = run("laws")
    assert code == 0
    for word in ("constant", "best_constant", "load_angle", "coupling", "sensors", "none", "0.052"):
        assert word in out


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


# --- bad input ---------------------------------------------------------------------------------------------------

LAWS_OF_USERS = """
class Base:
    period, information = 0.1, "none"
    def init(self): return None

class NotANumber(Base):
    def step(self, t, y, state): return (0.05, float("nan")), None

class WrongShape(Base):
    def step(self, t, y, state): return (0.05, 1e-4, 3.0), None

class Failing(Base):
    def step(self, t, y, state): return (1.0 / 0.0, 1e-4), None
"""

RUN = "[run]\nduration = 120\nblend = 40\nseeds = [1]\n"

BAD: dict[str, tuple[str, list[str]]] = {
    # name: (TOML, what the message must hold: field, value, a word of the mend)
    "negative inertia": ("[plant]\nJ11 = -21.68", ["plant.J11", "-21.68", "21.68"]),
    "negative damping": ("[plant]\nd1 = -1.0", ["plant.d1", "-1.0", "zero or positive"]),
    "cc below zero": ('[laws.mine]\nlaw = "constant"\ncc = -0.05', ["laws.mine.cc", "-0.05", "cc >= 0"]),
    "hs of zero": ("[sea]\nhs = 0", ["sea.hs", "0", "0.283"]),
    "hs below zero": ("[sea]\nhs = -0.2", ["sea.hs", "-0.2", "0.283"]),
    "gamma below one": ("[sea]\ngamma = 0.5", ["sea.gamma", "0.5", "at least 1"]),
    "hs as text": ('[sea]\nhs = "high"', ["sea.hs", "'high'", "number"]),
    "unknown law": ('[laws.mine]\nlaw = "cunning"', ["laws.mine.law", "'cunning'", "load_angle"]),
    "law returning nan": ('[laws.mine]\nlaw = "laws.py:NotANumber"', ["'mine'", "not finite", "t = 0.0 s"]),
    "law of a wrong shape": ('[laws.mine]\nlaw = "laws.py:WrongShape"', ["'mine'", "3.0", "two numbers"]),
    "law that fails": ('[laws.mine]\nlaw = "laws.py:Failing"', ["'mine'", "ZeroDivisionError", "laws.py:13"]),
    "law without its file": ('[laws.mine]\nlaw = "gone.py:Mine"', ["laws.mine.law", "gone.py", "no file"]),
    "unknown parameter of a law": ("[laws.load_angle]\nshear = 0.3", ["laws.load_angle.shear", "0.3", "share"]),
    "unknown table": ("[see]\nhs = 0.283", ["see", "unknown table", "sea"]),
    "unknown key": ("[sea]\nheight = 0.283", ["sea.height", "0.283", "hs"]),
    "unknown key of the run": ("[run]\nlength = 10", ["run.length", "10", "duration"]),
    "unknown key of the plant": ("[plant]\nd2 = 1.0", ["plant.d2", "1.0", "d1"]),
    "unknown sensor": ("[sensors.radar]\nnoise = 1.0", ["sensors.radar", "psi_rate"]),
    "unknown key of a sensor": ("[sensors.psi]\nnoize = 1.0", ["sensors.psi.noize", "noise"]),
    "negative noise": ("[sensors.psi]\nnoise = -1.0", ["sensors.psi.noise", "-1.0"]),
    "unknown key of the actuators": ("[actuators]\ncc_min = 0.0", ["actuators.cc_min", "cc_max"]),
    "actuator below zero": ("[actuators]\ncg_max = -0.02", ["actuators.cg_max", "-0.02", "0.02"]),
    "value for a table": ("sea = 3", ["sea", "3", "[sea]"]),
    "value for a law": ("[laws]\nmine = 3", ["laws.mine", "3", "[laws.mine]"]),
    "no toml": ("[sea\nhs = ", ["experiment", "TOML", "line"]),
    "unknown variant": ('[plant]\nvariant = "better"', ["plant.variant", "'better'", "corrected"]),
    "radiation of another kind": ("[plant]\nradiation = 3", ["plant.radiation", "3", "accurate"]),
    "duration shorter than the blend": ("[run]\nduration = 50\nblend = 100", ["run.duration", "50", "blend"]),
    "duration of the blend": ("[run]\nduration = 100\nblend = 100", ["run.duration", "100", "blend"]),
    "no seeds": ("[run]\nseeds = []", ["run.seeds", "[]", "seeds = [1, 2, 3]"]),
    "seeds of another type": ('[run]\nseeds = ["a"]', ["run.seeds", "'a'", "whole numbers"]),
    "seed twice": ("[run]\nseeds = [1, 1]", ["run.seeds", "[1, 1]", "once"]),
    "unstable step": ('[run]\ndt = 0.05\n[laws.mine]\nlaw = "constant"\ncc = 0.1', ["run.dt", "0.05", "dt <="]),
    "step of zero": ("[run]\ndt = 0.0", ["run.dt", "0.0", "positive"]),
    "spectrum without its file": ('[sea]\nkind = "spectrum"\nfile = "gone.csv"', ["gone.csv", "sea"]),
    "sea that holds no lock": ("[sea]\nhs = 0.005", ["sea.hs", "0.005", "Raise Hs"]),
    "period that does not fit": ("[laws.coupling]\nperiod = 0.25", ["laws.coupling.period", "0.25", "multiple"]),
}


def check_refusal(code: int, out: str, err: str, words: list[str]) -> None:
    assert code == 2, out + err
    assert err.startswith("Error: ") and "Traceback" not in err + out
    assert len(err.strip().splitlines()) == 1
    for word in words:
        assert word in err


@pytest.mark.parametrize("name", sorted(BAD))
def test_bad_experiment_is_refused_in_one_line(name: str, tmp_path: Path, run: Run) -> None:
    text, words = BAD[name]
    (tmp_path / "laws.py").write_text(LAWS_OF_USERS)
    toml = tmp_path / "bad.toml"
    toml.write_text(text if "[run]" in text or name == "value for a table" else RUN + text)
    out = tmp_path / "out"
    code, printed, err = run("compare", toml, "--out", out, "--workers", 1)
    check_refusal(code, printed, err, words)
    if "mine'" in words[0]:  # found out while it ran: finished runs of other laws may stay, results may not
        assert {p.name for p in out.iterdir()} <= {"runs"} if out.exists() else True
    else:
        assert not out.exists(), "half-written"


def test_seeds_that_were_tuned_on_are_refused(tmp_path: Path, run: Run) -> None:
    seeds = all_tuning_seeds()
    assert seeds, "the shipped laws tell which seeds they were tuned on"
    toml = tmp_path / "tuned.toml"
    toml.write_text(f"[run]\nduration = 120\nblend = 40\nseeds = [{seeds[0]}, 1]\n")
    code, out, err = run("compare", toml, "--out", tmp_path / "out")
    check_refusal(code, out, err, ["run.seeds", str(seeds[0]), "tuning", "Choose others"])
    assert not (tmp_path / "out").exists()
    assert not set(seeds) & set(build_experiment({}).run.seeds), "the default seeds are not those of the tuning"


def test_missing_experiment_is_refused(tmp_path: Path, run: Run) -> None:
    for path in (tmp_path / "none.toml", tmp_path):
        code, out, err = run("compare", path, "--out", tmp_path / "out")
        check_refusal(code, out, err, ["experiment", str(path)])
    assert not (tmp_path / "out").exists()


def test_folder_that_is_a_file_is_refused_before_the_runs(tmp_path: Path, run: Run) -> None:
    file = tmp_path / "taken"
    file.write_text("mine")
    for out in (file, file / "deeper"):
        code, printed, err = run("compare", "--out", out)
        check_refusal(code, printed, err, ["out", str(file), "another folder"])
    assert file.read_text() == "mine"


SIMULATE: dict[str, tuple[list[str], list[str]]] = {
    "unknown law": (["--law", "cunning"], ["law", "'cunning'", "constant"]),
    "missing file": (["--law", "gone.py:Mine"], ["gone.py", "no file"]),
    "cc below zero": (["--law", "constant", "--set", "cc=-0.1"], ["laws.constant.cc", "-0.1", "cc >= 0"]),
    "parameter as text": (["--law", "constant", "--set", "cc=much"], ["laws.constant.cc", "'much'", "number"]),
    "no pair": (["--law", "constant", "--set", "cc"], ["--set", "'cc'", "key=value"]),
    "unknown parameter": (["--law", "constant", "--set", "cd=1"], ["laws.constant.cd", "1.0", "cc"]),
    "gamma of best_constant": (["--law", "best_constant", "--set", "gamma=-1"], ["laws.best_constant", "-1.0"]),
    "gamma below one": (["--law", "constant", "--gamma", "0.9"], ["sea.gamma", "0.9", "at least 1"]),
    "hs": (["--law", "constant", "--hs", "-1"], ["sea.hs", "-1.0", "0.283"]),
    "wp": (["--law", "constant", "--wp", "0"], ["sea.wp", "0.0", "3.14"]),
    "frequency outside the table": (["--law", "constant", "--wp", "40"], ["sea", "40.0"]),
    "seed": (["--law", "constant", "--seed", "-1"], ["seed", "-1"]),
    "duration": (["--law", "constant", "--duration", "50"], ["duration", "50.0", "blend"]),
    "duration of the blend": (["--law", "constant", "--duration", "100"], ["duration", "100.0", "blend"]),
    "blend": (["--law", "constant", "--blend", "-5"], ["blend", "-5.0"]),
    "unstable step": (["--law", "constant", "--set", "cc=0.2", "--dt", "0.02"], ["run.dt", "0.02", "dt <="]),
    "step": (["--law", "constant", "--dt", "0"], ["run.dt", "0.0", "positive"]),
    "variant": (["--law", "constant", "--variant", "best"], ["plant.variant", "'best'", "corrected"]),
}


@pytest.mark.parametrize("name", sorted(SIMULATE))
def test_bad_simulation_is_refused_in_one_line(name: str, tmp_path: Path, run: Run) -> None:
    arguments, words = SIMULATE[name]
    given = arguments if "--duration" in arguments else [*arguments, "--duration", "120"]
    code, out, err = run("simulate", *given, "--out", tmp_path / "run.nc")
    check_refusal(code, out, err, words)
    assert not list(tmp_path.iterdir())


def test_simulation_into_nowhere_is_refused_first(tmp_path: Path, run: Run) -> None:
    code, out, err = run("simulate", "--law", "constant", "--out", tmp_path / "gone" / "run.nc")
    check_refusal(code, out, err, ["out", "gone", "Make the folder"])
    code, out, err = run("simulate", "--law", "constant", "--out", tmp_path)
    check_refusal(code, out, err, ["out", str(tmp_path), "name of a file"])


@pytest.mark.parametrize("content", [None, b"", b"plain text, no NetCDF", "other"])
def test_netcdf_of_another_layout_is_refused(tmp_path: Path, run: Run, content: Any) -> None:
    import xarray as xr

    file = tmp_path / "results.nc"
    if content == "other":
        xr.Dataset({"speed": ("time", [1.0, 2.0])}).to_netcdf(file, engine="h5netcdf")
    elif content is not None:
        file.write_bytes(content)
    before = {p.name for p in tmp_path.iterdir()}
    code, out, err = run("report", tmp_path)
    check_refusal(code, out, err, ["results", str(file)])
    assert {p.name for p in tmp_path.iterdir()} == before
    code, out, err = run("hydro", "check", file)
    check_refusal(code, out, err, [str(file)])


def test_import_of_what_is_not_there_is_refused(tmp_path: Path, run: Run) -> None:
    for kind in ("capytaine", "wamit", "nemoh"):
        code, out, err = run("hydro", "import", tmp_path / "gone", tmp_path / "new.nc", "--format", kind)
        check_refusal(code, out, err, ["gone"])
    code, out, err = run("hydro", "import", tmp_path / "gone", tmp_path / "new.nc", "--format", "aqwa")
    check_refusal(code, out, err, ["aqwa"])
    assert not list(tmp_path.iterdir())


def test_unknown_figure_is_refused(tmp_path: Path, run: Run) -> None:
    code, out, err = run("reproduce", "fig99", "--out", tmp_path / "out")
    check_refusal(code, out, err, ["fig99", "fig8"])
    assert not (tmp_path / "out").exists()


def test_error_of_the_program_itself_is_not_dressed_up_as_input(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """A ValueError that is no LawError is a bug: it must be seen with its traceback."""

    def broken(*arguments: object, **options: object) -> None:
        raise ValueError("a bug")

    monkeypatch.setattr("gyroctl.comparison.experiment.read_experiment", broken)
    with pytest.raises(ValueError, match="a bug"):
        run("compare")


def test_interruption_says_that_finished_runs_are_kept(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*arguments: object, **options: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("gyroctl.comparison.experiment.read_experiment", interrupted)
    code, _, err = run("compare")
    # typer turns an interruption into an exit of its own; either way it is no success and no traceback
    assert code in (1, 130) and "Traceback" not in err


def test_refusal_reaches_the_shell(tmp_path: Path) -> None:
    """Once through a process of its own, as a user sees it."""
    (tmp_path / "bad.toml").write_text("[sea]\ngama = 5\n")
    command = [sys.executable, "-m", "gyroctl", "compare", "bad.toml", "--out", "out"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    check_refusal(done.returncode, done.stdout, done.stderr, ["sea.gama", "5", "gamma"])
    assert {p.name for p in tmp_path.iterdir()} == {"bad.toml"}


# --- experiments -------------------------------------------------------------------------------------------------


def test_default_experiment_is_that_of_the_design() -> None:
    setup = read_experiment(None)
    assert setup.sea == gy.SeaState(hs=0.283, wp=3.14, gamma=5.0)
    assert len(setup.run.seeds) == 8 and setup.run.duration >= 600.0
    assert (setup.run.dt, setup.run.blend, setup.run.motion_limit) == (0.01, 100.0, 0.35)
    assert {"constant", "best_constant", "load_angle", "coupling"} <= set(setup.laws)
    assert setup.plant.parameters == gy.zhang2017().parameters
    assert (setup.actuators.cc_max, setup.actuators.cg_max, setup.actuators.period) == (0.3, 0.02, 0.1)


def test_quick_is_four_realisations_of_600_s() -> None:
    setup = read_experiment(None, quick=True)
    assert len(setup.run.seeds) == 4 and setup.run.duration == 600.0


def test_record_of_an_experiment_makes_the_same_experiment_again(tmp_path: Path) -> None:
    """What the summary keeps is enough to repeat it: sea, run, plant, sensors and actuators."""
    text = (
        SHORT
        + "[sea]\nhs = 0.2\ngamma = 2\n[plant]\nd1 = 1.5\n[sensors.psi]\nnoise = 0.01\n[actuators]\ncc_lag = 0.2\n"
    )
    one = build_experiment(tomllib.loads(text))
    kept = json.loads(json.dumps(one.record()))
    plant = {key: value for key, value in kept["plant"].items() if key in gy.Parameters.__dataclass_fields__}
    again = build_experiment({**kept, "plant": plant})
    assert again.sea == one.sea and again.run == one.run and again.actuators == one.actuators
    assert again.sensors == one.sensors and again.plant.parameters == one.plant.parameters
    assert dict(again.laws) == dict(one.laws)


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        ({"kind": "regular", "height": 0.2, "wp": 3.0}, gy.Regular(0.2, 3.0)),
        ({"kind": "bichromatic", "heights": [0.1, 0.2], "frequencies": [3, 3.3]}, gy.Bichromatic((0.1, 0.2), (3, 3.3))),
        ({"hs": 1, "wp": 3, "gamma": 1, "heading": 30}, gy.SeaState(1.0, 3.0, 1.0, 30.0)),
    ],
)
def test_kinds_of_seas(table: dict[str, Any], expected: Any) -> None:
    assert build_experiment({"sea": table, "run": {"seeds": [1]}}).sea == expected


def test_files_are_found_beside_the_experiment(tmp_path: Path) -> None:
    """Paths in the file are relative to it, not to where the command is typed."""
    home = tmp_path / "home"
    home.mkdir()
    (home / "laws.py").write_text(LAWS_OF_USERS)
    w = np.linspace(1.0, 8.0, 200)
    rows = "\n".join(f"{a},{b}" for a, b in zip(w, gy.SeaState().spectrum(w), strict=True))
    (home / "sea.csv").write_text(rows + "\n")
    (home / "mine.toml").write_text(
        '[sea]\nkind = "spectrum"\nfile = "sea.csv"\n[laws.mine]\nlaw = "laws.py:NotANumber"\n'
    )
    setup = read_experiment(home / "mine.toml")
    assert type(setup.laws["mine"]).__name__ == "NotANumber"
    assert setup.sea.hs == pytest.approx(0.283, rel=0.01)
