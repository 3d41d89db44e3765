"""The report of a comparison: one HTML file that works without a network, rebuilt from the NetCDF alone."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from gyroctl.reports import figures, layout, wording
from gyroctl.reports.evaluation import Evaluation, LawResult, evaluate
from gyroctl.reports.pareto import pareto
from gyroctl.reports.theme import DARK, LIGHT, law_styles, template
from gyroctl.reports.timeseries import time_series
from gyroctl.reports.verdict import judge
from gyroctl.statistics import NOT_DISTINGUISHABLE
from gyroctl.writing import write_text

if TYPE_CHECKING:
    import plotly.graph_objects as go
    import xarray as xr
    from markupsafe import Markup


class Plate(NamedTuple):
    """A figure of the report with its anchor, heading and caption."""

    anchor: str
    heading: str
    caption: str
    draw: Callable[[xr.Dataset, Evaluation], go.Figure]


PLATES = (
    Plate(
        "pareto",
        "Power against smoothness",
        "Each law at its mean power and power CV. Colour is the probability to hold lock, bars are 95 % intervals, the "
        "dotted line joins the laws that no other beats in both. Best is top left and petrol.",
        pareto,
    ),
    Plate(
        "power",
        "Power of every realisation",
        "One point a run; a line joins the runs of one realisation, so the eye compares like with like.",
        figures.power_per_realisation,
    ),
    Plate(
        "differences",
        "Paired differences",
        "Difference in mean power on identical realisations. The bar is the 95 % interval of the single comparison; "
        "the words and the filled markers follow the test after Holm's correction over all pairs.",
        figures.paired_forest,
    ),
    Plate(
        "survival",
        "How long lock holds",
        "Kaplan-Meier estimate of the probability that lock has not been lost yet. Runs that end in lock are censored. "
        "Bands are 95 % intervals, with more than three laws only of the best law and the reference.",
        figures.survival,
    ),
    Plate(
        "motion",
        "Motion against its limit",
        "98 % quantile of each rotation, one point a run; red crosses are beyond the limit.",
        figures.motion,
    ),
    Plate(
        "energy",
        "Where the energy goes",
        "Mean power flows. The stack ends at the wave input when the ledger closes; only the generator's share is "
        "output.",
        figures.energy,
    ),
)

GLOSSARY = (
    ("Mean power", "Time mean of the electrical power cg·ω'², mean over all realisations, lost runs included."),
    (
        "95 % interval",
        "Bootstrap (BCa) over realisations; at least four are needed. Ratios and differences resample pairs.",
    ),
    ("Power CV", "Standard deviation of the electrical power over its mean within a run: 0 is perfectly smooth."),
    ("P98/mean", "98 % quantile of the electrical power over its mean: how far the electronics must be oversized."),
    (
        "Lock",
        "The ring turns once a wave. Lost when the 10 s mean of its speed falls "
        "below half the peak wave frequency; re-locking does not undo it.",
    ),
    ("P(lock)", "Share of runs that never lost lock, with Wilson's interval."),
    (
        "MTLL",
        "Mean time to lose lock: total time in lock over the number of losses, with the exact chi-square interval.",
    ),
    ("Cycle slips", "Jumps of the ring by a whole turn against the phase of the waves, per 1000 waves."),
    (
        "Motion",
        "98 % quantile of |φ1| (horizontal) and |φ3| (vertical); the linear float model holds up to about 0.3 rad.",
    ),
    (
        "Information",
        "What a law may see: nothing, sensors, a forecast of the waves, or the true "
        "future (oracle, a bound and no competitor).",
    ),
    (
        "best_constant",
        "The best constant pair cc, cg found on the tuning seeds with the same budget as the other laws.",
    ),
    (
        "Not distinguishable",
        "The Holm-corrected paired test does not exclude that the two laws are equal on these waves.",
    ),
    ("Load share", "N·cg/(J4·V): used share of the torque that can hold the ring in step; above 1 lock cannot last."),
    ("Capture width ratio", "Mean power over the wave power that passes the width of the float."),
    (
        "Ledger residual",
        "Wave input minus radiated, hinge, slip, generator and stored power, relative to the wave input; worst run.",
    ),
)


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
    environment.filters.update(
        number=wording.number,
        interval=wording.interval,
        signed=wording.signed,
        integer=_integer,
        plain=wording.plain,
        minutes=wording.minutes,
        minutes_interval=wording.minutes_interval,
        watts=wording.watts,
        percent=wording.percent,
    )
    verdict = judge(found)
    return environment.get_template("report.html.j2").render(
        evaluation=found,
        verdict=verdict,
        sentences=[_emphasised(sentence, layout.names(ds)) for sentence in verdict.sentences],
        created=str(ds.attrs["created"])[:16].replace("T", " "),
        laws=found.by_power,
        styles=law_styles(layout.names(ds), found.reference),
        sea=sea_line(ds),
        figures=[
            (plate, _figure_json(plate.draw(ds, found)))
            for plate in PLATES
            if plate.anchor != "differences" or found.power_differences
        ],
        series=_figure_json(time_series(ds, found)) if layout.has_examples(ds) else None,
        example_seed=found.seeds[0],
        templates={
            name: _script_safe(json.dumps(template(colours).to_plotly_json(), sort_keys=True))
            for name, colours in (("light", LIGHT), ("dark", DARK))
        },
        plotly_js=get_plotlyjs(),
        balances=[_balance(law) for law in found.by_power],
        not_distinguishable=NOT_DISTINGUISHABLE,
        evaluation_seeds=wording.seed_ranges(found.seeds),
        tuning_seeds=wording.seed_ranges(found.tuning_seeds),
        overlap=wording.seed_ranges(found.seed_overlap) if found.seed_overlap else "",
        provenance=_provenance(ds),
        realisations=[(seed, str(digest)) for seed, digest in zip(found.seeds, ds["sha256"].values, strict=True)],
        experiment=_experiment_text(ds),
        parameters=_parameters(ds),
        glossary=GLOSSARY,
    )


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


def _script_safe(text: str) -> str:
    """JSON that cannot end the script element it stands in, whatever a law is called."""
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _emphasised(sentence: str, names: list[str]) -> Markup:
    """Sentence as HTML with the names of laws in bold and no line break inside ``95 %``."""
    from markupsafe import Markup, escape

    text = str(escape(sentence)).replace("95 %", "95&nbsp;%").replace("98 %", "98&nbsp;%")
    for name in names:
        quoted = re.escape(str(escape(name)))
        text = re.sub(rf"(?<![\w.-]){quoted}(?![\w-])", lambda match: f"<strong>{match.group()}</strong>", text)
    return Markup(text)


def _integer(value: int | None) -> str:
    return wording.NOTHING if value is None else str(value)


def _balance(law: LawResult) -> dict[str, Any]:
    """One row of the energy ledger, each flow with its share of the wave input."""
    flows = (law.power.value, law.slip_loss_w, law.hinge_w, law.radiated_w, law.stored_w)
    usable = math.isfinite(law.wave_input_w) and law.wave_input_w > 0.0
    return {"law": law, "flows": [(flow, 100.0 * flow / law.wave_input_w if usable else math.nan) for flow in flows]}


def _provenance(ds: xr.Dataset) -> list[tuple[str, str]]:
    rows = [("gyroctl", str(ds.attrs["gyroctl_version"])), ("Created", str(ds.attrs["created"]))]
    if "command" in ds.attrs:
        rows.append(("Command", str(ds.attrs["command"])))
    versions = layout.read_json(ds, "versions", {})
    if isinstance(versions, dict) and versions:
        rows.append(("Libraries", ", ".join(f"{name} {version}" for name, version in sorted(versions.items()))))
    for attribute, name in (
        ("hydrodynamics_sha256", "Hydrodynamics SHA-256"),
        ("plant", "Plant"),
        ("platform", "Platform"),
    ):
        if attribute in ds.attrs:
            rows.append((name, str(ds.attrs[attribute])))
    return rows


def _experiment_text(ds: xr.Dataset) -> str:
    experiment = layout.experiment(ds)
    return json.dumps(experiment, indent=2, ensure_ascii=False) if experiment else str(ds.attrs["experiment"])


def _parameters(ds: xr.Dataset) -> list[tuple[str, str]]:
    """Parameters of each law as ``name = value`` text."""
    stored = layout.read_json(ds, "parameters", {})
    if not isinstance(stored, dict):
        return []
    rows = []
    for law, values in stored.items():
        text = (
            ", ".join(f"{key} = {value}" for key, value in values.items()) if isinstance(values, dict) else str(values)
        )
        rows.append((str(law), text or "none"))
    return rows
