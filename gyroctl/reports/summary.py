"""summary.json: the numbers of a comparison for other programs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gyroctl.reports import layout
from gyroctl.reports.evaluation import Evaluation, LawResult, evaluate
from gyroctl.reports.resting import in_words
from gyroctl.statistics import Estimate, PairedDifference
from gyroctl.writing import plain

if TYPE_CHECKING:
    import xarray as xr


def summarise(ds: xr.Dataset, evaluation: Evaluation | None = None) -> dict[str, Any]:
    """Summary of a comparison, safe for JSON: what is not a finite number is None.

    Parameters
    ----------
    ds : xarray.Dataset
        Comparison in the layout of results.nc.
    evaluation : Evaluation, optional
        Its statistics, where they have been worked out already.

    Returns
    -------
    dict
        Keys ``experiment``, ``realisations``, ``laws``, and beside the contract ``yardstick``, ``tuning_seeds``,
        ``seed_states``, ``duration_s``, ``motion_limit_rad``, ``plant``, ``device``, ``tuned_for_another_device``,
        ``power_differences``, ``created``, ``gyroctl_version``.
        ``preview_s`` is None for all of the waves. Units are in the names: ``_w`` [W], ``_s`` [s], ``_ms`` [ms];
        motion [rad]; cycle slips per 1000 waves; ratios, CV and probabilities [1]. Intervals are at 95 %.

    Raises
    ------
    InputError
        The dataset has another layout.
    """
    ds = layout.open_results(ds)
    found = evaluate(ds) if evaluation is None else evaluation
    experiment = layout.read_json(ds, "experiment", None)
    summary: dict[str, Any] = plain(
        {
            "experiment": experiment if isinstance(experiment, dict) else {"text": str(ds.attrs["experiment"])},
            "realisations": [
                {"seed": seed, "sha256": str(digest)}
                for seed, digest in zip(found.seeds, ds["sha256"].values, strict=True)
            ],
            "laws": {law.name: _law(law) for law in found.laws},
            "power_differences": [_difference(difference) for difference in found.power_differences],
            "yardstick": dict(found.yardstick) if found.yardstick else None,
            "tuning_seeds": list(found.tuning_seeds),
            "seed_states": {state: list(seeds) for state, seeds in found.seed_states.items()},
            "duration_s": found.duration,
            "motion_limit_rad": found.motion_limit,
            "plant": found.plant,
            "device": layout.read_json(ds, "device", None),
            "tuned_for_another_device": layout.read_json(ds, "foreign_laws", []),
            "doubts_of_the_device": layout.read_json(ds, "doubts", []),
            "remarks": layout.read_json(ds, "remarks", []),
            "created": str(ds.attrs["created"]),
            "gyroctl_version": str(ds.attrs["gyroctl_version"]),
        }
    )
    return summary


def _law(law: LawResult) -> dict[str, Any]:
    estimates = {"mean_power_ci95": law.power, "power_cv_ci95": law.power_cv}
    estimates |= {"mttl_ci95": law.mttl, "ratio_ci95": law.ratio, "lock_probability_ci95": law.lock}
    return {
        "information": law.information,
        "preview_s": law.preview,
        "mean_power_w": law.power.value,
        "mean_power_ci95": _interval(law.power),
        "mean_power_locked_w": law.power_locked,
        "generated_w": law.generated_w,
        "stored_w": law.stored_w,
        "power_cv": law.power_cv.value,
        "power_cv_ci95": _interval(law.power_cv),
        "p98_over_mean": law.p98_over_mean,
        "locked": law.locked,
        "runs": law.runs,
        "failed": law.failed,
        "failures": {str(seed): why for seed, why in law.failures.items()},
        "lock_probability_ci95": _interval(law.lock),
        "in_step": law.in_step,
        "in_step_probability_ci95": _interval(law.step),
        "turns_kept": law.turns_kept,
        "mttl_s": law.mttl.value,
        "mttl_ci95": _interval(law.mttl),
        "cycle_slips": law.cycle_slips,
        "phi1_p98": law.phi1_p98,
        "phi3_p98": law.phi3_p98,
        "phi1_p98_worst": law.phi1_worst,
        "phi3_p98_worst": law.phi3_worst,
        "runs_over_motion_limit": law.over_limit,
        "runs_outside_model": law.outside_model,
        "outside_share": law.outside_share,
        "phi1_max": law.phi1_max,
        "phi3_max": law.phi3_max,
        **_card(law),
        "wave_input_w": law.wave_input_w,
        "radiated_w": law.radiated_w,
        "hinge_w": law.hinge_w,
        "slip_loss_w": law.slip_loss_w,
        "ledger_residual": law.ledger_residual,
        "capture_width_ratio": law.capture_width_ratio,
        "step_ms_median": law.step_ms_median,
        "step_ms_p99": law.step_ms_p99,
        "deadline_misses": law.deadline_misses,
        "fallbacks": law.fallbacks,
        "availability": law.availability,
        "lock_begins_s": law.lock_begins,
        "payback_s": law.payback_time,
        "motor_energy_j": law.motor_energy,
        "net_energy_j": law.net_energy,
        "starts": law.starts,
        "unloads": law.unloads,
        "ratio_to_best_constant": law.ratio.value,
        "ratio_ci95": _interval(law.ratio),
        "notes": {name: estimate.note for name, estimate in estimates.items() if estimate.note},
    }


def _card(law: LawResult) -> dict[str, Any]:
    """What the numbers rest on, with units in the names, and in words."""
    units = {"coupling_torque_max": "nm", "slip_max": "rad_s", "coupling_loss_max": "w"}
    units |= {"immersion_max": "m", "immersion_min": "m"}
    named = {f"{name}_{units[name]}" if name in units else name: value for name, value in law.card.items()}
    return {**named, "validity": in_words(law.card, law.name)}


def _difference(difference: PairedDifference) -> dict[str, Any]:
    return {
        "first": difference.first,
        "second": difference.second,
        "difference_w": difference.estimate.value,
        "ci95": _interval(difference.estimate),
        "p_value": difference.p_value,
        "p_holm": difference.p_holm,
        "holm_over": difference.tests,
        "verdict": difference.words,
    }


def _interval(estimate: Estimate) -> list[float]:
    return [estimate.low, estimate.high]
