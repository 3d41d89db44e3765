"""The starts that ship: they close after one wave, are those of the search, and belong to one device and sea alone."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.harness import start
from gyroctl.harness.start import SHIPPED, equivalent, key_of, locked_start, search, ship, shipped
from gyroctl.orbits.flow import Forcing, flow
from gyroctl.plant.equations import OMEGA, PSI

VARIANTS = ("corrected", "paper")


@pytest.mark.parametrize("variant", VARIANTS)
def test_shipped_start_closes_after_a_wave(variant: str) -> None:
    """By the flow alone: the ring has turned once, the flywheel is wherever it is, all else is as it was."""
    plant = gy.zhang2017(variant)
    wave = equivalent(gy.SeaState())
    x, (cc, cg) = shipped()[key_of(plant, wave)]
    end = flow(plant, x, cc, cg, Forcing.of(plant, wave), 1.0)[: x.size]
    end[PSI] -= 2.0 * math.pi
    rows = np.arange(x.size) != OMEGA
    np.testing.assert_allclose(end[rows], x[rows], rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("variant", VARIANTS)
def test_shipped_start_is_the_one_that_is_found(variant: str) -> None:
    plant = gy.zhang2017(variant)
    wave = equivalent(gy.SeaState())
    (x, controls), (found, at) = shipped()[key_of(plant, wave)], search(plant, wave)
    assert controls == at
    np.testing.assert_allclose(x, found, rtol=1e-10, atol=1e-13)  # the C library's sine differs between machines


@pytest.mark.parametrize("variant", VARIANTS)
def test_default_sea_is_not_searched(variant: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: Any) -> None:
        raise AssertionError("it was searched")

    monkeypatch.setattr(start, "_found", {})
    monkeypatch.setattr(start, "search", refuse)
    for sea in (gy.SeaState(), gy.SeaState(gamma=1.0)):  # the wave of equal energy knows no shape
        assert locked_start(gy.zhang2017(variant), sea)[0].size == 14
    with pytest.raises(AssertionError):
        locked_start(gy.zhang2017(variant), gy.SeaState(hs=0.28))


def test_key_tells_every_device_and_wave() -> None:
    plant, wave = gy.zhang2017(), equivalent(gy.SeaState())
    keys = [key_of(plant, wave)]
    k = plant.coefficients
    for name in k._fields:
        value = getattr(k, name)
        if value is None:
            continue
        other = (value[0] + 1e-9, *value[1:]) if isinstance(value, tuple) else value + 1e-9
        changed = replace(plant)
        changed.__dict__["coefficients"] = k._replace(**{name: other})
        keys.append(key_of(changed, wave))
    keys += [key_of(plant, replace(wave, **{name: getattr(wave, name) + 1e-9})) for name in ("height", "wp", "heading")]
    keys += [key_of(gy.zhang2017(excitation_phase="magnitude"), wave)]
    assert len(set(keys)) == len(keys) > 20
    assert key_of(gy.zhang2017(drag=0.5), wave) == "" not in shipped()


def test_what_ships_is_what_is_written(tmp_path: Path) -> None:
    ship({f"zhang2017 {name}": (gy.zhang2017(name), gy.SeaState()) for name in VARIANTS}, tmp_path / "starts.json")
    written, here = (json.loads(file.read_text(encoding="utf-8")) for file in (tmp_path / "starts.json", SHIPPED))
    assert [one["key"] for one in written] == [one["key"] for one in here]
