"""Who runs where: machine code on threads, plain Python in processes of its own."""

from __future__ import annotations

import pickle
from concurrent.futures import Future
from typing import Any

import pytest

import gyroctl as gy
from gyroctl.comparison import execution
from gyroctl.comparison.compare import Realisations
from gyroctl.comparison.items import Item, failed, work_items
from gyroctl.harness.run import Settings

SHORT = Settings(blend=20.0)


def test_a_compiled_law_around_a_slow_one_is_slow(device: gy.Plant, monkeypatch: pytest.MonkeyPatch) -> None:
    """A supervisor is a NamedTuple whatever it wraps: what it wraps decides."""
    sent: list[str] = []

    def noted(item: Item, processes: Any) -> Future[Any]:
        sent.append(item.name)
        future: Future[Any] = Future()
        future.set_result([failed(item, "not run here")])
        return future

    monkeypatch.setattr(execution, "_sent", noted)
    monkeypatch.setattr(execution, "_parts", lambda law: ())
    laws = {
        "plans": gy.law("supervisor", wraps={"law": "nmpc"}),
        "rules": gy.law("supervisor", wraps={"law": "coupling"}),
    }
    settings = Settings(blend=20.0)
    items = work_items(device, laws, Realisations(gy.SeaState(), (1, 2), 60.0), settings, 60.0)
    outcomes = execution.execute(items, 2, None, True)
    assert sent == ["plans", "plans"]
    assert {name for (name, _), outcome in outcomes.items() if not outcome.failure} == {"rules"}


def test_parts_to_be_compiled_travel_and_what_they_give_stays(device: gy.Plant) -> None:
    """Machine code cannot be sent back from the process that compiled it."""
    for part in gy.law("nmpc").preparations():
        assert callable(pickle.loads(pickle.dumps(part)))
    made: list[object] = []
    assert execution._prepare(lambda: made.append(object()) or (lambda: made)) is None
    assert made


def test_planner_as_machine_code_runs_on_threads(device: gy.Plant, monkeypatch: pytest.MonkeyPatch) -> None:
    def never(item: Item, processes: Any) -> Future[Any]:
        raise AssertionError("sent to a process")

    monkeypatch.setattr(execution, "_sent", never)
    monkeypatch.setattr(execution, "_parts", lambda law: ())
    items = work_items(device, {"plans": gy.law("nmpc")}, Realisations(gy.SeaState(), (1, 2), 60.0), SHORT, 60.0)
    outcomes = execution.execute(items, 2, None, True)
    assert {outcome.failure for outcome in outcomes.values()} == {""}


def test_planner_with_a_deadline_goes_to_processes(device: gy.Plant, monkeypatch: pytest.MonkeyPatch) -> None:
    sent: list[int] = []

    def noted(item: Item, processes: Any) -> Future[Any]:
        sent.append(item.seed)
        future: Future[Any] = Future()
        future.set_result([failed(item, "not run here")])
        return future

    monkeypatch.setattr(execution, "_sent", noted)
    monkeypatch.setattr(execution, "_parts", lambda law: ())
    law = gy.law("nmpc", deadline=10.0)
    execution.execute(
        work_items(device, {"plans": law}, Realisations(gy.SeaState(), (1, 2), 60.0), SHORT, 60.0), 2, None, True
    )
    assert sent == [1, 2]
