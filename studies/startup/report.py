"""Table, data and figure of the two ensembles."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.controllers.supervisor import Rules
from gyroctl.harness.laws import law as build
from gyroctl.harness.seed_ledger import ledger
from gyroctl.provenance import made
from gyroctl.statistics import lock_probability
from gyroctl.studies.startup.draw import draw
from gyroctl.studies.startup.runs import CG_MIN, Case, Ensemble, lost_runs, rest_runs
from gyroctl.studies.style import save, styled
from gyroctl.waves import SeaState
from gyroctl.writing import write_json, write_rows, write_text

LAWS = ("load_angle", "coupling")

WITHIN = {"rest": 200.0, "loss": 120.0}
"""Time by which lock must have begun, from the start and from the end of the fault, to count; and it must then hold to
the end of the run. [s]"""

MEANS = ("starts", "mean_power_w", "stored_w", "turns_kept", "cycle_slips", "outside_share")
MOTION = ("phi1_p98_rad", "phi1_max_rad", "phi3_max_rad")

PAYBACK = 600.0
"""Time by which the net energy is to be positive for good, from rest. [s]"""


def startup_report(
    out: Path,
    seeds: Sequence[int],
    laws: Sequence[str] = LAWS,
    gamma: float = 5.0,
    hs: float = 0.283,
    rules: Rules | None = None,
    dt: float = 0.01,
    durations: tuple[float, float] = (2000.0, 1200.0),
    quiet: bool = False,
) -> dict[str, Any]:
    """Run both ensembles and write startup.json, startup.md, startup_rest.csv, startup_loss.csv and startup.png.

    Parameters
    ----------
    out : Path
        Folder, made where it is missing.
    seeds : sequence of int
        Realisations.
    laws : sequence of str
        Registered laws that are wrapped.
    gamma, hs : float
        Sea. [-], [m]
    rules : Rules, optional
        Of the supervisor.
    dt : float
        Longest step. [s]
    durations : (float, float)
        Of the runs from rest and through the loss. [s]
    quiet : bool
        No progress.

    Returns
    -------
    dict
        What startup.json holds.

    Raises
    ------
    InputError
        For a law, a sea or seeds that cannot be used.
    """
    sea, built = SeaState(hs=hs, gamma=gamma), {name: build(name) for name in laws}
    asked = Ensemble(built, seeds, sea, rules, dt, quiet)
    rest, loss = rest_runs(asked, durations[0]), lost_runs(asked, durations[1])
    result = {
        **made(),
        "sea": {"hs_m": hs, "gamma": gamma, "wp_rad_s": sea.wp},
        "seeds": [int(seed) for seed in seeds],
        "seed_states": ledger().states(seeds),
        "dt_s": dt,
        "cg_min_nms": CG_MIN,
        "durations_s": list(durations),
        "rules": (rules or Rules())._asdict(),
        "rest": {case.law: _rest(case) for case in rest},
        "loss": {case.law: _loss(case) for case in loss},
    }
    write_json(out / "startup.json", result)
    write_text(out / "startup.md", table(result))
    for name, cases in (("rest", rest), ("loss", loss)):
        rows: list[list[str]] = [["law", *cases[0].columns]]
        for case in cases:
            for row in zip(*case.columns.values(), strict=True):
                rows.append([case.law, *(f"{value:.6g}" for value in row)])
        write_rows(out / f"startup_{name}.csv", rows)
    with styled():
        save(draw(rest, loss, f"gamma {gamma:g}, Hs {hs:g} m, {len(seeds)} realisations"), out / "startup.png")
    return result


def table(result: dict[str, Any]) -> str:
    """Both ensembles as Markdown."""
    seeds, rest, loss = result["seeds"], result["rest"], result["loss"]
    durations = result["durations_s"]
    lines = [
        f"Sea: gamma {result['sea']['gamma']:g}, Hs {result['sea']['hs_m']:g} m; seeds {min(seeds)} to {max(seeds)}; "
        f"motor down to cg = {result['cg_min_nms']:g} Nms, {result['rules']['motor_power']:g} W.",
        "",
        f"From rest, {durations[0]:g} s (median, 95 % quantile over the runs):",
        "",
        f"| wrapped law | locked within {WITHIN['rest']:g} s and to the end | 95 % interval | lock after [s] "
        f"| motor [J] | net energy positive after [s] | by {PAYBACK:g} s | net power [W] | availability "
        "| 98 % phi1 locked [rad] | largest phi1 [rad] |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for name, r in rest.items():
        cells = [name, f"{r['locked']}/{r['runs']}", _range(r["ci95"]), _pair(r["locked_after_s"])]
        cells += [_pair(r["motor_j"]), _pair(r["payback_s"]), f"{r['repaid']}/{r['runs']}", f"{r['net_power_w']:.2f}"]
        cells += [f"{r['availability']:.3f}", _pair(r["phi1_p98_rad"], 2), _pair(r["phi1_max_rad"], 2)]
        lines.append(f"| {' | '.join(cells)} |")
    lines += [
        "",
        f"Forced loss (generator stuck at its limit from 400 s on, 20 s at least and until the ring stalls), "
        f"{durations[1]:g} s; times from the end of the fault:",
        "",
        f"| wrapped law | lost | locked again within {WITHIN['loss']:g} s and to the end | 95 % interval "
        "| lock after [s] | fault [s] | motor [J] | largest phi1 [rad] |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, r in loss.items():
        cells = [name, f"{r['lost']}/{r['runs']}", f"{r['locked']}/{r['lost']}", _range(r["ci95"])]
        cells += [_pair(r[key]) for key in ("locked_after_s", "fault_s", "motor_j")]
        lines.append(f"| {' | '.join([*cells, _pair(r['phi1_max_rad'], 2)])} |")
    return "\n".join([*lines, ""])


def _rest(case: Case) -> dict[str, Any]:
    c = case.columns
    locked = (c["locked_after_s"] <= WITHIN["rest"]) & (c["catches"] > 0.0)
    counts = {"runs": locked.size, **_share(locked), "repaid": int(np.sum(c["payback_s"] <= PAYBACK))}
    means = {key: float(c[key].mean()) for key in ("net_power_w", "availability", *MEANS)}
    spreads = ("locked_after_s", "motor_j", "payback_s", *MOTION)
    return {**counts, **means, **_spreads(c, spreads)}


def _loss(case: Case) -> dict[str, Any]:
    c = {key: values[case.columns["lost"] > 0.0] for key, values in case.columns.items()}
    c["fault_s"] = c["fault_ends_s"] - 400.0
    locked = c["locked_after_s"] <= WITHIN["loss"]
    counts = {"runs": case.columns["lost"].size, "lost": locked.size, **_share(locked)}
    spreads = ("locked_after_s", "fault_s", "motor_j", *MOTION)
    return {**counts, **{key: float(c[key].mean()) for key in MEANS}, **_spreads(c, spreads)}


def _share(locked: NDArray[np.bool_]) -> dict[str, Any]:
    chance = lock_probability(locked)
    return {"locked": int(locked.sum()), "ci95": [chance.low, chance.high]}


def _spreads(c: dict[str, NDArray[np.float64]], keys: Sequence[str]) -> dict[str, Any]:
    return {"ledger_residual": float(c["ledger_residual"].max()), **{key: _spread(c[key]) for key in keys}}


def _spread(values: NDArray[np.float64]) -> dict[str, float | None]:
    """Median, 95 % quantile and worst; None where that many runs never got there."""
    filled = np.where(np.isnan(values), np.inf, values)
    median, q95 = (np.quantile(filled, part, method="higher") for part in (0.5, 0.95))
    found = {"median": median, "q95": q95, "worst": filled.max()}
    return {key: float(value) if np.isfinite(value) else None for key, value in found.items()}


def _pair(spread: dict[str, float | None], digits: int = 0) -> str:
    return ", ".join("never" if spread[key] is None else f"{spread[key]:.{digits}f}" for key in ("median", "q95"))


def _range(interval: Sequence[float]) -> str:
    return f"{interval[0]:.3f} to {interval[1]:.3f}"
