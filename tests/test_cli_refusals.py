"""Bad input of every command ends with exit code 2, one line, and nothing written."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from command_line import LAWS_OF_USERS, Run

from gyroctl.comparison.experiment import build_experiment
from gyroctl.harness.seed_ledger import all_tuning_seeds


def check_refusal(code: int, out: str, err: str, words: list[str]) -> None:
    assert code == 2, out + err
    assert err.startswith("Error: ") and "Traceback" not in err + out
    assert len(err.strip().splitlines()) == 1
    for word in words:
        assert word in err


# --- experiments -------------------------------------------------------------------------------------------------

RUN = "[run]\nduration = 120\nblend = 40\nseeds = [1]\n"

FAILING: dict[str, tuple[str, list[str]]] = {
    # name: (TOML, what the table must hold)
    "law returning nan": ('[laws.mine]\nlaw = "laws.py:NotANumber"', ["'mine'", "not finite", "t = 0.0 s"]),
    "law of a wrong shape": ('[laws.mine]\nlaw = "laws.py:WrongShape"', ["'mine'", "3.0", "two numbers"]),
    "law that fails": ('[laws.mine]\nlaw = "laws.py:Failing"', ["'mine'", "ZeroDivisionError", "laws.py:13"]),
}

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
    "law without its file": ('[laws.mine]\nlaw = "gone.py:Mine"', ["laws.mine.law", "gone.py", "no file"]),
    "number for a name": ("[laws.nmpc]\ninformation = 3", ["laws.nmpc.information", "3", "must be a name", "sensors"]),
    "list for a name": ("[laws.nmpc]\nsolver = [1]", ["laws.nmpc.solver", "[1]", "must be a name"]),
    "number for a group": ("[laws.nmpc]\ngauge = 10.0", ["laws.nmpc.gauge", "10.0", "several parameters", "distance"]),
    "number for a design": ("[laws.scheduled_lqr]\nplant = 1", ["laws.scheduled_lqr.plant", "1", "variant"]),
    "number for a law": ("[laws.supervisor]\nwraps = 2", ["laws.supervisor.wraps", "2", "must be a name"]),
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


@pytest.mark.parametrize("name", sorted(BAD))
def test_bad_experiment_is_refused_in_one_line(name: str, tmp_path: Path, run: Run) -> None:
    text, words = BAD[name]
    (tmp_path / "laws.py").write_text(LAWS_OF_USERS)
    toml = tmp_path / "bad.toml"
    toml.write_text(text if "[run]" in text or name == "value for a table" else RUN + text)
    out = tmp_path / "out"
    code, printed, err = run("compare", toml, "--out", out, "--workers", 1)
    check_refusal(code, printed, err, words)
    assert not out.exists(), "half-written"


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(FAILING))
def test_law_that_fails_is_named_beside_the_results_of_the_others(name: str, tmp_path: Path, run: Run) -> None:
    text, words = FAILING[name]
    (tmp_path / "laws.py").write_text(LAWS_OF_USERS)
    (tmp_path / "bad.toml").write_text(RUN + text)
    code, _, err = run("compare", tmp_path / "bad.toml", "--out", tmp_path / "out", "--workers", 1)
    assert code == 1 and all(word in err for word in words), err
    assert (tmp_path / "out" / "results.nc").is_file() and (tmp_path / "out" / "report.html").is_file()


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


# --- the other commands ------------------------------------------------------------------------------------------

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


# --- what is no bad input, and the shell -------------------------------------------------------------------------


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
