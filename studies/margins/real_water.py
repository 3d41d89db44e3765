"""The part of the margin study on real water: one choice after another, the drag that locks, and the picture."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gyroctl.harness.seed_ledger import ledger
from gyroctl.studies.margins.drag_lock import (
    GAMMA,
    SEEDS,
    Counted,
    DragLock,
    counted_in_a_sea,
    drag_that_locks,
    drags_to_count,
    duration_of,
)
from gyroctl.studies.margins.draw_water import water
from gyroctl.studies.margins.measures import Tick
from gyroctl.studies.margins.request import Request
from gyroctl.studies.margins.water import CHOICES, ChoiceMargins, choices_of, in_words, most, of_choice
from gyroctl.writing import Kept

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WATER_STAGES = len(CHOICES) + 3
"""How often the part tells that it goes on."""


def real_water(asked: Request, point: str, kept: Kept, tick: Tick) -> Figure:
    """Measure each choice, keep what is finished under ``water``, and draw it.

    Parameters
    ----------
    asked : Request
        Device, wave and controls; of the device what is linear.
    point : str
        Wave and controls in words.
    kept : Kept
        The report; a choice that fails is named there, and the others go on.
    tick : callable
        Called after each choice.
    """
    content: dict[str, Any] = {"choices": {}}
    kept.content["water"] = content
    found: dict[str, ChoiceMargins] = {}
    for name in choices_of(asked.plant):
        with kept.stage(f"water.{name}"):
            found[name] = of_choice(asked, name)
            content["choices"][name] = found[name].record()
        tick()
    content |= {"most": most(found), "words": in_words(found)}
    lock: DragLock | None = None
    with kept.stage("water.drag"):
        lock = drag_that_locks(asked)
        content["drag_that_locks"] = lock.record()
        content["words"] += f" {lock.in_words()}"
    tick()
    counted: list[Counted] = []
    with kept.stage("water.sea"):
        content["sea"] = {"gamma": GAMMA, "hs_m": asked.wave.hs, "duration_s": duration_of(asked), "seeds": list(SEEDS)}
        content["sea"] |= {"seed_states": ledger().states(SEEDS), "runs": []}
        for drag in drags_to_count(lock.drag if lock is not None else 0.0):
            counted.append(counted_in_a_sea(asked, drag))
            content["sea"]["runs"].append(counted[-1].record())
    tick()
    return water(found, lock, counted, point, asked.plant.parameters.length_scale)
