"""Estimator and forecast with a design model beyond the linear one: guess of the waves, model, and what it gains."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import gyroctl as gy
from gyroctl.harness.law_fingerprint import law_fingerprint
from gyroctl.harness.registry import describe
from gyroctl.harness.run import Settings, lead_in, run_law
from gyroctl.plant.beyond import coupling_torque
from gyroctl.plant.equations import OMEGA_RATE, PHI1, PSI, PSI_RATE
from gyroctl.plant.measurement import ROWS
from gyroctl.waves.channels import transfers
from gyroctl.waves.estimation import MomentEstimator, Predictor, relative_error, replay
from gyroctl.waves.estimation.observer import predict_state
from gyroctl.waves.estimation.ring_filter import secant
from gyroctl.waves.estimation.wave_signals import (
    band,
    known_of,
    put_signals,
    regression,
    seen_from,
    signal_table,
    unexplained,
)

Array = NDArray[np.float64]
SEED = 100041
CHOICES: dict[str, dict[str, Any]] = {
    "drag": {"drag": 0.5},
    "position": {"position": "moving", "drag": 0.5},
    "wetted": {"position": "moving", "drag": 0.5, "wetted": "reduced"},
    "at rest": {"wetted": "reduced", "coupling_cap": 2.0, "coupling_slip": 20.0, "bearing": 0.01},
}


@pytest.fixture(params=CHOICES, scope="module")
def design(request: pytest.FixtureRequest) -> gy.Plant:
    return gy.zhang2017(**CHOICES[request.param])


class Noting:
    """A law that keeps every state of another one."""

    def __init__(self, law: Any) -> None:
        self.law, self.states = law, []
        self.period, self.information, self.init = law.period, law.information, law.init

    def step(self, t: float, y: Any, state: Any) -> Any:
        command, state = self.law.step(t, y, state)
        self.states.append(state)
        return command, state


# --- the guess of the waves ------------------------------------------------------------------------------------------


class OneFrequency(NamedTuple):
    """A sea of a single frequency, one of those that are looked at."""

    heading: float
    wp: float = 3.14

    @property
    def omega(self) -> Array:
        return band(gy.SeaState(wp=self.wp))[90:91]

    def spectrum(self, omega: Array) -> Array:
        return np.asarray(np.isclose(omega, self.omega), float)


@pytest.mark.parametrize("heading", [0.0, 30.0])
def test_guess_is_exact_for_waves_of_one_frequency(design: gy.Plant, heading: float) -> None:
    sea: Any = OneFrequency(heading)
    guessed = regression(design, sea) @ known_of(design, sea.omega, heading)
    np.testing.assert_allclose(guessed, transfers(design, sea.omega, heading), rtol=1e-9, atol=1e-9)


def test_guess_leaves_what_it_says_in_a_realisation(design: gy.Plant) -> None:
    """Signals of random waves less the guess from their moments and rates: as large as `unexplained` reckons."""
    sea = gy.SeaState(hs=0.2, gamma=3.3)
    waves = gy.realise(design, sea, SEED, 2000.0)
    signals = waves.signals(design)
    me1, me3 = signals[:2]
    known = np.stack([me1, np.gradient(me1, waves.dt), me3, np.gradient(me3, waves.dt)])
    rest = dict(zip(design.channels, np.std(signals - regression(design, sea) @ known, axis=1), strict=True))
    beyond, total = design.coefficients.beyond, 0.0
    assert beyond is not None
    if beyond.position is not None:
        total += rest["Me1@2"] ** 2 + rest["Me3@2"] ** 2
    if beyond.reduced is not None:
        names = ("F1^0", "F3^0") if beyond.position is not None else ("F1", "F3")
        total += sum(rest[name] ** 2 for name in names)
    if beyond.drag is not None:
        water = np.std(signals[design.channels.index("w")])
        total += water**2 * (beyond.drag.factor1**2 * rest["u"] ** 2 + beyond.drag.factor3**2 * rest["w"] ** 2)
    assert unexplained(design, sea) == pytest.approx(np.sqrt(total), rel=0.1)


def test_signals_next_to_the_float_are_those_of_the_plant(design: gy.Plant) -> None:
    matrix, table = regression(design, gy.SeaState()), signal_table(design, gy.SeaState())
    known, x = np.array([80.0, -190.0, 130.0, 260.0]), np.zeros(len(design.labels))
    for phi1 in (0.0, 0.11, -0.34, 1.2, -1.57, 3.3):
        x[PHI1] = phi1
        wanted = design.near(x, matrix @ known)
        out = np.full(wanted.size, np.nan)
        put_signals(design.coefficients.beyond, table, phi1, *known, out)
        np.testing.assert_allclose(out, wanted, rtol=1e-12, atol=1e-9)


def test_linear_design_asks_for_nothing(device: gy.Plant) -> None:
    estimator = MomentEstimator.design(device)
    assert estimator.unexplained == 0.0 and estimator.turning == 0.0
    assert unexplained(device, gy.SeaState()) == 0.0


def test_forecast_reckons_with_what_the_guess_misses(design: gy.Plant) -> None:
    estimator = MomentEstimator.design(design)
    predictor = Predictor.design(design, estimator=estimator)
    noise = predictor.learner.noise[[0, 3], 0] if predictor.placed is None else predictor.placed.misfit
    assert np.all(noise >= estimator.unexplained**2)


# --- the model that runs along ---------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_period_of_the_model_is_that_of_the_plant(design: gy.Plant) -> None:
    """Against an adaptive integration of `Plant.derivative` with moments that swing on as the estimator takes them.

    The moments are those at the float, wherever it is: the model that runs along is that of a float at rest.
    """
    sea, design = gy.SeaState(), seen_from(design)
    estimator = MomentEstimator.design(design)
    state = estimator.init()
    start = np.zeros(len(design.labels))
    start[PSI], start[PSI_RATE], start[OMEGA_RATE] = 0.7, 3.0, 75.0
    start[[PHI1, 1, 4, 5]] = 0.21, -0.05, 0.6, -0.3
    wave = np.array([60.0, -150.0, 110.0, 220.0])
    state.x_hat[:], state.wave[:] = start, wave
    predict_state(estimator, state, 0.05, 4e-4)

    wp, spread, matrix = estimator.wp, estimator.spread, regression(design, sea)
    swing = np.kron(np.eye(2), np.array([[0.0, 1.0], [-(wp**2), -2.0 * spread * wp]]))

    def rate(t: float, z: Array) -> Array:
        return np.concatenate([design.derivative(z[:-4], (0.05, 4e-4), matrix @ z[-4:]), swing @ z[-4:]])

    found = solve_ivp(rate, (0.0, 0.1), np.append(start, wave), method="DOP853", rtol=1e-10, atol=1e-12).y[:, -1]
    np.testing.assert_allclose(state.wave, found[-4:], rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(state.x_hat, found[:-4], rtol=2e-4, atol=2e-4)


def test_variance_of_the_ring_follows_the_torque_that_is_left() -> None:
    plant = gy.zhang2017(coupling_slip=20.0, coupling_cap=2.0)
    beyond = plant.coefficients.beyond
    for slip in (-60.0, -5.0, 15.0, 80.0):
        torque = coupling_torque(beyond, 0.1, slip)
        assert secant(beyond, 0.1, slip) == pytest.approx(torque / slip, rel=1e-12)
    assert secant(beyond, 0.1, 0.0) == pytest.approx(0.1, rel=1e-6)
    assert secant(None, 0.1, 50.0) == 0.1


def test_what_slips_or_is_followed_is_designed_as_what_is_smooth() -> None:
    rough = gy.zhang2017(variant="realistic")
    one, other = MomentEstimator.design(rough), MomentEstimator.design(rough.rolling.smooth)
    assert one.k == other.k and one.unexplained == other.unexplained > 0.0
    np.testing.assert_array_equal(one.signals, other.signals)
    assert len(one.init().x_hat) == len(rough.rolling.labels)


# --- what it gains ---------------------------------------------------------------------------------------------------


def forecast_error(design: gy.Plant, measured: Array, commands: Array, moments: Array, **more: Any) -> Array:
    """Mean square error over the variance, (2, 3): now, at 0.5 s and at 1 s ahead."""
    estimator = MomentEstimator.design(design)
    predictor = Predictor.design(design, estimator=estimator, **more)
    said = replay(predictor, (0.5, 1.0), estimator, measured, commands)
    truth = moments[:, 1000 : len(said.now)]
    now = np.mean((said.now[1000:].T - truth) ** 2, axis=1) / np.mean(truth**2, axis=1)
    return np.column_stack([now, relative_error(predictor, (0.5, 1.0), said.ahead, moments, 100.0)])


@pytest.mark.slow
@pytest.mark.parametrize("choice", ["position", "wetted"])
def test_knowing_the_water_takes_most_of_the_error_away(choice: str) -> None:
    """Moments at rest from sensors on a float that moves; the truth has the finer radiation fit."""
    truth = gy.zhang2017(**CHOICES[choice], radiation="fine")
    settings = Settings(sensors=gy.Sensors())
    waves = lead_in(gy.realise(truth, gy.SeaState(), SEED, 300.0), settings)
    run, _ = run_law(truth, gy.law("coupling"), waves, settings)
    n = len(run.controls)
    errors = settings.sensors.arrays(n, SEED)
    measured = np.ascontiguousarray(run.states[:n, list(ROWS)] + errors.error)
    moments = np.ascontiguousarray(waves.moments[:, :: round(0.1 / waves.dt)])
    plain = forecast_error(gy.zhang2017(), measured, run.commands, moments)
    knowing = forecast_error(gy.zhang2017(**CHOICES[choice]), measured, run.commands, moments)
    careless = forecast_error(gy.zhang2017(**CHOICES[choice]), measured, run.commands, moments, floor=0.3)
    assert np.all(knowing < 0.55 * plain), (knowing, plain)
    np.testing.assert_allclose(careless, knowing, rtol=0.05)  # what is not reckoned with is learnt
    assert np.all(knowing[:, 1] < 0.25) and np.all(knowing[:, 2] < 0.6)


@pytest.mark.slow
def test_planner_designed_for_the_water_sees_it() -> None:
    """`nmpc` with the realistic design model on the realistic device: plans, and knows the moments at rest better."""
    truth, settings = gy.zhang2017(variant="realistic"), Settings(sensors=gy.Sensors())
    waves, errors = lead_in(gy.realise(truth, gy.SeaState(), SEED, 120.0), settings), []
    moments = waves.moments[:, :: round(0.1 / waves.dt)]
    for plant in (gy.zhang2017(), truth):
        law: Any = gy.law("nmpc", plant=plant)
        seen = Noting(law)
        run_law(truth, seen, waves, settings)
        assert law.counters(seen.states[-1])["failed_plans"] == 0
        told = np.array([law.memory(state).forecast.now for state in seen.states]).T
        error = told[:, 400:] - moments[:, 400 : told.shape[1]]
        errors.append(np.mean(error**2, axis=1) / np.mean(moments[:, 400:] ** 2, axis=1))
    assert np.all(errors[1] < 0.6 * errors[0]), errors


def test_design_model_of_a_law_is_named_or_told_by_its_choices() -> None:
    realistic: Any = gy.law("nmpc", plant="realistic")
    assert realistic.plant == gy.zhang2017(variant="realistic")
    other: Any = gy.law("nmpc", plant={"drag": 0.7, "wetted": "reduced"})
    assert other.plant == gy.zhang2017(drag=0.7, wetted="reduced")
    assert describe(realistic)["plant"] == realistic.plant.name
    assert law_fingerprint(realistic) != law_fingerprint(gy.law("nmpc"))
    for plant, field in (("wet", "laws.nmpc.plant.variant"), ({"drag": -1.0}, "laws.nmpc.plant.drag")):
        with pytest.raises(gy.InputError) as caught:
            gy.law("nmpc", plant=plant)
        assert caught.value.field == field
