"""A year at a site, from the runs of its sea states: energy, hours out of step, hours with a reversal.

All sums are over the sea states that are counted, each weighted by its hours in a mean year; intervals are 95 %.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.statistics import (
    Estimate,
    bootstrap_mean,
    lock_probability,
    stratified_ratio,
    stratified_share,
    stratified_sum,
)
from gyroctl.studies.site.runs import LawRuns
from gyroctl.studies.site.scatter import YEAR


class InCell(NamedTuple):
    """A law in a sea state, at the plant's scale where nothing else is said."""

    power: Estimate  # [W]
    power_at_site: Estimate  # [W]
    lock: Estimate  # probability to keep it to the end of a run [1]
    in_step: Estimate  # likewise [1]
    capture_width: Estimate  # at the site [m]
    capture_ratio: float  # over the width of the device [1]
    reversing: float  # share of the runs with a reversal [1]
    reversals: float  # in an hour [1/h]
    over_motion: float  # share of the runs beyond the limit of motion [1]
    failed: int


class Annual(NamedTuple):
    """A law in a year, at the site where nothing else is said."""

    energy: Estimate  # [kWh]
    energy_of_plant: Estimate  # of the plant itself, in the sea states at its scale [kWh]
    energy_if_lost: float  # were a run that loses lock worth nothing [kWh]
    mean_power: float  # over the year [W]
    capture_ratio: float  # energy over that of the waves on the width of the device, where it is counted [1]
    ratio_to_site: Estimate  # energy over that of the one pair for the site [1]
    ratio_to_seas: Estimate  # over that of the best pair of each sea state [1]
    out_of_step: Estimate  # hours [h]
    out_of_lock: Estimate  # hours of runs that lose lock [h]
    reversing: Estimate  # hours of runs with a reversal [h]
    reversals: float  # in the year [1]
    over_motion: float  # hours of runs beyond the limit of motion [h]
    failed: int  # runs


class Still(NamedTuple):
    """Time in which the device stands still and gives nothing, for want of a locked orbit or of waves."""

    hours: float  # in a year [h]
    in_waves: float  # energy of the waves in it [Wh/m]


NOTHING_STILL = Still(0.0, 0.0)

NO_LOCK = Estimate(0.0, 0.0, 0.0, "no locked orbit to begin on")


class Scale(NamedTuple):
    """What turns the plant's runs into the site's year."""

    length: float  # of the site's device over the plant's [1]
    width: float  # of the plant across the waves [m]
    scored: float  # time that a run is scored [s]
    motion_limit: float  # [rad]

    @property
    def power(self) -> float:
        """Of the power. [1]"""
        return float(self.length**3.5)

    @property
    def runs_an_hour(self) -> float:
        """Scored times in an hour of the site, whose waves are slower by the root of the scale. [1/h]"""
        return 3600.0 / (self.scored * float(np.sqrt(self.length)))


def in_cell(runs: LawRuns, at: int, flux: float, scale: Scale) -> InCell:
    """A law in the sea state at a place; `flux` is the power of the waves at the site [W/m]."""
    power = bootstrap_mean(runs.power[at])
    there = _times(power, scale.power)
    width = _times(there, 1.0 / flux) if flux > 0.0 else Estimate(np.nan, np.nan, np.nan, "no waves")
    good = ~runs.failed[at]
    turning = runs.reversals[at][good]
    return InCell(
        power,
        there,
        lock_probability(np.where(good, runs.locked[at], np.nan)),
        lock_probability(np.where(good, runs.in_step[at], np.nan)),
        width,
        width.value / (scale.width * scale.length),
        _mean(turning > 0.0),
        _mean(turning) * scale.runs_an_hour,
        _mean(runs.motion[at][good] > scale.motion_limit),
        int(runs.failed[at].sum()),
    )


def standing_still() -> InCell:
    """Any law in a sea state in which no lock begins."""
    return InCell(NO_LOCK, NO_LOCK, NO_LOCK, NO_LOCK, NO_LOCK, 0.0, 0.0, 0.0, 0.0, 0)


def annual(
    laws: Mapping[str, LawRuns],
    hours: NDArray[np.float64],
    flux: NDArray[np.float64],
    scale: Scale,
    site: str,
    seas: str,
    still: Still = NOTHING_STILL,
) -> dict[str, Annual]:
    """Each law in a year.

    Parameters
    ----------
    laws : mapping of str to LawRuns
        Runs in the sea states that are run.
    hours, flux : (cells,) array
        Of these sea states in a year [h], and the power of their waves at the site [W/m].
    scale : Scale
        From the plant to the site.
    site, seas : str
        Names of the pair for the whole site and of the best pairs of the sea states.
    still : Still
        Time that counts beside them, in which nothing is given and there is no lock.
    """
    in_waves = (float(hours @ flux) + still.in_waves) * scale.width * scale.length
    found = {}
    for name, runs in laws.items():
        plant = _times(stratified_sum(runs.power, hours), 1e-3)
        energy = _times(plant, scale.power)
        kept = np.where(runs.locked, runs.power, 0.0)
        turning = np.nan_to_num(runs.reversals, nan=0.0)
        found[name] = Annual(
            energy,
            plant,
            float(np.nansum(hours * _rows(kept))) * 1e-3 * scale.power,
            energy.value * 1e3 / YEAR,
            energy.value * 1e3 / in_waves if in_waves > 0.0 else float("nan"),
            stratified_ratio(runs.power, laws[site].power, hours),
            stratified_ratio(runs.power, laws[seas].power, hours),
            _more(stratified_share(~runs.in_step, hours), still.hours),
            _more(stratified_share(runs.lost, hours), still.hours),
            stratified_share((turning > 0.0) | runs.failed, hours),
            float(hours @ _rows(turning)) * scale.runs_an_hour,
            float(hours @ _rows(runs.motion > scale.motion_limit)),
            int(runs.failed.sum()),
        )
    return found


def _rows(values: NDArray[Any]) -> NDArray[np.float64]:
    """Mean of each sea state."""
    return np.asarray(np.mean(np.asarray(values, np.float64), axis=1))


def _mean(values: NDArray[Any]) -> float:
    return float(np.mean(values)) if values.size else float("nan")


def _more(estimate: Estimate, sure: float) -> Estimate:
    """Estimate with a number added that is sure."""
    value, low, high, note = estimate
    return Estimate(value + sure, low + sure, high + sure, note)


def _times(estimate: Estimate, factor: float) -> Estimate:
    """Estimate in another unit."""
    value, low, high, note = estimate
    return Estimate(value * factor, low * factor, high * factor, note)
