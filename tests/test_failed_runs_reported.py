"""A law that failed in a run is out of the verdict, and table, summary and page say so, with the reason."""

from __future__ import annotations

import io
import json

import numpy as np
import pytest
import xarray as xr
from rich.console import Console
from test_reports_synthetic import synthetic

from gyroctl.reports import evaluate, judge, print_table, summarise
from gyroctl.reports.report import render

WHY = "law 'x' raised at t = 30.1 s: no more <b>"


def broken(runs: int) -> tuple[xr.Dataset, str]:
    """A comparison whose winner failed in its first runs, and the name of that law."""
    ds = synthetic(realisations=16)
    law = judge(evaluate(ds)).winner
    assert law is not None
    failed = np.zeros((ds.sizes["law"], ds.sizes["realisation"]), bool)
    failed[list(ds.law.values).index(law), :runs] = True
    for name in ds.data_vars:
        if ds[name].dims == ("law", "realisation"):
            verdict = ds[name].dtype == bool  # what is no number is no yes, as in a comparison
            ds[name] = ds[name] & ~failed if verdict else ds[name].astype(float).where(~failed)
    ds["failed"] = (("law", "realisation"), failed)
    ds["failure"] = (("law", "realisation"), np.where(failed, WHY, "").astype(object))
    return ds, law


@pytest.mark.parametrize("runs", [1, 15, 16])
def test_a_law_that_failed_cannot_win(runs: int) -> None:
    ds, law = broken(runs)
    verdict = judge(evaluate(ds))
    assert verdict.winner not in (None, law)
    said = next(sentence for sentence in verdict.sentences if sentence.startswith(law))
    assert f"failed in {runs} of 16 runs ({WHY})" in said


@pytest.mark.slow
@pytest.mark.parametrize("runs", [1, 16])
def test_summary_table_and_page_count_and_name_it(runs: int) -> None:
    ds, law = broken(runs)
    found = json.loads(json.dumps(summarise(ds), allow_nan=False))["laws"]
    assert {name: row["failed"] for name, row in found.items()} == {name: runs * (name == law) for name in found}
    assert set(found[law]["failures"].values()) == {WHY} and len(found[law]["failures"]) == runs
    assert found[law]["locked"] <= 16 - runs and found[law]["runs"] == 16
    out = io.StringIO()
    print_table(ds, console=Console(file=out, width=200))
    assert f"{runs}/16" in next(line for line in out.getvalue().splitlines() if law in line)
    page = render(ds)
    assert "Runs that failed" in page and "no more &lt;b&gt;" in page


@pytest.mark.slow
def test_nothing_is_said_where_nothing_failed() -> None:
    ds = synthetic(realisations=16)
    assert "Runs that failed" not in render(ds)
    assert all(law.failed == 0 for law in evaluate(ds).laws)


def test_time_to_loss_does_not_count_a_run_that_failed_as_held() -> None:
    ds, law = broken(16)
    found = evaluate(ds).law(law)
    assert np.isnan([found.mttl.value, found.mttl.low]).all() and found.mttl.note.startswith("no runs")
