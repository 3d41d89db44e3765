"""Every margin of a scheduled law's table, put into the nonlinear loop of its cell: stable at .95, unstable at 1.05."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import pytest
from numba import njit

import gyroctl as gy
from gyroctl.controllers.gain_scheduled.cell import Filters
from gyroctl.controllers.gain_scheduled.margins import cell_loop
from gyroctl.controllers.gain_scheduled.scheduled import Scheduled
from gyroctl.controllers.gain_scheduled.table import read_table, row_of, table_file
from gyroctl.loop_margins.closed_loop_orbit import LoopOrbit
from gyroctl.loop_margins.trial import try_loop

NAMES = ("scheduled_lqr", "scheduled_lmi")
CELLS = 27
FAR = 12.0
"""A gain margin beyond this is not put to the test: some are about a hundred, where any loop saturates at once."""

SIZE = 1e-6
"""Of the disturbance: large beside the 1e-9 to which the orbit is known, also where it decays by a factor of twenty."""

compiled_step = njit(error_model="numpy")(Scheduled.step)


class Fast:
    """The law with its step compiled: a trial takes up to 16000 of them."""

    def __init__(self, law: Any) -> None:
        self.law, self.period = law, law.period

    def step(self, t: float, y: Any, state: Any) -> Any:
        return compiled_step(self.law, t, y, state)


def confirm(loop: LoopOrbit, margins: dict[str, Any]) -> list[tuple[str, str, float]]:
    """Try each finite margin on both sides of it; return those that were tried."""
    tried = []
    for channel, found in margins.items():
        low, high = found["gain"]
        limits = [("gain", low, -1), ("gain", high, 1), ("delay", found["delay"], 1)]
        for kind, value, outwards in limits:
            if not (math.isfinite(value) and value > 0.0) or (kind == "gain" and value > FAR):
                continue
            for factor in (0.95, 1.05):
                trial = try_loop(loop, channel, size=SIZE, **{kind: value * factor**outwards})
                assert trial.growth == pytest.approx(trial.predicted, rel=1e-3)
                if kind == "delay" and factor > 1.0 and trial.predicted < 1.0:  # stable again a little beyond
                    trial = try_loop(loop, channel, size=SIZE, delay=value * 1.02)
                    assert trial.growth == pytest.approx(trial.predicted, rel=1e-3)
                assert trial.stable == (factor < 1.0), (channel, kind, value, factor, trial.growth, trial.predicted)
            tried.append((channel, kind, value))
    return tried


def loop_in_table(device: gy.Plant, name: str, index: int) -> tuple[LoopOrbit, dict[str, Any]]:
    content = read_table(table_file(name))
    one = content["cells"][index]
    loop = cell_loop(device, one["wave_height"], one["frequency"], row_of(one), Filters(**content["filters"]))
    assert loop.status == "stable"
    return dataclasses.replace(loop, law=Fast(loop.law)), one["margins"]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "index"), [("scheduled_lqr", 13), ("scheduled_lmi", 19)])
def test_margins_of_a_cell_hold_in_the_nonlinear_loop(device: gy.Plant, name: str, index: int) -> None:
    loop, margins = loop_in_table(device, name, index)
    near = {channel: margins[channel] for channel in ("cg", "phi1_rate")}
    assert confirm(loop, near)


@pytest.mark.slow
@pytest.mark.parametrize("index", range(CELLS))
@pytest.mark.parametrize("name", NAMES)
def test_every_margin_of_every_cell_holds_in_the_nonlinear_loop(device: gy.Plant, name: str, index: int) -> None:
    assert len(read_table(table_file(name))["cells"]) == CELLS
    loop, margins = loop_in_table(device, name, index)
    far = all(found["gain"][1] > FAR and not math.isfinite(found["delay"]) for found in margins.values())
    assert confirm(loop, margins) or far
