"""A comparison whose processes are killed at random, in the small, and the witnesses by which that is judged."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
import time
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
import xarray as xr

import gyroctl as gy
from gyroctl import writing
from gyroctl.disk import DISK
from gyroctl.engine import Store

ROOT = Path(gy.__file__).resolve().parents[1]
BENCHMARKS = ROOT / "benchmarks"

pytestmark = [
    pytest.mark.skipif(sys.platform != "linux", reason="needs the file events and processes of Linux"),
    pytest.mark.skipif(not BENCHMARKS.is_dir(), reason="the tests run outside a clone"),
]


def script(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"of_{path.stem}", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.slow
@pytest.mark.parametrize("mode", ["--alone", "--scheduler"])
def test_nothing_is_lost_stored_twice_or_computed_again(mode: str, tmp_path: Path) -> None:
    if mode == "--scheduler":
        pytest.importorskip("distributed", reason="needs the extra cluster: dask.distributed")
    counts = ("--items", "60", "--duration", "100", "--pool", "2", "--workers", "3", "--drivers", "2")
    command = [sys.executable, str(BENCHMARKS / "kills.py"), mode, *counts, "--out", str(tmp_path / "kills.json")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    found = json.loads((tmp_path / "kills.json").read_text())[mode.removeprefix("--")]
    assert found["wrong"] == 0 and found["stored"] == found["items"] == 60
    assert sum(found["killed"].values()) == (6 if mode == "--scheduler" else 5)


def test_what_a_killed_process_left_goes_when_its_folder_is_written_to(tmp_path: Path) -> None:
    """Also beside the results, where a report or results.nc was half-written."""
    ended = subprocess.run([sys.executable, "-c", "import os; print(os.getpid())"], capture_output=True, check=True)
    dead, me = int(ended.stdout), DISK.owner()
    left, under_way = (tmp_path / f".results.{process}-{me.host}.{me.start}1.part.nc" for process in (dead, me.process))
    left.touch()
    under_way.touch()
    writing.write_text(tmp_path / "summary.json", "")
    assert not left.exists() and under_way.exists()


def test_a_result_that_a_process_holds_while_it_is_born_is_not_written_in_place(tmp_path: Path) -> None:
    """Between fork and exec it has a copy of what is open: the last to close tells of a close under the new name."""
    witness = script(BENCHMARKS / "kills_witness.py").Witness(tmp_path)
    part = tmp_path / ".a.part.run"
    with part.open("wb") as stream:
        stream.write(b"x")
        stream.flush()
        holding = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE, pass_fds=[stream.fileno()])
    part.rename(tmp_path / "a.run")
    holding.communicate(b"\n")
    time.sleep(0.3)
    assert witness.count == 1 and not witness.other
    (tmp_path / "a.run").write_bytes(b"y")
    time.sleep(0.3)
    assert list(witness.other) == ["a.run"]


def test_witnesses_see_what_is_wrong(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    witnessing = script(BENCHMARKS / "kills_witness.py")
    journal = script(BENCHMARKS / "kills_journal" / "sitecustomize.py")
    monkeypatch.setenv("KILLS_JOURNAL", str(tmp_path / "journal"))
    results = xr.Dataset({"mean_power": ("run", [1.0, np.nan]), "step_ms_p99": ("run", [0.1, 0.2])})
    for place in ("serial", "killed"):
        (tmp_path / place / "runs").mkdir(parents=True)
        results.to_netcdf(tmp_path / place / "results.nc", engine="h5netcdf")
    witness = witnessing.Witness(tmp_path / "killed" / "runs")
    serial, killed = Store(tmp_path / "serial" / "runs"), Store(tmp_path / "killed" / "runs")

    def save(store: Store, key: str, power: float = 1.0, clock: float = 0.1) -> None:
        store.save(key, {"sha256": "", "values": {"mean_power": power, "step_ms_p99": clock}})

    def ran(key: str, *words: str) -> None:
        for word in words or ("begin", "end"):
            journal.note(word, [SimpleNamespace(key=key)])

    def table() -> dict[str, int]:
        time.sleep(0.3)
        return dict(
            witnessing.found(
                witness, witnessing.journal(tmp_path / "journal"), killed.folder.parent, tmp_path / "serial"
            )
        )

    assert killed.folder is not None
    for key in ("a", "b"):
        save(serial, key)
    ran("a", "begin")  # killed before it was stored
    for key in ("a", "b"):
        ran(key)
        save(killed, key, clock=0.7)  # what a clock has measured may differ
    good = table()
    assert not any(good[name] for name in witnessing.WRONG)
    assert (good["runs_begun"], good["runs_ended"], good["most_begun_of_one"]) == (3, 2, 2)

    ran("a")
    save(killed, "a", power=np.nextafter(1.0, 2.0))
    killed.path("b").write_bytes(killed.path("b").read_bytes())
    save(serial, "c")
    save(killed, "d")
    (killed.folder / ".e.12-0123abcd.xyz.part.run").touch()
    results.assign(mean_power=("run", [1.0, 2.0])).to_netcdf(tmp_path / "killed" / "results.nc", engine="h5netcdf")
    bad = table()
    expected = {"computed_again_though_stored": 1, "stored_twice": 1, "written_in_place_or_gone": 1, "lost": 1}
    expected |= {"never_asked_for": 1, "other_bits": 2, "other_results": 1, "half_written": 1}
    assert {name: bad[name] for name in expected} == expected
