"""Pictures and tables on a page: drawings in its colours and as wide as they were drawn, words at the left."""

from __future__ import annotations

import base64
import io
import re
import subprocess
import sys
from xml.etree import ElementTree

import matplotlib.pyplot as plt
import numpy as np
import pytest
from test_reports_pages import PIXEL

from gyroctl.reports.canvas import DESK, as_svg, look
from gyroctl.reports.page import DRAWN_MAX, LEAST, as_source, width_of
from gyroctl.reports.theme import DARK, LIGHT
from gyroctl.studies.evaluation.page import in_html

SVG = """<?xml version="1.0"?>
<svg width="90pt" height="45pt" viewBox="0 0 90 45" xmlns="http://www.w3.org/2000/svg">
<path d="M 0 0 L 9 9" style="fill: #ffffff"/><text style="font-size: 9px; fill: #1f2933">word</text></svg>
"""


def test_drawing_beside_a_picture_is_shown_as_an_image_and_follows_the_page_into_the_dark(tmp_path):
    (tmp_path / "a.png").write_bytes(PIXEL)
    assert as_source(tmp_path / "a.png").startswith("data:image/png;base64,")
    (tmp_path / "a.svg").write_text(SVG)
    source = as_source(tmp_path / "a.png")
    assert source.startswith("data:image/svg+xml;base64,")
    text = base64.b64decode(source.partition(",")[2]).decode()
    assert text.count("prefers-color-scheme: dark") == 1 and text.count("<svg") == 1
    assert f'[style*="fill: {LIGHT.ink.lower()}"]{{fill:{DARK.ink}!important}}' in text
    assert f'path[style*="fill: #ffffff"]{{fill:{DARK.card}!important}}' in text  # areas alone: white numbers stay
    (tmp_path / "a.svg").write_text(SVG + " " * DRAWN_MAX)
    assert as_source(tmp_path / "a.png").startswith("data:image/png;base64,")


def test_picture_is_as_wide_as_it_was_drawn(tmp_path):
    head = PIXEL[:16] + (2080).to_bytes(4, "big") + PIXEL[20:]
    (tmp_path / "a.png").write_bytes(head)
    assert width_of(tmp_path / "a.png") == round(13.0 * 72 * 1.15)  # 2080 dots are 13 in
    (tmp_path / "a.png").write_bytes(b"no picture")
    assert width_of(tmp_path / "a.png") == width_of(tmp_path / "missing.png") == LEAST


def test_columns_of_words_begin_at_the_left_and_those_of_numbers_end_at_the_right():
    text = (
        "| law | target | power | more |\n| --- | ---: | ---: | ---: |\n"
        "| a | met | 1.5 W | – |\n| b | open | – | > 3 |\n| c | – | −2 | ∞ |\n"
    )
    found = in_html(text, "T")
    heads = re.findall(r"<th([^>]*)>(\w+)</th>", found)
    assert [(name, "text" in more) for more, name in heads if "col" in more] == [
        ("law", True),
        ("target", True),
        ("power", False),
        ("more", False),
    ]
    assert [name for more, name in heads if "row" in more and "text" in more] == ["a", "b", "c"]
    assert re.findall(r'<td class="text">([^<]*)</td>', found) == ["met", "open", "–"]


@pytest.mark.parametrize("name", ["", "results.nc"])
def test_what_holds_no_results_is_refused_before_a_library_is_loaded(tmp_path, name):
    (tmp_path / "results.nc" if name else tmp_path / "notes.txt").write_text("no NetCDF")
    code = f"""
import sys
from gyroctl.cli.app import app
from gyroctl.errors import InputError
try:
    app(["report", {str(tmp_path / name)!r}], standalone_mode=False)
except InputError as error:
    print(error.field, *{{"scipy", "xarray", "matplotlib", "pandas"}} & set(sys.modules))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["results"]


def test_points_of_one_look_share_it_and_none_is_lost():
    """What a page of many runs weighs is its points."""
    colours, many = ["#009e73", "#d55e00"], 400
    figure, axes = plt.subplots()
    for k, colour in enumerate(colours):
        axes.plot(np.arange(many), np.arange(many) % 7 + k, "o", color=colour)
    axes.plot([1.0, 2.0], [9.0, 9.0], "s", color=colours[0])
    plain = io.StringIO()
    with look(DESK):
        figure.savefig(plain, format="svg")
        text = as_svg(figure, "key", "words")
    plt.close(figure)
    theirs = re.findall(r'<use xlink:href="#[^"]*" x="([^"]*)" y="([^"]*)" style="([^"]*)"', plain.getvalue())
    assert len(theirs) > 2 * many
    page = ElementTree.fromstring(text)
    above = {id(node): group for group in page.iter("g") for node in group}
    points = [node for node in page.iter("use") if node.get("x")]
    assert [tuple(node.get(name) for name in "xy") for node in points] == [
        tuple(f"{round(float(value), 2):.12g}" for value in (x, y)) for x, y, _ in theirs
    ]
    for node, (_, _, style) in zip(points, theirs, strict=True):
        if style.startswith("fill: #"):  # not of the page's own colours
            assert (node.get("style") or above[id(node)].get("style")) == style
    shapes = {node.get("id") for node in page.iter("path")}
    assert {node.get("href")[1:] for node in points} <= shapes
    assert sum(node.get("style") is None for node in points) >= 2 * many and len(text) < 60 * len(points) + 12_000


def test_letter_that_the_font_of_this_machine_lacks_is_no_word_of_a_command(recwarn):
    """The page has the text itself, and its browser another font."""
    figure, axes = plt.subplots()
    axes.set_title("\N{EGYPTIAN HIEROGLYPH A001} \N{SUBSCRIPT ONE}")
    with look(DESK):
        text = as_svg(figure, "key", "words")
    plt.close(figure)
    assert "\N{EGYPTIAN HIEROGLYPH A001}" in text and not recwarn.list
