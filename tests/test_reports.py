"""Summary, verdict, table, picture and HTML report of synthetic comparisons, edge cases included."""

from __future__ import annotations

import base64
import gzip
import io
import json
import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from rich.console import Console
from test_reports_synthetic import CHARACTERS, FOUR, save, synthetic

from gyroctl.errors import InputError
from gyroctl.harness.registry import registered
from gyroctl.reports import evaluate, judge, open_results, print_table, summarise, write_picture, write_report
from gyroctl.reports.canvas import DESK, TELEPHONE, look
from gyroctl.reports.labels import SIDES, Box, place
from gyroctl.reports.panel import Panels
from gyroctl.reports.report import DRAW, sea_line
from gyroctl.reports.theme import law_styles
from gyroctl.reports.wording import number, percent, seed_ranges, watts

CONTRACT = [
    "information",
    "mean_power_w",
    "mean_power_ci95",
    "power_cv",
    "p98_over_mean",
    "locked",
    "runs",
    "lock_probability_ci95",
    "mttl_s",
    "cycle_slips",
    "phi1_p98",
    "phi3_p98",
    "slip_loss_w",
    "ledger_residual",
    "step_ms_median",
    "step_ms_p99",
    "deadline_misses",
    "fallbacks",
    "ratio_to_best_constant",
    "ratio_ci95",
]

EDGES = {
    "ordinary": {},
    "one law, one run": {"laws": ("constant",), "realisations": 1},
    "three runs": {"realisations": 3},
    "all lost": {"lock": 0.0},
    "none lost": {"lock": 1.0},
    "no examples": {"examples": False},
    "many laws, no reference": {"laws": tuple(CHARACTERS)[1:], "realisations": 12},
}


@pytest.fixture(params=EDGES, ids=list(EDGES))
def edge(request):
    return synthetic(**EDGES[request.param])


# --- summary.json ---------------------------------------------------------------------------------------------------


def test_summary_has_the_contract_and_is_strict_json(edge):
    summary = json.loads(json.dumps(summarise(edge), allow_nan=False))
    assert {"experiment", "realisations", "laws"} <= set(summary)
    assert list(summary["laws"]) == [str(law) for law in edge["law"].values]
    for law in summary["laws"].values():
        assert set(CONTRACT) <= set(law)
    assert [r["seed"] for r in summary["realisations"]] == edge["realisation"].values.tolist()
    assert [r["sha256"] for r in summary["realisations"]] == edge["sha256"].values.tolist()


def test_summary_numbers_are_those_of_the_dataset():
    ds = synthetic(realisations=16)
    laws = summarise(ds)["laws"]
    reference = float(ds["mean_power"].sel(law="best_constant").mean())
    for name, law in laws.items():
        row = ds.sel(law=name)
        assert law["mean_power_w"] == pytest.approx(float(row["mean_power"].mean()))
        assert law["mean_power_ci95"][0] < law["mean_power_w"] < law["mean_power_ci95"][1]
        assert law["locked"] == int(row["locked"].sum())
        assert law["runs"] == 16
        assert law["ratio_to_best_constant"] == pytest.approx(law["mean_power_w"] / reference)
        assert law["ledger_residual"] == pytest.approx(float(np.abs(row["ledger_residual"]).max()))
    assert laws["best_constant"]["ratio_ci95"] == pytest.approx([1.0, 1.0])


def test_summary_without_losses_or_reference_has_null_and_a_reason():
    law = summarise(synthetic(("constant", "coupling"), lock=1.0))["laws"]["constant"]
    assert law["mttl_s"] is None
    assert law["mttl_ci95"][0] > 600.0
    assert law["mttl_ci95"][1] is None
    assert law["ratio_to_best_constant"] is None
    assert "best_constant" in law["notes"]["ratio_ci95"]


def test_order_of_realisations_changes_no_number():
    ds = synthetic(realisations=9)
    shuffled = ds.isel(realisation=[4, 0, 8, 2, 6, 1, 7, 3, 5])
    for a, b in zip(evaluate(ds).laws, evaluate(shuffled).laws, strict=True):
        assert a.power.value == pytest.approx(b.power.value)
        assert a.lock == b.lock
        assert a.mttl[:3] == pytest.approx(b.mttl[:3], nan_ok=True)


# --- layout ---------------------------------------------------------------------------------------------------------


def test_other_layout_names_everything_that_is_missing(tmp_path):
    path = tmp_path / "run.nc"
    save(xr.Dataset({"power": ("time", np.ones(3))}), path)
    out = tmp_path / "report.html"
    with pytest.raises(InputError) as caught:
        write_report(path, out)
    assert caught.value.field == "results"
    assert caught.value.value == str(path)
    for part in (
        "dimension law",
        "variable mean_power",
        "variable ledger_residual",
        "coordinate sha256",
        "tuning_seeds",
    ):
        assert part in str(caught.value)
    assert not out.exists()


@pytest.mark.parametrize("content", [None, b"", b"not a netcdf file", b"\x89HDF\r\n\x1a\ncut off", b"CDF\x01cut off"])
def test_missing_or_foreign_file_is_a_clear_error(tmp_path, content):
    path = tmp_path / "results.nc"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError, match="results = "):
        open_results(path)


@pytest.mark.parametrize(("engine", "kind"), [("h5netcdf", "NETCDF4"), ("scipy", "NETCDF3_64BIT")])
def test_either_netcdf_gives_the_same_summary(tmp_path, engine, kind):
    if engine == "h5netcdf":
        pytest.importorskip("h5py", reason="writing NetCDF 4 needs h5py")
    ds = synthetic()
    ds.to_netcdf(tmp_path / "results.nc", engine=engine, format=kind)
    assert summarise(open_results(tmp_path)) == summarise(ds)


@pytest.mark.slow
def test_directory_stands_for_its_results(tmp_path):
    save(synthetic(), tmp_path / "results.nc")
    assert open_results(tmp_path).sizes["law"] == len(FOUR)
    assert write_report(tmp_path, tmp_path) == tmp_path / "report.html"


def test_flattened_variable_is_refused():
    ds = synthetic()
    with pytest.raises(InputError, match=r"dimensions \(law, realisation\) of mean_power"):
        open_results(ds.assign(mean_power=ds["mean_power"].mean("realisation")))


@pytest.mark.slow
@pytest.mark.parametrize("contact", ["rolling", "friction"])
def test_device_is_named_and_reversals_are_told_of_the_contact_that_it_has(tmp_path, contact):
    ds = synthetic()
    ds["reversals"] = ds["locked"] * 0.0
    ds["reversals"].loc[{"law": "coupling"}] = 7.0
    ds.attrs.update(plant="zhang2017 realistic", contact=contact)
    (caveat,) = [c for c in judge(evaluate(ds)).caveats if "rolls backwards" in c]
    assert "coupling 7.0 times a run" in caveat
    assert ("a plant whose contact rolls leaves the rest of it out" in caveat) == (contact == "rolling")
    text = io.StringIO()
    print_table(ds, console=Console(file=text, width=100, color_system=None))
    assert text.getvalue().startswith("Device: zhang2017 realistic\n")
    assert "<span>zhang2017 realistic</span>" in write_report(ds, tmp_path / "report.html").read_text(encoding="utf-8")
    assert summarise(ds)["plant"] == "zhang2017 realistic"


# --- HTML report ----------------------------------------------------------------------------------------------------


class Links(HTMLParser):
    """Collect what a page would load or link to, its headings and its table cells."""

    def __init__(self) -> None:
        super().__init__()
        self.addresses: list[str] = []
        self.tags: list[str] = []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.addresses += [value for name, value in attrs if name in ("src", "href", "data", "action", "poster")]


def parsed(page: str) -> Links:
    links = Links()
    links.feed(page)
    return links


def without_scripts(page: str) -> str:
    return re.sub(r"<script.*?</script>", "", page, flags=re.S)


@pytest.mark.slow
def test_report_is_written_for_every_edge_case(edge, tmp_path):
    path = write_report(edge, tmp_path / "deep" / "report.html")
    page = path.read_text(encoding="utf-8")
    assert [p.name for p in path.parent.iterdir()] == ["report.html"]
    body = without_scripts(page)
    assert "nan" not in re.sub(r"<[^>]*>", " ", body).lower().split()
    for name in edge["law"].values:
        assert str(name) in body
    for digest in edge["sha256"].values:
        assert str(digest) in body


@pytest.mark.slow
def test_report_loads_nothing_from_outside(tmp_path):
    page = write_report(synthetic(), tmp_path / "report.html").read_text(encoding="utf-8")
    links = parsed(page)
    assert links.addresses and all(address.startswith("#") for address in links.addresses)
    assert "link" not in links.tags
    assert not re.search(r"url\((?!#)|@import|https?://", without_scripts(page))
    assert "default-src 'none'" in page  # the browser enforces it, whatever plotly would like to fetch
    library = re.findall(r'<script type="text/plain" id="library">(.*?)</script>', page)
    assert gzip.decompress(base64.b64decode(library[0])).decode().count("plotly.js v") == 1


@pytest.mark.slow
def test_report_is_the_same_from_memory_and_from_the_file(tmp_path):
    ds = synthetic()
    save(ds, tmp_path / "results.nc")
    from_memory = write_report(ds, tmp_path / "a.html").read_bytes()
    assert write_report(tmp_path / "results.nc", tmp_path / "b.html").read_bytes() == from_memory


@pytest.mark.parametrize("width", [80, 90])
def test_no_number_of_the_table_is_cut(width):
    ds = synthetic(tuple(CHARACTERS))
    text = io.StringIO()
    print_table(ds, console=Console(file=text, width=width, color_system=None))
    assert "…" not in text.getvalue()
    for law in evaluate(ds).laws:
        row = next(line for line in text.getvalue().splitlines() if f" {law.name} " in line)
        assert {number(law.power.value), number(law.turns_kept), f"{law.locked}/{law.runs}"} <= set(row.split())


def test_every_axis_of_the_report_has_a_unit(tmp_path):
    ds = synthetic()
    found = evaluate(ds)
    for name, draw in DRAW.items():
        for paper in (DESK, TELEPHONE):
            with look(paper):
                drawn = draw(ds, found, paper).figure
            if isinstance(drawn, Panels):
                said = [(one.title, one.y.label) for one in drawn.panels] + [(drawn.panels[-1].x.label,)]
            else:
                said = [(one.get_xlabel(), one.get_ylabel(), one.get_title(loc="left")) for one in drawn.axes]
            for told in said:
                assert any(re.search(r"\[[^\]]+\]", text) for text in told), f"{name} has an axis without a unit"


@pytest.mark.slow
def test_report_flags_motion_and_seed_overlap(tmp_path):
    ds = synthetic(tuning_seeds=(8, 9))
    ds["phi1_p98"].loc[{"law": "coupling"}] = 0.41
    body = without_scripts(write_report(ds, tmp_path / "report.html").read_text(encoding="utf-8"))
    assert '<span class="flag">over</span> 0.410' in body
    assert "overlap: 8" in body


def test_no_two_registered_laws_look_the_same():
    styles = law_styles(list(registered()), "best_constant")
    reference = styles.pop("best_constant")
    for part in ("colour", "symbol", "marker"):
        assert len({getattr(style, part) for style in styles.values()}) == len(styles) >= 10
    assert reference.colour not in {style.colour for style in styles.values()}


@pytest.mark.slow
def test_hostile_names_cannot_leave_their_place(tmp_path):
    ds = synthetic().assign_coords(law=["best_constant", "</script><b>x", "load_angle", "a&b"])
    page = write_report(ds, tmp_path / "report.html").read_text(encoding="utf-8")
    assert "<b>x" not in page.replace("\\u003cb\\u003e", "")
    assert page.count("</script>") == page.count("<script")


def test_unknown_attributes_and_missing_extras_are_no_obstacle(tmp_path):
    ds = synthetic(examples=False).drop_vars(["label", "step_ms_median", "outside_model", "capture_width_ratio"])
    ds.attrs.update(experiment="not json", parameters="{", extra=3)
    with pytest.raises(InputError, match="attribute duration"):
        summarise(ds)
    ds.attrs["duration"] = 600.0
    assert summarise(ds)["experiment"] == {"text": "not json"}
    assert "not json" in write_report(ds, tmp_path / "report.html").read_text(encoding="utf-8")


# --- table, picture, words ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("width", [80, 140])
def test_table_has_a_row_a_law_and_fits(edge, width):
    text = io.StringIO()
    print_table(edge, console=Console(file=text, width=width, color_system=None))
    lines = text.getvalue().splitlines()
    assert max(len(line) for line in lines) <= width
    rows = lines[3 : 3 + edge.sizes["law"]]
    for name in edge["law"].values:
        assert any(f" {name} " in row for row in rows)
        locked = int(edge["locked"].sel(law=name).sum())
        assert any(f" {name} " in row and f" {locked}/{edge.sizes['realisation']} " in row for row in rows)


def test_picture_is_written_for_every_edge_case(edge, tmp_path):
    path = write_picture(edge, tmp_path / "picture.png")
    assert path.read_bytes().startswith(b"\x89PNG")
    assert path.stat().st_size > 20_000


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (1.9999, "2.00"),
        (9.999, "10.0"),
        (0.35, "0.350"),
        (12345.0, "12300"),
        (0.0, "0"),
        (-0.5, "−0.500"),
        (float("nan"), "–"),
        (None, "–"),
        (float("inf"), "∞"),
        (3e-7, "3.00e−7"),
    ],
)
def test_numbers_have_three_significant_digits(value, text):
    assert number(value) == text


def test_small_words():
    assert watts(-0.001) == "0.00"
    assert percent(-0.01) == "0.0 %"
    assert seed_ranges((3, 1, 2, 9, 11, 12)) == "1 to 3, 9, 11, 12"
    assert seed_ranges(()) == "none"


def test_names_avoid_error_bars_and_one_another():
    crossed = place([(0.5, 0.5)], ["law"], [Box(0.0, 1.0, 0.51, 1.0)])
    assert crossed[0].up == -1
    sides = place([(0.5, 0.5), (0.5, 0.51)], ["first", "second"], [])
    assert sides[0] != sides[1]
    assert all(side in SIDES for side in sides)


def test_import_of_the_reports_stays_light():
    heavy = ("scipy", "plotly", "matplotlib", "jinja2", "xarray", "rich")
    code = f"import sys, gyroctl.reports; print([m for m in {heavy!r} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize(
    ("sea", "line"),
    [
        ({"kind": "jonswap", "hs": 0.283, "wp": 3.14, "gamma": 5.0}, "Hs 0.283 m, Tp 2 s, ωp 3.14 rad/s, γ 5"),
        ({"kind": "spectrum", "file": "lab.csv"}, "spectrum of lab.csv, Hs 0.256 m, Tp 2.63 s, ωp 2.39 rad/s"),
        ({"kind": "regular", "height": 0.2, "wp": 3.0}, "height 0.2 m, T 2.09 s, ωp 3 rad/s"),
        ("no table", ""),
    ],
)
def test_sea_stands_at_the_head_of_a_report(sea: object, line: str) -> None:
    """Of a sea from a file its name, and the height and the peak that were measured."""
    ds = synthetic().assign_attrs(experiment=json.dumps({"sea": sea}), hs=0.256125, wp=2.38761)
    assert sea_line(ds) == line


def test_report_tells_what_of_the_device_is_doubtful(tmp_path: Path) -> None:
    ds = synthetic().assign_attrs(doubts='["lever: a + b = <1.126> m"]', foreign_laws='["tracking"]')
    write_report(ds, tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text()
    assert "The check of the device doubts its lever: a + b = &lt;1.126&gt; m." in page
    assert "Tuned for another device than this one: " in page
    assert '"doubts_of_the_device": ["lever: a + b = <1.126> m"]' in json.dumps(summarise(ds, evaluate(ds)))
