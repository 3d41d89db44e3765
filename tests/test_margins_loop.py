"""Margins of a law in the loop: against the nonlinear loop, python-control and the definition of the disk."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.loop_margins.closed_loop_orbit import LoopOrbit, close_loop
from gyroctl.loop_margins.dual_numbers import NotDifferentiable, step_jacobian
from gyroctl.loop_margins.margins import (
    DELAY_MAX,
    LoopMargins,
    OpenedLoop,
    channel_margins,
    delayed_transition,
    loop_margins,
    open_loop,
)
from gyroctl.loop_margins.trial import try_loop
from gyroctl.nested import leaves, like
from gyroctl.plant.measurement import Measurement

WAVE = gy.Regular(height=0.2, wp=3.14)


class Held(NamedTuple):
    value: float


class Regulator(NamedTuple):
    """Integral action of cg on the flywheel speed: an oscillation through delay."""

    integral: float = 3e-4
    speed: float = 68.0
    cc: float = 0.06
    period: float = 0.1

    def init(self) -> Held:
        return Held(2.5e-3)

    def step(self, t: float, y: Any, state: Held) -> tuple[tuple[float, float], Held]:
        new = state.value + self.integral * self.period * (y.omega_rate - self.speed)
        return (self.cc, max(new, 0.0)), Held(new)


class Both(NamedTuple):
    """Both controls move, with the load angle and the ring speed: gains that end stability in several places."""

    damping: float = 2.0
    period: float = 0.1

    def init(self) -> Held:
        return Held(0.0)

    def step(self, t: float, y: Any, state: Held) -> tuple[tuple[float, float], Held]:
        slip = 22.555555555555557 * y.psi_rate - y.omega_rate
        u1 = math.cos(y.psi) * y.phi1_rate - math.sin(y.psi) * y.phi3_rate
        slow = state.value + (1.0 - math.exp(-self.period)) * (u1 - state.value)
        cc = max(0.1 + 0.1 * self.damping * (y.psi_rate - 3.14), 0.0)
        return (cc, 2.5e-3 + 2e-4 * slip + 3e-3 * (slow - 0.3)), Held(slow)


class Stubborn(NamedTuple):
    """Rounds what it measures: it has no derivative."""

    period: float = 0.1

    def init(self) -> tuple[()]:
        return ()

    def step(self, t: float, y: Any, state: tuple[()]) -> tuple[tuple[float, float], tuple[()]]:
        return (0.052, 1e-3 + 1e-6 * float(np.array([y.psi_rate], float)[0])), ()


LAWS: dict[str, Any] = {"regulator": Regulator(), "both": Both(), "load_angle": None}


@pytest.fixture(scope="module", params=LAWS)
def loop(request: pytest.FixtureRequest, device: gy.Plant) -> LoopOrbit:
    law = LAWS[request.param]
    return close_loop(device, WAVE, gy.law(request.param) if law is None else law)


@pytest.fixture(scope="module")
def margins(loop: LoopOrbit) -> LoopMargins:
    return loop_margins(loop)


def confirm(loop: LoopOrbit, margins: LoopMargins) -> int:
    """Put every finite margin into the nonlinear loop at 0.95 and 1.05 of it; return how many there were."""
    count = 0
    for name, found in margins.channels.items():
        low, high = found.gain
        trials = [("gain", high)] if math.isfinite(high) else []
        trials += [("delay", found.delay)] if math.isfinite(found.delay) else []
        for kind, value in trials:
            count += 1
            inside = try_loop(loop, name, **{kind: 0.95 * value})
            outside = try_loop(loop, name, **{kind: 1.05 * value})
            assert inside.stable and inside.growth < 1.0, (name, kind, value)
            assert not outside.stable and outside.growth > 1.0, (name, kind, value)
            for trial in (inside, outside):
                assert trial.growth == pytest.approx(trial.predicted, rel=2e-4)
        if low > 0.0:
            count += 1
            assert try_loop(loop, name, gain=low / 0.95).stable
            assert not try_loop(loop, name, gain=low * 0.95).stable
    return count


# --- the bar: each margin in the nonlinear loop -------------------------------------------------------------------


@pytest.mark.slow
def test_every_gain_and_delay_margin_holds_in_the_nonlinear_loop(loop: LoopOrbit, margins: LoopMargins) -> None:
    assert margins.status == "stable"
    assert confirm(loop, margins) >= 2


@pytest.mark.slow
def test_margins_of_the_coupling_law_hold_as_well(device: gy.Plant) -> None:
    """The law that clips and switches; its loop is stable in the higher waves only."""
    loop = next(
        found
        for height in (0.3, 0.35, 0.25, 0.2, 0.4)
        if (found := close_loop(device, gy.Regular(height, 3.14), gy.law("coupling"))).status == "stable"
    )
    for name in ("cc", "cg", "psi", "phi1_rate"):
        found = channel_margins(loop, name)
        for kind, value in (("gain", found.gain[1]), ("delay", found.delay)):
            if not math.isfinite(value):
                continue
            for factor in (0.95, 1.005, 1.05):
                trial = try_loop(loop, name, **{kind: factor * value}, size=1e-7)
                assert trial.stable == (trial.predicted < 1.0), (name, kind, factor)
                if factor < 1.01:  # a delay may stabilise again a little further on
                    assert trial.stable == (factor < 1.0), (name, kind, factor)


def test_regulator_has_a_delay_margin(device: gy.Plant) -> None:
    """A slow loop: phase over frequency of the crossing is the delay, as for a time-invariant one."""
    loop = close_loop(device, WAVE, Regulator())
    found = channel_margins(loop, "cg")
    assert 0.5 < found.delay < DELAY_MAX * 2.0 and math.isinf(found.gain[1])
    radius = np.exp(1j * math.radians(found.phase))
    crossing = open_loop(loop, ("cg",)).multipliers(radius)[0]
    frequency = abs(np.angle(crossing)) / (2 * math.pi / 3.14)
    assert math.radians(found.phase) / frequency == pytest.approx(found.delay, rel=0.02)
    assert channel_margins(loop, "omega_rate").delay == pytest.approx(found.delay, rel=1e-4)


def test_delay_changes_nothing_at_zero_and_is_continuous_over_a_sample(loop: LoopOrbit) -> None:
    h = loop.flow.period
    for name in ("cg", "psi_rate", "omega_rate"):
        after = delayed_transition(loop, name)
        radius = [float(np.max(np.abs(np.linalg.eigvals(after(d * h))))) for d in (0.0, 1e-6, 0.9999, 1.0, 1.0001)]
        assert radius[0] == pytest.approx(abs(loop.multipliers[0]), rel=1e-9)
        assert radius[1] == pytest.approx(radius[0], abs=1e-5)
        np.testing.assert_allclose(radius[2:], radius[3], atol=1e-4)


# --- consistency -------------------------------------------------------------------------------------------------


def test_closed_loop_is_periodic_and_its_multipliers_are_those_of_a_disturbance(loop: LoopOrbit) -> None:
    flow, x, state = loop.flow, loop.states[0], loop.law_states[0]
    for k in range(flow.samples):
        command, state = loop.law.step(k * flow.period, Measurement(*x[[2, 6, 7, 0, 1, 4, 5]].tolist()), state)
        x = flow.advance(x, command[0], command[1], k)
    gap = x - loop.states[0]
    gap[2] -= 2 * math.pi
    assert np.max(np.abs(gap[flow.free])) < 1e-9
    np.testing.assert_allclose(leaves(state), leaves(loop.law_states[0]), rtol=1e-8, atol=1e-10)
    opened = open_loop(loop, ("cc",))
    np.testing.assert_allclose(np.abs(opened.multipliers()[:5]), np.abs(loop.multipliers[:5]), rtol=1e-8)
    trial = try_loop(loop, "cg")
    assert trial.stable and trial.growth == pytest.approx(abs(loop.multipliers[0]), abs=1e-4)


def test_disk_is_inside_the_other_margins(margins: LoopMargins) -> None:
    for name, found in margins.channels.items():
        low, high = found.guaranteed_gain
        assert found.gain[0] <= low + 1e-9 and high <= found.gain[1] * (1 + 1e-6), name
        assert found.guaranteed_phase <= found.phase + 1e-6, name
        assert 0.0 < found.disk <= 2.0 + 1e-9


@pytest.mark.parametrize("channel", ["cg", "psi_rate"])
def test_any_gain_and_phase_inside_the_disk_leaves_the_loop_stable(loop: LoopOrbit, channel: str) -> None:
    """Another one in every sample: f = (1 + d/2)/(1 - d/2), |d| < alpha."""
    opened = open_loop(loop, (channel,))
    alpha, rng = opened.disk(), np.random.default_rng(0)
    for _ in range(40):
        d = 0.999 * alpha * np.exp(2j * math.pi * rng.random(opened.A.shape[0]))
        factor = (1 + d / 2) / (1 - d / 2)
        product: Any = np.eye(opened.A.shape[1])
        for k, f in enumerate(factor):
            product = (opened.A[k] + f * opened.B[k] @ opened.C[k]) @ product
        assert np.max(np.abs(np.linalg.eigvals(product))) < 1.0


def test_nyquist_plot_reaches_minus_one_at_the_gain_margin(device: gy.Plant) -> None:
    loop = close_loop(device, WAVE, Both())
    opened = open_loop(loop, ("cc",))
    _, high = opened.gain_margin()
    angle = abs(np.angle(opened.multipliers(high)[0]))
    loci = np.linalg.eigvals(opened.loop_gain(np.array([angle]))[0])
    assert np.min(np.abs(high * loci + 1.0)) < 1e-5
    angles, course = opened.nyquist(50)
    assert course.shape == (50, loop.flow.samples) and angles[-1] == pytest.approx(math.pi)


def test_law_without_feedback_has_every_margin(device: gy.Plant) -> None:
    margins = loop_margins(close_loop(device, WAVE, gy.law("constant")))
    for found in margins.channels.values():
        assert found.gain == (0.0, math.inf) and found.phase == 180.0
        assert found.guaranteed_gain == (0.0, math.inf) and found.disk == pytest.approx(2.0)


# --- a time-invariant loop: python-control says the same ----------------------------------------------------------


@pytest.mark.parametrize("samples", [1, 4])
@pytest.mark.parametrize("gain", [0.2, 0.5])
def test_time_invariant_loop_has_the_classical_margins(samples: int, gain: float) -> None:
    """Seen over one sample or lifted over four: the same gain, phase and disk."""
    import control

    plant = control.c2d(control.tf([gain], [1.0, 0.6, 0.3, 0.0]), 0.5)
    space = control.ss(plant)
    a, b, c = (np.repeat(part[None], samples, 0) for part in (space.A, -space.B, space.C))
    opened = OpenedLoop(("v",), a, b, c)
    loop = opened if opened.radius() < 1.0 else None
    if loop is None:
        opened = OpenedLoop(("v",), a, 0.2 * b, c)
        plant = 0.2 * plant
    gm, pm, _, _ = control.margin(plant)
    assert opened.gain_margin()[1] == pytest.approx(gm, rel=1e-6)
    assert opened.phase_margin() == pytest.approx(pm, rel=1e-6)
    omega = np.geomspace(1e-3, math.pi / 0.5, 20000)
    alpha = control.disk_margins(control.ss(plant), omega, skew=0.0)[0]
    assert opened.disk() == pytest.approx(alpha, rel=1e-4)


# --- derivatives of laws -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("law", [Regulator(), Both(), "load_angle", "coupling", "constant"], ids=str)
def test_derivative_of_a_law_is_that_of_differences(law: Any) -> None:
    law = gy.law(law) if isinstance(law, str) else law
    y, state = Measurement(1.0, 3.0, 66.0, 0.05, 0.03, 0.1, -0.2), law.init()
    for i in range(5, 0, -1):  # no sensor tells the same twice
        seen = Measurement(*(value - 1e-3 * i * (j + 1) for j, value in enumerate(y)))
        _, state = law.step(0.0, seen, state)

    def flat(z: Any) -> Any:
        (cc, cg), new = law.step(0.0, Measurement(*z[:7]), like(state, z[7:]))
        return np.array([cc, cg, *leaves(new)])

    point, e = np.array([*y, *leaves(state)]), 1e-6
    expected = np.array([(flat(point + e * d) - flat(point - e * d)) / (2 * e) for d in np.eye(point.size)]).T
    values, by_y, by_s = step_jacobian(law, 0.0, y, state)
    np.testing.assert_allclose(values, flat(point), rtol=5e-16)  # a quotient is a product with the inverse here
    np.testing.assert_allclose(np.hstack([by_y, by_s]), expected, atol=1e-8)


class Menagerie(NamedTuple):
    """Every function that a law may use."""

    period: float = 0.1

    def helper(self, x: Any) -> Any:
        return math.tanh(x) + math.hypot(x, 2.0) + math.fmod(x, 0.7)

    def init(self) -> tuple[()]:
        return ()

    def step(self, t: float, y: Any, state: tuple[()]) -> tuple[tuple[Any, Any], tuple[()]]:
        a = math.sqrt(y.psi) * math.exp(-y.psi_rate) / (1.0 + y.psi**2) + math.atan2(y.phi1, y.phi3) - abs(y.phi3)
        b = math.log(y.psi_rate) + 2.0**y.psi + y.psi**y.psi_rate + self.helper(y.phi1) + np.sin(y.phi3)
        return (a + math.remainder(y.psi, 0.4), b + max(y.phi1, 0.0) + math.asin(y.phi1) + math.tan(y.psi)), ()


def test_derivatives_of_all_functions() -> None:
    y, e = Measurement(0.9, 1.3, 66.0, 0.35, -0.23, 0.1, -0.2), 1e-6
    law = Menagerie()
    _, by_y, _ = step_jacobian(law, 0.0, y, ())
    for i in range(7):
        up, down = (np.array(law.step(0.0, Measurement(*(np.array(y) + s * e * np.eye(7)[i])), ())[0]) for s in (1, -1))
        np.testing.assert_allclose(by_y[:, i], (up - down) / (2 * e), atol=1e-8)


# --- what has no margin says so -----------------------------------------------------------------------------------


def test_law_that_is_not_differentiable_says_which_margins_are_missing(device: gy.Plant) -> None:
    with pytest.raises(NotDifferentiable):
        step_jacobian(Stubborn(), 0.0, Measurement(1.0, 3.0, 66.0, 0.05, 0.03, 0.1, -0.2), ())
    loop = close_loop(device, WAVE, Stubborn())
    assert loop.status == "not differentiable"
    assert "Gain, phase, delay and disk margins" in loop.advice
    assert loop_margins(loop).channels == {}


def test_unstable_loop_is_reported_and_has_no_margin(device: gy.Plant) -> None:
    """Small coupling: the horizontal mode grows, whatever the constant law holds."""
    loop = close_loop(
        device, WAVE, gy.law("constant", cc=0.02, cg=1e-3), settle=0, start=gy.lock_orbit(device, WAVE, 0.02, 1e-3)
    )
    assert loop.status == "unstable" and abs(loop.multipliers[0]) > 1.0
    margins = loop_margins(loop)
    assert margins.status == "unstable" and margins.channels == {} and margins.advice
    assert not try_loop(loop, "cg").stable


def test_wave_without_lock_has_no_loop(device: gy.Plant) -> None:
    loop = close_loop(device, gy.Regular(0.005, 3.14), gy.law("load_angle"))
    assert loop.status in ("no orbit", "not periodic") and loop.advice
    with pytest.raises(gy.InputError, match="no orbit to disturb"):
        try_loop(loop, "cg")


def test_bad_requests_are_named(device: gy.Plant, loop: LoopOrbit) -> None:
    with pytest.raises(gy.InputError, match="channels"):
        open_loop(loop, ("cc", "psi"))
    with pytest.raises(gy.InputError, match="channels"):
        channel_margins(loop, "torque")
    with pytest.raises(gy.InputError, match="either a gain or a delay"):
        try_loop(loop, "cg", gain=2.0, delay=0.1)
    with pytest.raises(gy.InputError, match=r"law\.period"):
        close_loop(device, WAVE, Regulator(period=-0.1))
