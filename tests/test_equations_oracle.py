"""The equations of motion against an independent symbolic derivation, and the errata that only mechanics can settle."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import sympy as sp
from oracles import Derivation, derive, jacobian, radiation_realisation, random_states, runge_kutta, table_1
from oracles.derivations import FREE_ACCELERATIONS, FREE_SPEEDS, boltzmann_hamel, lagrange, virtual_power
from oracles.four_bodies import J11, J13, J14, J22, N, a, axial_1, b, m1, m2, m3, m4, psi, psi_rate, w1, w3

import gyroctl as gy

CC, CG, WP = 0.052, 3.5e-4, 3.14


@pytest.fixture(scope="module")
def plant() -> Any:
    return gy.zhang2017()


@pytest.fixture(scope="module")
def exact() -> Derivation:
    return derive()


def moment_on_lever(plant: Any, state: Any, waves: Any) -> Any:
    """Waves less spring, damper and radiation [Nm]: M1 and M3 but for the added inertia."""
    p = plant.parameters
    radiation = [radiation_realisation(plant, j).p @ state[8 + 3 * j : 11 + 3 * j] for j in (0, 1)]
    return waves - np.array([p.k1, p.k3]) * state[:2] - np.array([p.d1, p.d3]) * state[4:6] - np.array(radiation)


def added_inertia(plant: Any) -> Any:
    return np.array([plant.parameters.Jh1, plant.parameters.Jh3])


def oracle(derivation: Derivation, plant: Any, state: Any, u: tuple[float, float], waves: Any) -> Any:
    moment = moment_on_lever(plant, state, waves)
    return derivation.accelerations(state[2], state[4:8], table_1(plant), u, moment, added_inertia(plant))


def mass_matrix(derivation: Derivation, plant: Any, state: Any) -> Any:
    added = np.diag([*added_inertia(plant), 0.0, 0.0])
    return derivation.mass_matrix(state[2], state[4:8], table_1(plant)) + added


def cases(seed: int) -> Any:
    rng = np.random.default_rng(seed)
    for state in random_states(100, seed):
        yield state, (rng.uniform(0.0, 0.3), rng.uniform(0.0, 0.02)), rng.normal(0.0, 100.0, 2)


def test_virtual_power_equals_boltzmann_hamel() -> None:
    """Two derivations that share no step agree, and the unknown inertia of the float about the lever drops out."""
    for one, other in zip(virtual_power(), boltzmann_hamel(), strict=True):
        assert sp.simplify(one - other) == 0
        assert not one.has(axial_1)


def test_lagrange_with_body_rates_loses_the_lever_term() -> None:
    """Trap 3b: taking phi1', phi3' for derivatives of angles loses C2 psi' times the other rate, nothing else."""
    C2 = J22 + J13 / 2 + J14 / 2
    lost = [full - paper for full, paper in zip(virtual_power(), lagrange(), strict=True)]
    for found, expected in zip(lost, (-C2 * psi_rate * w3, C2 * psi_rate * w1, 0, 0), strict=True):
        assert sp.simplify(found - expected) == 0


def test_inertia_is_that_of_equation_16() -> None:
    J1 = J11 + J22 / 2 + J13 / 2 + J14 / 2 + m1 * a**2 + (m2 + m3 + m4) * (a + b) ** 2
    J2 = J22 + (N**2 + sp.Rational(1, 2)) * J13 + J14 / 2
    J3, J4 = J13 / 2, J14
    K = J3 + J4 / 2
    c, s = sp.cos(psi), sp.sin(psi)
    expected = sp.Matrix(
        [
            [J1 + K * c**2, -K * c * s, 2 * N * J3 * c, J4 * c],
            [-K * c * s, J1 + K * s**2, -2 * N * J3 * s, -J4 * s],
            [2 * N * J3 * c, -2 * N * J3 * s, J2, 0],
            [J4 * c, -J4 * s, 0, J4],
        ]
    )
    derived = sp.Matrix(virtual_power()).jacobian(FREE_ACCELERATIONS)
    assert sp.simplify(derived - expected) == sp.zeros(4, 4)
    assert len(FREE_SPEEDS) == derived.shape[0]


@pytest.mark.parametrize("lever_gyroscopic", [True, False])
@pytest.mark.parametrize("generator_reaction", [True, False])
def test_accelerations_of_every_choice(plant: Any, lever_gyroscopic: bool, generator_reaction: bool) -> None:
    chosen = plant.replace(lever_gyroscopic=lever_gyroscopic, generator_reaction=generator_reaction)
    derivation = derive(lever_gyroscopic=lever_gyroscopic, generator_reaction=generator_reaction)
    for state, u, waves in cases(seed=11):
        expected = oracle(derivation, chosen, state, u, waves)
        np.testing.assert_allclose(chosen.derivative(state, u, tuple(waves))[4:8], expected, rtol=1e-10)


@pytest.mark.parametrize(("variant", "paper"), [("corrected", False), ("paper", True)])
def test_presets_take_their_side(variant: str, paper: bool) -> None:
    preset = gy.zhang2017(variant)
    derivation = derive(lever_gyroscopic=not paper, generator_reaction=paper)
    for state, u, waves in cases(seed=12):
        expected = oracle(derivation, preset, state, u, waves)
        np.testing.assert_allclose(preset.derivative(state, u, tuple(waves))[4:8], expected, rtol=1e-10)


def test_the_paper_differs_by_two_moments_and_no_more(plant: Any, exact: Derivation) -> None:
    """Forces on the lever, paper less corrected: the reaction counted twice, and the lever term missing."""
    p = plant.parameters
    C2 = p.J22 + p.J13 / 2 + p.J14 / 2
    paper = plant.replace(lever_gyroscopic=False, generator_reaction=True)
    for state, u, waves in cases(seed=13):
        rate_1, rate_3, ring, spin = state[4:8]
        change = (paper.derivative(state, u, tuple(waves)) - plant.derivative(state, u, tuple(waves)))[4:8]
        reaction = u[1] * spin * np.array([np.cos(state[2]), -np.sin(state[2])])
        lever = C2 * ring * np.array([rate_3, -rate_1])
        np.testing.assert_allclose(mass_matrix(exact, plant, state) @ change, [*(reaction - lever), 0, 0], atol=1e-11)


def test_rigid_connection_is_the_same_device_with_a_geared_flywheel(plant: Any, exact: Derivation) -> None:
    """The gear omega' = N psi' as an ideal constraint on the derivation; the coupling then has no slip to act on."""
    rigid = plant.replace(connection="rigid")
    gear = plant.parameters.r2 / plant.parameters.r1
    geared = np.vstack([np.eye(3), [0.0, 0.0, gear]])
    for state, u, waves in cases(seed=14):
        state[7] = gear * state[6]
        free = oracle(exact, rigid, state, u, waves)
        mass = mass_matrix(exact, rigid, state)
        expected = geared @ np.linalg.solve(geared.T @ mass @ geared, geared.T @ mass @ free)
        np.testing.assert_allclose(rigid.derivative(state, u, tuple(waves))[4:8], expected, rtol=1e-10)


@pytest.mark.parametrize("direction", [0, 1])
def test_radiation_states_realise_the_fit(plant: Any, direction: int) -> None:
    realisation, fit = radiation_realisation(plant, direction), plant.radiation[direction]
    for omega in (0.3, 1.2, 3.14, 8.0, 30.0):
        s = 1j * omega
        expected = np.polyval(fit.p, s) / np.polyval([1.0, *fit.q], s)
        assert realisation(omega) == pytest.approx(expected, rel=1e-9)
        assert realisation(omega).real > 0.0


def test_lever_swings_about_the_vertical_at_1_29(plant: Any) -> None:
    """omega_1 = sqrt(k1/(J1 + Jh1)), ring at rest across the vertical axis, without and with the water's memory."""
    state = np.zeros(14)
    state[2] = np.pi / 2
    slopes = jacobian(plant, state)
    p = plant.parameters
    inner = (p.J22 + p.J13 + p.J14) / 2
    J1 = p.J11 + inner + p.m1 * p.a**2 + (p.m2 + p.m3 + p.m4) * (p.a + p.b) ** 2
    assert np.sqrt(-slopes[4, 0]) == pytest.approx(np.sqrt(p.k1 / (J1 + p.Jh1)), rel=1e-12)
    assert np.sqrt(-slopes[4, 0]) == pytest.approx(1.29, abs=0.005)
    poles = np.linalg.eigvals(slopes)
    swing = poles[np.argmin(np.abs(poles - 1.2j))]
    assert 1.1 < swing.imag < 1.29
    assert -0.05 < swing.real < 0.0


@pytest.mark.parametrize("direction", [0, 1])
def test_printed_sign_of_28_feeds_the_motion(plant: Any, direction: int) -> None:
    """Trap 1: free decay from a push without hinge damping. The printed sign is the plant's with twice Mr added."""
    free = plant.replace(d1=0.0, d3=0.0)
    # the ring's diameter across the moving axis: then the other direction and the ring stay out of it
    start = np.zeros(14)
    start[2] = np.pi / 2 if direction == 0 else 0.0
    start[4 + direction] = 0.1
    rows = slice(8 + 3 * direction, 11 + 3 * direction)
    output = radiation_realisation(free, direction).p
    stiffness = (free.parameters.k1, free.parameters.k3)[direction]
    parameters, derivation = table_1(free), derive()

    def energy(state: Any) -> float:
        kinetic = derivation.energy(state[2], state[4:8], parameters) + added_inertia(free) @ state[4:6] ** 2 / 2
        return float(kinetic + stiffness * state[direction] ** 2 / 2)

    def fly(sign: float) -> float:
        def rate(time: float, state: Any) -> Any:
            moment = np.zeros(2)
            moment[direction] = (1.0 - sign) * (output @ state[rows])
            return free.derivative(state, (0.0, 0.0), tuple(moment))

        state = start
        for step in range(600):
            state = runge_kutta(rate, 0.02 * step, state, 0.02)
        return energy(state) / energy(start)

    assert fly(+1.0) < 1.0
    assert fly(-1.0) > 1.0


def test_energy_balances_and_the_brackets_make_work(plant: Any, exact: Derivation) -> None:
    """Trap 3: the oracle's energy changes along the plant's motion as the powers say; the brackets add cg omega' u1."""
    p = plant.parameters
    gear, parameters = p.r2 / p.r1, table_1(plant)
    for brackets in (False, True):
        chosen = plant.replace(generator_reaction=brackets)
        for state, (cc, cg), waves in cases(seed=15):
            rate = chosen.derivative(state, (cc, cg), tuple(waves))
            moved = state + 1e-30j * rate
            kinetic = exact.energy(moved[2], moved[4:8], parameters) + added_inertia(plant) @ moved[4:6] ** 2 / 2
            spring = np.array([p.k1, p.k3]) @ moved[:2] ** 2 / 2
            stored = (kinetic + spring).imag / 1e-30
            moment = moment_on_lever(plant, state, waves) + np.array([p.k1, p.k3]) * state[:2]
            slip = state[7] - gear * state[6]
            balance = stored - moment @ state[4:6] + cc * slip**2 + cg * state[7] ** 2
            along_axis = np.cos(state[2]) * state[4] - np.sin(state[2]) * state[5]
            excess = cg * state[7] * along_axis if brackets else 0.0
            scale = cc * slip**2 + cg * state[7] ** 2 + abs(moment @ state[4:6]) + 1.0
            assert balance == pytest.approx(excess, abs=1e-10 * scale)


def test_brackets_make_energy_out_of_nothing_in_lock(plant: Any, exact: Derivation) -> None:
    """Twenty waves of 0.1 m: the ledger closes; with the brackets 0.05 % of the wave's work comes from nowhere."""
    parameters, p = table_1(plant), plant.parameters
    stiffness, damping = np.array([p.k1, p.k3]), np.array([p.d1, p.d3])
    excitation = 0.1 * np.array([880.0, 2096.1]) * np.exp(1j * np.deg2rad([88.5, 6.6]))
    outputs = [radiation_realisation(plant, j).p for j in (0, 1)]
    gear = p.r2 / p.r1

    def stored(state: Any) -> float:
        kinetic = exact.energy(state[2], state[4:8], parameters) + added_inertia(plant) @ state[4:6] ** 2 / 2
        return float(kinetic + stiffness @ state[:2] ** 2 / 2)

    def ledger(chosen: Any) -> tuple[float, float, float]:
        """Return the energy gained from nowhere, cg omega' u1 integrated, and the wave's work [J]."""

        def rate(time: float, extended: Any) -> Any:
            state = extended[:14]
            waves = (excitation * np.exp(1j * WP * time)).real
            swing, ring, spin = state[4:6], state[6], state[7]
            radiated = (outputs[0] @ state[8:11]) * swing[0] + (outputs[1] @ state[11:14]) * swing[1]
            loss = radiated + damping @ swing**2 + CC * (spin - gear * ring) ** 2 + CG * spin**2
            excess = CG * spin * (np.cos(state[2]) * swing[0] - np.sin(state[2]) * swing[1])
            return [*chosen.derivative(state, (CC, CG), tuple(waves)), waves @ swing, loss, excess]

        state = np.zeros(17)
        state[6:8] = WP, 70.0
        start, dt = state, 2 * np.pi / WP / 200
        for step in range(4000):
            state = runge_kutta(lambda time, x: np.array(rate(time, x)), step * dt, state, dt)
        assert state[2] == pytest.approx(20 * 2 * np.pi, abs=1.0), "not in lock"
        return stored(state) - stored(start) - (state[14] - state[15]), state[16], state[14]

    residual, _, work = ledger(plant)
    assert abs(residual) < 1e-6 * work
    residual, excess, work = ledger(plant.replace(generator_reaction=True))
    assert residual == pytest.approx(excess, abs=1e-6 * work)
    assert 4e-4 < residual / work < 6e-4
