"""Laws from elsewhere on a worker of a cluster: a process serves for many runs, and what breaks it fails alone."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

import gyroctl as gy
from gyroctl.comparison import alone
from gyroctl.comparison.compare import Realisations
from gyroctl.comparison.items import Item, perform, work_items
from gyroctl.comparison.parcels import parcels
from gyroctl.harness.run import Settings
from gyroctl.harness.travelling import by_value

LAWS = """
import os, sys, time
from dataclasses import dataclass

@dataclass(frozen=True)
class Mine:
    period: float = 0.1
    information: str = "none"
    does: str = ""
    def init(self): return None
    def step(self, t, y, state):
        if t > 30.0 and self.does == "ends":
            os.kill(os.getpid(), 9)
        if t > 30.0 and self.does == "sleeps":
            time.sleep(600.0)
        if t == 0.0 and self.does == "talks":
            print("a word" * 100)
            sys.stdin.read()
        return (0.05, 2e-4), None
"""

pytestmark = pytest.mark.slow


@pytest.fixture
def clean() -> Iterator[None]:
    yield
    while alone._idle:
        alone._idle.pop().end()


@pytest.mark.usefixtures("clean")
def test_one_process_serves_until_a_run_breaks_it(
    device: gy.Plant, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "mine.py").write_text(LAWS)
    waves = Realisations(gy.SeaState(), (1, 2), 60.0)

    def asked(does: str) -> list[Item]:
        law = gy.law(f"{tmp_path}/mine.py:Mine", does=does)
        return work_items(device, {"mine": law}, waves, Settings(blend=40.0), 60.0)

    served, expected = set(), {item.seed: perform([item])[0] for item in asked("")}
    for item in (*asked(""), *asked("talks")):
        (outcome,) = alone.in_a_process(*parcels([item], by_value(item.law)))
        here = expected[item.seed]  # what it says there, and asks for, goes no way of ours
        clocks = {"step_ms_median", "step_ms_p99"}
        assert not outcome.failure and outcome.sha256 == here.sha256
        assert {k: v for k, v in outcome.values.items() if k not in clocks} == pytest.approx(
            {k: v for k, v in here.values.items() if k not in clocks}, rel=0.0, abs=0.0, nan_ok=True
        )
        served.add(alone._idle[0].process.pid)
        assert len(alone._idle) == 1
    assert len(served) == 1

    item = asked("ends")[0]
    (outcome,) = alone.in_a_process(*parcels([item], by_value(item.law)))
    assert "signal 9" in outcome.failure and not alone._idle

    monkeypatch.setattr(alone, "GRACE", 20.0)
    item = replace(asked("sleeps")[0], time_limit=1.0)
    (outcome,) = alone.in_a_process(*parcels([item], by_value(item.law)))
    assert "took longer than 1 s" in outcome.failure and not alone._idle


@pytest.mark.usefixtures("clean")
def test_process_without_work_goes_away(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(alone, "IDLE", 0.2)
    process = alone._Process()
    alone._idle.append(process)
    process.end_if_idle()
    process.process.wait(timeout=30.0)
    assert not alone._idle
