"""The report of a comparison: one HTML file that works without a network, rebuilt from the NetCDF alone."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gyroctl.names import in_markup
from gyroctl.reports import figures, layout, wording
from gyroctl.reports.evaluation import Evaluation, evaluate
from gyroctl.reports.pareto import pareto
from gyroctl.reports.resting import in_words
from gyroctl.reports.theme import DARK, LIGHT, law_styles, template
from gyroctl.reports.timeseries import POINTS, time_series
from gyroctl.reports.verdict import judge, shown
from gyroctl.writing import write_text

if TYPE_CHECKING:
    import plotly.graph_objects as go
    import xarray as xr
    from markupsafe import Markup

DRAW: dict[str, Callable[[xr.Dataset, Evaluation], go.Figure]] = {
    "pareto": pareto,
    "power": figures.power_per_realisation,
    "differences": figures.paired_forest,
    "survival": figures.survival,
    "motion": figures.motion,
    "energy": figures.energy,
}
"""Figures by their anchor in the page, which holds their headings and captions."""

BY_RUN = ("power", "motion")
"""Those with a point for each run."""

RUNS = 2000
"""Realisations of which each run is drawn and each hash is listed: of more, so many of them."""


def write_report(source: xr.Dataset | str | Path, out_path: str | Path, evaluation: Evaluation | None = None) -> Path:
    """Write the self-contained HTML report of a comparison.

    Parameters
    ----------
    source : xarray.Dataset, str or Path
        Comparison, its results.nc, or the directory that holds it.
    out_path : str or Path
        File to write; ``report.html`` inside it when it is a directory.
    evaluation : Evaluation, optional
        Statistics of the comparison, where they have been worked out already.

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
    return write_text(path, render(ds, evaluation))


def render(ds: xr.Dataset, evaluation: Evaluation | None = None) -> str:
    """HTML text of the report.

    Parameters
    ----------
    ds : xarray.Dataset
        Comparison in the layout of results.nc.
    evaluation : Evaluation, optional
        Its statistics, where they have been worked out already.

    Returns
    -------
    str
        Complete page; equal input gives equal text.
    """
    from jinja2 import Environment, PackageLoader, StrictUndefined
    from plotly.offline import get_plotlyjs

    found = evaluate(ds) if evaluation is None else evaluation
    environment = Environment(
        loader=PackageLoader("gyroctl.reports"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    # what words the text and the figures words the page: each function of `wording` is a filter
    environment.filters["in_words"] = in_words
    environment.filters |= {name: words for name, words in vars(wording).items() if callable(words)}
    verdict, drawn = judge(found), shown(found)
    few = found if len(drawn) == len(found.laws) else replace(found, laws=drawn)
    few_ds = ds if few is found else ds.sel(law=[law.name for law in drawn])
    styles = law_styles(layout.names(ds), found.reference) | law_styles(layout.names(few_ds), found.reference)
    marked = _in_markup(few_ds, few)
    by_run = _few_runs(*marked)
    return environment.get_template("report.html.j2").render(
        evaluation=found,
        verdict=verdict,
        sentences=[_emphasised(sentence, layout.names(ds)) for sentence in (*verdict.sentences, *_foreign(ds))],
        created=str(ds.attrs["created"])[:16].replace("T", " "),
        laws=found.by_power,
        broken=[law for law in found.by_power if law.failures],
        drawn=drawn,
        styles=styles,
        sea=sea_line(ds),
        figures={
            name: _figure_json(draw(*(by_run if name in BY_RUN else marked)))
            for name, draw in DRAW.items()
            if name != "differences" or found.power_differences
        },
        series=_series_json(time_series(*marked)) if layout.has_examples(ds) else None,
        points=POINTS,
        templates={
            name: _script_safe(json.dumps(template(colours).to_plotly_json(), sort_keys=True))
            for name, colours in (("light", LIGHT), ("dark", DARK))
        },
        plotly_js=get_plotlyjs(),
        provenance=_provenance(ds),
        realisations=list(zip(found.seeds[:RUNS], map(str, ds["sha256"].values[:RUNS]), strict=True)),
        drawn_runs=len(by_run[1].seeds),
        experiment=_experiment_text(ds),
        parameters=_parameters(ds),
    )


def _few_runs(ds: xr.Dataset, found: Evaluation) -> tuple[xr.Dataset, Evaluation]:
    """Comparison with no more than about `RUNS` realisations: every so many-th, and those that stand out."""
    count = ds.sizes["realisation"]
    if count <= RUNS:
        return ds, found
    chosen = set(np.linspace(0, count - 1, RUNS).round().astype(int).tolist())
    for variable in ("mean_power", "phi1_p98", "phi3_p98"):
        for row in layout.values(ds, variable):
            if (known := np.flatnonzero(np.isfinite(row))).size:
                chosen |= {int(known[row[known].argmin()]), int(known[row[known].argmax()])}
    at = sorted(chosen)
    return ds.isel(realisation=at), replace(found, seeds=tuple(found.seeds[k] for k in at))


def _in_markup(ds: xr.Dataset, found: Evaluation) -> tuple[xr.Dataset, Evaluation]:
    """Comparison whose laws are called as markup writes their names: the text of a figure is markup to plotly."""
    names = [in_markup(name) for name in layout.names(ds)]
    if names == layout.names(ds):
        return ds, found
    drawn = ds.assign_coords(law=names)
    return drawn, evaluate(drawn)


def sea_line(ds: xr.Dataset) -> str:
    """Describe the sea in one line, as far as the experiment says: ``Hs 0.283 m, ωp 3.14 rad/s, γ 5, heading 0°``."""
    sea = layout.experiment(ds).get("sea")
    if not isinstance(sea, dict):
        return ""
    known = (
        ("hs", "Hs", " m"),
        ("height", "height", " m"),
        ("wp", "ωp", " rad/s"),
        ("gamma", "γ", ""),
        ("heading", "heading", "°"),
    )
    return ", ".join(
        f"{name} {wording.plain(float(sea[key]))}{unit}"
        for key, name, unit in known
        if isinstance(sea.get(key), int | float)
    )


def _figure_json(figure: go.Figure) -> str:
    """Figure as JSON without its template, which the page holds once for light and once for dark."""
    figure.layout.template = None
    return _script_safe(str(figure.to_json()))


def _series_json(figure: go.Figure) -> str:
    """Time series as JSON in which the times that all lines share stand once: the page hands them to each line."""
    figure.layout.template = None
    content = json.loads(str(figure.to_json()))
    content["layout"]["meta"] = {"time": content["data"][0]["x"]}
    for trace in content["data"]:
        assert trace.pop("x") == content["layout"]["meta"]["time"]
    return _script_safe(json.dumps(content, separators=(",", ":")))


def _script_safe(text: str) -> str:
    """JSON that cannot end the script element it stands in, whatever a law is called."""
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


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
    """Sentence on the laws whose parameters were tuned for another device, where there are any."""
    names = layout.read_json(ds, "foreign_laws", [])
    if not isinstance(names, list) or not names:
        return []
    listed = ", ".join(str(name) for name in names)
    return [f"Tuned for another device than this one: {listed}."]


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
