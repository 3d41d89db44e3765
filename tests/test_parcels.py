"""Items on their way to a process: what they share is packed once, and found done by the next one."""

from __future__ import annotations

import pickle
from typing import Any

import cloudpickle
import pytest

import gyroctl as gy
from gyroctl.comparison import execution, items, parcels
from gyroctl.comparison.compare import Realisations
from gyroctl.harness.run import Settings
from gyroctl.waves import realisation

SEEDS = tuple(range(1, 5))


@pytest.fixture
def work(device: gy.Plant) -> list[items.Item]:
    law = gy.law("constant", cc=0.05, cg=2e-4)
    return items.work_items(device, {"pair": law}, Realisations(gy.SeaState(), SEEDS, 60.0), Settings(blend=20.0), 60.0)


def arrived(work: list[items.Item]) -> list[parcels.Parcel]:
    """Parcels as they come out of the pipe, one after the other."""
    return [pickle.loads(pickle.dumps(one)) for one in parcels.parcels(work, cloudpickle.dumps(work[0].law))]


def test_the_sea_is_prepared_once_for_all_that_arrive(work: list[items.Item], monkeypatch: pytest.MonkeyPatch) -> None:
    prepared: list[Any] = []

    def counted(*arguments: Any) -> Any:
        prepared.append(arguments)
        return realisation_prepare(*arguments)

    realisation_prepare = realisation.prepare
    monkeypatch.setattr(realisation, "prepare", counted)
    monkeypatch.setattr(realisation, "_latest", None)
    found = [execution.perform_packed(parcel)[0] for parcel in arrived(work)]
    assert len(prepared) == 1
    monkeypatch.undo()
    for item, outcome in zip(work, found, strict=True):
        (here,) = items.perform([item])
        clocks = {"step_ms_median", "step_ms_p99"}
        assert outcome.sha256 == here.sha256 == item.sha256
        assert outcome.series.keys() == here.series.keys()
        assert {k: v for k, v in outcome.values.items() if k not in clocks} == pytest.approx(
            {k: v for k, v in here.values.items() if k not in clocks}, rel=0.0, abs=0.0, nan_ok=True
        )


def test_other_plants_and_seas_arrive_as_themselves(work: list[items.Item], device: gy.Plant) -> None:
    heavier, calm = device.replace(d1=3.0), Realisations(gy.SeaState(hs=0.1), SEEDS, 60.0)
    law, settings = work[0].law, work[0].settings
    others = [
        items.work_items(*each, settings, 60.0)[0]
        for each in ((heavier, {"pair": law}, work[0].waves), (device, {"pair": law}, calm))
    ]
    sent = [work[0], others[0], work[1], others[1]]
    opened = [parcels.opened(parcel, law) for parcel in arrived(sent)]
    assert [one.key for one in opened] == [one.key for one in sent]
    assert [one.plant.parameters for one in opened] == [one.plant.parameters for one in sent]
    assert [one.waves for one in opened] == [one.waves for one in sent]


def test_what_is_not_shared_is_small(work: list[items.Item]) -> None:
    """A plant has its tables with it; they are in one message once, however many items it brings."""
    one, all_of_them = arrived(work)[0], tuple(parcels.parcels(work, b""))
    assert len(pickle.dumps(one.item)) < 2000
    assert len(pickle.dumps(all_of_them)) < len(one.shared) + 2000 * len(work)
