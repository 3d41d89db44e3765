"""The part of the margin study on real water: what it keeps, what its picture shows, how it is asked for."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from command_line import Run

import gyroctl as gy
from gyroctl.errors import InputError
from gyroctl.statistics import wilson
from gyroctl.studies.margins import real_water, request
from gyroctl.studies.margins.drag_lock import Counted, Curve, DragLock
from gyroctl.studies.margins.draw_water import water
from gyroctl.studies.margins.water import ALL, ChoiceMargins
from gyroctl.studies.style import styled
from gyroctl.writing import Kept

LINEAR = ChoiceMargins("linear", "stable", 0.99, "horizontal", -0.002, 0.002, 1.2, 5e-3, 5e-3, "fold", 1.5, 0.04)
DRAG = ChoiceMargins("drag 0.5", "stable", 0.8, "horizontal", -0.09, 0.08, 1.2, 4.9e-3, 4.9e-3, "fold", -17.0)
LOCK = DragLock(
    0.04,
    1.2,
    1e-12,
    {"cc": 0.052, "height": 0.2},
    (
        Curve("cc", np.array([0.01, 0.052, 0.3]), np.array([0.12, 0.04, 0.0])),
        Curve("height", np.array([0.1, 0.2]), np.array([0.043, 0.04])),
    ),
)


def test_picture_shows_the_numbers() -> None:
    found = {"linear": LINEAR, "drag 0.5": DRAG, ALL: ChoiceMargins(ALL, "no orbit")}
    counted = [Counted(0.0, wilson(0, 16), 0.0, 1.6), Counted(0.5, wilson(16, 16), 0.0, 0.2)]
    with styled():
        figure = water(found, LOCK, counted, "a wave")
        figure.canvas.draw()
    fold, border, damping, over_cc, over_height, shares = figure.axes
    assert [bar.get_width() for bar in fold.patches] == pytest.approx([0.0, -2.0])
    assert [bar.get_width() for bar in border.patches] == pytest.approx([1.5, -17.0])
    assert [bar.get_width() for bar in damping.patches] == pytest.approx([0.2, 8.0])
    assert [text.get_text() for text in fold.get_yticklabels()] == list(found)
    assert any("no orbit" in text.get_text() for text in border.texts)
    for panel, line, at in ((over_cc, LOCK.curves[0], 0.052), (over_height, LOCK.curves[1], 0.2)):
        np.testing.assert_array_equal(panel.lines[0].get_ydata(), line.drag)
        assert (panel.lines[1].get_xdata()[0], panel.lines[1].get_ydata()[0]) == (at, 0.04)
    low, high = shares.get_ylim()
    assert low < 0.0 and high > 1.0
    with styled():
        assert len(water(found, None, [], "a wave").axes) == 3


def test_part_is_kept_choice_by_choice_and_a_failure_leaves_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, device: gy.Plant
) -> None:
    asked, kept, ticks = request(device, 0.2, 3.14, 0.052, 3.5e-4), Kept({}, tmp_path / "margins.json"), [0]
    names = ("linear", "drag 0.5", "drag 1")
    monkeypatch.setattr(real_water, "choices_of", lambda _: {name: {"bearing": 0.01} for name in names})
    written: list[list[str]] = []

    def of_choice(_: object, name: str) -> ChoiceMargins:
        path = tmp_path / "margins.json"
        written.append(list(json.loads(path.read_text())["water"]["choices"]) if path.exists() else [])
        if name == "drag 1":
            raise ArithmeticError("no such water")
        return {"linear": LINEAR, "drag 0.5": DRAG}[name]

    def locks(_: object) -> DragLock:
        raise InputError("cc", 0.3, "the lock needs neither drag nor hinge damping here", "Lower cc")

    monkeypatch.setattr(real_water, "of_choice", of_choice)
    monkeypatch.setattr(real_water, "drag_that_locks", locks)
    monkeypatch.setattr(real_water, "counted_in_a_sea", lambda _, drag: Counted(drag, wilson(15, 16), 0.5, 0.3))
    with styled():
        real_water.real_water(asked, "a wave", kept, lambda: ticks.__setitem__(0, ticks[0] + 1))
    found = json.loads((tmp_path / "margins.json").read_text())
    assert written == [[], ["linear"], ["linear", "drag 0.5"]]
    assert set(found["water"]["choices"]) == {"linear", "drag 0.5"}
    assert found["water"]["choices"]["drag 0.5"]["cc_border"] is None
    assert found["water"]["most"]["fold"] == "drag 0.5" and "Drag 0.5 alone" in found["water"]["words"]
    assert set(found["failed"]) == {"water.drag 1", "water.drag"}
    assert [run["locked"] for run in found["water"]["sea"]["runs"]] == [15, 15, 15]
    assert [run["drag"] for run in found["water"]["sea"]["runs"]] == [0.0, 0.5, 1.0]
    assert found["water"]["sea"]["hs_m"] == pytest.approx(0.2 * math.sqrt(2.0))
    assert "spent" in found["water"]["sea"]["seed_states"]
    assert ticks[0] == len(names) + 2


def test_choices_of_the_plant_are_asked_for_by_name(run: Run, tmp_path: Path) -> None:
    out = ("--out", str(tmp_path))
    code, _, error = run("margins", "--plant", "contact=friction", *out)
    assert code == 2 and "plant.smooth" in error
    code, _, error = run("margins", "--plant", "drag", *out)
    assert code == 2 and "--plant" in error
    code, _, error = run("lockmap", "--plant", "wetted=surface", *out)
    assert code == 2 and "plant.smooth" in error
    assert not list(tmp_path.iterdir())
