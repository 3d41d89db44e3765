"""The study: table and figure of skill against the lead."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student_t

from gyroctl.devices import zhang2017
from gyroctl.errors import InputError
from gyroctl.harness.actuation import Actuators
from gyroctl.harness.seed_ledger import ledger
from gyroctl.plant import Plant
from gyroctl.provenance import made
from gyroctl.studies.forecast.draw import draw
from gyroctl.studies.forecast.skill import FIRST, LEADS, SOURCES, Skill, skill
from gyroctl.studies.style import save, styled
from gyroctl.waves import DriftingSea, SeaState
from gyroctl.writing import write_json, write_rows

SEAS: dict[str, SeaState | DriftingSea] = {
    "gamma 1": SeaState(gamma=1.0),
    "gamma 5": SeaState(gamma=5.0),
    "gamma 50": SeaState(gamma=50.0),
    "gamma 5, peak 2.8 to 3.5 rad/s": DriftingSea(wp=2.8, wp_end=3.5, gamma=5.0, over=1000.0),
}
"""The seas of the study."""

REAL_WATER: dict[str, Callable[[], Plant]] = {
    "gamma 5, realistic device, linear design": zhang2017,
    "gamma 5, realistic device, realistic design": partial(zhang2017, variant="realistic"),
}
"""The device in real water, and what estimator and forecast are designed with there."""

WITHIN = ("one", "two")
"""Deviations that the forecast says of itself, within which errors are counted."""

LAG = Actuators(cc_lag=0.02)
"""Actuators in real water."""


def forecast_report(out: Path, seeds: Sequence[int], duration: float = 1000.0, law: str = "coupling") -> str:
    """Write forecast.csv, forecast.json and forecast.png into `out`, and return the table as text.

    Parameters
    ----------
    out : Path
        Directory, made where it is missing.
    seeds : sequence of int
        Realisations.
    duration : float
        Of each. [s]
    law : str
        The law that moves the device meanwhile.

    Raises
    ------
    InputError
        For no seed, or a duration that leaves nothing to judge.
    """
    if not seeds:
        raise InputError("forecast.seeds", list(seeds), "names no realisation", "Give for example 100000:100004")
    if not duration >= FIRST + 2.0 * LEADS[-1]:
        raise InputError("forecast.duration", duration, "leaves nothing to judge", f"Give more than {FIRST + 16:g} s")
    truth = zhang2017(radiation="fine")  # finer than the design model, as in every evaluation
    found = {name: skill(sea, law, seeds, duration, truth) for name, sea in SEAS.items()}
    real = zhang2017(variant="realistic", radiation="fine")
    wet = {
        name: skill(SEAS["gamma 5"], law, seeds, duration, real, design(), LAG) for name, design in REAL_WATER.items()
    }
    runs = f"{len(seeds)} realisations of {duration:g} s under the law {law}"
    note = f"truth: finer radiation fit; {runs}; default sensors"
    with styled():
        save(draw(found, note), out / "forecast.png")
        save(draw(wet, f"truth: the realistic device; {runs}; default sensors"), out / "forecast_real_water.png")
    rows = [*_rows(found), *_rows(wet)]
    write_rows(out / "forecast.csv", [["sea", "source", "moment", *(f"error_at_{lead:g}_s" for lead in LEADS)], *rows])
    at_the_sample = {name: {"estimator": value.now[0], "smoothed": value.now[1]} for name, value in found.items()}
    head = {**made(), "seeds": list(seeds), "seed_states": ledger().states(seeds), "duration_s": duration, "law": law}
    skills, wet_skills = (
        {name: dict(zip(SOURCES, value.error, strict=True)) for name, value in each.items()} for each in (found, wet)
    )
    within = {name: dict(zip(WITHIN, value.within, strict=True)) for name, value in {**found, **wet}.items()}
    spread = {name: _halves(value) for name, value in {**found, **wet}.items()}
    errors = {"error": skills, "error_in_real_water": wet_skills, "half_width": spread, "within_its_deviations": within}
    content = {"note": note, "error_at_the_sample": at_the_sample, "leads_s": LEADS, **errors}
    write_json(out / "forecast.json", {**head, **content})
    return _text(rows) + _sample({**found, **wet})


def _halves(value: Skill) -> NDArray[np.float64]:
    """Half the width of the 95 % interval of the mean error from the sensors over the realisations, (2, leads)."""
    runs = value.runs[:, SOURCES.index("sensors")]
    quantile = student_t.ppf(0.975, len(runs) - 1) if len(runs) > 1 else np.nan
    return np.asarray(quantile * np.std(runs, axis=0, ddof=min(1, len(runs) - 1)) / np.sqrt(len(runs)))


def _rows(found: dict[str, Skill]) -> list[list[str]]:
    return [
        [name, source, f"Me{moment}", *(f"{error:.3f}" for error in value.error[s, j])]
        for name, value in found.items()
        for s, source in enumerate(SOURCES)
        for j, moment in enumerate((1, 3))
    ]


def _text(rows: list[list[str]]) -> str:
    head = f"| sea | from | moment | {' | '.join(f'{lead:g} s' for lead in LEADS)} |\n"
    rule = "| --- | --- | --- |" + " ---: |" * len(LEADS) + "\n"
    return head + rule + "".join(f"| {' | '.join(row)} |\n" for row in rows if "nan" not in row)


def _sample(found: dict[str, Skill]) -> str:
    text = "\n"
    for name, value in found.items():
        estimator, smoothed = (f"{me1:.4f} {me3:.4f}" for me1, me3 in value.now)
        text += f"{name}: at the sample, estimator {estimator}, smoothed {smoothed} (Me1, Me3)\n"
        for count, shares in zip(WITHIN, value.within, strict=True):
            at = "; ".join(" ".join(f"{share:.3f}" for share in moment) for moment in shares)
            text += f"{name}: within {count} of the deviations that it says, by lead (Me1; Me3) {at}\n"
    return text
