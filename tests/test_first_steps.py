"""What a newcomer meets first: help with units, version, time left, names that are not there, mixed-up arguments."""

from __future__ import annotations

import json
import re
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click
import numpy as np
import pytest
import typer
from typer.testing import CliRunner

import gyroctl as gy
from gyroctl import provenance
from gyroctl.cli.app import app
from gyroctl.comparison.experiment import build_experiment
from gyroctl.harness.law_check import check_law
from gyroctl.simulation.progress import Progress
from gyroctl.version import VERSION

LAWS = """
from typing import NamedTuple


class Typo(NamedTuple):
    period: float = 0.1

    @property
    def information(self):
        return "sensors"

    def init(self):
        return (0.0,)

    def step(self, t, y, state):
        return (0.06, 4e-4 * y.psi_dot), state


class Wild(Typo):
    def step(self, t, y, state):
        return (0.06, 4e-4), (state[0] + 0.0 * y.psi_rate,)
"""

# --- help and version --------------------------------------------------------------------------------------------


def commands() -> dict[str, click.Command]:
    """Every command with its words, also those of the groups."""
    found: dict[str, click.Command] = {}

    def look(command: Any, words: str) -> None:
        found[words] = command
        for name, part in getattr(command, "commands", {}).items():
            look(part, f"{words} {name}".strip())

    look(typer.main.get_command(app), "")
    return found


def squeezed(text: str) -> str:
    """Text without what lays it out: boxes, line breaks, repeated blanks."""
    return re.sub(r"[\s\u2500-\u257f]+", "", text)


@pytest.mark.parametrize("words", list(commands()))
def test_help_of_every_command_keeps_its_brackets(words: str) -> None:
    command = commands()[words]
    shown = squeezed(CliRunner().invoke(app, [*words.split(), "--help"], env={"COLUMNS": "300", "TERM": "dumb"}).output)
    for parameter in command.params:
        assert squeezed(getattr(parameter, "help", None) or "") in shown, parameter.name


def test_units_stand_in_the_help() -> None:
    """Guard of the test above: there are units to lose."""
    texts = [getattr(p, "help", "") or "" for command in commands().values() for p in command.params]
    assert sum("[" in text for text in texts) > 20
    shown = CliRunner().invoke(app, ["simulate", "--help"], env={"COLUMNS": "200"}).output
    assert "Significant wave height [m]." in shown and "[Nms]" in shown and "[s]" in shown


def test_version() -> None:
    done = CliRunner().invoke(app, ["--version"])
    assert done.exit_code == 0 and done.output.startswith(f"gyroctl {VERSION}")


# --- progress ----------------------------------------------------------------------------------------------------


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    now = [0.0]
    monkeypatch.setattr("gyroctl.simulation.progress.time.monotonic", lambda: now[0])
    return now


def test_compilation_is_no_part_of_the_time_left(clock: list[float]) -> None:
    """60 s of compilation, then 1 s a run: an estimate over all would say ten times too much."""
    with Progress("runs", 100) as progress:
        clock[0] = 61.0
        progress.advance()
        assert progress.left(clock[0]) is None
        for second in range(62, 72):
            clock[0] = float(second)
            progress.advance()
        assert progress.left(clock[0]) == pytest.approx(89.0, rel=0.05)


def test_what_was_stored_is_no_part_of_the_time_left(clock: list[float]) -> None:
    with Progress("runs", 120) as progress:
        progress.skip(100)
        for second in (5, 10, 15, 20):
            clock[0] = float(second)
            progress.advance()
        assert progress.done == 104
        assert progress.left(clock[0]) == pytest.approx(80.0, rel=0.05)


def test_slow_runs_after_quick_ones_soon_count(clock: list[float]) -> None:
    """100 quick runs, then each takes 10 s: after eight of them the time left is nearly right."""
    with Progress("runs", 120) as progress:
        for i in range(100):
            clock[0] = 0.1 * i
            progress.advance()
        for _ in range(8):
            clock[0] += 10.0
            progress.advance()
        assert progress.left(clock[0]) == pytest.approx(120.0, rel=0.15)


def test_time_left_of_runs_that_end_side_by_side(clock: list[float]) -> None:
    """Fillings of 16 that take 250 s: said at their first run or after their last, it is that of the fillings left."""
    with Progress("runs", 96) as progress:
        for filling in range(6):
            clock[0] += 250.0
            for _ in range(16):
                progress.advance()
                said, truly = progress.left(clock[0]), 250.0 * (5 - filling)
                assert (said is None) == (filling == 0)
                assert said is None or truly <= said <= truly + 260.0
                clock[0] += 0.01


def test_long_compilation_is_said(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gyroctl.simulation.progress.PATIENCE", 0.05)
    with Progress("runs", 3):
        time.sleep(0.3)
    with Progress("quiet", 3, quiet=True):
        time.sleep(0.3)
    said = capsys.readouterr().err
    assert said.count("compiling") == 1 and "quiet" not in said


def test_simulation_of_a_plain_law_tells_each_sample(device: gy.Plant) -> None:
    waves, count = gy.realise(device, gy.SeaState(), 1, 30.0), [0]

    def tick() -> None:
        count[0] += 1

    gy.simulate(device, "coupling", waves, gy.Settings(blend=10.0), compiled=False, progress=tick)
    assert count[0] == 300


def test_check_of_a_law_tells_its_lines(device: gy.Plant) -> None:
    from gyroctl.harness.law_check import LINES

    ticks: list[int] = []
    check_law("coupling", device, 2, lambda: ticks.append(1))
    assert len(ticks) == LINES


# --- names that are not there ------------------------------------------------------------------------------------


def test_misread_measurement_is_answered_with_the_names_there_are(tmp_path: Path, device: gy.Plant) -> None:
    (tmp_path / "mine.py").write_text(LAWS)
    y = gy.Measurement(*np.arange(7.0))
    with pytest.raises(AttributeError, match="did you mean psi_rate"):
        y.psi_dot  # noqa: B018
    assert not hasattr(y, "omega") and y._replace(psi=2.0).psi == 2.0
    line = next(i for i, text in enumerate(LAWS.splitlines(), 1) if "psi_dot" in text)
    with pytest.raises(gy.LawError) as failed:
        gy.simulate(device, gy.law(f"{tmp_path / 'mine.py'}:Typo"), gy.realise(device, gy.SeaState(), 1, 150.0))
    check = next(check for check in check_law(f"{tmp_path / 'mine.py'}:Typo", device, 2) if not check.passed)
    for text in (str(failed.value), f"{check.found} {check.mend}"):
        assert all(name in text for name in ("psi_dot", *gy.Measurement._fields)), text
        assert f"mine.py:{line}" in text, text
    assert "Return ((cc, cg), state)" not in check.mend


# --- arguments that are mixed up ---------------------------------------------------------------------------------

PLANT = gy.zhang2017()
WAVES = gy.realise(PLANT, gy.SeaState(), 1, 150.0)
LAW = gy.law("coupling")
WAVE = gy.Regular(0.2, 3.14)

MIXED: list[tuple[str, Callable[[], Any]]] = [
    ("laws", lambda: gy.compare(PLANT, [LAW], [WAVES])),  # type: ignore[list-item]
    ("laws", lambda: gy.compare(PLANT, LAW, [WAVES])),  # type: ignore[arg-type]
    ("laws", lambda: gy.compare(PLANT, "coupling", [WAVES])),
    ("laws.a", lambda: gy.compare(PLANT, {"a": 3}, [WAVES])),  # type: ignore[dict-item]
    ("laws.a", lambda: gy.compare(PLANT, {"a": type(LAW)}, [WAVES])),  # type: ignore[dict-item]
    ("waves", lambda: gy.compare(PLANT, {"a": LAW}, gy.SeaState())),  # type: ignore[arg-type]
    ("waves", lambda: gy.compare(PLANT, {"a": LAW}, [gy.SeaState()])),  # type: ignore[list-item]
    ("plant", lambda: gy.compare({"a": LAW}, PLANT, [WAVES])),  # type: ignore[arg-type]
    ("settings", lambda: gy.compare(PLANT, {"a": LAW}, [WAVES], 300.0)),  # type: ignore[arg-type]
    ("law", lambda: gy.simulate(PLANT, WAVES, LAW)),  # type: ignore[arg-type]
    ("law", lambda: gy.simulate(PLANT, type(LAW), WAVES)),  # type: ignore[arg-type]
    ("law", lambda: gy.simulate(PLANT, "couplign", WAVES)),
    ("waves", lambda: gy.simulate(PLANT, LAW, gy.SeaState())),  # type: ignore[arg-type]
    ("plant", lambda: gy.simulate("zhang2017", LAW, WAVES)),  # type: ignore[arg-type]
    ("settings", lambda: gy.simulate(PLANT, LAW, WAVES, 0.01)),  # type: ignore[arg-type]
    ("wave", lambda: gy.lock_orbit(PLANT, gy.SeaState(), 0.052, 3.5e-4)),  # type: ignore[arg-type]
    ("wave", lambda: gy.lock_orbit(PLANT, 0.2, 0.052, 3.5e-4)),  # type: ignore[arg-type]
    ("plant", lambda: gy.lock_orbit(WAVE, PLANT, 0.052, 3.5e-4)),  # type: ignore[arg-type]
    ("cc", lambda: gy.lock_orbit(PLANT, WAVE, "a", 3.5e-4)),  # type: ignore[arg-type]
    ("wave", lambda: gy.margins(PLANT, gy.SeaState(), 0.052, 3.5e-4)),  # type: ignore[arg-type]
    ("plant", lambda: gy.margins(WAVE, PLANT, 0.052, 3.5e-4)),  # type: ignore[arg-type]
    ("law", lambda: gy.margins(PLANT, WAVE, 0.052, 3.5e-4, law=3)),  # type: ignore[arg-type]
    ("plant", lambda: gy.realise(gy.SeaState(), PLANT, 1)),  # type: ignore[arg-type]
    ("sea", lambda: gy.realise(PLANT, 0.283, 1)),  # type: ignore[arg-type]
    ("sea", lambda: gy.scan(PLANT, WAVES, [(0.052, 3.5e-4)], [1])),  # type: ignore[arg-type]
    ("plant", lambda: gy.scan(gy.SeaState(), PLANT, [(0.052, 3.5e-4)], [1])),  # type: ignore[arg-type]
    ("law", lambda: gy.law(LAW)),  # type: ignore[arg-type]
]


@pytest.mark.parametrize(("field", "call"), MIXED, ids=[f"{i}-{field}" for i, (field, _) in enumerate(MIXED)])
def test_mixed_up_argument_is_refused_by_its_name(field: str, call: Callable[[], Any]) -> None:
    with pytest.raises(gy.InputError) as caught:
        call()
    assert caught.value.field == field and caught.value.mend


def test_names_stand_for_laws() -> None:
    settings = gy.Settings(blend=50.0)
    named = gy.simulate(PLANT, "coupling", WAVES, settings)
    np.testing.assert_array_equal(named.psi, gy.simulate(PLANT, LAW, WAVES, settings).psi)
    assert named.attrs["law"] == "coupling"
    by_list = gy.compare(PLANT, ["coupling"], [WAVES], settings, quiet=True)
    by_law = gy.compare(PLANT, {"coupling": LAW}, WAVES, settings, quiet=True)  # type: ignore[arg-type]
    np.testing.assert_array_equal(by_list.mean_power, by_law.mean_power)


# --- seas that are the same for every seed -----------------------------------------------------------------------


def test_several_seeds_of_a_record_are_refused_before_any_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def never(*_: object) -> None:
        raise AssertionError("a run began")

    monkeypatch.setattr("gyroctl.comparison.execution.perform", never)
    np.savetxt(tmp_path / "sea.csv", np.column_stack([WAVES.time, WAVES.elevation]), delimiter=",")
    record = {"kind": "record", "file": "sea.csv"}
    for sea in (record, {"kind": "regular", "height": 0.2, "wp": 3.14}):
        tables = {"sea": sea, "run": {"duration": 150.0, "blend": 50.0, "seeds": [1, 2]}, "laws": {"constant": {}}}
        with pytest.raises(gy.InputError, match="same waves") as caught:
            build_experiment(tables, folder=tmp_path)
        assert caught.value.field == "run.seeds"
    one = gy.ElevationRecord(WAVES.time, WAVES.elevation)
    waves = [gy.realise(PLANT, one, seed, 150.0) for seed in (1, 2)]
    with pytest.raises(gy.InputError, match="same waves"):
        gy.compare(PLANT, {"a": LAW}, waves, quiet=True)


# --- what a result says of itself --------------------------------------------------------------------------------


def test_changed_plant_is_called_by_what_was_changed() -> None:
    assert gy.zhang2017().name == "zhang2017 corrected"
    changed = gy.zhang2017(d1=3.0)
    assert changed.name == PLANT.replace(d1=3).name == "zhang2017 corrected, d1 = 3"
    assert changed.replace(k1=150.0).name == "zhang2017 corrected, k1 = 150, d1 = 3"
    assert changed.replace(d1=2.0).name == "zhang2017 corrected" and changed.replace(d1=2.0) == PLANT
    assert gy.zhang2017("paper").name == "zhang2017 paper"
    assert gy.zhang2017(radiation="fine").name == "zhang2017 corrected, radiation = fine"
    assert PLANT.replace(lever_gyroscopic=False).name == "zhang2017 corrected, lever_gyroscopic = off"
    assert PLANT.replace(radiation=gy.zhang2017("paper").radiation).name == "zhang2017 corrected, other radiation"
    assert changed.replace(name="mine").replace(k1=150.0).name == "mine, k1 = 150"


@pytest.fixture(scope="module")
def compared(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A comparison of a changed plant by the command, in a folder of its own."""
    home = tmp_path_factory.mktemp("compared")
    run = "[run]\nduration = 120\nblend = 50\nseeds = [1]\n"
    (home / "mine.toml").write_text(f"{run}[plant]\nd1 = 3\n[laws.coupling]\n[laws.constant]\n")
    words = ["compare", str(home / "mine.toml"), "--out", str(home / "out")]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sys.argv", ["gyroctl", *words])
        done = CliRunner().invoke(app, words)
    assert done.exit_code == 0, done.output
    return home


def test_results_know_what_made_them(compared: Path) -> None:
    import xarray as xr

    with xr.open_dataset(compared / "out" / "results.nc", engine="h5netcdf") as ds:
        known = dict(ds.attrs)
    assert known["plant"] == "zhang2017 corrected, d1 = 3"
    assert known["gyroctl_version"] == VERSION and known["commit"] == provenance.commit()
    assert json.loads(known["versions"]) == provenance.versions()
    assert set(provenance.versions()) == {"python", "numpy", "scipy", "numba", "casadi"}
    assert known["command"] == "gyroctl compare mine.toml --out out"
    assert known["platform"] == provenance.machine()
    assert not [value for value in known.values() if isinstance(value, str) and str(compared.parent) in value]
    page = (compared / "out" / "report.html").read_text()
    assert "zhang2017 corrected, d1 = 3" in page and "gyroctl compare mine.toml --out out" in page
    assert "zhang2017 corrected, d1 = 3" in (compared / "out" / "summary.json").read_text()


@pytest.mark.slow
def test_report_written_again_keeps_the_command_of_the_comparison(compared: Path) -> None:
    done = CliRunner().invoke(app, ["report", str(compared / "out"), "--out", str(compared / "again")])
    assert done.exit_code == 0
    assert "gyroctl compare mine.toml --out out" in (compared / "again" / "report.html").read_text()


def test_trajectory_knows_what_made_it(tmp_path: Path) -> None:
    import xarray as xr

    out = tmp_path / "run.nc"
    done = CliRunner().invoke(app, ["simulate", "--law", "coupling", "--duration", "120", "--out", str(out)])
    assert done.exit_code == 0, done.output
    with xr.open_dataset(out, engine="h5netcdf") as ds:
        assert json.loads(ds.attrs["versions"]) == provenance.versions()
        assert ds.attrs["command"].startswith("gyroctl") and str(tmp_path) not in ds.attrs["command"]


def test_processor_names_its_instructions() -> None:
    name, _, instructions = provenance.processor().partition(": ")
    assert name and len(instructions.split()) >= 1


def test_commit_is_that_of_the_checkout_alone(tmp_path: Path) -> None:
    assert provenance.commit(tmp_path) == ""
    subprocess.run(["git", "init", "-q", str(tmp_path)], check=True)
    (tmp_path / "inside").mkdir()
    assert provenance.commit(tmp_path / "inside") == "", "a package within somebody else's repository"
    assert provenance.commit(tmp_path) == "", "no commit yet"
    (tmp_path / "a").write_text("1")
    author = ["-c", "user.name=a", "-c", "user.email=a@b"]
    subprocess.run(["git", "-C", str(tmp_path), "add", "a"], check=True)
    subprocess.run(["git", "-C", str(tmp_path), *author, "commit", "-qm", "a"], check=True)
    provenance.commit.cache_clear()
    first = provenance.commit(tmp_path)
    assert re.fullmatch(r"[0-9a-f]{40}", first)
    (tmp_path / "a").write_text("2")
    provenance.commit.cache_clear()
    assert provenance.commit(tmp_path) == f"{first}, changed"


ELSEWHERE = "/data/me"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["compare", f"{ELSEWHERE}/a.toml", "--out=/data/b"], "gyroctl compare a.toml --out=b"),
        (["compare", "D:\\my\\a.toml"], "gyroctl compare a.toml"),
        (
            ["simulate", "--law", f"{ELSEWHERE}/laws.py:Mine", "--set", "cc=0.1"],
            "gyroctl simulate --law laws.py:Mine --set cc=0.1",
        ),
        (["bound", "--law", "nmpc information=oracle"], 'gyroctl bound --law "nmpc information=oracle"'),
        (["compare", "mine/a.toml"], "gyroctl compare mine/a.toml"),
    ],
)
def test_command_is_kept_without_folders_of_the_machine(words: list[str], said: str) -> None:
    assert provenance.command_line(words) == said


# --- a run that is no longer finite, a comparison that is stopped ------------------------------------------------


def test_simulation_that_is_not_finite_is_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever the reason: no number, no file, no success."""
    real = gy.simulate

    def broken(*arguments: Any, **options: Any) -> Any:
        ds = real(*arguments, **options)
        ds["energy_generator"][600:] = np.nan
        ds["psi_rate"][600:] = np.nan
        return ds

    monkeypatch.setattr("gyroctl.simulate", broken)
    out = tmp_path / "run.nc"
    done = CliRunner().invoke(app, ["simulate", "--law", "constant", "--duration", "120", "--out", str(out)])
    assert isinstance(done.exception, gy.InputError) and "t = 60.0 s" in str(done.exception)
    assert not out.exists() and "nan W" not in done.output
