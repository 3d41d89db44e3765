"""Margins, bounds and the paper's ensembles on the workers of a Dask scheduler: the same as here comes out."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_cluster import local  # noqa: F401  (a fixture)

import gyroctl as gy
from gyroctl.engine import ahead
from gyroctl.engine.ahead import Piece, do_ahead
from gyroctl.engine.cluster import connected
from gyroctl.engine.steps import Steps
from gyroctl.studies.bound import bound_report
from gyroctl.studies.bound import quick as quick_effort
from gyroctl.studies.margins import margin_report, request
from gyroctl.studies.paper import ensembles, reproduce
from gyroctl.studies.paper.ensembles import Setup, ensemble

pytest.importorskip("distributed", reason="needs the extra cluster: dask.distributed")


def half(number: float) -> float:
    """What a worker does."""
    if number < 0.0:
        raise gy.InputError("number", number, "is negative", "Give another one")
    return 0.5 * number


def forbidden(*_: Any, **__: Any) -> Any:
    raise AssertionError("this was done before")


def test_steps_are_done_there_kept_and_found_here(local: Any, tmp_path: Path) -> None:  # noqa: F811
    steps = Steps(tmp_path, "given", ("gyroctl.errors",), ())
    told: list[int] = []
    pieces = [Piece(steps, f"half of {n}", half, (float(n),)) for n in (3, -1, 4)]
    with connected(local.scheduler_address) as client:
        do_ahead(client, pieces, lambda: told.append(1))
        assert len(told) == 3
        do_ahead(client, [pieces[0], pieces[2]], lambda: told.append(1))
    assert len(told) == 5 and len(list(tmp_path.glob("*.run"))) == 2
    assert [steps(f"half of {n}", forbidden) for n in (3, 4)] == [1.5, 2.0]
    with pytest.raises(gy.InputError, match="is negative"):
        steps("half of -1", forbidden)
    again = Steps(tmp_path, "given", ("gyroctl.errors",), ())
    assert again("half of 4", forbidden) == 2.0 and again("half of -1", lambda: 7.0) == 7.0


def test_what_is_kept_is_not_sent(local: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:  # noqa: F811
    steps = Steps(tmp_path, "given", ("gyroctl.errors",), ())
    steps("half of 3", lambda: 1.5)
    monkeypatch.setattr(ahead, "do_there", forbidden)
    with connected(local.scheduler_address) as client:
        do_ahead(client, [Piece(steps, "half of 3", half, (3.0,))])


def test_ensembles_of_the_paper_are_the_same_there(local: Any, device: gy.Plant) -> None:  # noqa: F811
    pairs, setup = [(0.052, 3.5e-4), (0.104, 2e-4)], Setup((1, 2), 150.0, quiet=True)
    here = ensemble(setup, device, 5.0, pairs, "here")
    with connected(local.scheduler_address) as client:
        there = ensemble(Setup((1, 2), 150.0, quiet=True, client=client), device, 5.0, pairs, "here")
    for pair in pairs:
        for one, other in zip(here[pair], there[pair], strict=True):
            np.testing.assert_array_equal(one, other)


def test_address_of_a_scheduler_is_met_before_any_work(tmp_path: Path, device: gy.Plant) -> None:
    asked = request(device, 0.2, 3.14, 0.052, 3.5e-4)
    for study in (
        lambda: margin_report(asked, tmp_path / "out", quiet=True, scheduler="tcp://host"),
        lambda: bound_report(device, gy.SeaState(), [1], 60.0, {}, tmp_path / "out", quiet=True, scheduler="host:1"),
        lambda: reproduce(["fig8"], tmp_path / "out", True, scheduler="tcp://host"),
    ):
        with pytest.raises(gy.InputError, match="no address") as error:
            study()
        assert error.value.field == "scheduler" and not (tmp_path / "out").exists()


@pytest.mark.slow
def test_margins_are_measured_there_to_the_same_numbers(
    local: Any,  # noqa: F811
    tmp_path: Path,
    device: gy.Plant,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked = request(device, 0.2, 3.14, 0.052, 3.5e-4, law_name="load_angle")
    margin_report(asked, tmp_path / "here", 8, quiet=True)
    margin_report(asked, tmp_path / "there", 8, quiet=True, scheduler=local.scheduler_address)
    one, other = (json.loads((tmp_path / name / "margins.json").read_text()) for name in ("here", "there"))
    for name in ("constant_controls", "law", "maps", "orbit"):
        assert one[name] == other[name], name
    assert not other["failed"]
    stored = [{path.name for path in (tmp_path / name / "runs").glob("*.run")} for name in ("here", "there")]
    assert stored[0] == stored[1] and len(stored[0]) == 6
    monkeypatch.setattr("gyroctl.studies.margins.measures.constant_margins", forbidden)
    monkeypatch.setattr("gyroctl.studies.margins.mapped.map_controls", forbidden)
    margin_report(asked, tmp_path / "there", 8, quiet=True)


@pytest.mark.slow
def test_windows_are_searched_there_to_the_same_bound(local: Any, tmp_path: Path, device: gy.Plant) -> None:  # noqa: F811
    effort, laws = replace(quick_effort(device), rounds=1, iterations=20, polish=10), {"coupling": gy.law("coupling")}
    how: dict[str, Any] = {"effort": effort, "quiet": True}
    here = bound_report(device, gy.SeaState(), [1, 2], 40.0, laws, tmp_path / "here", **how)
    how["scheduler"] = local.scheduler_address
    there = bound_report(device, gy.SeaState(), [1, 2], 40.0, laws, tmp_path / "there", **how)
    assert here["windows"] == there["windows"] and len(here["windows"]) == 2 and not there["failed"]
    again = bound_report(device, gy.SeaState(), [1, 2], 40.0, laws, tmp_path / "there", **(how | {"scheduler": None}))
    assert again["windows"] == here["windows"]


def test_ensembles_use_the_workers(monkeypatch: pytest.MonkeyPatch, local: Any, device: gy.Plant) -> None:  # noqa: F811
    sent: list[str] = []

    def noted(client: Any, pieces: Any, done: Any) -> None:
        sent.extend(piece.name for piece in pieces)
        do_ahead(client, pieces, done)

    monkeypatch.setattr(ensembles, "do_ahead", noted)
    with connected(local.scheduler_address) as client:
        ensemble(Setup((1,), 120.0, quiet=True, client=client), device, 5.0, [(0.052, 3.5e-4)], "there")
    assert sent == ["pair 0"]
