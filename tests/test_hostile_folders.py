"""Folders of results that others made: pipes, devices, links in circles, names of nobody, rights of nobody."""

from __future__ import annotations

import json
import os
import shutil
import stat
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from command_line import Run

from gyroctl.disk import DISK
from gyroctl.engine import Store
from gyroctl.engine.again import copy_study
from gyroctl.engine.state import _alive
from gyroctl.writing import left_over, written_whole

pytestmark = pytest.mark.skipif(os.name == "nt", reason="pipes, devices and links")

KEY = "ab" * 32


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """One sound result, and all that may lie beside it."""
    runs = tmp_path / "out" / "runs"
    Store(runs).save(KEY, {"values": {}}, None, {"law": "mine", "step": "one"})
    os.mkfifo(runs / f"{'cd' * 32}.run")
    (runs / f"{'ef' * 32}.run").symlink_to("/dev/zero")
    (runs / f"{'01' * 32}.run").mkdir()
    os.mkfifo(runs / "pipe.plan.json")
    (runs / "zero.plan.json").symlink_to("/dev/zero")
    (runs / "circle").symlink_to(runs)
    (tmp_path / "out" / "self").symlink_to(tmp_path / "out")
    return tmp_path / "out"


def test_what_has_no_end_is_not_waited_for(folder: Path, run: Run) -> None:
    store, said = Store(folder / "runs", lambda _: None), list[object]()

    def loaded() -> None:
        said.extend(store.load(key * 32) for key in ("cd", "ef", "01"))

    reader = threading.Thread(target=loaded, daemon=True)
    reader.start()
    reader.join(20.0)
    assert said == [None, None, None] and store.refused.total() == 3
    code, out, _ = run("status", folder)
    assert code == 0 and json.loads(out)["lines"][0]["done"] == 1
    code, out, _ = run("clean", folder)
    assert code == 0 and json.loads(out)["damaged"]["files"] == 4
    assert {path.name for path in (folder / "runs").iterdir()} == {f"{KEY}.run", f"{'01' * 32}.run", "circle"}


def test_copy_of_a_study_ends_and_may_be_written_to(folder: Path, tmp_path: Path) -> None:
    (folder / "table.json").write_text("{}")
    (folder / "table.json").chmod(0o400)
    (folder / "runs").chmod(0o500)
    copy = tmp_path / "copy"
    copy_study(folder, copy, {"table.json"})
    (folder / "runs").chmod(0o700)
    names = {path.relative_to(copy).as_posix() for path in copy.rglob("*") if not path.is_dir()}
    assert names == {f"runs/{KEY}.run", f"self/runs/{KEY}.run"}
    assert (copy / "runs").stat().st_mode & stat.S_IWUSR


def test_rights_of_new_files_are_those_of_the_process(tmp_path: Path) -> None:
    """Of many threads at once: no moment in which a file is open to all, and the process keeps what it withholds."""
    before = os.umask(0o027)
    try:

        def write(number: int) -> None:
            for each in range(20):
                with written_whole(tmp_path / f"{number}-{each}") as part:
                    part.write_text("x")

        threads = [threading.Thread(target=write, args=(number,)) for number in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert {stat.S_IMODE(path.stat().st_mode) for path in tmp_path.iterdir()} == {0o640}
    finally:
        assert os.umask(before) == 0o027


def test_what_an_earlier_process_of_the_same_number_left_is_cleaned(tmp_path: Path) -> None:
    """In a container the command is number 1 or 7 each time."""
    me = DISK.owner()
    mine = tmp_path / f".x.{me.process}-{me.host}.{me.start}77.part.run"
    before = tmp_path / f".x.{me.process}-{me.host}.0123456777.part.run"
    for path in (mine, before):
        path.write_bytes(b"half")
    assert left_over(tmp_path) == [before]


def test_new_folders_are_made_with_their_names_on_the_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    synced: list[Path] = []
    monkeypatch.setattr(type(DISK), "sync_folder", lambda self, folder: synced.append(folder))
    with written_whole(tmp_path / "a" / "b" / "file") as part:
        part.write_text("x")
    assert synced == [tmp_path, tmp_path / "a", tmp_path / "a" / "b"]


@pytest.mark.slow
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is full")
def test_output_that_cannot_be_written_is_no_traceback(folder: Path) -> None:
    with Path("/dev/full").open("w") as full:
        line = [sys.executable, "-m", "gyroctl", "status", str(folder)]
        done = subprocess.run(line, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode != 0 and "Traceback" not in done.stderr and done.stderr.count("\n") <= 1, done.stderr


@pytest.mark.parametrize("process", [0, -1, -(10**30), 10**30])
def test_number_of_no_process_is_none(process: int) -> None:
    assert not _alive(process)


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A disk of 256 kB, where this user may mount one."""
    place = tmp_path / "small"
    place.mkdir()
    made = shutil.which("mount") and shutil.which("umount")
    line = ["mount", "-t", "tmpfs", "-o", "size=256k", "tmpfs", str(place)]
    if not made or subprocess.run(line, capture_output=True, check=False).returncode:
        pytest.skip("this user may mount nothing")
    yield place
    subprocess.run(["umount", "-l", str(place)], capture_output=True, check=False)


def test_disk_that_fills_up_keeps_what_was_stored(small_disk: Path) -> None:
    runs, said = small_disk / "out" / "runs", list[str]()
    numbers, stored = np.random.default_rng(1).random(3000), list[str]()
    store = Store(runs, said.append)
    with pytest.raises(OSError, match="No space left"):
        for number in range(100):
            key = f"{number:064x}"
            store.save(key, {"number": number}, {"time": numbers})
            stored.append(key)
    assert 2 < len(stored) < 20
    assert {path.name for path in runs.iterdir()} == {f"{key}.run" for key in stored}
    for key in stored:
        record = Store(runs, said.append).load(key)
        assert record is not None and record.arrays["time"].tobytes() == numbers.tobytes()
    with pytest.raises(OSError, match="No space left"):
        store.save(stored[0], {"number": -1}, {"time": numbers})
    record = store.load(stored[0])
    assert record is not None and record.content["number"] == 0 and not said
