"""Panels: what is drawn stands where the numbers say, ticks are round, gaps stay gaps."""

from __future__ import annotations

import re

import numpy as np
import pytest

from gyroctl.reports.canvas import DESK, TILE, Room, panels
from gyroctl.reports.panel import Line, Mark, Panel, Scale, as_markup, held, in_digits, round_numbers, stairs

RED = "#cc0000"
ROOM = Room(left=50.0, right=20.0, top=10.0, bottom=40.0)


def drawn(x: Scale, y: Scale, *what: Line | Mark, title: str = "") -> str:
    """Panel of 250 px by 100 px, its lower left corner at (50, 110)."""
    return as_markup(panels(TILE, 100.0, [Panel(x, y, what, title)], ROOM), "alt")


def points(text: str, colour: str = RED) -> list[list[tuple[float, float]]]:
    """Corners of each path of a colour."""
    found = re.findall(rf'd="M([^"]*?)z?" style="(?:stroke|fill):{colour}', text)
    return [[tuple(map(float, pair.split())) for pair in path.split("L")] for path in found]


def test_a_point_stands_at_its_share_of_the_way():
    x, y = np.array([0.0, 2.0, 10.0]), np.array([0.0, 5.0, 10.0])
    assert points(drawn(Scale(0.0, 10.0, "x"), Scale(0.0, 10.0, "y"), Line(x, y, RED))) == [
        [(50.0, 110.0), (100.0, 60.0), (300.0, 10.0)]
    ]


def test_a_factor_of_ten_is_the_same_way_everywhere_on_a_logarithmic_axis():
    x = np.array([1.0, 10.0, 100.0])
    text = drawn(Scale(1.0, 100.0, "x", "log"), Scale(0.0, 2.0, "y"), Line(x, np.array([0.0, 2.0, 0.0]), RED))
    assert points(text) == [[(50.0, 110.0), (175.0, 10.0), (300.0, 110.0)]]


def test_an_axis_that_is_logarithmic_beyond_one_is_even_up_to_there_and_joins_without_a_step():
    scale = Scale(0.0, 1000.0, "", "log beyond 1")
    at = scale.share(np.array([0.0, 0.5, 1.0, 1.0 + 1e-9, 10.0, 100.0, 1000.0]))
    assert at[1] == pytest.approx(at[2] / 2.0)
    assert at[3] == pytest.approx(at[2])
    np.testing.assert_allclose(np.diff(at[3:]), at[4] - at[3])
    assert at[-1] == 1.0


def test_what_is_beyond_an_end_is_drawn_at_it():
    scale = Scale(1.0, 10.0, "", "log")
    assert scale.share(np.array([0.0, -5.0, 1e9])).tolist() == [0.0, 0.0, 1.0]


def test_a_gap_in_the_numbers_is_a_gap_in_the_line():
    y = np.array([0.0, 1.0, np.nan, 1.0, 0.0, np.nan, 1.0])
    text = drawn(Scale(0.0, 6.0, ""), Scale(0.0, 1.0, ""), Line(np.arange(7.0), y, RED))
    assert [len(path) for path in points(text)] == [2, 2]  # a lone point has no line


def test_points_that_turn_nothing_are_left_out_and_every_corner_is_kept():
    x = np.linspace(0.0, 10.0, 101)
    straight = points(drawn(Scale(0.0, 10.0, ""), Scale(0.0, 1.0, ""), Line(x, np.full(101, 0.5), RED)))
    assert straight == [[(50.0, 60.0), (300.0, 60.0)]]
    zigzag = np.tile([0.0, 1.0], 50)
    corners = points(drawn(Scale(0.0, 99.0, ""), Scale(0.0, 1.0, ""), Line(np.arange(100.0), zigzag, RED)))[0]
    assert len(corners) == 100
    there_and_back = points(
        drawn(Scale(0.0, 1.0, ""), Scale(0.0, 1.0, ""), Line(np.full(5, 0.5), np.array([0.0, 1.0, 1.0, 0.2, 0.2]), RED))
    )
    assert there_and_back == [[(175.0, 110.0), (175.0, 10.0), (175.0, 90.0)]]


def test_stairs_hold_each_count_between_its_edges_and_end_at_zero():
    x, y = stairs(np.array([2.0, 1.0]), np.array([0.0, 1.0, 3.0]))
    assert list(zip(x, y, strict=True)) == [(0, 0), (0, 2), (1, 2), (1, 1), (3, 1), (3, 0)]
    assert np.trapezoid(y, x) == 2.0 * 1.0 + 1.0 * 2.0


def test_a_held_line_stays_at_a_value_until_the_next():
    x, y = held(np.array([0.0, 1.0, 2.0]), np.array([5.0, 7.0, 9.0]))
    assert list(zip(x, y, strict=True)) == [(0, 5), (1, 5), (1, 7), (2, 7), (2, 9)]


def test_marks_go_from_end_to_end():
    text = drawn(Scale(0.0, 10.0, ""), Scale(0.0, 4.0, ""), Mark(5.0, RED), Mark(1.0, "#00cc00", level=True))
    assert f'd="M175 10V110" style="stroke:{RED}' in text
    assert 'd="M50 85H300" style="stroke:#00cc00' in text


@pytest.mark.parametrize(
    ("low", "high", "ticks"),
    [
        (0.0, 10.0, (0.0, 2.5, 5.0, 7.5, 10.0)),
        (-1.0, 1.0, (-1.0, -0.5, 0.0, 0.5, 1.0)),
        (947.0, 1063.0, (950.0, 1000.0, 1050.0)),
        (3.0, 3.0, (3.0,)),
    ],
)
def test_ticks_are_round_numbers(low, high, ticks):
    assert round_numbers(low, high, 4) == pytest.approx(ticks)


@pytest.mark.parametrize("power", range(-7, 8))
@pytest.mark.parametrize("most", [2, 4, 9])
def test_there_are_always_ticks_and_not_too_many(power, most):
    for begin, width in ((0.0, 1.0), (0.37, 2.9), (-3.1, 7.7)):
        low, high = begin * 10.0**power, (begin + width) * 10.0**power
        found = round_numbers(low, high, most)
        assert 1 <= len(found) <= most + 1
        assert low - 1e-9 * width * 10.0**power <= found[0] <= found[-1] <= high + 1e-9 * width * 10.0**power


def test_numbers_of_ticks_are_told_apart_with_one_number_of_decimals():
    assert in_digits((0.0, 0.25, 0.5)) == ["0.00", "0.25", "0.50"]
    assert in_digits((-0.002, 0.0, 0.002)) == ["\N{MINUS SIGN}0.002", "0.000", "0.002"]
    assert in_digits((950.0, 1000.0)) == ["950", "1000"]


def test_a_number_stands_at_the_place_of_its_tick():
    text = drawn(Scale(0.0, 10.0, "across [1]"), Scale(0.0, 4.0, "up [1]"))
    below = dict(re.findall(r'<text x="([\d.]+)" y="[\d.]+">([\d.]+)</text>', text))
    assert len(below) == 5
    assert all(float(x) == 50.0 + 25.0 * float(number) for x, number in below.items())


def test_names_are_text_and_the_picture_is_told_in_words():
    text = as_markup(
        panels(DESK, 50.0, [Panel(Scale(0, 1, "<b>"), Scale(0, 1, "a&b"), [], '"><script>')]), '"><script>'
    )
    assert "&lt;b&gt;" in text and "a&amp;b" in text and "<script>" not in text and "<b>" not in text
    assert re.match(r'<svg class="drawn" role="img" aria-label="&quot;&gt;&lt;script&gt;"', text)
