"""Work on a second thread: begun when told, its result or failure where it is asked for, ended where the rest fails."""

from __future__ import annotations

import threading
import time
from concurrent.futures import CancelledError

import pytest

from gyroctl.studies.margins.beside import Tick, beside


def test_work_begins_when_it_is_told_to() -> None:
    begun = threading.Event()
    with beside(lambda tick: begun.set(), lambda: None) as work:
        assert not begun.wait(0.05)
        work.begin()
        work.begin()  # once
        assert begun.wait(5.0)
    begun.clear()
    with beside(lambda tick: begun.set(), lambda: None):
        pass
    assert not begun.is_set()


def test_result_and_ticks_come_back() -> None:
    told: list[int] = []

    def work(tick: Tick) -> str:
        tick()
        return threading.current_thread().name

    with beside(work, lambda: told.append(1)) as found:
        assert found.result() != threading.current_thread().name
        assert found.result() == found.result()
    assert told == [1]


def test_failure_beside_is_told_where_it_is_asked_for() -> None:
    def work(tick: Tick) -> None:
        raise ValueError("no orbit")

    with beside(work, lambda: None) as found:
        found.begin()
        with pytest.raises(ValueError, match="no orbit"):
            found.result()


def test_work_beside_ends_where_the_other_fails() -> None:
    ended: list[str] = []
    began = threading.Event()

    def work(tick: Tick) -> None:
        try:
            for _ in range(2000):
                began.set()
                tick()
                time.sleep(0.005)
            ended.append("itself")
        except CancelledError:
            ended.append("told")

    with pytest.raises(KeyError), beside(work, lambda: None) as found:
        found.begin()
        assert began.wait(5.0)
        raise KeyError("the other work")
    assert ended == ["told"]
