"""A site from its table to its files: pairs, runs, sums, then JSON, CSV, picture and page."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gyroctl.engine.state import RUNS
from gyroctl.errors import InputError
from gyroctl.harness.plausibility import far_seas
from gyroctl.harness.registry import describe
from gyroctl.harness.seed_ledger import ledger
from gyroctl.harness.sight import sight
from gyroctl.harness.yardstick import BASELINE, Yardstick
from gyroctl.provenance import made
from gyroctl.reports.wording import seed_ranges
from gyroctl.studies.evaluation.seeds import states_in_words
from gyroctl.studies.site.annual import Scale, Still, annual, in_cell, standing_still
from gyroctl.studies.site.cells import MEANING, Cell, Scaled, cell_of
from gyroctl.studies.site.draw import draw
from gyroctl.studies.site.page import write_page
from gyroctl.studies.site.pairs import pair_of_site, pairs_of_seas
from gyroctl.studies.site.request import SITE_PAIR, SiteRequest
from gyroctl.studies.site.runs import LawRuns, run_cells
from gyroctl.studies.site.sheets import write_sheets
from gyroctl.studies.style import save, styled
from gyroctl.waves.checks import whole
from gyroctl.writing import plain, write_json

NEAR_DEPTH = 0.05
"""Difference of depths, as a part, from which it is said. [1]"""


PAIRS = "the best constant pair of each sea state, see cells in site.json"


def site_report(ask: SiteRequest) -> dict[str, Any]:
    """Run a site and write ``site.json``, ``cells.csv``, ``annual.csv``, ``matrices.csv``, ``site.png``, ``site.html``.

    Parameters
    ----------
    ask : SiteRequest
        From `site_request`.

    Returns
    -------
    dict
        What site.json holds.

    Raises
    ------
    InputError
        Where no sea state of the table can be counted, or the budget of the searches is too small.
    """
    begin = time.monotonic()
    on = Scaled(ask.scatter.kind, ask.gamma, ask.scale, ask.depth, ask.duration, ask.rarest)
    cells = [cell_of(ask.plant, one, on) for one in ask.scatter.bins]
    run = [cell for cell in cells if cell.state == "run"]
    if not run:
        why = "; ".join(dict.fromkeys(cell.why for cell in cells))[:300]
        raise InputError("scatter", len(cells), f"no sea state of the table can be run: {why}", "Give another --scale")
    for remark in _far(ask, cells):
        ask.say(f"Note: {remark}.")
    ask.say(f"{len(run)} of {len(cells)} sea states are run, {_runs(ask, len(run))} runs of {ask.duration:g} s")
    pairs, site = _pairs(ask, run)
    runs = run_cells(ask, run, pairs, site)
    content = _content(ask, cells, pairs, site, runs)
    content["seconds"] = round(time.monotonic() - begin, 1)
    found: dict[str, Any] = dict(plain(content))
    write_json(ask.out / "site.json", found)
    write_sheets(found, ask.out)
    with styled(formulas=False):
        save(draw(found), ask.out / "site.png")
    write_page(found, ask.out / "site.html")
    return found


def _pairs(ask: SiteRequest, run: Sequence[Cell]) -> tuple[dict[str, Yardstick], Yardstick]:
    """Best constant pair of each sea state that is run, and the one for all of them."""
    seas, shares = {cell.name: cell.sea for cell in run if cell.sea}, {cell.name: cell.bin.share for cell in run}
    folder, workers = ask.out / RUNS, ask.workers or os.cpu_count() or 1
    how = (ask.settings, ask.motion_limit, ask.duration, ask.budget, folder, workers, ask.quiet)
    pairs = pairs_of_seas(ask.plant, seas, *how)
    site = pair_of_site(ask.plant, seas, shares, pairs, ask.settings, ask.duration, folder, workers, ask.quiet)
    return pairs, site


def _runs(ask: SiteRequest, seas: int) -> int:
    return whole("runs", seas * (len(ask.laws) + 2) * len(ask.seeds), 0, 10**8, "Ask for less")


def _content(
    ask: SiteRequest,
    cells: Sequence[Cell],
    pairs: Mapping[str, Yardstick],
    site: Yardstick,
    runs: Mapping[str, LawRuns],
) -> dict[str, Any]:
    scale = scale_of(ask)
    run = [cell for cell in cells if cell.state == "run"]
    hours, flux = np.array([cell.hours for cell in run]), np.array([cell.flux for cell in run])
    places = {cell.name: at for at, cell in enumerate(run)}
    idle = [cell for cell in cells if cell.counted and cell.state != "run"]
    still = Still(sum(cell.hours for cell in idle), sum(cell.hours * cell.flux for cell in idle))
    year = annual(runs, hours, flux, scale, SITE_PAIR, BASELINE, still)
    failed = {f"{law}, {cell}": why for law, own in runs.items() for cell, why in own.failures.items()}
    return {
        "study": "site",
        **made(),
        "request": {**ask.record(), "seed_states": ledger().states(ask.seeds)},
        "device": {
            "name": ask.plant.name,
            "width_m": scale.width,
            "depth_m": ask.plant.depth,
            "width_at_site_m": scale.width * ask.scale,
        },
        "scatter": {
            "layout": ask.scatter.layout,
            "period": ask.scatter.kind,
            "occurrence": ask.scatter.told,
            "sum": ask.scatter.total,
            "notes": list(ask.scatter.notes),
        },
        "laws": _laws(ask, site),
        "resource": resource(ask, cells),
        "annual": {law: one._asdict() for law, one in year.items()},
        "cells": [_cell(cell, places, runs, scale, pairs.get(cell.name)) for cell in cells],
        "states": MEANING,
        "remarks": remarks(ask, cells, runs),
        "failed": failed,
    }


def scale_of(ask: SiteRequest) -> Scale:
    """What turns the plant's runs into the site's year."""
    width = ask.plant.parameters.d + ask.plant.parameters.c  # crests run along the lever, and so does the capsule
    return Scale(ask.scale, width, ask.duration - ask.settings.score_from, ask.motion_limit)


def _laws(ask: SiteRequest, site: Yardstick) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, law in ask.laws.items():
        found[name] = {"sees": sight(law).level, "words": "", "parameters": describe(law)}
    found[SITE_PAIR] = {"sees": "none", "words": site.words, "parameters": {"cc": site.cc, "cg": site.cg}}
    found[BASELINE] = {"sees": "the sea state", "words": PAIRS, "parameters": {}}
    return found


def _cell(
    cell: Cell, places: Mapping[str, int], runs: Mapping[str, LawRuns], scale: Scale, pair: Yardstick | None
) -> dict[str, Any]:
    sea = cell.sea
    told: dict[str, Any] = {
        "name": cell.name,
        "hs_m": cell.bin.hs,
        "period_s": cell.bin.period,
        "tp_s": cell.tp,
        "hours": cell.hours,
        "share": cell.bin.share,
        "flux_w_per_m": cell.flux,
        "state": cell.state,
        "why": cell.why,
        "plant_sea": {"hs_m": sea.hs, "tp_s": 2.0 * math.pi / sea.wp, "wp_rad_s": sea.wp, "gamma": sea.gamma}
        if sea is not None
        else None,
        "pair": {"cc_nms": pair.cc, "cg_nms": pair.cg, "words": pair.words} if pair is not None else None,
    }
    at = places.get(cell.name)
    told["laws"] = {}
    if at is not None:
        told["laws"] = {law: in_cell(own, at, cell.flux, scale)._asdict() for law, own in runs.items()}
    elif cell.state == "no lock":
        told["laws"] = {law: standing_still()._asdict() for law in runs}
    return told


def resource(ask: SiteRequest, cells: Sequence[Cell]) -> dict[str, Any]:
    """Hours and wave energy of the year by what became of the sea states; what is not known counts as none."""
    flux = {cell.name: cell.flux if math.isfinite(cell.flux) else 0.0 for cell in cells}
    whole_year = sum(cell.hours * flux[cell.name] for cell in cells)
    parts = {}
    for state in MEANING:
        own = [cell for cell in cells if cell.state == state]
        energy = sum(cell.hours * flux[cell.name] for cell in own)
        parts[state] = {
            "sea_states": len(own),
            "hours": sum(cell.hours for cell in own),
            "share": sum(cell.bin.share for cell in own),
            "energy_share": energy / whole_year if whole_year > 0.0 else 0.0,
        }
    return {
        "mean_flux_w_per_m": whole_year / sum(cell.hours for cell in cells),
        "energy_kwh_per_m": 1e-3 * whole_year,
        "not_in_the_table_share": ask.scatter.missing,
        "parts": parts,
    }


def _far(ask: SiteRequest, cells: Sequence[Cell]) -> list[str]:
    """Tell where the site's seas, brought to the plant, are not those of such a device."""
    seas = [(cell.sea, cell.bin.share) for cell in cells if cell.sea is not None]
    return far_seas(ask.plant, [sea for sea, _ in seas], [share for _, share in seas])


def remarks(ask: SiteRequest, cells: Sequence[Cell], runs: Mapping[str, LawRuns]) -> list[str]:
    """What a reader must know beside the numbers."""
    said = [f"tuned for another device: {', '.join(ask.foreign)}"] if ask.foreign else []
    for state, words in MEANING.items():
        own = [cell for cell in cells if cell.state == state]
        if state in ("run", "calm") or not own:
            continue
        parts = resource(ask, cells)["parts"][state]
        named = "; ".join(f"{cell.name}" for cell in own[:4]) + (f" and {len(own) - 4} more" if own[4:] else "")
        said.append(
            f"{len(own)} sea states, {100 * parts['share']:.3g} % of the time and "
            f"{100 * parts['energy_share']:.3g} % of the wave energy of the table: {words} ({named})"
        )
    said += _far(ask, cells)
    if ask.scatter.missing:
        said.append(f"{100 * ask.scatter.missing:.3g} % of the year are not in the table and give nothing")
    at_plant = ask.plant.depth * ask.scale
    if math.isfinite(at_plant) and not abs(ask.depth / at_plant - 1.0) <= NEAR_DEPTH:
        said.append(
            f"the hydrodynamics are those of {at_plant:.3g} m of water at the site's scale; its depth of "
            f"{ask.depth:g} m counts for the power of the waves and where they break, not for the motion"
        )
    said.append(
        f"a run begins in lock and is scored for {ask.duration - ask.settings.score_from:g} s, "
        f"{(ask.duration - ask.settings.score_from) * math.sqrt(ask.scale) / 60.0:.3g} min at the site: starts, and "
        "what is lost later than that, are in no number"
    )
    for law, of_law in runs.items():
        if of_law.failed.any():
            said.append(f"{law}: {int(of_law.failed.sum())} runs failed; their realisations are in no sum of it")
    said.append(f"realisations {seed_ranges(ask.seeds)} in every sea state: {states_in_words(ask.seeds)}")
    return said
