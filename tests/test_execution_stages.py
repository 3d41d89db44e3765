"""Who runs where: machine code on threads, plain Python in processes of its own."""

from __future__ import annotations

from concurrent.futures import Future
from typing import Any

import pytest

import gyroctl as gy
from gyroctl.comparison import execution
from gyroctl.comparison.compare import Realisations
from gyroctl.comparison.items import Item, failed, work_items
from gyroctl.harness.run import Settings


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
