"""The report of a comparison: one HTML file that works without a network, rebuilt from the NetCDF alone."""

from __future__ import annotations

import base64
import gc
import gzip
import json
import math
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import lru_cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gyroctl.reports import figures, layout, page, wording
from gyroctl.reports.beside import NOTHING, Beside, look_beside
from gyroctl.reports.canvas import Drawing, Paper, plate
from gyroctl.reports.coinciding import idle_wrappers
from gyroctl.reports.evaluation import Evaluation, evaluate
from gyroctl.reports.law_section import sections, use_words
from gyroctl.reports.pareto import pareto
from gyroctl.reports.theme import law_styles
from gyroctl.reports.timeseries import LEVELS, POINTS, closer_look, script_safe, shown_first, time_series
from gyroctl.reports.verdict import judge, shown
from gyroctl.writing import write_text

if TYPE_CHECKING:
    import xarray as xr
    from markupsafe import Markup

DRAW: dict[str, Callable[[xr.Dataset, Evaluation, Paper], Drawing]] = {
    "pareto": pareto,
    "power": figures.power_per_realisation,
    "differences": figures.paired_forest,
    "survival": figures.survival,
    "motion": figures.motion,
    "energy": figures.energy,
    "series": time_series,
}
"""Figures by their anchor in the page, which holds their headings and captions."""

BY_RUN = ("power", "motion")
"""Those with a point for each run."""

RUNS = 2000
"""Realisations of which each hash is listed: of more, so many of them."""

SWEPT_AFTER = 100_000
"""New objects between two looks for unused cycles, while a page is drawn."""

POINTS_OF_RUNS, RUNS_LEAST = 3600, 100
"""Points of a figure with a point for each run, about, and realisations that are drawn at least: of more so many."""


def write_report(
    source: xr.Dataset | str | Path,
    out_path: str | Path,
    evaluation: Evaluation | None = None,
    beside: Path | None = None,
) -> Path:
    """Write the self-contained HTML report of a comparison.

    Margins of its laws and tables of an evaluation that lie in the folder of the results, or in folders within it, are
    told in the sections of the laws.

    Parameters
    ----------
    source : xarray.Dataset, str or Path
        Comparison, its results.nc, or the directory that holds it.
    out_path : str or Path
        File to write; ``report.html`` inside it when it is a directory.
    evaluation : Evaluation, optional
        Statistics of the comparison, where they have been worked out already.
    beside : Path, optional
        Folder in which margins and tables are looked for; by default that of the source, or of the page.

    Returns
    -------
    Path
        The written file. It appears whole or not at all.

    Raises
    ------
    InputError
        The source is missing or is no comparison.
    """
    ds = layout.open_results(source)
    path = Path(out_path)
    path = path / "report.html" if path.is_dir() else path
    home = beside or (Path(source) if isinstance(source, str | Path) else path.parent)
    return write_text(path, render(ds, evaluation, look_beside(home if home.is_dir() else home.parent)))


def render(ds: xr.Dataset, evaluation: Evaluation | None = None, beside: Beside = NOTHING) -> str:
    """HTML text of the report.

    Parameters
    ----------
    ds : xarray.Dataset
        Comparison in the layout of results.nc.
    evaluation : Evaluation, optional
        Its statistics, where they have been worked out already.
    beside : Beside, optional
        Margins and tables that tell something about its laws.

    Returns
    -------
    str
        Complete page; equal input gives equal text.
    """
    with seldom_swept():
        return _rendered(ds, evaluate(ds) if evaluation is None else evaluation, beside)


@contextmanager
def seldom_swept() -> Iterator[None]:
    """Look for unused cycles seldom: a figure is thousands of objects, and a sixth of the time went to looking."""
    usual = gc.get_threshold()
    gc.set_threshold(SWEPT_AFTER, *usual[1:])
    try:
        yield
    finally:
        gc.set_threshold(*usual)


def _rendered(ds: xr.Dataset, found: Evaluation, beside: Beside) -> str:
    verdict, idle = judge(found), idle_wrappers(ds)
    drawn = tuple(law for law in shown(found) if law.name not in idle)
    few = found if len(drawn) == len(found.laws) else replace(found, laws=drawn)
    few_ds = ds if few is found else ds.sel(law=[law.name for law in drawn])
    styles = law_styles(layout.names(ds), found.reference) | law_styles(layout.names(few_ds), found.reference)
    by_run = _few_runs(few_ds, few)
    wanted = {
        name: draw
        for name, draw in DRAW.items()
        if (name != "differences" or found.power_differences) and (name != "series" or layout.has_examples(ds))
    }
    drawings = {
        name: plate(partial(draw, *(by_run if name in BY_RUN else (few_ds, few))), name)
        for name, draw in wanted.items()
    }
    series = closer_look(few_ds, few) if layout.has_examples(ds) else None
    values = {
        "evaluation": found,
        "verdict": verdict,
        "sentences": [_emphasised(sentence, layout.names(ds)) for sentence in (*verdict.sentences, *_foreign(ds))],
        "created": str(ds.attrs["created"])[:16].replace("T", " "),
        "laws": found.by_power,
        "broken": [law for law in found.by_power if law.failures],
        "drawn": drawn,
        "idle": idle,
        "styles": styles,
        "sea": sea_line(ds),
        "figures": {**dict.fromkeys(DRAW), **drawings},
        "sections": sections(few_ds, few, drawn),
        "use_words": use_words(ds),
        "beside": beside,
        "shown": shown_first(few),
        "series": {"head": script_safe(series["head"]), "text": series["text"]} if series else None,
        "library": packed_library() if series else "",
        "points": POINTS,
        "levels": LEVELS,
        "provenance": _provenance(ds),
        "realisations": list(zip(found.seeds[:RUNS], map(str, ds["sha256"].values[:RUNS]), strict=True)),
        "drawn_runs": len(by_run[1].seeds),
        "experiment": _experiment_text(ds),
        "parameters": _parameters(ds),
    }
    return page.render("report.html.j2", values)


@lru_cache(maxsize=1)
def packed_library() -> str:
    """Plotting library for the closer look, as base64 of gzip: the page unpacks it when it is asked for."""
    from plotly.offline import get_plotlyjs

    return base64.b64encode(gzip.compress(get_plotlyjs().encode(), 9, mtime=0)).decode("ascii")


def _few_runs(ds: xr.Dataset, found: Evaluation) -> tuple[xr.Dataset, Evaluation]:
    """Comparison with no more than about `POINTS_OF_RUNS` runs: every so many-th, and those that stand out."""
    count = ds.sizes["realisation"]
    most = max(POINTS_OF_RUNS // ds.sizes["law"], RUNS_LEAST)
    if count <= most:
        return ds, found
    chosen = set(np.linspace(0, count - 1, most).round().astype(int).tolist())
    for variable in ("mean_power", "phi1_p98", "phi3_p98"):
        for row in layout.values(ds, variable):
            if (known := np.flatnonzero(np.isfinite(row))).size:
                chosen |= {int(known[row[known].argmin()]), int(known[row[known].argmax()])}
    at = sorted(chosen)
    return ds.isel(realisation=at), replace(found, seeds=tuple(found.seeds[k] for k in at))


def sea_line(ds: xr.Dataset) -> str:
    """Describe the sea in one line, as far as the file says: ``Hs 0.283 m, Tp 2 s, ωp 3.14 rad/s, γ 5``.

    Of a sea from a file also that; its height and peak are those that the comparison measured.
    """
    told = layout.experiment(ds).get("sea")
    if not isinstance(told, dict):
        return ""
    measured = {key: float(f"{ds.attrs[key]:.3g}") for key in ("hs", "wp") if key in ds.attrs and "height" not in told}
    sea = {**measured, **told}
    source = [f"{sea.get('kind', 'sea')} of {sea['file']}"] if isinstance(sea.get("file"), str) else []
    if isinstance(sea.get("wp"), int | float) and sea["wp"] > 0.0:
        sea["tp"] = float(f"{2.0 * math.pi / sea['wp']:.3g}")
    known = (
        ("hs", "Hs", " m"),
        ("height", "height", " m"),
        ("tp", "T" if "height" in told else "Tp", " s"),
        ("wp", "ωp", " rad/s"),
        ("gamma", "γ", ""),
        ("heading", "heading", "°"),
    )
    numbers = [
        f"{name} {wording.plain(float(sea[key]))}{unit}"
        for key, name, unit in known
        if isinstance(sea.get(key), int | float)
    ]
    return ", ".join([*source, *numbers])


def _emphasised(sentence: str, names: list[str]) -> Markup:
    """Sentence as HTML with the names of laws in bold and no line break inside ``95 %``."""
    from markupsafe import Markup, escape

    text = str(escape(sentence)).replace("95 %", "95&nbsp;%").replace("98 %", "98&nbsp;%")
    for name in names:
        written = str(escape(name))
        if written not in text:  # quick: there may be thousands of names
            continue
        quoted = re.escape(written)
        text = re.sub(rf"(?<![\w.-]){quoted}(?![\w-])", lambda match: f"<strong>{match.group()}</strong>", text)
    return Markup(text)


def _provenance(ds: xr.Dataset) -> list[tuple[str, str]]:
    versions = layout.read_json(ds, "versions", {})
    libraries = sorted(versions.items()) if isinstance(versions, dict) else ()
    known = {
        "gyroctl": ds.attrs["gyroctl_version"],
        "Created": ds.attrs["created"],
        "Command": ds.attrs.get("command"),
        "Libraries": ", ".join(f"{name} {version}" for name, version in libraries) or None,
        "Hydrodynamics SHA-256": ds.attrs.get("hydrodynamics_sha256"),
        "Plant": ds.attrs.get("plant"),
        "Changed against Table 1": _changed(ds),
        "Platform": ds.attrs.get("platform"),
        "Commit": ds.attrs.get("commit") or None,
    }
    return [(name, str(value)) for name, value in known.items() if value is not None]


def _foreign(ds: xr.Dataset) -> list[str]:
    """Sentences on laws that were tuned for another device, on what of the device to doubt, and on odd numbers."""
    names, doubts, odd = (layout.read_json(ds, name, []) for name in ("foreign_laws", "doubts", "remarks"))
    listed = ", ".join(str(name) for name in names) if isinstance(names, list) else ""
    told = [f"The check of the device doubts its {doubt}." for doubt in doubts] if isinstance(doubts, list) else []
    told += [f"Note: {remark}." for remark in odd] if isinstance(odd, list) else []
    return [*([f"Tuned for another device than this one: {listed}."] if listed else []), *told]


def _changed(ds: xr.Dataset) -> str | None:
    """What of the device was changed against Table 1, None where the file does not say."""
    device = layout.read_json(ds, "device", None)
    if not isinstance(device, dict) or not isinstance(device.get("changed"), dict):
        return None
    rows = [f"{name} = {row.get('device')} ({row.get('table_1')})" for name, row in device["changed"].items()]
    length = device.get("length_scale", 1.0)
    size = [] if length == 1.0 else [f"{length:g} times the length"]
    own = ["own hydrodynamics"] if device.get("hydrodynamics") == "own" else []
    return ", ".join([*size, *rows, *own]) or "nothing"


def _experiment_text(ds: xr.Dataset) -> str:
    experiment = layout.experiment(ds)
    return json.dumps(experiment, indent=2, ensure_ascii=False) if experiment else str(ds.attrs["experiment"])


def _parameters(ds: xr.Dataset) -> list[tuple[str, str]]:
    """Parameters of each law as ``name = value`` text."""
    stored = layout.read_json(ds, "parameters", {})
    return (
        [(str(law), _settings(values) or "none") for law, values in stored.items()] if isinstance(stored, dict) else []
    )


def _settings(values: Any) -> str:
    return ", ".join(f"{key} = {value}" for key, value in values.items()) if isinstance(values, dict) else str(values)
