"""Time series of many realisations under one constant pair, for the figures that show runs."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.controllers.rule_based import Constant
from gyroctl.devices import zhang2017
from gyroctl.harness.run import Settings, lead_in, run_law
from gyroctl.plant.equations import OMEGA_RATE, PHI1, PHI3, PSI, PSI_RATE
from gyroctl.simulation.lock import WINDOW, loss_time
from gyroctl.simulation.progress import track
from gyroctl.studies.paper.ensembles import BLEND, WP, Setup, sea
from gyroctl.waves import realise


class Series(NamedTuple):
    """Runs on a common time axis; arrays (seeds, samples) unless noted."""

    time: NDArray[np.float64]  # (samples,) [s]
    phi1: NDArray[np.float64]  # [rad]
    phi3: NDArray[np.float64]  # [rad]
    ring_speed: NDArray[np.float64]  # [rad/s]
    ring_speed_10s: NDArray[np.float64]  # mean of the past 10 s, NaN before [rad/s]
    flywheel_speed: NDArray[np.float64]  # [rad/s]
    power: NDArray[np.float64]  # [W]
    loss_time: NDArray[np.float64]  # (seeds,) [s]

    def example(self, lost: bool) -> int:
        """Index of a typical run: of those that lost lock, the one nearest to the median time; else the first."""
        is_lost = ~np.isnan(self.loss_time)
        chosen = np.flatnonzero(is_lost == lost)
        if chosen.size == 0:
            return 0
        if not lost:
            return int(chosen[0])
        times = self.loss_time[chosen]
        return int(chosen[np.argmin(np.abs(times - np.median(times)))])


@lru_cache(maxsize=8)
def time_series(setup: Setup, gamma: float, cc: float, cg: float, variant: str = "corrected") -> Series:
    """Run the first `setup.examples` realisations and keep their signals, sampled at 0.1 s."""
    given = (variant, gamma, cc, cg, setup.examples)
    steps = setup.kept((__name__,), Series, f"time series, {variant}, gamma {gamma:g}", zhang2017(variant), *given)
    return steps(f"cc {cc:g}, cg {cg:g}", lambda: _run(setup, gamma, cc, cg, variant))


def _run(setup: Setup, gamma: float, cc: float, cg: float, variant: str) -> Series:
    plant, settings, law = zhang2017(variant), Settings(blend=BLEND), Constant(cc, cg)
    chosen = setup.seeds[: setup.examples]
    states = []
    for seed in track(chosen, f"time series, gamma {gamma:g}", len(chosen), setup.quiet):
        waves = lead_in(realise(plant, sea(gamma), seed, setup.duration), settings)
        record, _ = run_law(plant, law, waves, settings, "constant")
        states.append(record.states[:, [PHI1, PHI3, PSI, PSI_RATE, OMEGA_RATE]])
    phi1, phi3, psi, speed, flywheel = np.stack(states).transpose(2, 0, 1)
    period = settings.actuators.period
    span = round(WINDOW / period)
    mean = np.full(psi.shape, np.nan)
    mean[:, span:] = (psi[:, span:] - psi[:, :-span]) / WINDOW
    time = np.arange(psi.shape[1]) * period
    return Series(time, phi1, phi3, speed, mean, flywheel, cg * flywheel**2, np.asarray(loss_time(psi.T, period, WP)))
