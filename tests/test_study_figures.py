"""Figures of the studies in three forms: for the eye, as text that stays text, and for print."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from result_blocks import pictures

from gyroctl.studies.style import DENSE, FORMATS, label, save, sheet, styled, written
from gyroctl.version import VERSION

SVG = "{http://www.w3.org/2000/svg}"


def drawn(words: str = "mean power [W]", points: int = 50) -> Any:
    figure, (axes,) = sheet(1, 1, (5.0, 3.0), "A title", "a note")
    axes.plot(np.linspace(0.0, 1.0, points), np.random.default_rng(1).normal(size=points), label="a law")
    axes.legend(loc="upper right")
    label(axes, "", "time [s]", words)
    return figure


def texts_of(path: Path) -> str:
    return " ".join("".join(node.itertext()) for node in ElementTree.parse(path).iter(f"{SVG}text"))


def test_a_figure_is_written_in_all_forms_and_says_who_drew_it(tmp_path: Path) -> None:
    with styled():
        path = save(drawn(), tmp_path / "one.png")
    assert path == tmp_path / "one.png"
    assert sorted(tmp_path.iterdir()) == sorted(written(path)) == sorted(tmp_path / f"one.{form}" for form in FORMATS)
    with Image.open(path) as image:
        assert image.info["Software"] == f"gyroctl {VERSION}" and image.width == 800
    assert f"gyroctl {VERSION}" in (tmp_path / "one.svg").read_text(encoding="utf-8")
    assert f"gyroctl {VERSION}".encode() in (tmp_path / "one.pdf").read_bytes()


def test_text_stays_text_in_svg_and_fonts_are_embedded_as_truetype_in_pdf(tmp_path: Path) -> None:
    with styled():
        save(drawn(), tmp_path / "one.png")
    said = texts_of(tmp_path / "one.svg")
    assert all(words in said for words in ("A title", "a note", "a law", "time [s]", "mean power [W]"))
    content = (tmp_path / "one.pdf").read_bytes()
    assert b"/FontFile2" in content and b"/Subtype /Type3" not in content


def test_the_same_figure_is_the_same_file(tmp_path: Path) -> None:
    for folder in ("a", "b"):
        with styled():
            save(drawn(), tmp_path / folder / "one.png")
    for form in FORMATS:
        first, second = ((tmp_path / folder / f"one.{form}").read_bytes() for folder in ("a", "b"))
        assert first == second, form


@pytest.mark.slow
def test_long_series_are_pictures_within_svg_and_pdf_and_short_ones_are_lines(tmp_path: Path) -> None:
    for name, points in (("long", 4 * DENSE), ("short", 100)):
        with styled():
            save(drawn(points=points), tmp_path / f"{name}.png")
    assert (tmp_path / "long.svg").stat().st_size < 400_000 and (tmp_path / "long.pdf").stat().st_size < 400_000
    tags = {
        name: {node.tag for node in ElementTree.parse(tmp_path / f"{name}.svg").iter()} for name in ("long", "short")
    }
    assert f"{SVG}image" in tags["long"] and f"{SVG}image" not in tags["short"]
    assert "time [s]" in texts_of(tmp_path / "long.svg")


def test_names_from_outside_stay_text_in_every_form(tmp_path: Path) -> None:
    hostile = '</text><script>alert(1)</script> & "<b>'
    with styled(formulas=False):
        save(drawn(hostile), tmp_path / "one.png")
    tree = ElementTree.parse(tmp_path / "one.svg")
    assert not [node for node in tree.iter() if node.tag.endswith("script")]
    assert hostile in texts_of(tmp_path / "one.svg")


def test_a_figure_that_cannot_be_drawn_leaves_nothing_behind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    figure = drawn()

    def refuse(*_: Any, **__: Any) -> None:
        raise OSError("no space left")

    monkeypatch.setattr(type(figure), "savefig", refuse)
    with pytest.raises(OSError, match="no space"):
        save(figure, tmp_path / "one.png")
    assert not list(tmp_path.iterdir())


def test_panels_that_are_compared_have_one_scale() -> None:
    with styled():
        figure = pictures.PICTURES["docs/seas.png"].figure()
    assert len({(axes.get_xlim(), axes.get_ylim()) for axes in figure.axes}) == 1


def test_a_colour_that_changes_makes_pictures_of_the_pages_stale(monkeypatch: pytest.MonkeyPatch) -> None:
    import write_results

    before, read = write_results._key("docs/seas.png"), Path.read_bytes
    for file in (*pictures.LOOK, "studies/evaluation/draw.py", "docs/results/seas.json"):

        def changed(path: Path, file: str = file) -> bytes:
            return read(path) + (b"#" if path == write_results.ROOT / file else b"")

        with monkeypatch.context() as patch:
            patch.setattr(Path, "read_bytes", changed)
            assert write_results._key("docs/seas.png") != before, file
