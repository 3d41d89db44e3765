"""The pages that are shared: what is drawn and told of each law, what coincides, what lies beside, structure."""

from __future__ import annotations

import base64
import gzip
import json
import re
from html.parser import HTMLParser

import numpy as np
import pytest
from test_reports_synthetic import CHARACTERS, save, synthetic
from typer.testing import CliRunner

from gyroctl.cli.app import app
from gyroctl.errors import InputError
from gyroctl.reports import evaluate, write_report
from gyroctl.reports.beside import look_beside
from gyroctl.reports.canvas import DESK, TELEPHONE, as_svg, look
from gyroctl.reports.coinciding import groups, idle_wrappers
from gyroctl.reports.figures import survival
from gyroctl.reports.labels import Box, place_freely
from gyroctl.reports.law_section import sections
from gyroctl.reports.panel import Line
from gyroctl.reports.pareto import pareto
from gyroctl.reports.timeseries import LEVELS, UNKNOWN, closer_look, in_steps, time_series
from gyroctl.simulation.effort import effort
from gyroctl.simulation.lock import load_angle, load_share
from gyroctl.studies.evaluation.page import in_html

PIXEL = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="
)
SIGNAL = {"gain": [0.0, 7.25], "phase_deg": 61.5, "delay_s": None, "disk_alpha": 0.93}
CELL = {
    "envelope_rad_s": 0.15,
    "frequency_rad_s": 3.15,
    "bandwidth": 0.5,
    "wave_height_m": 0.125,
    "lock_share": 0.85,
    "least": {"gain": {"value": 7.25, "channel": "cg"}, "delay": {"value": None, "channel": "cg"}},
    "margins": {"cg": SIGNAL},
}
MARGINS = {
    "gyroctl_version": "0.1.0",
    "date": "2026-03-02",
    "versions": {"numpy": "2.0"},
    "request": {
        "device": "zhang2017 corrected",
        "wave": {"height_m": 0.2, "wp_rad_s": 3.14},
        "controls": {"cc_nms": 0.052, "cg_nms": 3.5e-4},
        "law": {"name": "load_angle", "share": 0.35},
    },
    "orbit": {"status": "stable"},
    "meaning": {"stability": "The locked orbit is <stable>.", "cg_headroom": "cg may be raised by 8.5 dB."},
    "not_available": [],
    "figures": ["nyquist.png"],
    "sea": {"words": "Hs 0.283 m, Tp 2 s", "wave": "of height Hs/sqrt 2"},
    "constant_controls": {"headroom": {"cg": {"value": 3.5e-4, "limit": 5.19e-3, "decibel": 23.4, "ending": "fold"}}},
    "law": {
        "headroom": {"cg": {"value": 1.0, "limit": 2.66, "decibel": 8.5, "ending": "fold"}},
        "linear": {"channels": {"cg": {"gain": [0.0, 3.2], "phase_deg": 41.5, "delay_s": 0.12, "disk": 0.61}}},
        "cells": {"design_plant": "a plant", "method": "LQR", "differs": {}, "nearest": 0, "cells": [CELL]},
    },
}


class Structure(HTMLParser):
    """Elements of a page that a reader without a mouse or without eyes goes by."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))

    def of(self, *tags: str) -> list[dict[str, str | None]]:
        return [attrs for tag, attrs in self.found if tag in tags]


def margins_in(folder):
    """Margin study of the law load_angle in a folder."""
    folder.mkdir(parents=True)
    (folder / "margins.json").write_text(json.dumps(MARGINS))
    (folder / "nyquist.png").write_bytes(PIXEL)
    return folder


def evaluation_in(folder):
    """Table of an evaluation in a folder."""
    folder.mkdir(parents=True)
    power = {"value": 4.4, "low": 4.0, "high": 4.8}
    row = {"law": "load_angle", "power": power, "ratio": power, "locked": 8, "in_step": 7, "runs": 8, "turns_kept": 1.0}
    content = {"table": "robustness", "title": "Devices", "date": "2026-03-02", "cases": {"k1 -20 %": [row]}}
    (folder / "robustness.json").write_text(json.dumps(content))
    table = "| law | power [W] |\n| --- | ---: |\n| load_angle | 4.4 |\n"
    text = f"# Devices\n\n![Devices](robustness.png)\n\n## Cases\n\n{table}"
    (folder / "robustness.md").write_text(text)
    (folder / "robustness.png").write_bytes(PIXEL)
    return folder


def supervised(starts: float = 0.0):
    """Comparison in which the last law wraps another one, with its runs."""
    ds = synthetic(("best_constant", "load_angle", "coupling", "constant"))
    for values in ds.data_vars.values():
        if "law" in values.dims and values.dtype.kind != "U":
            values.loc[{"law": "coupling"}] = values.sel(law="load_angle").values
    ds["starts"] = (("law", "realisation"), np.zeros((4, 8)))
    ds["starts"].loc[{"law": "coupling"}] = starts
    ds.attrs["parameters"] = json.dumps(
        {"load_angle": {"share": 0.3}, "coupling": {"patience": 60.0, "law_share": 0.3}}
    )
    return ds


# --- weight ---------------------------------------------------------------------------------------------------------


def test_line_in_steps_keeps_its_least_and_greatest_value_and_its_gaps():
    line = np.array([0.1, -3.75, np.nan, 12.5, 0.2])
    steps, (low, high) = in_steps(line)
    assert (low, high) == (-3.75, 12.5)
    assert (steps[1], steps[3], steps[2]) == (0, LEVELS, UNKNOWN)
    back = low + (high - low) * steps[[0, 4]] / LEVELS
    np.testing.assert_allclose(back, [0.1, 0.2], atol=(high - low) / LEVELS)


def test_closer_look_holds_every_peak_of_every_law():
    ds = synthetic(duration=2000.0)
    ds["example_power"].loc[{"law": "coupling"}][777] = 99.5  # a peak of one sample, far from the middle
    found = evaluate(ds)
    packed = closer_look(ds, found)
    head = packed["head"]
    lines = np.frombuffer(gzip.decompress(base64.b64decode(packed["text"])), "<u2").reshape(-1, len(head["time"]))
    assert len(lines) == len(head["ranges"]) == 1 + 7 * 4
    at = 1 + head["laws"].index("coupling")
    low, high = head["ranges"][at]
    assert high == 99.5 and lines[at].max() == LEVELS and lines[at].min() == 0
    assert abs(head["time"][int(lines[at].argmax())] - 77.7) < 5.0
    assert low == float(ds["example_power"].sel(law="coupling").min())


@pytest.mark.slow
def test_page_of_eleven_laws_is_no_larger_than_four_megabytes(tmp_path):
    ds = synthetic(tuple(CHARACTERS), duration=2000.0).isel(law=[0, 1, 2, 3, 4, 5, 1, 2, 3, 4, 5])
    ds = ds.assign_coords(law=["best_constant", *(f"law_{k}" for k in range(1, 11))])
    assert write_report(ds, tmp_path / "report.html").stat().st_size <= 4_000_000


# --- what coincides -------------------------------------------------------------------------------------------------


def test_laws_that_all_hold_lock_share_one_line():
    ds = synthetic(lock=1.0)
    with look(DESK):
        drawing = survival(ds, evaluate(ds), DESK)
    assert [key.label for key in drawing.keys] == ["all laws: 8/8 held lock"]
    assert len(drawing.figure.axes[0].lines) == 1


def test_laws_that_lose_lock_at_other_times_have_lines_of_their_own():
    ds = synthetic(lock=0.0)
    with look(DESK):
        drawing = survival(ds, evaluate(ds), DESK)
    assert len(drawing.keys) == len(drawing.figure.axes[0].lines) == 4
    assert groups([np.array([1.0]), np.array([2.0]), np.array([1.0])]) == [[0, 2], [1]]


@pytest.mark.slow
def test_wrapper_that_did_nothing_is_said_and_not_drawn(tmp_path):
    ds = supervised()
    assert idle_wrappers(ds) == {"coupling": "load_angle"}
    page = write_report(ds, tmp_path / "report.html").read_text(encoding="utf-8")
    assert "coupling did nothing in any run" in page
    assert not re.search(r'<h3 id="law-\d+"><span[^>]*></span>coupling</h3>', page)
    assert "load_angle = coupling" not in page


@pytest.mark.parametrize("change", ["it acted", "other numbers", "no wrapper"])
def test_law_that_differs_is_drawn(change):
    ds = supervised(starts=1.0 if change == "it acted" else 0.0)
    if change == "other numbers":
        ds["phi1_p98"].loc[{"law": "coupling", "realisation": 3}] += 1e-9
    if change == "no wrapper":
        ds.attrs["parameters"] = json.dumps({"coupling": {"share": 0.3}})
    assert idle_wrappers(ds) == {}


# --- pictures -------------------------------------------------------------------------------------------------------


def test_names_find_free_places_or_none():
    area = Box(0.0, 200.0, 0.0, 100.0)
    points = [(100.0, 50.0), (104.0, 52.0), (98.0, 47.0)]
    found = place_freely(points, [(60.0, 14.0)] * 3, [], area)
    boxes = [box for box in found if box is not None]
    assert len(boxes) == 3
    assert not any(a.overlap(b) for k, a in enumerate(boxes) for b in boxes[:k])
    assert place_freely([(5.0, 5.0)], [(300.0, 14.0)], [], area) == [None]


@pytest.mark.parametrize("paper", [DESK, TELEPHONE], ids=["desk", "telephone"])
def test_points_of_the_pareto_plot_are_the_means_of_the_laws(paper):
    ds = synthetic(tuple(CHARACTERS))
    with look(paper):
        figure = pareto(ds, evaluate(ds), paper).figure
    drawn = {
        tuple(line.get_xydata()[0]) for line in figure.axes[0].lines if line.get_marker() not in ("None", None, "")
    }
    means = zip(ds["power_cv"].mean("realisation").values, ds["mean_power"].mean("realisation").values, strict=True)
    for cv, power in means:
        assert any(cv == pytest.approx(x) and power == pytest.approx(y) for x, y in drawn)


def test_load_share_is_drawn_with_all_its_values():
    ds = synthetic()
    ds["example_load_share"].loc[{"law": "load_angle"}] = np.linspace(0.0, 4000.0, ds.sizes["time"])
    panel = time_series(ds, evaluate(ds), DESK).figure.panels[-1]
    top = max(float(np.max(line.y)) for line in panel.drawn if isinstance(line, Line))
    assert panel.y.high >= top > 1000.0
    assert panel.y.low <= 0.0


def test_markup_and_formulas_in_a_name_are_text_in_a_picture():
    ds = synthetic().assign_coords(law=["best_constant", "<b>$x^2$</b>", "#1f2933 2.34567", "a&b"])
    with look(DESK):
        text = as_svg(pareto(ds, evaluate(ds), DESK).figure, "key", '"><script>')
    assert "&lt;b&gt;$x^2$&lt;/b&gt;" in text and "#1f2933 2.34567" in text and "a&amp;b" in text
    assert "<b>" not in text and "<script>" not in text
    assert not re.search(r' id="(?!key-)', text)


# --- what is told of a law ------------------------------------------------------------------------------------------


def test_use_of_the_actuators_is_counted():
    cc = np.array([0.0, 0.3, 0.3, 0.0, 0.0])
    found = effort(np.stack([cc, np.full(5, 0.01)], axis=-1), (0.3, 0.02), 0.1)
    assert found["cc_mean"] == pytest.approx(0.12)
    assert found["cc_travel"] == pytest.approx(0.6 / 0.4)  # up and down in four steps
    assert (found["cc_moving"], found["cc_at_limit"], found["cc_at_zero"]) == (0.5, 0.4, 0.6)
    assert (found["cg_travel"], found["cg_moving"], found["cg_at_limit"], found["cg_at_zero"]) == (0.0, 0.0, 0.0, 0.0)


def test_load_angle_of_a_steady_lock_is_constant_and_its_pull_that_of_the_load_share():
    time, wp, angle, pull = np.arange(0.0, 40.0, 0.05), 3.14, -0.7, 0.8
    psi = wp * time
    turned = pull * np.exp(1j * (angle - psi))  # phi1' + i phi3' that exp(i psi) brings to rest
    found = load_angle(psi, turned.real, turned.imag, 0.05, wp)
    np.testing.assert_allclose(found, angle, atol=1e-9)
    share = load_share(psi, turned.real, turned.imag, np.full(time.size, 0.002), 0.05, wp, 0.01)
    np.testing.assert_allclose(share, 0.002 / (0.01 * pull), rtol=1e-9)


def test_section_of_a_law_says_what_a_load_share_above_one_means():
    ds = synthetic(("best_constant", "coupling"))
    ds["example_load_share"].loc[{"law": "coupling"}] = np.where(np.arange(ds.sizes["time"]) % 5 < 2, 1.7, 0.4)
    found = evaluate(ds)
    told = {one.law.name: one for one in sections(ds, found, found.by_power)}
    assert "above 1 for 40.0 % of the time" in told["coupling"].load_words
    assert "no overload in itself" in told["coupling"].load_words
    assert "no overload" not in told["best_constant"].load_words
    assert [tile.title for tile in told["coupling"].tiles][:2] == ["Distribution of the power", "Spectrum of the power"]


def test_use_of_the_actuators_is_of_all_runs_where_they_are_recorded():
    ds = synthetic(("best_constant", "coupling"))
    found = evaluate(ds)
    of_one = sections(ds, found, found.laws)[1].rows[0]
    values = {"mean": 0.15, "travel": 0.06, "moving": 0.5, "at_limit": 0.25, "at_zero": 0.125}
    for control in ("cc", "cg"):
        for what, value in values.items():
            ds[f"{control}_{what}"] = (("law", "realisation"), np.full((2, 8), value))
    ds.attrs["experiment"] = json.dumps(
        {**json.loads(ds.attrs["experiment"]), "actuators": {"cc_max": 0.3, "cg_max": 0.02}}
    )
    row = sections(ds, found, found.laws)[1].rows[0]
    assert of_one.mean != row.mean == 0.15
    assert (row.duty, row.travel) == pytest.approx((0.5, 12.0))
    assert (row.moving, row.at_limit, row.at_zero) == (0.5, 0.25, 0.125)


@pytest.mark.slow
def test_what_lies_beside_a_comparison_is_told_with_its_law(tmp_path):
    save(synthetic(), tmp_path / "results.nc")
    margins_in(tmp_path / "margins")
    evaluation_in(tmp_path / "evaluation")
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "margins.json").write_text("{")
    page = write_report(tmp_path, tmp_path / "report.html").read_text(encoding="utf-8")
    own = page[page.index("</span>load_angle</h3>") :]
    own = own[: own.index("</section>")]
    assert "Margins, from margins/margins.json" in own and "The locked orbit is &lt;stable&gt;." in own
    assert "Robustness, from evaluation/robustness.json" in own and "k1 -20 %" in own
    assert page.count("Margins, from margins/margins.json") == 1
    assert "other/margins.json" in page and look_beside(tmp_path).unread[0].startswith("other/margins.json")


# --- structure of the pages -----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def family(tmp_path_factory):
    """Pages of the family by their name."""
    folder = tmp_path_factory.mktemp("family")
    margins_in(folder / "m")
    evaluation_in(folder / "e")
    save(synthetic(), folder / "results.nc")
    for part in ("m", "e", "."):
        done = CliRunner().invoke(app, ["report", str(folder / part)])
        assert done.exit_code == 0, done.output
    names = {"comparison": "report.html", "margins": "m/margins.html", "evaluation": "e/evaluation.html"}
    return {name: (folder / file).read_text(encoding="utf-8") for name, file in names.items()}


@pytest.mark.parametrize("name", ["comparison", "margins", "evaluation"])
def test_page_can_be_read_without_eyes_and_mouse(family, name):
    page = re.sub(r"<script.*?</script>", "", family[name], flags=re.S)
    parts = Structure(page)
    assert all(head.get("scope") in ("col", "row") for head in parts.of("th"))
    scrolling = [one for one in parts.of("div") if one.get("class") == "scroll"]
    labels = [str(one["aria-label"]) for one in scrolling]
    assert labels and all(one.get("tabindex") == "0" and one.get("role") == "region" for one in scrolling)
    assert len(set(labels)) == len(labels)
    assert all(one.get("role") == "img" and one.get("aria-label") for one in parts.of("svg"))
    assert all(one.get("alt") for one in parts.of("img"))
    assert page.count("<figcaption") == page.count("<figure") >= 1
    anchors = {one["id"] for one in parts.of("h2", "h3") if "id" in one}
    listed = {str(one["href"])[1:] for one in parts.of("a") if one.get("class") != "skip"}
    assert anchors == listed and len(anchors) >= 2
    identifiers = [attrs["id"] for _, attrs in parts.found if "id" in attrs]
    assert len(set(identifiers)) == len(identifiers)
    first = next(attrs for tag, attrs in parts.found if tag in ("a", "button", "summary"))
    assert first["href"] == "#content" and any(one.get("id") == "content" for one in parts.of("main"))
    assert not re.search(r"""(?:src|href)\s*=\s*["']?(?:https?:)?//|url\(http|@import""", page)


def test_margins_page_has_the_numbers_of_its_file(family):
    page = family["margins"]
    for part in (
        "8.50",
        "2.66",
        "fold",
        "41.5",
        "0.610",
        "The locked orbit is &lt;stable&gt;.",
        "data:image/png;base64",
        "sea Hs 0.283 m, Tp 2 s",
        "times its own cg",
        "Nms",
        "Definitions",
        "re-locking does not undo it",
        "Of the law load_angle. Harmonic Nyquist plot",
        "61.5",
        "nearest",
    ):
        assert part in page
    assert page.count("7.25") == 2 and "85.0" in page and page.count("∞") >= 2


def test_table_of_an_evaluation_is_markup_of_ours_alone():
    text = "# T\n\n## Cases\n\n| law | power |\n| --- | ---: |\n| <img src=x onerror=a()> | [b](javascript:c) |\n"
    found = in_html(text, 'a "title"')
    assert "<img" not in found and "<a " not in found
    assert '<th scope="row" class="text">&lt;img' in found and 'aria-label="a &quot;title&quot;, table 1"' in found
    assert "<h3>Cases</h3>" in found and "<h2>" not in found


@pytest.mark.parametrize(
    ("file", "content"),
    [
        ("margins.json", "[]"),
        ("margins.json", '{"request": 3}'),
        ("site.json", '{"study": "site"}'),
        ("site.json", "{"),
    ],
)
def test_damaged_study_is_refused_by_name_and_leaves_nothing(tmp_path, file, content):
    (tmp_path / file).write_text(content)
    done = CliRunner().invoke(app, ["report", str(tmp_path)])
    assert isinstance(done.exception, InputError)
    assert done.exception.field == "results"
    assert [path.name for path in tmp_path.iterdir()] == [file]
