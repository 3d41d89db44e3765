"""The load of the rolling contact against the constraint forces of a rigid-body engine, and in slow motion."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from oracles import Engine, Forcing, radiation_realisation, random_states

import gyroctl as gy
from gyroctl.plant.contact import contact_load


@pytest.fixture(scope="module")
def plant() -> Any:
    return gy.zhang2017()


def passive(plant: Any, state: Any) -> Any:
    """Spring, damper and radiation on the lever. [Nm]"""
    p = plant.parameters
    memory = [radiation_realisation(plant, j).p @ state[8 + 3 * j : 11 + 3 * j] for j in (0, 1)]
    return -np.array([p.k1, p.k3]) * state[:2] - np.array([p.d1, p.d3]) * state[4:6] - np.array(memory)


def test_load_is_that_of_the_engines_constraints(plant: Any) -> None:
    """Moment that presses and torque that rolls: forces in the joints of a rigid-body engine, in any attitude."""
    engine = Engine(plant.parameters)
    rng = np.random.default_rng(31)
    states, controls, moments, expected = [], [], [], []
    for state in random_states(100, seed=31):
        attitude = rng.normal(size=4)
        u, waves = (rng.uniform(0.0, 0.3), rng.uniform(0.0, 0.02)), rng.normal(0.0, 100.0, 2)
        engine.place(attitude / np.linalg.norm(attitude), state[2], state[4:8])
        forcing = Forcing(waves + passive(plant, state))
        expected.append(engine.contact(engine.accelerations(u, forcing), u, forcing))
        states.append(state)
        controls.append(u)
        moments.append(waves)
    found = contact_load(plant, np.array(states).T, np.array(controls).T, np.array(moments).T)
    pressing, rolling = np.array(expected).T
    np.testing.assert_allclose(found.M3, pressing, rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(found.torque, rolling, rtol=1e-8, atol=1e-8)
    needed = plant.parameters.N * np.abs(rolling / pressing)
    np.testing.assert_allclose(found.traction, needed, rtol=1e-7)


def test_in_slow_motion_the_needed_friction_is_the_swing_over_the_ring_speed(plant: Any) -> None:
    """Without slip and load only the gyroscopic torque of the swing has to be carried: mu = |u3|/psi', whatever N."""
    N = plant.parameters.N
    rng = np.random.default_rng(32)
    x = np.zeros((len(plant.labels), 50))
    x[2], x[6] = rng.uniform(0.0, 6.0, 50), rng.uniform(2.0, 4.0, 50)
    x[4:6] = rng.normal(0.0, 0.3, (2, 50))
    swing = np.sin(x[2]) * x[4] + np.cos(x[2]) * x[5]
    # moments under which the lever does not accelerate, and the slip at which the coupling takes the flywheel along
    cc, moments = 0.1, np.zeros((2, 50))
    x[7] = N * x[6]
    for _ in range(200):
        rate = plant.derivative(x, (cc, 0.0), moments)
        x[7] += 0.01 * (rate[7] - N * rate[6])
        by_one = [plant.derivative(x, (cc, 0.0), moments + step) - rate for step in np.eye(2)[:, :, None]]
        slopes = np.array([[by[4], by[5]] for by in by_one]).transpose(2, 1, 0)
        moments = moments - np.linalg.solve(slopes, rate[4:6].T[:, :, None])[:, :, 0].T
    found = contact_load(plant, x, (cc, 0.0), moments)
    np.testing.assert_allclose(found.traction, np.abs(swing) / x[6], rtol=0.1, atol=0.02)


def test_one_state_is_as_good_as_many(plant: Any) -> None:
    """A single state gives numbers, equal to those in a batch."""
    states = np.array(random_states(4, seed=33)).T
    many = contact_load(plant, states, (0.05, 3e-4), (10.0, -20.0))
    one = contact_load(plant, states[:, 2], (0.05, 3e-4), (10.0, -20.0))
    for value, values in zip(one, many, strict=True):
        np.testing.assert_allclose(value, values[2], rtol=1e-12)


def test_the_rigid_connection_carries_the_flywheel_through_the_contact() -> None:
    """Geared to the axis, the flywheel turns with it: the contact carries both, and the torque of the generator."""
    plant = gy.zhang2017(connection="rigid")
    p = plant.parameters
    state = np.zeros(len(plant.labels))
    state[6], state[7] = 3.0, 3.0 * p.N
    rate = plant.derivative(state, (0.0, 1e-3), (0.0, 0.0))
    turning = np.cos(state[2]) * rate[4] - np.sin(state[2]) * rate[5]
    found = contact_load(plant, state, (0.0, 1e-3), (0.0, 0.0))
    expected = (p.J13 + p.J14) * (p.N * rate[6] + turning) + 1e-3 * state[7]
    np.testing.assert_allclose(found.torque, expected, rtol=1e-10)
