"""Processes that are ended from outside, or killed while they hold what all of a pool share: no run fails for it."""

from __future__ import annotations

from pathlib import Path

import pytest

import gyroctl as gy
from gyroctl.comparison import processes
from gyroctl.comparison.alone import in_a_process
from gyroctl.comparison.execution import execute
from gyroctl.comparison.items import Item, Realisations, perform, work_items
from gyroctl.comparison.parcels import parcels
from gyroctl.harness.run import Settings
from gyroctl.harness.travelling import by_value

LAW = """
import gc, os, time
from dataclasses import dataclass
from pathlib import Path

from pebble.pool.channel import WorkerChannel

BEGUN, KILLED = (Path(__file__).parent / name for name in ("begun", "killed"))

def first():
    try:
        KILLED.mkdir()
    except FileExistsError:
        return False
    return True

@dataclass(frozen=True)
class Mine:
    period: float = 0.1
    information: str = "none"
    killed: bool = False
    def init(self): return None
    def step(self, t, y, state):
        if self.killed and 30.0 < t < 30.15:
            with BEGUN.open("a") as file:
                file.write(f"{os.getpid()}\\n")
            while len(set(BEGUN.read_text().split())) < 2:
                time.sleep(0.01)  # until another is at work as well
            if first():
                (channel,) = [one for one in gc.get_objects() if isinstance(one, WorkerChannel)]
                channel.mutex.acquire(timeout=60.0)
                os.kill(os.getpid(), 9)
        return (0.05, 2e-4), None
"""


def test_processes_do_not_wait_long_for_the_pipe() -> None:
    begun = processes.Processes(1)
    try:
        held = begun.schedule(eval, ("__import__('pebble').CONSTS.channel_lock_timeout",)).result(timeout=60.0)
        assert held == processes.HELD == 10.0
    finally:
        begun.pool.stop()
        begun.pool.join()


@pytest.mark.slow
def test_no_other_run_fails_with_one_that_holds_the_pipe(
    device: gy.Plant, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(processes, "HELD", 1.0)
    (tmp_path / "mine.py").write_text(LAW)
    waves = Realisations(gy.SeaState(), (1, 2, 3), 60.0)

    def asked(killed: bool) -> list[Item]:
        law = gy.law(f"{tmp_path}/mine.py:Mine", killed=killed)
        return work_items(device, {"mine": law}, waves, Settings(blend=40.0), 60.0)

    outcomes = execute(asked(True), 2, None, True)
    assert {seed for _, seed in outcomes} == set(waves.seeds)
    assert (tmp_path / "killed").exists()
    expected = {item.seed: perform([item])[0] for item in asked(False)}
    for (_, seed), outcome in outcomes.items():
        assert outcome.failure == "" and outcome.sha256 == expected[seed].sha256
        assert outcome.values["mean_power"] == expected[seed].values["mean_power"]


ASKED = """
import os
from dataclasses import dataclass
from pathlib import Path

ASKED = Path(__file__).parent / "asked"

@dataclass(frozen=True)
class Mine:
    period: float = 0.1
    information: str = "none"
    times: int = 0
    signal: int = 15
    def init(self): return None
    def step(self, t, y, state):
        if t > 30.0 and len(list(ASKED.glob("*"))) < self.times:
            (ASKED / str(os.getpid())).touch()
            os.kill(os.getpid(), self.signal)
        return (0.05, 2e-4), None
"""


@pytest.mark.parametrize("beside_a_worker", [False, True])
@pytest.mark.parametrize(("times", "signal"), [(1, 15), (2, 9), (9, 15)])
def test_run_whose_process_is_ended_from_outside_is_run_again(
    device: gy.Plant, tmp_path: Path, times: int, signal: int, beside_a_worker: bool
) -> None:
    """Whoever ends a process says nothing of its law; where it happens again and again, that is told as it is."""
    (tmp_path / "asked").mkdir()
    (tmp_path / "mine.py").write_text(ASKED)
    law = gy.law(f"{tmp_path}/mine.py:Mine", times=times, signal=signal)
    (item,) = work_items(device, {"mine": law}, Realisations(gy.SeaState(), (1,), 60.0), Settings(blend=40.0), 60.0)
    if beside_a_worker:
        (outcome,) = in_a_process(*parcels([item], by_value(law)))
    else:
        (outcome,) = execute([item], 2, None, True).values()
    assert len(list((tmp_path / "asked").iterdir())) == min(times, 3)
    if times < 3:
        assert outcome.failure == "" and outcome.values["mean_power"] > 0.0
    else:
        assert "3 times" in outcome.failure and "signal 15" in outcome.failure and "exit" not in outcome.failure
