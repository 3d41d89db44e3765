"""What objects tell of themselves: a few lines, a card with a picture, escaped, and no stored result rests on it."""

from __future__ import annotations

import ast
import html.parser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import gyroctl as gy
from gyroctl.comparison.labelled import Comparison
from gyroctl.faces.show import Face, as_html, as_text, shown
from gyroctl.faces.svg import bars, curves
from gyroctl.fingerprint.rests_on import LOOKS, rooms_of
from gyroctl.harness.registry import registered
from gyroctl.hydrodynamics.database import shipped
from gyroctl.simulation.labelled import Trajectory
from gyroctl.waves import Bichromatic, DriftingSea, SpreadSea, TurningSea, TwoPeaks

HOSTILE = '"><script>alert(1)</script><img src=x onerror=alert(2)>\x1b[31m'


def comparison(laws: tuple[str, ...] = ("best_constant", "coupling", "mine"), runs: int = 4) -> Comparison:
    """A comparison as `gyroctl.compare` labels it, in its leading variables."""
    rng = np.random.default_rng(3)
    shape, dims = (len(laws), runs), ("law", "realisation")
    data: dict[str, Any] = {
        name: (dims, rng.uniform(low, high, shape), {"units": unit})
        for name, low, high, unit in (
            ("mean_power", 1.0, 5.0, "W"),
            ("power_cv", 0.1, 0.5, "1"),
            ("phi1_p98", 0.2, 0.3, "rad"),
            ("phi3_p98", 0.2, 0.3, "rad"),
        )
    }
    data["locked"] = (dims, rng.uniform(0.0, 1.0, shape) > 0.3)
    told = {"plant": "zhang2017 corrected", "duration": 2000.0, "hs": 0.283, "wp": 3.14, "motion_limit": 0.35}
    return Comparison(data, {"law": list(laws), "realisation": np.arange(runs)}, told)


def trajectory(law: str = "coupling") -> Trajectory:
    """A run as `gyroctl.simulate` labels it, in its leading variables."""
    time = np.arange(400) * 0.1
    names = ("elevation", "psi_rate", "phi1", "phi3", "cc", "cg", "power")
    data = {name: ("time", i + np.sin(3.14 * time)) for i, name in enumerate(names)}
    return Trajectory(data, {"time": time}, {"law": law, "seed": 1, "hs": 0.283, "wp": 3.14, "plant": "zhang2017"})


@pytest.fixture(scope="module")
def objects(device: gy.Plant) -> dict[str, Any]:
    """One of each kind that tells itself."""
    orbit = gy.lock_orbit(device, gy.Regular(0.2, 3.14), 0.052, 3.5e-4)
    model = orbit.linearise()
    sea = gy.SeaState()
    omega = np.linspace(1.0, 6.0, 60)
    seas: list[Any] = [sea, gy.Regular(0.2, 3.14), Bichromatic((0.1, 0.05), (3.0, 3.4)), DriftingSea(), TwoPeaks()]
    seas += [TurningSea(), SpreadSea(sea), gy.TabulatedSpectrum(omega, sea.spectrum(omega))]
    seas += [gy.ElevationRecord(np.arange(600) * 0.5, 0.1 * np.sin(1.5 * np.arange(600)))]
    laws = {name: gy.law(name) for name in registered()}
    return {
        "plant": device,
        "realistic plant": gy.zhang2017("realistic"),
        "parameters": device.parameters,
        "excitation": device.excitation,
        "hydrodynamics": shipped(),
        **{f"{type(each).__name__}": each for each in seas},
        "realisation": gy.realise(device, sea, 1, 50.0),
        "orbit": orbit,
        "mode": orbit.modes[0],
        "model": model,
        "averaged": model.averaged(),
        "lifted": model.lifted(),
        "harmonic": model.harmonic(),
        "settings": gy.Settings(),
        "sensors": gy.Sensors(),
        **{f"law {name}": law for name, law in laws.items()},
        "law from a function": gy.law_from(lambda y: (0.06, 1e-4 * y.psi_rate)),
        "trajectory": trajectory(),
        "comparison": comparison(),
    }


class Reader(html.parser.HTMLParser):
    """Names of the elements of a text, and whether each is closed in its turn."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.seen: list[str] = []
        self.attributes: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.open.append(tag)
        self.seen.append(tag)
        self.attributes += [name for name, _ in attrs]

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.seen.append(tag)
        self.attributes += [name for name, _ in attrs]

    def handle_endtag(self, tag: str) -> None:
        assert self.open and self.open.pop() == tag


def read(text: str) -> Reader:
    """Read HTML whose elements must all be closed."""
    reader = Reader()
    reader.feed(text)
    reader.close()
    assert reader.open == []
    return reader


KNOWN = {"div", "strong", "table", "tbody", "tr", "th", "td"}
KNOWN |= {"svg", "title", "path", "text", "polyline", "circle", "rect"}


def test_repr_is_five_lines_at_most(objects: dict[str, Any]) -> None:
    for name, each in objects.items():
        lines = repr(each).splitlines()
        assert len(lines) <= 5 and all(len(line) <= 120 for line in lines) and len(repr(each)) > 15, name


def test_card_has_a_picture_that_says_what_it_shows_and_fetches_nothing(objects: dict[str, Any]) -> None:
    without = {"parameters", "settings", "sensors"}  # rows of numbers
    for name, each in objects.items():
        text = each._repr_html_()
        found = read(text)
        assert set(found.seen) <= KNOWN, name
        assert ("svg" in found.seen) == (name not in without), name
        assert "aria-label" in found.attributes or name in without
        assert not {"src", "href", "onerror", "onload"} & set(found.attributes) and "http" not in text
        assert len(text) < 12_000, name


def test_repr_tells_what_one_asks_first(objects: dict[str, Any]) -> None:
    orbit = objects["orbit"]
    for word in ("stable", "0.2 m", "cc 0.052", f"{orbit.power:.4g} W"):
        assert word in repr(orbit)
    assert "zhang2017 corrected" in repr(objects["plant"]) and "d1 2" in repr(objects["plant"])
    assert "50 s" in repr(objects["realisation"]) and objects["realisation"].sha256[:12] in repr(objects["realisation"])
    power = comparison().mean_power.values.mean(axis=1)
    name = str(comparison().law.values[power.argmax()])
    assert f"{name} {power.max():.3g} W" in " ".join(repr(comparison()).split())


def test_repr_of_a_sea_builds_it_again() -> None:
    """It stands in the record of results."""
    for sea in (gy.SeaState(0.2, 3.0, 2.0), gy.Regular(0.1, 3.0, 20.0)):
        assert eval(f"gy.{sea!r}") == sea


def test_names_from_outside_stay_text(device: gy.Plant) -> None:
    plant = device.replace(name=HOSTILE)
    for each in (plant, comparison((HOSTILE, "b")), trajectory(HOSTILE)):
        text = each._repr_html_()
        assert set(read(text).seen) <= KNOWN and "<script" not in text and "onerror=alert(2)>" not in text
        assert "\x1b" not in text + repr(each) and len(repr(each).splitlines()) <= 5
    for picture in (bars({HOSTILE: 1.0}, HOSTILE, ["red"]), curves([0, 1], {HOSTILE: [0, 1]}, HOSTILE, HOSTILE)):
        assert set(read(picture).seen) <= KNOWN and "<script" not in picture


def test_what_cannot_be_told_does_not_raise() -> None:
    @shown(lambda it: Face("it", [("value", str(it.value))]))
    class Half:
        """No member `value`."""

    assert "cannot be shown" in repr(Half()) and "cannot be shown" in Half()._repr_html_()  # type: ignore[attr-defined]


def test_long_texts_are_cut() -> None:
    face = Face("x" * 5000, [(f"name {i}", "y" * 5000) for i in range(50)])
    assert len(as_text(face).splitlines()) <= 5 and len(as_text(face)) < 600
    assert len(as_html(face)) < 50 * 500


def test_picture_keeps_the_peaks_of_a_long_curve() -> None:
    values = np.zeros(100_000)
    values[77_777], values[33_333] = 5.0, -3.0
    text = curves(np.arange(values.size), {"curve": values}, "time [s]", "value [1]")
    points = [tuple(map(float, pair.split(","))) for pair in text.split('points="')[1].split('"')[0].split()]
    heights = [y for _, y in points]
    assert len(points) < 500 and min(heights) == 16.0 and max(heights) == 100.0  # both edges of the axes are reached


def test_datasets_remain_datasets() -> None:
    run, found = trajectory(), comparison()
    for each in (run, found):
        assert isinstance(each, xr.Dataset) and isinstance(each.copy(), type(each))
        assert type(each.dataset) is xr.Dataset and each.identical(each.dataset)
        assert len(repr(each.dataset).splitlines()) > 8
    assert type(found.isel(law=0)) is Comparison and "<xarray" in repr(found.isel(law=0))  # no longer a comparison
    assert "<xarray" in repr(run[["cc"]]) and float(run.power.mean()) == pytest.approx(6.0, abs=0.1)


# --- no result rests on it ---------------------------------------------------------------------------------------


def test_no_key_rests_on_faces_and_plots() -> None:
    for work in ("gyroctl.comparison.items", "gyroctl.studies.margins.report", "gyroctl.tuning.tune"):
        rooms = rooms_of(work)
        assert "plant" in rooms and not set(rooms) & set(LOOKS), work


ROOT = Path(gy.__file__).resolve().parent
USES = {"shown", "pictured", "as_text", "as_html", "Drawn", "plain", "draw_bode", "law_styles"}
"""What rooms that compute may take of those that show, beside faces and figures."""


def test_rooms_that_compute_only_decorate_and_draw() -> None:
    """What is excluded from every key must not reach a number: of faces and plots only these names are imported."""
    for path in ROOT.rglob("*.py"):
        room = path.relative_to(ROOT).parts[0]
        if room in (*LOOKS, "reports", "studies", "palette.py"):
            continue
        text = path.read_text(encoding="utf-8")
        for node in ast.walk(ast.parse(text)) if "faces" in text or "plots" in text else ():
            if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[1:2] in (["faces"], ["plots"]):
                names = {name.name for name in node.names}
                strange = {n for n in names - USES if not n.endswith(("_face", "_figure")) and n != "frequencies"}
                assert not strange, f"{path.name}: {strange}"


def test_keys_of_runs_do_not_hang_on_the_repr(monkeypatch: pytest.MonkeyPatch, device: gy.Plant) -> None:
    from gyroctl.comparison.items import Realisations, work_items

    law = gy.law("load_angle")

    def key() -> str:
        waves = Realisations(gy.SeaState(), (1,), 120.0)
        return work_items(device, {"law": law}, waves, gy.Settings(), 60.0)[0].key

    first = key()
    for kind in (gy.Plant, gy.Settings, gy.Parameters, type(law), type(device.excitation)):
        monkeypatch.setattr(kind, "__repr__", lambda self: "another")
    assert first and key() == first
