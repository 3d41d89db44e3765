"""What a comparison says, law by law: every number of the report, the table and summary.json comes from here."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gyroctl.reports import layout
from gyroctl.statistics import (
    Estimate,
    PairedDifference,
    Survival,
    bootstrap_mean,
    finite_mean,
    lock_probability,
    lock_survival,
    mean_time_to_loss,
    paired_differences,
    paired_ratio,
)

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class LawResult:
    """One law over all realisations.

    Means are over all realisations, lost runs included, so that losing lock costs power here as it does at sea.

    Parameters
    ----------
    name, label, information : str
        Name in the experiment, name in words, and what the law may see (none, sensors, forecast, oracle).
    runs, locked : int
        Number of runs, and of those that held lock to the end.
    power, power_cv, ratio : Estimate
        Mean electrical power [W], coefficient of variation of power within a run [1], mean power over that of the
        reference [1].
    power_locked : float
        Mean electrical power of the runs that held lock. [W]
    p98_over_mean, cycle_slips : float
        98 % quantile of power over its mean [1]; cycle slips per 1000 waves.
    lock, mttl : Estimate
        Probability to hold lock [1]; mean time to lose lock [s].
    survival : Survival
        Kaplan-Meier curve of lock.
    phi1_p98, phi3_p98, phi1_worst, phi3_worst : float
        98 % of |phi1|, |phi3|: mean over realisations and the worst realisation. [rad]
    over_limit, outside_model : int
        Runs whose 98 % motion exceeds the limit; runs that leave the range of the linear float model.
    wave_input_w, radiated_w, hinge_w, slip_loss_w, stored_w : float
        Mean power flows. [W]
    ledger_residual : float
        Largest |residual| of the energy ledger, relative to the wave input. [1]
    capture_width_ratio, saturations, step_ms_median, step_ms_p99 : float
        Mean capture width ratio [1], saturated samples (mean of what is stored), median and worst 99 % time of a
        step. [ms]
    deadline_misses, fallbacks, starts, unloads : int or None
        Sums over realisations, None where not recorded: the last two count what a supervisor did.
    availability, lock_begins, payback_time : float
        Mean share of time in locked production [1]; medians of the time at which that begins, and from which the net
        energy stays positive [s], NaN where half of the runs never get there.
    motor_energy, net_energy : float
        Mean energy that the motor took, and of the generator less that. [J]
    """

    name: str
    label: str
    information: str
    runs: int
    locked: int
    power: Estimate
    power_locked: float
    power_cv: Estimate
    p98_over_mean: float
    ratio: Estimate
    lock: Estimate
    mttl: Estimate
    survival: Survival
    cycle_slips: float
    phi1_p98: float
    phi3_p98: float
    phi1_worst: float
    phi3_worst: float
    over_limit: int
    outside_model: int
    wave_input_w: float
    radiated_w: float
    hinge_w: float
    slip_loss_w: float
    stored_w: float
    ledger_residual: float
    capture_width_ratio: float
    saturations: float
    step_ms_median: float
    step_ms_p99: float
    deadline_misses: int | None
    fallbacks: int | None
    availability: float
    lock_begins: float
    payback_time: float
    motor_energy: float
    net_energy: float
    starts: int | None
    unloads: int | None


@dataclass(frozen=True)
class Evaluation:
    """A whole comparison: the laws, their paired differences and what the numbers refer to.

    Parameters
    ----------
    laws : tuple of LawResult
        In the order of the file.
    power_differences, cv_differences : tuple of PairedDifference
        Every pair of laws on identical realisations, in mean power [W] and in power CV [1]; each family Holm-corrected.
    reference : str or None
        The law that ratios refer to, None where the comparison has none.
    seeds, tuning_seeds : tuple of int
        Evaluation seeds and tuning seeds.
    duration : float
        Duration of every run. [s]
    motion_limit : float
        Limit of the 98 % motion. [rad]
    """

    laws: tuple[LawResult, ...]
    power_differences: tuple[PairedDifference, ...]
    cv_differences: tuple[PairedDifference, ...]
    reference: str | None
    seeds: tuple[int, ...]
    tuning_seeds: tuple[int, ...]
    duration: float
    motion_limit: float

    def law(self, name: str) -> LawResult:
        """Find the result of the law `name`."""
        return next(law for law in self.laws if law.name == name)

    @property
    def by_power(self) -> tuple[LawResult, ...]:
        """The laws, most mean power first."""
        return tuple(sorted(self.laws, key=lambda law: -law.power.value if np.isfinite(law.power.value) else np.inf))

    @property
    def seed_overlap(self) -> tuple[int, ...]:
        """Seeds that were used both for tuning and for evaluation: should be empty."""
        return tuple(sorted(set(self.seeds) & set(self.tuning_seeds)))

    def difference(self, first: str, second: str) -> PairedDifference:
        """Paired difference in mean power between two laws, the one with more power first."""
        return next(d for d in self.power_differences if {d.first, d.second} == {first, second})


def evaluate(source: xr.Dataset) -> Evaluation:
    """Work out every statistic of a comparison.

    Parameters
    ----------
    source : xarray.Dataset
        Comparison in the layout of results.nc.

    Returns
    -------
    Evaluation
        Deterministic: equal datasets give equal digits.

    Raises
    ------
    InputError
        The dataset has another layout.
    """
    ds = layout.open_results(source)
    laws = layout.names(ds)
    reference = layout.REFERENCE if layout.REFERENCE in laws else None
    limit = float(ds.attrs.get("motion_limit", layout.MOTION_LIMIT))
    return Evaluation(
        laws=tuple(_law(ds, index, reference, limit) for index in range(len(laws))),
        power_differences=paired_differences(laws, _values(ds, "mean_power")),
        cv_differences=paired_differences(laws, _values(ds, "power_cv"), words=("rougher", "smoother")),
        reference=reference,
        seeds=tuple(int(seed) for seed in ds["realisation"].values),
        tuning_seeds=_tuning_seeds(ds),
        duration=layout.duration(ds),
        motion_limit=limit,
    )


def _law(ds: xr.Dataset, index: int, reference: str | None, limit: float) -> LawResult:
    name = layout.names(ds)[index]
    row = {v: _values(ds, v)[index] for v in (*layout.REQUIRED, *layout.OPTIONAL)}
    locked = _flags(ds, "locked")[index]
    length = layout.duration(ds)
    power = row["mean_power"]
    if reference is None:
        ratio = Estimate(np.nan, np.nan, np.nan, "no best_constant in this comparison")
    else:
        ratio = paired_ratio(power, _values(ds, "mean_power")[layout.names(ds).index(reference)])
    return LawResult(
        name=name,
        label=str(ds["label"].values[index]) if "label" in ds.variables else name,
        information=str(ds["information"].values[index]),
        runs=locked.size,
        locked=int(locked.sum()),
        power=bootstrap_mean(power),
        power_locked=finite_mean(power[locked]),
        power_cv=bootstrap_mean(row["power_cv"]),
        p98_over_mean=finite_mean(row["p98_over_mean"]),
        ratio=ratio,
        lock=lock_probability(locked),
        mttl=mean_time_to_loss(row["loss_time"], length),
        survival=lock_survival(row["loss_time"], length),
        cycle_slips=finite_mean(row["cycle_slips"]),
        phi1_p98=finite_mean(row["phi1_p98"]),
        phi3_p98=finite_mean(row["phi3_p98"]),
        phi1_worst=_largest(row["phi1_p98"]),
        phi3_worst=_largest(row["phi3_p98"]),
        over_limit=int(((row["phi1_p98"] > limit) | (row["phi3_p98"] > limit)).sum()),
        outside_model=int(_flags(ds, "outside_model")[index].sum()),
        wave_input_w=finite_mean(row["wave_input_w"]),
        radiated_w=finite_mean(row["radiated_w"]),
        hinge_w=finite_mean(row["hinge_w"]),
        slip_loss_w=finite_mean(row["slip_loss_w"]),
        stored_w=finite_mean(row["stored_w"]),
        ledger_residual=_largest(np.abs(row["ledger_residual"])),
        capture_width_ratio=finite_mean(row["capture_width_ratio"]),
        saturations=finite_mean(row["saturations"]),
        step_ms_median=_median(row["step_ms_median"]),
        step_ms_p99=_largest(row["step_ms_p99"]),
        deadline_misses=_total(row["deadline_misses"]),
        fallbacks=_total(row["fallbacks"]),
        availability=finite_mean(row["availability"]),
        lock_begins=_usual(row["lock_begins"]),
        payback_time=_usual(row["payback_time"]),
        motor_energy=finite_mean(row["motor_energy"]),
        net_energy=finite_mean(row["net_energy"]),
        starts=_total(row["starts"]),
        unloads=_total(row["unloads"]),
    )


def _values(ds: xr.Dataset, variable: str) -> NDArray[np.float64]:
    """Values over (law, realisation), NaN where the file has no such variable."""
    if variable not in ds.variables:
        return np.full((ds.sizes["law"], ds.sizes["realisation"]), np.nan)
    return np.asarray(ds[variable].transpose("law", "realisation").values, dtype=np.float64)


def _flags(ds: xr.Dataset, variable: str) -> NDArray[np.bool_]:
    values = _values(ds, variable)
    return np.asarray(np.isfinite(values) & (values != 0.0), dtype=np.bool_)


def _largest(values: NDArray[np.float64]) -> float:
    kept = values[np.isfinite(values)]
    return float(kept.max()) if kept.size else float("nan")


def _median(values: NDArray[np.float64]) -> float:
    kept = values[np.isfinite(values)]
    return float(np.median(kept)) if kept.size else float("nan")


def _usual(values: NDArray[np.float64]) -> float:
    """Median in which a run that never gets there counts as later than all others."""
    middle = np.sort(values)[values.size // 2]  # NaN is sorted last
    return float(middle)


def _total(values: NDArray[np.float64]) -> int | None:
    kept = values[np.isfinite(values)]
    return int(kept.sum()) if kept.size else None


def _tuning_seeds(ds: xr.Dataset) -> tuple[int, ...]:
    seeds = layout.read_json(ds, "tuning_seeds", [])
    return tuple(int(seed) for seed in seeds) if isinstance(seeds, list) else ()
