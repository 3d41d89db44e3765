"""A study under faults of disk, processes and scheduler: `benchmarks/faults.py` in small, and what failed once."""

from __future__ import annotations

import json
import os
import random
import sys
from collections import Counter
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from gyroctl.disk import DISK
from gyroctl.engine.plan import Plan, Wanted
from gyroctl.tuning.log import TuningLog

FOLDER = Path(__file__).resolve().parents[1] / "benchmarks"

HISTORIES = 2000


@pytest.fixture
def history(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    if not FOLDER.is_dir():
        pytest.skip("the tests run outside a clone")
    monkeypatch.syspath_prepend(str(FOLDER))
    import faults_history

    return sys.modules.get("faults_history", faults_history)


def test_nothing_is_lost_whatever_happens(history: ModuleType) -> None:
    """Two thousand histories, and all that broke something once; the number of each plays it again."""
    seen: Counter[str] = Counter()
    kept = json.loads((FOLDER / "faults_seeds.json").read_text(encoding="utf-8"))
    for seed in [*kept, *range(HISTORIES)]:
        try:
            seen.update(history.played(seed))
        except BaseException as error:
            raise AssertionError(f"python benchmarks/faults.py --only {seed}: {error!r}") from error
    expected = ("came through", "killed", "power cut", "disk refused", "ConnectionError", "worker lost", "twice")
    for what in (*expected, "worker left out", "damaged: flip", "damaged: another's"):
        assert seen[what] > 20, f"{what}: hardly ever played"


def test_a_history_is_told_by_its_number(history: ModuleType) -> None:
    """With threads that take turns, too: 31 is one of those."""
    for seed in (3, 31):
        assert history.History(seed).threads == (seed == 31)
        assert history.played(seed) == history.played(seed)


def disk_of(history: ModuleType, number: int = 1) -> Any:
    """Disk of a process, on a medium of its own."""
    medium, world = history.Medium(random.Random(1)), history.World(random.Random(1))
    process = history.Process(number, "0123abcd")
    medium.processes.append(process)
    return history.SimulatedDisk(medium, process, lambda: history.Pool(world, print, False), lambda: None)


def test_a_study_that_finds_all_of_its_results_settles_their_folder(history: ModuleType) -> None:
    """Who made the folder was killed before its name came to the disk: nothing is stored then, and all told stored."""
    disk = disk_of(history)
    disk.make_folder(history.ROOT / "out")
    disk.make_folder(history.FOLDER)
    place = history.FOLDER / "a.run"
    disk.write(disk.new_file(history.FOLDER, "a", ".run"), b"a result")
    (written,) = disk.names(history.FOLDER)
    disk.sync(written)
    disk.rename(written, place)
    disk.sync_folder(history.FOLDER)
    assert history.ROOT / "out" in disk.medium.pending
    with Plan(history.FOLDER, "a case", [Wanted("a", "law", 1)], disk):
        assert not disk.medium.pending, "a power cut takes what is not on the disk"
    disk.medium.cut()
    assert disk.medium.files[place].data == b"a result"


def test_a_line_behind_what_another_process_left_torn_meanwhile_is_whole(history: ModuleType) -> None:
    disk = disk_of(history)
    log, append = TuningLog(history.LOG, disk), disk.append
    log.add("step 0", [0.0])

    def behind(path: Path, content: bytes) -> None:
        append(path, b'{"key": "step 7", "val')
        append(path, content)

    disk.append = behind
    log.add("step 1", [1.0])
    disk.append = append
    log.add("step 2", [2.0])
    disk.medium.cut()
    disk.process.dead = False
    assert TuningLog(history.LOG, disk).steps == {"step 0": [0.0], "step 1": [1.0], "step 2": [2.0]}


def test_line_is_synced_by_the_handle_that_wrote_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A failure to write back is told to those who have the file open, and not to who opens it afterwards."""
    synced, opened, there = os.fsync, Path.open, []

    def noted(handle: int) -> None:
        there.append(os.fstat(handle).st_size)
        synced(handle)

    def begun(path: Path, *words: Any, **more: Any) -> Any:
        there.append(path.name)
        return opened(path, *words, **more)

    monkeypatch.setattr(os, "fsync", noted)
    monkeypatch.setattr(Path, "open", begun)
    DISK.append(tmp_path / "log", b"a line\n")
    DISK.append(tmp_path / "log", b"another\n")
    assert there == ["log", 7, "log", 15]


def test_of_two_who_write_to_a_file_both_hear_that_it_could_not_be_written_back(history: ModuleType) -> None:
    first, heard = disk_of(history), []
    second = history.SimulatedDisk(first.medium, history.Process(2, "0"), first.pool, lambda: None)
    log, beside = TuningLog(history.LOG, first), TuningLog(history.LOG, second)
    log.add("step 0", [0.0])
    written = second._written

    def between(*words: Any, **more: Any) -> None:
        written(*words, **more)
        first.process.faults[first.process.count + 3] = "error"  # of its sync
        with pytest.raises(OSError, match="Input/output"):
            log.add("step 1", [1.0])
        heard.append(first.medium.files[history.LOG].errors)

    second._written = between
    with pytest.raises(OSError, match="Input/output"):
        beside.add("step 2", [2.0])
    assert heard == [1]
