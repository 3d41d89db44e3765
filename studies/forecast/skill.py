"""Error of the forecast against the lead, by what it is made from."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.devices import zhang2017
from gyroctl.harness.actuation import Actuators
from gyroctl.harness.laws import law
from gyroctl.harness.run import Settings, lead_in, run_law
from gyroctl.harness.sensing import Sensors
from gyroctl.plant import Plant
from gyroctl.plant.measurement import ROWS
from gyroctl.waves import DriftingSea, SeaState, realise
from gyroctl.waves.estimation import MomentEstimator, Predictor, coverage, relative_error, replay, replay_moments

Array = NDArray[np.float64]

LEADS = (0.5, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0)
"""How far ahead. [s]"""

FIRST = 200.0
"""What is foreseen before does not count: the sea is blended in over 100 s and then learnt. [s]"""

SOURCES = ("true moments", "true moments, sea known", "sensors", "sensors, sea known", "sensors, generic sea")
"""What a forecast is made from."""


class Skill(NamedTuple):
    """Mean square errors over the variance of the moments."""

    error: Array  # (sources, 2, leads)
    now: Array  # (2, 2), at the sample: of the estimator's moments, of the smoothed ones
    within: Array  # (2, 2, leads), "sensors": share of errors within one and two deviations that the forecast says
    runs: Array  # (realisations, sources, 2, leads), the errors of each


def skill(
    sea: SeaState | DriftingSea,
    name: str,
    seeds: Sequence[int],
    duration: float,
    truth: Plant,
    design: Plant | None = None,
    actuators: Actuators | None = None,
) -> Skill:
    """Forecast on closed-loop runs of a law, the estimator being designed on another plant than the true one.

    Parameters
    ----------
    sea : SeaState or DriftingSea
        The waves; a drifting sea is not known, and "sea known" is then NaN.
    name : str
        Law that moves the device.
    seeds : sequence of int
        Realisations.
    duration : float
        Of each. [s]
    truth : Plant
        What the loop is run with.
    design : Plant, optional
        What estimator and forecast are designed with; the linear device.
    actuators : Actuators, optional
        Of the loop; ideal ones.
    """
    design, settings = design or zhang2017(), Settings(sensors=Sensors(), actuators=actuators or Actuators())
    slow = settings.actuators
    estimator = MomentEstimator.design(design, delay=slow.delay, lag=(slow.cc_lag, slow.cg_lag))
    known = sea if isinstance(sea, SeaState) else None
    errors, now, within = [], [], []
    for seed in seeds:
        waves = lead_in(realise(truth, sea, seed, duration), settings)
        run, _ = run_law(truth, law(name), waves, settings)
        n = len(run.controls)
        measured = _measured(run.states[:n], settings.sensors, seed)
        moments = np.ascontiguousarray(waves.moments[:, :: round(slow.period / waves.dt)])
        row = []
        for source in SOURCES:
            if "sea known" in source and known is None:
                row.append(np.full((2, len(LEADS)), np.nan))
                continue
            learns = "known" not in source and "generic" not in source
            heard = None if "true" in source else estimator
            predictor = Predictor.design(
                design, sea=known if "known" in source else None, estimator=heard, forgetting=120.0 if learns else None
            )
            if heard is None:
                ahead = replay_moments(predictor, LEADS, moments[:, :n])
            else:
                said = replay(predictor, LEADS, estimator, measured, run.commands)
                ahead = said.ahead
                if source == "sensors":
                    now.append([_at_the_sample(moments, values) for values in (said.me_hat, said.now)])
                    within.append(coverage(predictor, LEADS, said, moments, FIRST))
            row.append(relative_error(predictor, LEADS, ahead, moments, FIRST))
        errors.append(row)
    error, sampled, share = (np.mean(each, axis=0) for each in (errors, now, within))
    return Skill(error, sampled, share, np.array(errors))


def _measured(states: Array, sensors: Sensors, seed: int) -> Array:
    """What the sensors said of the states (n, rows), as in the loop: (n, 7)."""
    errors = sensors.arrays(len(states), seed)
    y = states[:, list(ROWS)] + errors.error
    for channel, quantum in enumerate(errors.quantum):
        if quantum > 0.0:
            y[:, channel] = np.floor(y[:, channel] / quantum + 0.5) * quantum
    return np.ascontiguousarray(y)


def _at_the_sample(moments: Array, said: Array) -> Array:
    first, n = round(FIRST / 0.1), len(said)
    truth = moments[:, first:n]
    return np.asarray(np.mean((said[first:].T - truth) ** 2, axis=1) / np.mean(truth**2, axis=1))
