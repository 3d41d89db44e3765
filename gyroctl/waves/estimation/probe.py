"""Forecast of degradable quality: an up-wave probe that tells the moments some seconds ahead, and what lies beyond.

A probe up-wave of the float sees a wave before it arrives. Here it tells the moments `lead` seconds ahead, with an
error of its own; beyond that the predictor goes on from what it told. With no lead this is a forecast from the true
moments of now, with a lead of the whole horizon it is an oracle. What a probe with an error tells is smoothed: the mean
of the moments given all that it told, by the same covariance.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.plant.compiled import stamped
from gyroctl.waves.checks import seed_number
from gyroctl.waves.estimation import predictor as below
from gyroctl.waves.estimation.moment_model import Array
from gyroctl.waves.estimation.predictor import FLOOR, Predictor, PredictorState, observe, predict

SOURCES = (*below.SOURCES, __file__)

PROBE_DOMAIN = 0x70726F62
"""Spawn key ("prob" in ASCII): the error of the probe is no other random number of the same seed."""


class Probe(NamedTuple):
    """What the probe tells of one realisation; build it with `Probe.design`."""

    told: Array  # (2, n) moments at the instants of the samples, with the error of the probe [Nm]
    lead: int  # [steps]
    errs: bool = False  # whether there is an error in it

    @classmethod
    def design(
        cls, predictor: Predictor, moments: Array, dt: float, lead: float = 0.0, noise: float = 0.0, seed: int = 0
    ) -> Probe:
        """Set the probe up.

        Parameters
        ----------
        predictor : Predictor
            What goes on beyond the lead. For a noisy probe, design it with the `floor` of `floor_of`.
        moments : (2, n) array
            True moments. [Nm]
        dt : float
            Their spacing; it divides the predictor's step. [s]
        lead : float
            How far ahead the probe tells, rounded to steps; infinite for all of the horizon. [s]
        noise : float
            Standard deviation of its error, as a part of that of each moment. [-]
        seed : int
            Seed of the error.

        Raises
        ------
        InputError
            For moments of another shape, spacing that does not divide the step, a negative lead or noise, a bad seed.
        """
        every = round(predictor.step / dt) if math.isfinite(dt) and dt > 0.0 else 0
        if every < 1 or not math.isclose(every * dt, predictor.step, rel_tol=1e-9):
            problem = f"does not divide the predictor's step of {predictor.step:g} s"
            raise InputError("probe.dt", dt, problem, "Realise the waves with another dt")
        if moments.ndim != 2 or moments.shape[0] != 2:
            raise InputError("probe.moments", moments.shape, "must be of shape (2, n)", "Give waves.moments")
        if math.isnan(lead) or lead < 0.0:
            raise InputError("probe.lead", lead, "must not be negative", "Give seconds, or inf for an oracle")
        if not 0.0 <= noise < math.inf:
            raise InputError("probe.noise", noise, "must be zero or positive", "Give a part of the moments' deviation")
        told = np.ascontiguousarray(moments[:, ::every], np.float64)
        if noise > 0.0:
            told = told + error_of(np.std(told, axis=1), noise, told.shape, seed)
        steps = predictor.horizon if math.isinf(lead) else round(lead / predictor.step)
        return cls(told, min(steps, predictor.horizon), noise > 0.0)


def floor_of(deviation: Array, noise: float) -> tuple[float, float] | None:
    """White noise of each moment that a predictor behind such a probe reckons with, None for its default. [Nm]

    `deviation` (2,) is that of the moments [Nm], and `noise` the error as a part of it.
    """
    if noise == 0.0:
        return None
    one, three = (math.hypot(FLOOR, noise * float(size)) for size in deviation)
    return one, three


def error_of(deviation: Array, noise: float, shape: tuple[int, ...], seed: int) -> Array:
    """Error of a probe, of a `shape` (2, n): `noise` times the `deviation` (2,) of the moments, from the seed. [Nm]"""
    if noise == 0.0:
        return np.zeros(shape)
    source = np.random.SeedSequence(seed_number(seed), spawn_key=(PROBE_DOMAIN,))
    error = np.random.Generator(np.random.PCG64(source)).standard_normal(shape)
    return np.asarray(noise * deviation[:, None] * error, np.float64)


@stamped(SOURCES)
def foresee(predictor: Predictor, probe: Probe, state: PredictorState, sample: int, out: NDArray[np.float64]) -> None:
    """Write the moments (2, n) at 1 .. n steps after `sample`, n up to the horizon. [Nm]

    Samples are to be asked for in their order; one that was left out is caught up with. `state` is a state of
    `predictor` that sees nothing but this probe; `state.now` holds the moments at the sample as told, or smoothed.
    Beyond the end of the record the moments are zero.

    Parameters
    ----------
    predictor : Predictor
        The forecast, beyond what the probe tells.
    probe : Probe
        What is told of the waves, and how far ahead.
    state : PredictorState
        Changed in place.
    sample : int
        Number of the sample that is now.
    out : (2, n) array
        Written: Me1 and Me3. [Nm]
    """
    told, last = probe.told, probe.told.shape[1] - 1
    reach = min(sample + probe.lead, last)
    leads = out.shape[1]
    if leads > probe.lead or probe.errs:
        while state.samples[0] <= reach:
            at = state.samples[0]
            observe(predictor, state, told[0, at], told[1, at])
        predict(predictor, state, state.coming)
    for i in range(2):
        for lead in range(leads):
            ahead = sample + lead + 1
            if ahead <= reach:
                out[i, lead] = told[i, ahead]
            elif lead < probe.lead or ahead - reach > predictor.horizon:
                out[i, lead] = 0.0
            else:
                out[i, lead] = state.coming[i, ahead - reach - 1]
        state.now[i] = told[i, min(sample, last)]
    if probe.errs:
        for age in range(reach - min(sample, last) + 1):
            lead = reach - age - sample - 1
            for i in range(2):
                smooth = smoothed(predictor, state, i, age)
                if lead < 0:
                    state.now[i] = smooth
                elif lead < leads:
                    out[i, lead] = smooth


@stamped(SOURCES)
def smoothed(predictor: Predictor, state: PredictorState, moment: int, age: int) -> float:
    """Mean of a moment `age` steps before what was observed last, given all of that; after `predict`. [Nm]

    What was observed are the moments themselves and white noise, so the covariance with a later one is that of the
    later with this one.
    """
    ages, ahead, w, total, i = predictor.learner.ages, state.memory.ahead, state.weights, 0.0, moment
    for a in range(ages.size):
        if ages[a] >= state.samples[0]:
            break
        lag = ages[a] - age
        for j in range(2):
            total += (ahead[2 * i + j, lag] if lag >= 0 else ahead[2 * j + i, -lag]) * w[2 * a + j]
    return total
