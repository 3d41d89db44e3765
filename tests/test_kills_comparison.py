"""Fairness by hand: whose waves, whose number, and what a stored result rests on."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.comparison import items
from gyroctl.comparison.compare import Realisations, check_fair, compare
from gyroctl.comparison.items import Outcome, perform, work_items
from gyroctl.harness.run import Settings

SETTINGS = Settings(blend=20.0)
WAVES = Realisations(gy.SeaState(), (100011, 100005, 100008, 100003), 60.0)
LAWS = {"weak": gy.law("constant", cg=1e-4), "strong": gy.law("constant", cg=3e-4)}


def test_every_number_stands_at_its_law_and_its_seed(device: gy.Plant) -> None:
    ds = compare(device, LAWS, WAVES, SETTINGS, workers=1, quiet=True, tuning_seeds=())
    assert ds.realisation.values.tolist() == list(WAVES.seeds)
    for item in work_items(device, LAWS, WAVES, SETTINGS, 60.0):
        (alone,) = perform([item])
        stands = ds.sel(law=item.name, realisation=item.seed)
        for name in ("mean_power", "phi1_p98", "phi3_p98", "wave_input_w", "cycle_slips"):
            assert float(stands[name]) == alone.values[name], (item.name, item.seed, name)
        assert str(stands.sha256.values) == alone.sha256
    assert np.unique(ds.mean_power.values).size == 8, "no two of them are alike"


def test_slips_go_by_the_waves_on_phi3(device: gy.Plant, monkeypatch: pytest.MonkeyPatch) -> None:
    """phi3 drives the ring: the phase of the waves is that of its moment."""
    seen: list[Any] = []
    plain = items.evaluate

    def noting(plant: gy.Plant, record: Any, moment: Any, *rest: Any, **more: Any) -> Any:
        seen.append(moment)
        return plain(plant, record, moment, *rest, **more)

    monkeypatch.setattr(items, "evaluate", noting)
    perform(work_items(device, LAWS, WAVES, SETTINGS, 60.0)[:1])
    waves = WAVES.at(device, WAVES.seeds[0], SETTINGS)
    np.testing.assert_array_equal(seen[0], waves.moments[1])


def outcome(sha256: str) -> Outcome:
    return Outcome(sha256, {}, {})


@pytest.mark.parametrize("at", [0, 1, 2])
@pytest.mark.parametrize("foreign", ["0", "z"])
def test_other_waves_at_any_place_are_refused(at: int, foreign: str) -> None:
    same = [outcome(name) for name in "abc"]
    other = [*same[:at], outcome(foreign), *same[at + 1 :]]
    check_fair({"first": same, "second": same})
    with pytest.raises(gy.InputError, match="differs"):
        check_fair({"first": same, "second": other})


@pytest.mark.parametrize("seeds", [(1, 2, 1), (1, 2, 100200)], ids=["repeated", "kept for tuning, the last"])
def test_seeds_that_repeat_or_were_tuned_on_are_refused(device: gy.Plant, seeds: tuple[int, ...]) -> None:
    with pytest.raises(gy.InputError, match=r"run\.seeds"):
        compare(device, LAWS, replace(WAVES, seeds=seeds), SETTINGS, tuning_seeds=[100200], quiet=True)


def keys(device: gy.Plant, laws: Any = None, waves: Realisations = WAVES, settings: Settings = SETTINGS) -> set[str]:
    return {item.key for item in work_items(device, laws or {"weak": LAWS["weak"]}, waves, settings, 60.0)}


def test_key_of_a_result_knows_all_that_it_rests_on(device: gy.Plant, monkeypatch: pytest.MonkeyPatch) -> None:
    known = keys(device)
    assert len(known) == len(WAVES.seeds) and keys(device) == known
    assert not known & keys(device, {"weak": LAWS["strong"]}), "the law, whatever its name"
    assert keys(device, {"another name": LAWS["weak"]}) == known
    assert not known & keys(device.replace(d1=1.9))
    assert not known & keys(device, waves=replace(WAVES, sea=gy.SeaState(hs=0.3)))
    assert not known & keys(device, settings=replace(SETTINGS, dt=0.005))
    floating = device.replace(drag=0.5)
    assert floating.geometry is not None
    denser = floating.replace(geometry=replace(floating.geometry, g=9.8))
    assert not keys(floating) & keys(denser), "float and water where they act"
    monkeypatch.setattr(items, "code_of", lambda *modules: "other code")
    assert not known & keys(device)


def test_stored_results_are_each_item_s_own(device: gy.Plant, tmp_path: Path) -> None:
    first = compare(device, LAWS, WAVES, SETTINGS, workers=1, results=tmp_path, quiet=True, tuning_seeds=())
    again = compare(device, LAWS, WAVES, SETTINGS, workers=1, results=tmp_path, quiet=True, tuning_seeds=())
    np.testing.assert_array_equal(first.mean_power.values, again.mean_power.values)
    assert first.sha256.values.tolist() == again.sha256.values.tolist()


def test_capture_width_is_over_the_length_of_the_float(device: gy.Plant) -> None:
    """Crests run along the lever, and so does the capsule: its diameter and its cylinder."""
    from gyroctl.waves import prepare
    from gyroctl.waves.energy import wave_power

    item = work_items(device, LAWS, WAVES, SETTINGS, 60.0)[0]
    per_metre = wave_power(prepare(device, WAVES.sea, WAVES.duration, WAVES.dt), device.depth)
    assert item.available == pytest.approx(per_metre * (0.550 + 0.080))
