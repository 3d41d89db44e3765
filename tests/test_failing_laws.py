"""A law that fails ends its own run alone: it is counted and named, and every other run goes on to the same bits."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import failing_laws as failing
import numpy as np
import pytest
import xarray as xr

import gyroctl as gy
from gyroctl.comparison import execution
from gyroctl.harness.law_entry import compile_law
from gyroctl.harness.protocol import LawError
from gyroctl.harness.run import Settings, lead_in, run_law

FILE = Path(failing.__file__)
SETTINGS = Settings(blend=20.0)
RAISING = {"Raises": "no more", "Beyond": "IndexError", "Divides": "ZeroDivisionError", "Nothing": "no number"}
PLAIN = {
    "Exits": "called for an exit",
    "Dies": "called for an exit",
    "Infinite": "not finite",
    "Three": "expected",
    "Words": "expected",
    "Interrupts": "MemoryError",
}


@pytest.mark.parametrize("name", RAISING)
def test_compiled_and_plain_laws_fail_alike(device: gy.Plant, name: str) -> None:
    law = getattr(failing, name)()
    assert compile_law(law) is not None
    waves = lead_in(gy.realise(device, gy.SeaState(), 100001, 60.0), SETTINGS)
    said = []
    for compiled in (True, False):
        with pytest.raises(LawError, match=RAISING[name]) as caught:
            run_law(device, law, waves, SETTINGS, name, compiled)
        said.append((str(caught.value), caught.value.kind, caught.value.time))
    assert said[0] == said[1]
    assert said[0][2] == pytest.approx(30.1, abs=0.11)


def test_half_a_command_that_is_no_number_stops_the_run(device: gy.Plant) -> None:
    waves = lead_in(gy.realise(device, gy.SeaState(), 100001, 60.0), SETTINGS)
    for compiled in (True, False):
        with pytest.raises(LawError, match="not finite") as caught:
            run_law(device, failing.Half(), waves, SETTINGS, "half", compiled)
        assert caught.value.time == pytest.approx(30.1, abs=0.11)


@pytest.fixture(scope="module")
def compared(tmp_path_factory: pytest.TempPathFactory) -> tuple[subprocess.CompletedProcess[str], Path]:
    """One comparison by the command line of laws that fail, beside two that do not."""
    out = tmp_path_factory.mktemp("failing")
    names = ["Well", *RAISING, *PLAIN, "Plain"]
    tables = "".join(f'[laws.{name.lower()}]\nlaw = "{FILE}:{name}"\n' for name in names)
    (out / "experiment.toml").write_text(
        f"[run]\nduration = 60.0\nblend = 20.0\nseeds = [1, 2]\n[laws.load_angle]\n{tables}", encoding="utf-8"
    )
    command = [sys.executable, "-m", "gyroctl", "compare", "experiment.toml", "--out", "out", "--allow-code", str(FILE)]
    return subprocess.run(command, cwd=out, capture_output=True, text=True, timeout=300), out / "out"


def test_each_failure_is_named_and_counted(compared: tuple[subprocess.CompletedProcess[str], Path]) -> None:
    done, out = compared
    assert done.returncode == 1, done.stderr
    assert "Exception ignored" not in done.stderr and "Traceback" not in done.stderr
    with xr.open_dataset(out / "results.nc", engine="h5netcdf") as ds:
        for name, part in {**RAISING, **PLAIN}.items():
            run = ds.sel(law=name.lower())
            assert run.failed.values.all() and not run.locked.values.any()
            assert all(part in str(reason) for reason in run.failure.values), run.failure.values
            assert np.isnan(run.mean_power.values).all()
        well = ds.sel(law=["well", "load_angle", "best_constant", "plain"])
        assert not well.failed.values.any() and np.isfinite(well.mean_power.values).all()
    laws = json.loads((out / "summary.json").read_text(encoding="utf-8"))["laws"]
    assert {name: row["failed"] for name, row in laws.items() if row["failed"]} == {
        name.lower(): 2 for name in {**RAISING, **PLAIN}
    }
    assert all(part in laws[name.lower()]["failures"]["1"] for name, part in {**RAISING, **PLAIN}.items())
    shown = " ".join(done.stdout.split())
    assert "raises is out: it failed in 2 of 2 runs" in shown and "* raises" not in shown


@pytest.mark.slow
def test_other_laws_have_the_bits_that_they_have_alone(
    device: gy.Plant, compared: tuple[subprocess.CompletedProcess[str], Path]
) -> None:
    waves = [gy.realise(device, gy.SeaState(), seed, 60.0) for seed in (1, 2)]
    laws = {"well": failing.Well(), "load_angle": gy.law("load_angle")}
    alone = gy.compare(device, laws, waves, SETTINGS, quiet=True)
    with xr.open_dataset(compared[1] / "results.nc", engine="h5netcdf") as ds:
        for variable in ("mean_power", "power_cv", "cycle_slips", "wave_input_w"):
            np.testing.assert_array_equal(ds[variable].sel(law=list(laws)), alone[variable])


@pytest.mark.slow
def test_every_run_gets_the_law_anew(device: gy.Plant) -> None:
    """Whatever a law hides, on itself or in its module, the order of the seeds changes nothing."""
    found = {}
    for seeds in ((1, 2, 3), (3, 1, 2)):
        waves = [gy.realise(device, gy.SeaState(), seed, 60.0) for seed in seeds]
        ds = gy.compare(device, {"plain": failing.Plain()}, waves, SETTINGS, workers=1, quiet=True)
        found[seeds] = dict(zip(seeds, ds.mean_power.values[0], strict=True))
    assert found[1, 2, 3] == found[3, 1, 2]


@pytest.mark.slow
@pytest.mark.parametrize("law", [failing.Sleeps(), failing.Endless()], ids=lambda law: type(law).__name__)
def test_a_law_that_does_not_come_back_is_given_up(
    device: gy.Plant, law: gy.Law, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(execution, "GRACE", 8.0)
    waves = [gy.realise(device, gy.SeaState(), 1, 60.0)]
    laws = {"stays": law, "well": failing.Well()}
    ds = gy.compare(device, laws, waves, SETTINGS, workers=2, quiet=True, time_limit=1.0)
    assert ds.failed.values.tolist() == [[True], [False]]
    assert "took longer than 1 s" in str(ds.failure.values[0, 0])


def test_a_slow_law_is_given_up_by_its_own_clock(device: gy.Plant) -> None:
    class Slow(failing.Plain):
        def step(self, t: float, y: object, state: object) -> object:
            failing.time.sleep(0.02)
            return (0.06, 3e-4), state

    waves = lead_in(gy.realise(device, gy.SeaState(), 1, 60.0), SETTINGS)
    with pytest.raises(LawError, match=r"took 0\.[3-9] s so far at t = \d\.\d s: 0\.3 s are allowed"):
        run_law(device, Slow(), waves, SETTINGS, "slow", time_limit=0.3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "part"), [("Exits", "exit"), ("Dies", "exit"), ("Beyond", "IndexError"), ("Nothing", "no number")]
)
def test_check_tells_each_failure(name: str, part: str) -> None:
    command = [sys.executable, "-m", "gyroctl", "laws", "check", f"{FILE}:{name}", "--runs", "2"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 2
    assert part in " ".join(done.stdout.split()), done.stdout
