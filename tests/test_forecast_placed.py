"""Forecast of a float that moves, against dense Gaussian conditioning and realisations, and what it says of itself."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import gyroctl as gy
from gyroctl.hydrodynamics.dispersion import wavenumber
from gyroctl.waves.estimation import MomentEstimator, Predictor, coverage, forecast_spread, observe, predict
from gyroctl.waves.estimation.placed import ALIKE, FAR, LEAST, SLOW, SLOWER, Placed, learn_scale
from gyroctl.waves.estimation.predictor import PredictorState
from gyroctl.waves.estimation.skill import Replay

Array = NDArray[np.float64]
HEADING = 20.0


@pytest.fixture(scope="module")
def plant() -> gy.Plant:
    return gy.zhang2017(position="moving")


def designed(plant: gy.Plant, **more: Any) -> Predictor:
    """A predictor that knows the sea and learns nothing of it."""
    sea = gy.SeaState(heading=HEADING)
    estimator = MomentEstimator.design(plant, sea)
    return Predictor.design(plant, sea=sea, estimator=estimator, forgetting=None, horizon=4.0, **more)


class Drawn:
    """Moments seen at a float that wanders, and those at rest, drawn from the model of the predictor."""

    def __init__(self, predictor: Predictor, plant: gy.Plant, samples: int, seed: int, misfit: Array) -> None:
        c = predictor.placed
        assert c is not None and plant.geometry is not None
        rng, self.c = np.random.default_rng(seed), c
        edges = np.append(1.0 + 0.1 * c.edges[:-1], 1.0 + 0.1 * c.edges[-1])
        self.omega = 0.5 * (edges[1:] + edges[:-1])
        self.variance = np.array(
            [0.1 * predictor.learner.prior[low:high].sum() for low, high in zip(c.edges[:-1], c.edges[1:], strict=True)]
        )
        self.k = wavenumber(self.omega, plant.depth, plant.geometry.g) * math.cos(math.radians(HEADING))
        seen = np.stack([c.seen[0] + 1j * c.seen[1], c.seen[2] + 1j * c.seen[3]])
        true = c.ahead[:, : self.omega.size, 0] - 1j * c.ahead[:, self.omega.size :, 0]
        draw = rng.standard_normal((2, self.omega.size)) * np.sqrt(self.variance)
        amplitude, t = draw[0] + 1j * draw[1], 0.1 * np.arange(samples + 40)
        self.place = 0.4 * np.sin(0.9 * t + 0.3)
        self.at = np.exp(1j * (np.outer(t, self.omega) - np.outer(plant.geometry.reach * self.place, self.k)))
        self.still = np.exp(1j * np.outer(t, self.omega))
        self.seen, self.true = seen, true
        noise = np.sqrt(misfit)[:, None] * rng.standard_normal((2, samples + 40))
        self.values = np.real((seen * amplitude) @ self.at.T) + noise
        self.rest = np.real((true * amplitude) @ self.still.T)

    def looked_at(self, samples: int) -> NDArray[np.complex128]:
        """Moments of unit waves at what is looked at of so many samples, as rows."""
        rows = samples - 1 - self.c.ages[self.c.ages < samples]
        return np.stack([self.seen[j] * self.at[rows] for j in range(2)], axis=1).reshape(2 * rows.size, -1)

    def conditioned(self, misfit: Array, samples: int, lead: int) -> tuple[Array, Array]:
        """Mean and deviation of the moments `lead` steps after the last of so many samples, by dense matrices."""
        ages = self.c.ages[self.c.ages < samples]
        rows, of = samples - 1 - ages, self.looked_at(samples)
        to = self.true * self.still[samples - 1 + lead]
        G = np.real((of * self.variance) @ of.conj().T) + np.diag(np.tile(misfit, ages.size))
        g = np.real((to * self.variance) @ of.conj().T)
        mean = g @ np.linalg.solve(G, self.values[:, rows].T.ravel())
        whole = np.real((to * self.variance) @ to.conj().T)
        return mean, np.sqrt(np.diag(whole - g @ np.linalg.solve(G, g.T)))


def fed(predictor: Predictor, drawn: Drawn, samples: int) -> tuple[PredictorState, Array]:
    state, out = predictor.init(), np.empty((2, 40))
    for i in range(samples):
        observe(predictor, state, drawn.values[0, i], drawn.values[1, i], drawn.place[i])
    predict(predictor, state, out)
    return state, out


@pytest.mark.slow
@pytest.mark.parametrize("samples", [1, 6, 45, 170])
def test_mean_and_deviation_are_those_of_the_conditional_distribution(plant: gy.Plant, samples: int) -> None:
    predictor = designed(plant)
    assert predictor.placed is not None
    misfit = predictor.placed.misfit
    drawn = Drawn(predictor, plant, samples, 3, misfit)
    state, out = fed(predictor, drawn, samples)
    for lead in (0, 1, 5, 20, 40):
        mean, deviation = drawn.conditioned(misfit, samples, lead)
        got = state.now if lead == 0 else out[:, lead - 1]
        np.testing.assert_allclose(got, mean, rtol=1e-7, atol=1e-6)
        np.testing.assert_allclose(state.placed.spread[:, lead], deviation, rtol=1e-7)
    said = np.empty((2, 3))
    forecast_spread(predictor, state, np.array([0, 7, 40]), said)
    np.testing.assert_array_equal(said, state.placed.spread[:, [0, 7, 40]])


def test_few_broad_bins_serve_as_well_as_many_narrow_ones(plant: gy.Plant) -> None:
    """The covariance of the bins of the forecast against the integral over the spectrum, as far as it is looked at."""
    predictor = designed(plant)
    c, sea = predictor.placed, gy.SeaState(heading=HEADING)
    assert c is not None
    bins = c.k.size
    variance = np.array(
        [0.1 * sea.spectrum(1.05 + 0.1 * np.arange(a, b)).sum() for a, b in zip(c.edges[:-1], c.edges[1:], strict=True)]
    )
    omega = np.arange(0.5, 12.0, 0.002)
    he, S = plant.excitation(omega, HEADING), sea.spectrum(omega)
    parts = c.ahead.reshape(2, 2, bins, -1)
    for i in range(2):
        for lag in (0, 10, 40):
            ours = np.sum(
                variance * (parts[i, 0, :, lag] * parts[i, 0, :, 0] + parts[i, 1, :, lag] * parts[i, 1, :, 0])
            )
            exact = np.sum(np.abs(he[i]) ** 2 * np.cos(0.1 * lag * omega) * S) * 0.002
            whole = np.sum(np.abs(he[i]) ** 2 * S) * 0.002
            assert ours == pytest.approx(exact, abs=0.03 * whole)


def test_errors_are_as_large_as_it_says(plant: gy.Plant) -> None:
    """Realisations of its own model: the squared errors over the variances that it says are one on the average."""
    predictor = designed(plant)
    assert predictor.placed is not None
    squares = []
    for seed in range(150):
        drawn = Drawn(predictor, plant, 100, seed, predictor.placed.misfit)
        state, out = fed(predictor, drawn, 100)
        said = np.concatenate([state.now[:, None], out], axis=1)
        squares.append(((said - drawn.rest[:, 99:140]) / state.placed.spread) ** 2)
    mean = np.mean(squares, axis=0)[:, [0, 1, 5, 10, 20, 40]]
    np.testing.assert_allclose(mean, 1.0, atol=0.4)  # 3.5 deviations of the mean of 150
    assert np.mean(mean) == pytest.approx(1.0, abs=0.15)


def followed(predictor: Predictor, drawn: Drawn, samples: int) -> PredictorState:
    state, out = predictor.init(), np.empty((2, 40))
    for i in range(samples):
        observe(predictor, state, drawn.values[0, i], drawn.values[1, i], drawn.place[i])
        predict(predictor, state, out)
    return state


@pytest.mark.slow
@pytest.mark.parametrize("size", [(30.0, 12.0), (9.0, 45.0)])
def test_misfit_is_learnt(plant: gy.Plant, size: tuple[float, float]) -> None:
    """White noise of another size than was reckoned with: found by a fifth, and the scale of the deviation stays."""
    predictor = designed(plant)
    true, found, scale = np.square(size), [], []
    for seed in range(3):
        state = followed(predictor, Drawn(predictor, plant, 1500, seed, true), 1500)
        found.append(state.placed.misfit)
        scale.append(state.placed.scale)
    np.testing.assert_allclose(np.sqrt(np.mean(found, axis=0)), size, rtol=0.2)
    np.testing.assert_allclose(np.mean(scale, axis=0), 1.0, atol=0.35)


def test_deviation_grows_where_the_waves_are_larger_than_the_spectrum(plant: gy.Plant) -> None:
    """Twice the amplitudes that it believes in: no noise, so it is the scale that has to tell."""
    predictor = designed(plant)
    drawn = Drawn(predictor, plant, 1500, 1, np.array([100.0, 100.0]))
    for name in ("values", "rest"):
        setattr(drawn, name, 2.0 * getattr(drawn, name))
    state = followed(predictor, drawn, 1500)
    assert np.all(state.placed.scale > 1.5)
    np.testing.assert_allclose(
        state.placed.spread**2, np.minimum(state.placed.scale, 4.0)[:, None] * state.placed.variance, rtol=1e-12
    )


def test_scale_is_learnt_by_its_formula(plant: gy.Plant) -> None:
    predictor = designed(plant)
    c = predictor.placed
    assert isinstance(c, Placed)
    state, now, later = predictor.init().placed, np.array([10.0, 20.0]), np.array([12.0, -30.0])
    state.variance[:] = np.array([[100.0], [400.0]]) * np.linspace(1.0, 3.0, 41)
    learn_scale(c, state, 50, now, later)
    np.testing.assert_array_equal(state.scale, 1.0)
    for between in (51, 59):
        learn_scale(c, state, between, now, later)
    np.testing.assert_array_equal(state.judged[0], later)
    learn_scale(c, state, 60, now, later)
    deviations = np.minimum((now - later) ** 2 / (state.variance[:, 10] - state.variance[:, 0]), FAR)
    np.testing.assert_allclose(state.scale, 1.0 + 1.0 / SLOWER * (deviations - 1.0), rtol=1e-12)
    before = state.scale.copy()
    learn_scale(c, state, 71, now, later)  # the sample at which it was due was left out: nothing is said
    np.testing.assert_array_equal(state.scale, before)


def test_misfit_is_learnt_once_a_sample(plant: gy.Plant) -> None:
    """Asked twice for the forecast of one sample, it learns once, by the residual of dense matrices, a quarter more."""
    predictor = designed(plant)
    assert predictor.placed is not None
    first = predictor.placed.misfit
    drawn = Drawn(predictor, plant, 60, 8, first)
    state, out = fed(predictor, drawn, 60)
    alone = []
    for j in range(2):  # the newest value of a moment, foreseen from all others
        of = drawn.looked_at(60)
        G = np.real((of * drawn.variance) @ of.conj().T) + np.diag(np.tile(first, len(of) // 2))
        values = drawn.values[:, 59 - drawn.c.ages[drawn.c.ages < 60]].T.ravel()
        rest = np.arange(len(of)) != j
        weights = np.linalg.solve(G[np.ix_(rest, rest)], G[rest, j])
        alone.append((values[j] - weights @ values[rest]) ** 2 / (G[j, j] - weights @ G[rest, j]))
    wanted = np.maximum(first * np.exp(0.1 / SLOW * (ALIKE * np.minimum(alone, FAR) - 1.0)), LEAST**2)
    np.testing.assert_allclose(state.placed.misfit, wanted, rtol=1e-9)
    before = state.placed.misfit.copy()
    predict(predictor, state, out)
    np.testing.assert_array_equal(state.placed.misfit, before)


def test_deviation_at_rest_is_that_of_the_normal_equations(device: gy.Plant) -> None:
    from test_forecast_predictor import covariance, towards
    from wave_predictors import fed as told
    from wave_predictors import known, moments

    predictor = known(device, floor=3.0)
    for count in (7, 300):
        state = told(predictor, moments(device, gy.SeaState(), 30.0)[:, :count])
        out = np.empty((2, 3))
        forecast_spread(predictor, state, np.array([0, 10, 20]), out)
        size = 2 * int(np.sum(predictor.learner.ages < count))
        G = covariance(predictor)[:size, :size]
        for moment in range(2):
            for at, lead in enumerate((0, 10, 20)):
                g = towards(predictor, moment, lead)[:size]
                whole = state.memory.ahead[3 * moment, 0]
                assert out[moment, at] ** 2 == pytest.approx(whole - g @ np.linalg.solve(G, g), rel=1e-5, abs=1e-3)


def test_coverage_counts_errors_within_deviations(device: gy.Plant) -> None:
    predictor, rng = Predictor.design(device), np.random.default_rng(2)
    ahead, spread = np.zeros((4000, 2, 1)), np.full((4000, 2, 1), 3.0)
    spread[:, 1] = 1.5
    said = Replay(np.zeros((4000, 1)), np.zeros((4000, 2)), np.zeros((4000, 2)), ahead, spread, np.zeros((4000, 7)))
    share = coverage(predictor, (1.0,), said, 3.0 * rng.standard_normal((2, 4000)))
    np.testing.assert_allclose(share[:, 0, 0], [0.6827, 0.9545], atol=0.03)
    np.testing.assert_allclose(share[:, 1, 0], [0.3829, 0.6827], atol=0.03)
