"""What a comparison says, law by law: every number of the report, the table and summary.json comes from here."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.reports import layout
from gyroctl.statistics import (
    Estimate,
    PairedDifference,
    Survival,
    bootstrap_mean,
    finite_largest,
    finite_mean,
    lock_probability,
    lock_survival,
    mean_time_to_loss,
    paired_differences,
    paired_ratio,
)

if TYPE_CHECKING:
    import xarray as xr

ROUGH = ("rougher", "smoother")
"""What more and less of the power CV are called."""


@dataclass(frozen=True)
class LawResult:
    """One law over all realisations.

    Means are over all realisations, lost runs included, so that losing lock costs power here as it does at sea.
    Sums are None, other numbers NaN where the file does not record them.
    """

    name: str  # in the experiment
    label: str  # in words
    information: str  # what the law may see: none, sensors, gauge, forecast, oracle
    preview: float  # how far ahead it is told the waves, infinite for all of them [s]
    runs: int  # realisations
    failures: Mapping[int, str]  # why runs failed, by seed: these have no numbers
    locked: int  # runs that held lock to the end
    in_step: int | None  # runs in step with the waves
    power: Estimate  # mean power that is judged: generated and stored, over the time [W]
    power_locked: float  # the same of the runs that held lock [W]
    generated_w: float  # its electrical part [W]
    power_cv: Estimate  # coefficient of variation of power within a run [1]
    p98_over_mean: float  # 98 % quantile of power over its mean [1]
    ratio: Estimate  # mean power over that of the reference [1]
    lock: Estimate  # probability to hold lock [1]
    mttl: Estimate  # mean time to lose lock [s]
    survival: Survival  # Kaplan-Meier curve of lock
    step: Estimate  # probability to be in step [1]
    turns_kept: float  # ring speed over that of the waves [1]
    cycle_slips: float  # per 1000 waves [-]
    phi1_p98: float  # 98 % of |phi1|, mean over realisations [rad]
    phi3_p98: float  # 98 % of |phi3|, mean over realisations [rad]
    phi1_worst: float  # 98 % of |phi1|, worst realisation [rad]
    phi3_worst: float  # 98 % of |phi3|, worst realisation [rad]
    over_limit: int  # runs whose 98 % motion exceeds the limit
    outside_model: int  # runs that leave the range of the linear float model
    outside_share: float  # share of the time beyond it, |phi| > 0.3 rad [1]
    phi1_max: float  # largest |phi1| of any run [rad]
    phi3_max: float  # largest |phi3| of any run [rad]
    wave_input_w: float  # mean power flow, as the next four [W]
    radiated_w: float  # [W]
    hinge_w: float  # [W]
    slip_loss_w: float  # [W]
    stored_w: float  # [W]
    ledger_residual: float  # largest |residual| of the energy ledger, relative to the wave input [1]
    capture_width_ratio: float  # [1]
    saturations: float  # saturated samples, mean of what is stored [-]
    step_ms_median: float  # time of a step [ms]
    step_ms_p99: float  # 99 % of the time of a step, worst run [ms]
    deadline_misses: int | None  # sum over realisations
    fallbacks: int | None  # sum over realisations
    availability: float  # mean share of time in locked production [1]
    lock_begins: float  # median time at which that begins, NaN where half of the runs never get there [s]
    payback_time: float  # median time from which the net energy stays positive, NaN likewise [s]
    motor_energy: float  # mean energy that the motor took [J]
    net_energy: float  # mean energy of the generator less that of the motor [J]
    starts: int | None  # of a supervisor, sum over realisations
    unloads: int | None  # of a supervisor, sum over realisations
    card: Mapping[str, float] = field(default_factory=dict)  # what the numbers rest on [unit of each], see `_card`

    @property
    def failed(self) -> int:
        """Runs that failed."""
        return len(self.failures)

    @property
    def flows(self) -> dict[str, float]:
        """Where the wave input goes. [W]"""
        lost = {"slip": self.slip_loss_w, "hinge": self.hinge_w, "radiated": self.radiated_w}
        return {"generator": self.generated_w, **lost, "stored": self.stored_w}


@dataclass(frozen=True)
class Evaluation:
    """A whole comparison: the laws, their paired differences and what the numbers refer to."""

    laws: tuple[LawResult, ...]  # in the order of the file
    power_differences: tuple[PairedDifference, ...]  # mean power of pairs of laws, Holm-corrected, see `_pairs` [W]
    cv_differences: tuple[PairedDifference, ...]  # power CV of the same pairs [1]
    reference: str | None  # the law that ratios refer to, None where the comparison has none
    seeds: tuple[int, ...]  # evaluation seeds
    tuning_seeds: tuple[int, ...]  # seeds that laws were tuned on
    duration: float  # of every run [s]
    motion_limit: float  # of the 98 % motion [rad]
    yardstick: Mapping[str, Any] | None = None  # how the reference was found, None where the file does not say
    seed_states: Mapping[str, Sequence[int]] = field(default_factory=dict)  # seeds by their state in the ledger
    plant: str = ""  # name of the device, empty where the file does not say
    slips: bool = False  # whether its rolling contact may slip
    strongest: str = ""  # of more than a few laws the one that all are compared with beside the reference
    powers: Mapping[str, NDArray[np.float64]] = field(default_factory=dict, repr=False)  # of each run, by law [W]

    def law(self, name: str) -> LawResult:
        """Find the result of the law `name`."""
        return self._by_name[name]

    @cached_property
    def _by_name(self) -> dict[str, LawResult]:
        return {law.name: law for law in self.laws}

    @cached_property
    def _by_pair(self) -> dict[tuple[str, frozenset[str]], PairedDifference]:
        kinds = {"power": self.power_differences, "cv": self.cv_differences}
        return {(kind, frozenset((d.first, d.second))): d for kind, found in kinds.items() for d in found}

    @cached_property
    def by_power(self) -> tuple[LawResult, ...]:
        """The laws, most mean power first."""
        return tuple(sorted(self.laws, key=lambda law: -law.power.value if np.isfinite(law.power.value) else np.inf))

    @property
    def seed_overlap(self) -> tuple[int, ...]:
        """Seeds that were used both for tuning and for evaluation: should be empty."""
        return tuple(sorted(set(self.seeds) & set(self.tuning_seeds)))

    def difference(self, first: str, second: str) -> PairedDifference:
        """Paired difference in mean power between two laws, the one with more power first.

        A pair that is not among `power_differences` is compared now, and corrected as one of all pairs.
        """
        known = self._by_pair.get(("power", frozenset((first, second))))
        if known is None:
            both, every = np.stack([self.powers[first], self.powers[second]]), _every(len(self.powers))
            (known,) = paired_differences([first, second], both, tests=every)
        return known

    def cv_difference(self, first: str, second: str) -> PairedDifference:
        """Paired difference in power CV of a pair that is among `power_differences`."""
        return self._by_pair["cv", frozenset((first, second))]


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
    tuning_seeds = layout.read_json(ds, "tuning_seeds", [])
    power, cv = layout.values(ds, "mean_power"), layout.values(ds, "power_cv")
    strongest = _strongest(ds, power) if len(laws) > layout.FEW else ""
    return Evaluation(
        laws=tuple(_laws(ds, reference, limit)),
        power_differences=_pairs(laws, power, reference, strongest),
        cv_differences=_pairs(laws, cv, reference, strongest, words=ROUGH, zero_if_lost=False),
        strongest=strongest,
        powers=dict(zip(laws, power, strict=True)),
        reference=reference,
        seeds=tuple(int(seed) for seed in ds["realisation"].values),
        tuning_seeds=tuple(int(seed) for seed in tuning_seeds) if isinstance(tuning_seeds, list) else (),
        duration=layout.duration(ds),
        motion_limit=limit,
        yardstick=layout.read_json(ds, "yardstick", None),
        seed_states=layout.read_json(ds, "seed_states", {}),
        plant=str(ds.attrs.get("plant", "")),
        slips=ds.attrs.get("contact") == "friction",
    )


def _strongest(ds: xr.Dataset, power: NDArray[np.float64]) -> str:
    """Law with the most mean power among those without an oracle, or among all where each has one."""
    means = np.array([finite_mean(row) for row in power])
    causal = np.isfinite(means) & (ds["information"].values != "oracle")
    among = causal if causal.any() else np.isfinite(means)
    return layout.names(ds)[int(np.argmax(np.where(among, means, -np.inf)))]


def _every(laws: int) -> int:
    """Pairs of so many laws."""
    return laws * (laws - 1) // 2


def _pairs(
    laws: Sequence[str], values: NDArray[np.float64], reference: str | None, strongest: str, **kind: Any
) -> tuple[PairedDifference, ...]:
    """Pairs of laws that are compared: all of a few laws, and of more those with the reference and the strongest.

    The pairs with the reference are named before there is a result: Holm's correction counts them alone. The strongest
    is known by its result: its pairs are corrected as some of all pairs, so that the words stay right for it.
    """
    if not strongest:
        return paired_differences(laws, values, **kind)
    with_reference = [(law, reference) for law in laws if law != reference] if reference is not None else []
    with_strongest = [(law, strongest) for law in laws if law not in (strongest, reference) and strongest != reference]
    chosen = paired_differences(laws, values, pairs=with_strongest, tests=_every(len(laws)), **kind)
    return (*paired_differences(laws, values, pairs=with_reference, **kind), *chosen)


def _laws(ds: xr.Dataset, reference: str | None, limit: float) -> Iterator[LawResult]:
    """Each variable is read once, and not once a law."""
    names, failures = layout.names(ds), layout.failures(ds)
    table = {variable: layout.values(ds, variable) for variable in (*layout.REQUIRED, *layout.OPTIONAL)}
    if "generated_w" not in ds.variables:  # of old, the mean power was the electrical one
        table["generated_w"] = table["mean_power"]
    beside = table["mean_power"][names.index(reference)] if reference is not None else None
    labels = [str(label) for label in ds["label"].values] if "label" in ds.variables else names
    seen = [str(level) for level in ds["information"].values]
    ahead = ds["preview"].values if "preview" in ds.variables else np.full(len(names), np.nan)
    for k, name in enumerate(names):
        row = {variable: values[k] for variable, values in table.items()}
        facts = {"name": name, "label": labels[k], "information": seen[k], "preview": float(ahead[k])}
        yield _law(ds, row, failures[k], beside, limit, facts)


def _law(
    ds: xr.Dataset,
    row: Mapping[str, NDArray[np.float64]],
    failures: Mapping[int, str],
    beside: NDArray[np.float64] | None,
    limit: float,
    facts: Mapping[str, Any],
) -> LawResult:
    locked, duration = _flags(row["locked"]), layout.duration(ds)
    finished = np.isfinite(row["locked"]) & ~np.isin(ds["realisation"].values, list(failures))
    known, unknown = "in_step" in ds.variables, Estimate(np.nan, np.nan, np.nan, "not recorded")
    ratio = Estimate(np.nan, np.nan, np.nan, "no best_constant in this comparison")
    if beside is not None:
        ratio = paired_ratio(row["mean_power"], beside)
    means = ("p98_over_mean", "cycle_slips", "turns_kept", "capture_width_ratio", "saturations", "generated_w")
    floating = ("outside_share", *layout.MOTION, *layout.FLOWS)
    supervised = ("availability", "motor_energy", "net_energy")
    same: dict[str, Any] = {variable: finite_mean(row[variable]) for variable in (*means, *floating, *supervised)}
    same |= {variable: _total(row[variable]) for variable in ("deadline_misses", "fallbacks", "starts", "unloads")}
    return LawResult(
        **facts,
        runs=locked.size,
        failures=failures,
        locked=int(locked.sum()),
        in_step=_total(row["in_step"]),
        step=lock_probability(_flags(row["in_step"])) if known else unknown,
        power=bootstrap_mean(row["mean_power"]),
        power_locked=finite_mean(row["mean_power"][locked]),
        power_cv=bootstrap_mean(row["power_cv"], zero_if_lost=False),
        ratio=ratio,
        lock=lock_probability(row["locked"]),
        mttl=mean_time_to_loss(row["loss_time"], duration, finished=finished),
        survival=lock_survival(row["loss_time"], duration, finished=finished),
        phi1_worst=finite_largest(row["phi1_p98"]),
        phi3_worst=finite_largest(row["phi3_p98"]),
        over_limit=int(((row["phi1_p98"] > limit) | (row["phi3_p98"] > limit)).sum()),
        outside_model=int(_flags(row["outside_model"]).sum()),
        phi1_max=finite_largest(row["phi1_max"]),
        phi3_max=finite_largest(row["phi3_max"]),
        ledger_residual=finite_largest(np.abs(row["ledger_residual"])),
        step_ms_median=_median(row["step_ms_median"]),
        step_ms_p99=finite_largest(row["step_ms_p99"]),
        lock_begins=_usual(row["lock_begins"]),
        payback_time=_usual(row["payback_time"]),
        card=_card(row),
        **same,
    )


def _card(row: Mapping[str, NDArray[np.float64]]) -> dict[str, float]:
    """What the numbers of a law rest on: largest and smallest sizes of any run, counts and shares as means."""
    extreme = {"immersion_min": lambda values: -finite_largest(-values)}
    extreme |= {name: finite_largest for name in layout.CARD if name.endswith("_max")}
    return {name: float(extreme.get(name, finite_mean)(row[name])) for name in layout.CARD}


def _flags(values: NDArray[np.float64]) -> NDArray[np.bool_]:
    return np.asarray(np.isfinite(values) & (values != 0.0), dtype=np.bool_)


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
