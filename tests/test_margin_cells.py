"""Whose number is whose in a margin report, and the margins that the table of a scheduled law carries."""

from __future__ import annotations

import math
from typing import Any

import pytest

import gyroctl as gy
from gyroctl.controllers.gain_scheduled import law_of, read_table, table_file
from gyroctl.controllers.supervisor import wrap
from gyroctl.devices.scaling import scaled_plant
from gyroctl.froude import growth
from gyroctl.harness.for_device import in_model_scale
from gyroctl.studies.margins import MarginResult, draw_orbit, find_orbit, request
from gyroctl.studies.margins.cells import KINDS, design_margins
from gyroctl.studies.margins.measures import LoopAnswer, Margins, linear_margins
from gyroctl.studies.margins.request import Request
from gyroctl.studies.margins.words import meanings

NAMES = ("scheduled_lqr", "scheduled_lmi")
WAVE = gy.Regular(0.25 / math.sqrt(2.0), 2.0 * math.pi / 2.2)


def asked_of(device: gy.Plant, law: str) -> Request:
    return request(device, WAVE.height, WAVE.wp, 0.052, 3.5e-4, law_name=law)


# --- whose number it is ------------------------------------------------------------------------------------------


def test_words_of_a_law_are_of_its_own_orbit(device: gy.Plant) -> None:
    asked = asked_of(device, "scheduled_lqr")
    orbit = find_orbit(asked)
    answer = linear_margins(orbit, asked)
    assert answer.status == "stable" and answer.loop is not None
    said = meanings(asked, orbit, None, answer, design_margins(asked))
    pair = said.pop("constant_controls")
    assert all(text.startswith("Law scheduled_lqr: ") for text in said.values())
    of_pair, of_law = (f"{100.0 * share:.3g} % of what" for share in (orbit.lock_share, answer.loop.lock_share))
    assert of_law in said["lock_reserve"] and of_pair in pair and of_pair not in str(said)
    assert 0.9 < answer.loop.lock_share < 1.0, "the share of the table at this bandwidth is 0.95"
    assert said["loop_margins"].startswith("Law scheduled_lqr: It is weakest at")


@pytest.mark.parametrize("answer", [None, LoopAnswer(None, None, "not periodic: it swings", "not periodic")])
def test_law_without_an_orbit_of_its_own_shows_no_number_as_its_own(
    device: gy.Plant, answer: LoopAnswer | None
) -> None:
    asked = asked_of(device, "scheduled_lqr")
    orbit = find_orbit(asked)
    said = meanings(asked, orbit, None, answer, design_margins(asked))
    pair = said.pop("constant_controls")
    for name in ("stability", "lock_reserve"):
        assert said[name].startswith("Law scheduled_lqr: Not known") and "%" not in said[name]
    assert f"{100.0 * orbit.lock_share:.3g} % of what" in pair
    if answer is not None:
        assert "cell margins" in said["loop_margins"]


def test_law_that_failed_is_not_given_the_numbers_of_the_constant_controls(device: gy.Plant) -> None:
    asked = asked_of(device, "scheduled_lqr")
    orbit, failed = find_orbit(asked), {"law": "RuntimeError: no more"}
    of_pair = Margins({}, {}, (), orbit.power)
    found = MarginResult(asked, orbit, of_pair, None, None, failed)
    assert found.margins is None and "power" not in found.meaning
    assert math.isnan(found.lock_reserve) and math.isnan(found.load_angle) and math.isnan(found.decay_time)
    assert "own orbit not known" in repr(found)


def test_constant_controls_alone_are_named(device: gy.Plant) -> None:
    asked = request(device, 0.2, 3.14, 0.052, 3.5e-4)
    said = meanings(asked, find_orbit(asked), None, None)
    assert set(said) == {"stability", "lock_reserve"}
    assert all(text.startswith("Constant controls: ") for text in said.values())


@pytest.mark.parametrize(
    ("name", "words"), [("", "stable; multipliers over"), ("law coupling", "none of the loop with the law coupling")]
)
def test_picture_of_the_multipliers_says_whose_they_are(device: gy.Plant, name: str, words: str) -> None:
    drawn = draw_orbit.multipliers(find_orbit(request(device, 0.2, 3.14, 0.052, 3.5e-4)), None, name, "point")
    note = " ".join(drawn._supxlabel.get_text().split())
    assert "dots: the orbit of the constant controls" in note and words in note
    assert drawn._suptitle.get_text() == "Floquet multipliers: constant controls"


# --- margins of the table ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_cells_are_those_of_the_table(device: gy.Plant, name: str) -> None:
    content = read_table(table_file(name))
    found = design_margins(asked_of(device, name))
    assert found is not None and found.differs == {} and found.plant == content["provenance"]["plant"]
    assert str([cell.margins for cell in found.cells]) == str([cell["margins"] for cell in content["cells"]])  # NaN
    for kind in KINDS:
        every = {
            (one["gain"][1] if kind == "gain" else one[kind], channel, i)
            for i, cell in enumerate(content["cells"])
            for channel, one in cell["margins"].items()
            if channel != "controls"
        }
        least = found.worst(kind)
        assert tuple(least) in every and least.value == min(value for value, _, _ in every)
    near = found.cells[found.nearest]
    assert near.bandwidth == min(content["nodes"]["bandwidth"]) and near.frequency in (2.7, 3.15)
    assert len(found.record()["cells"]) == len(content["cells"])


def test_cells_of_a_wrapped_and_of_a_scaled_law_are_found(device: gy.Plant) -> None:
    law, length = gy.law("scheduled_lqr"), 4.0
    asked = asked_of(device, "scheduled_lqr")
    plain = design_margins(asked)
    large, wave = scaled_plant(device, length), gy.Regular(length * WAVE.height, WAVE.wp / math.sqrt(length))
    scaled = Request(large, wave, 0.1, 0.1, 1, "x", in_model_scale(law, length))
    found = design_margins(scaled)
    assert plain is not None and found is not None and found.nearest == plain.nearest
    assert found.cells[0].height == pytest.approx(length * plain.cells[0].height)
    assert found.worst("delay").value == pytest.approx(growth("s", length) * plain.worst("delay").value)
    assert found.worst("disk") == plain.worst("disk")
    wrapped = Request(device, WAVE, 0.052, 3.5e-4, 1, "supervisor", wrap(law))
    assert str(design_margins(wrapped)) == str(plain)


def test_law_that_is_not_as_designed_says_so(device: gy.Plant) -> None:
    asked = request(device, 0.2, 3.14, 0.052, 3.5e-4, law_name="scheduled_lqr", parameters={"effort": 2.0})
    found = design_margins(asked)
    assert found is not None and found.differs == {"effort": 2.0}
    said = meanings(asked, find_orbit(asked), None, None, found)["cell_margins"]
    assert "not of this law, which runs with effort 2" in said


def test_law_of_a_table_of_ones_own_and_of_none(device: gy.Plant) -> None:
    content = read_table(table_file("scheduled_lqr"))
    cells = [{**cell, "point": {**cell["point"], "share": 0.5}} for cell in content["cells"]]
    own: Any = law_of({**content, "cells": cells})
    found = design_margins(Request(device, WAVE, 0.052, 3.5e-4, 1, "own", own))
    assert found is not None and {cell.share for cell in found.cells} == {0.5}
    unknown = own._replace(cells=tuple(0.5 * value for value in own.cells))
    for law in (unknown, gy.law("load_angle"), None):
        assert design_margins(Request(device, WAVE, 0.052, 3.5e-4, 1, "x", law)) is None
