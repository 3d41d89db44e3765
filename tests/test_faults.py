"""A study under faults of disk, processes and scheduler: `benchmarks/faults.py` in small, and what failed once."""

from __future__ import annotations

import json
import random
import sys
from collections import Counter
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

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
