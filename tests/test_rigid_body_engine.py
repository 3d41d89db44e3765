"""The equations of motion against MuJoCo: exact moment by moment, and how the error grows with finite rotations."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from oracles import Engine, Forcing, free_flight, radiation_realisation, random_states, runge_kutta

import gyroctl as gy

U = (0.052, 3.5e-4)
WP = 3.14


@pytest.fixture(scope="module")
def plant() -> Any:
    return gy.zhang2017()


def slope(sizes: Any, errors: Any) -> Any:
    """Exponent of the error's growth with the amplitude, per column."""
    return np.polyfit(np.log(sizes), np.log(np.asarray(errors)), 1)[0]


def tilted(phi: Any) -> Any:
    """Quaternion of the rotation vector (phi1, 0, phi3)."""
    angle = np.hypot(*phi)
    return np.array([np.cos(angle / 2), *(np.sin(angle / 2) / angle * np.array([phi[0], 0.0, phi[1]]))])


def passive_moment(plant: Any, phi: Any, state: Any) -> Any:
    """Spring, damper and radiation on the lever [Nm], the springs at the deflection `phi`."""
    p = plant.parameters
    radiation = [radiation_realisation(plant, j).p @ state[8 + 3 * j : 11 + 3 * j] for j in (0, 1)]
    return -np.array([p.k1, p.k3]) * phi - np.array([p.d1, p.d3]) * state[4:6] - np.array(radiation)


def test_accelerations_are_exact_in_any_attitude(plant: Any) -> None:
    """Body-frame rates, moments about the lever's axes: where the lever points, and how far it turned, is no matter."""
    engine = Engine(plant.parameters)
    rng = np.random.default_rng(21)
    for state in random_states(100, seed=21):
        attitude = rng.normal(size=4)
        u, waves = (rng.uniform(0.0, 0.3), rng.uniform(0.0, 0.02)), rng.normal(0.0, 100.0, 2)
        engine.place(attitude / np.linalg.norm(attitude), state[2], state[4:8])
        found = engine.accelerations(u, Forcing(waves + passive_moment(plant, state[:2], state)))
        np.testing.assert_allclose(plant.derivative(state, u, tuple(waves))[4:8], found, rtol=1e-10)


def test_without_the_lever_term_the_engine_is_out_of_balance_by_just_that(plant: Any) -> None:
    """Inverse dynamics of the printed motion: what is missing on the lever is C2 psi' (phi3', -phi1')."""
    p = plant.parameters
    C2 = p.J22 + p.J13 / 2 + p.J14 / 2
    engine, printed = Engine(p), plant.replace(lever_gyroscopic=False)
    for state in random_states(20, seed=22):
        engine.place(tilted(state[:2]), state[2], state[4:8])
        motion = printed.derivative(state, U, (0.0, 0.0))[4:8]
        missing = engine.unbalanced(motion, U, Forcing(passive_moment(plant, state[:2], state)))
        expected = C2 * state[6] * np.array([state[5], -state[4], 0.0, 0.0])
        np.testing.assert_allclose(missing, expected, atol=1e-10 * np.max(np.abs(expected)) + 1e-9)


def acceleration_errors(engine: Engine, truth: Any, model: Any, sizes: Any) -> Any:
    """Mean error of the accelerations over 20 states, for each size of phi and all that goes with it, shape (n, 4)."""
    errors = np.zeros((len(sizes), 4))
    sea = np.random.default_rng(23).normal(0.0, 200.0, (20, 2))
    for state, waves in zip(random_states(20, seed=23, amplitude=1.0), sea, strict=True):
        for row, size in zip(errors, sizes, strict=True):
            small = state.copy()
            small[:2], small[4:6], small[8:] = size * state[:2], size * state[4:6], size * state[8:]
            engine.place(tilted(small[:2]), small[2], small[4:8])
            moments = size * waves + passive_moment(truth, engine.tilt(), small)
            found = engine.accelerations(U, Forcing(moments, "space"))
            row += np.abs(found - model.derivative(small, U, tuple(size * waves))[4:8]) / 20
    return errors


def test_error_of_the_accelerations_is_of_third_order(plant: Any) -> None:
    """Outer forces of fixed direction at the float: the model errs by phi^3, without the lever term by phi."""
    engine = Engine(plant.parameters)
    sizes = np.array([0.001, 0.002, 0.004, 0.008])
    assert np.all(slope(sizes, acceleration_errors(engine, plant, plant, sizes)) > 2.95)
    printed = plant.replace(lever_gyroscopic=False)
    assert np.all(slope(sizes, acceleration_errors(engine, plant, printed, sizes)) < 1.2)


def integrated(model: Any, start: Any, u: tuple[float, float], waves: Any, steps: int, dt: float) -> Any:
    """States of the model from `start` on, shape (steps + 1, 14)."""

    def rate(time: float, state: Any) -> Any:
        return model.derivative(state, u, tuple(waves(time)))

    history = [start]
    for step in range(steps):
        history.append(runge_kutta(rate, step * dt, history[-1], dt))
    return np.array(history)


def flight_errors(plant: Any, size: float, choices: list[dict[str, Any]]) -> Any:
    """Largest error over five seconds of phi1, phi3, psi, omega' for each choice of the model, shape (choices, 4).

    What drives phi must shrink with it: waves and push, but also flywheel and spin axis (their gyroscopic moment is
    82 Nm), coupling and generator. So the flywheel has `size` times its inertia, and turns at the spin of the lock.
    """
    p = plant.parameters
    light = plant.replace(J14=size * p.J14, J13=size * p.J13)
    u, steps, dt = (size * U[0], size * U[1]), 1000, 0.005
    start = np.zeros(14)
    start[[2, 4, 5, 6, 7]] = 0.3, 0.2 * size, -0.2 * size, 3.1, 69.0

    def waves(time: float) -> Any:
        return size * np.array([88.0, 210.0]) * np.cos(WP * time + np.array([1.54, 0.12]))

    def outer(time: float, tilt: Any, tilt_rate: Any) -> Any:
        return waves(time) - np.array([p.k1, p.k3]) * tilt - np.array([p.d1, p.d3]) * tilt_rate

    radiation = (radiation_realisation(light, 0), radiation_realisation(light, 1))
    truth = free_flight(Engine(light.parameters), start[[2, 4, 5, 6, 7]], u, outer, radiation, steps, dt)
    errors = []
    for choice in choices:
        motion = integrated(light.replace(**choice), start, u, waves, steps, dt)
        difference = motion[:, [0, 1, 2, 7]] - np.column_stack([truth.tilt, truth.psi, truth.speeds[:, 3]])
        errors.append(np.max(np.abs(difference), axis=0))
    return np.array(errors)


@pytest.mark.slow
def test_error_of_the_motion_is_of_third_order(plant: Any) -> None:
    """Five seconds of flight, radiation and all: phi as a surveyor sees the float, ring angle and spin."""
    sizes = np.array([0.01, 0.02, 0.04])
    errors = np.array([flight_errors(plant, size, [{}, {"lever_gyroscopic": False}]) for size in sizes])
    assert np.all(slope(sizes, errors[:, 0]) > 2.8)
    without = slope(sizes, errors[:, 1])
    assert np.all(without[:2] < 1.2)
    assert np.all(errors[0, 1, :2] > 10.0 * errors[0, 0, :2])


@pytest.mark.parametrize(("brackets", "factor"), [(False, 1.0), (True, 2.0)])
def test_brackets_double_what_the_generator_does_to_the_lever(plant: Any, brackets: bool, factor: float) -> None:
    """Trap 3: the generator alone brakes the flywheel, ring and lever at rest; in the engine a torque pair does it."""
    chosen = plant.replace(generator_reaction=brackets)
    engine, u = Engine(plant.parameters), (0.0, 1e-3)
    state = np.zeros(14)
    state[2], state[7] = 0.4, 70.0
    engine.place(np.array([1.0, 0.0, 0.0, 0.0]), state[2], state[4:8])
    truth = engine.accelerations(u, Forcing(np.zeros(2)))
    assert np.min(np.abs(truth[:2])) > 1e-5
    found = chosen.derivative(state, u, (0.0, 0.0))[4:8]
    np.testing.assert_allclose(found[:2], factor * truth[:2], rtol=1e-10)


def test_a_lever_on_two_hinges_adds_the_reaction_about_the_lever(plant: Any) -> None:
    """Limit of the model: on a fixed and a moving hinge the lever does turn about itself.

    Then the reaction C2 psi'' about the lever leans onto phi1: a moment C2 psi'' phi3, of first order. The plant, whose
    lever cannot turn about itself, is right to leave it out.
    """
    p = plant.parameters
    C2 = p.J22 + p.J13 / 2 + p.J14 / 2
    engine, sizes = Engine(p, "two hinges"), np.array([0.0005, 0.001, 0.002, 0.004])
    state = random_states(1, seed=24, amplitude=1.0)[0]
    state[8:] = 0.0
    as_is, mended = [], []
    for size in sizes:
        small = state.copy()
        small[:2], small[4:6] = size * state[:2], size * state[4:6]
        engine.place(small[:2], small[2], small[4:8])
        motion = plant.derivative(small, U, (0.0, 0.0))[4:8]
        missing = engine.unbalanced(motion, U, Forcing(passive_moment(plant, small[:2], small)))
        as_is.append(np.abs(missing[:2]))
        mended.append(np.abs(missing[0] - C2 * motion[2] * small[1]))
    assert slope(sizes, as_is)[0] == pytest.approx(1.0, abs=0.1)
    assert slope(sizes, as_is)[1] > 1.9
    assert slope(sizes, mended) > 1.9
