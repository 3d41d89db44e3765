"""Kramers-Kronig, passive fits and their certificates, against closed forms, sampling and a matrix inequality."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from gyroctl.errors import InputError
from gyroctl.hydrodynamics import fit_radiation, shipped, shipped_fit
from gyroctl.hydrodynamics.interpolation import spline
from gyroctl.hydrodynamics.kramers_kronig import added_mass_inf, dispersion
from gyroctl.hydrodynamics.passive_descent import _numerator, _poles_from, _poles_to
from gyroctl.hydrodynamics.passivity import certify, real_part
from gyroctl.hydrodynamics.radiation import PAPER_FIT, SHIPPED_FITS, assess

coefficients = st.floats(-3.0, 3.0)


def response(p: np.ndarray, q: np.ndarray, omega: np.ndarray) -> np.ndarray:
    return np.polyval(p, 1j * omega) / np.polyval([1.0, *q], 1j * omega)


def test_spline_is_scipys_with_the_same_end_slopes() -> None:
    rng = np.random.default_rng(1)
    x = np.sort(rng.uniform(0.0, 5.0, 12))
    y = rng.normal(size=(3, 12)) + 1j * rng.normal(size=(3, 12))
    fine = np.linspace(x[0], x[-1], 400)
    ends = [
        np.array([np.polyval(np.polyder(np.polyfit(x[s], row[s], 2)), x[e]) for row in y])
        for s, e in ((slice(0, 3), 0), (slice(-3, None), -1))
    ]
    oracle = CubicSpline(x, y, axis=-1, bc_type=((1, ends[0]), (1, ends[1])))(fine)
    assert np.allclose(spline(x, y, fine), oracle, atol=1e-9)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_spline_of_few_points_is_the_polynomial(n: int) -> None:
    x = np.arange(1.0, n + 1.0)
    at = np.linspace(1.0, max(n, 1), 7)
    assert np.allclose(spline(x, x ** (n - 1), at), at ** (n - 1))


def test_kramers_kronig_recovers_a_known_causal_function() -> None:
    """For a rational H the damping Re H gives the added mass Im H / w."""
    p, q = PAPER_FIT[0]
    omega = np.linspace(0.05, 60.0, 600)
    h = response(p, q, omega)
    found = dispersion(omega, h.real)
    inner = (omega > 0.3) & (omega < 40.0)
    assert np.max(np.abs(found - h.imag / omega)[inner]) < 1e-3 * np.max(np.abs(h.imag / omega))


def test_added_mass_at_infinity_of_a_known_function_from_a_table_like_the_shipped_one() -> None:
    p, q = PAPER_FIT[0]
    omega = shipped().omega
    h = response(p, q, omega)
    value, _ = added_mass_inf(omega, 14.39 + h.imag / omega, h.real)
    assert value == pytest.approx(14.39, abs=0.5)  # the damping of a rational function falls slowly: w^-2


@pytest.mark.parametrize("direction", [0, 1])
def test_shipped_table_obeys_kramers_kronig_at_every_frequency(direction: int) -> None:
    hydro = shipped()
    estimates = hydro.added_mass[direction] - dispersion(hydro.omega, hydro.damping[direction])
    assert np.max(np.abs(estimates / hydro.added_mass_inf[direction] - 1.0)) < 0.01


@pytest.mark.slow
@pytest.mark.parametrize("name", ["accurate", "fine"])
@pytest.mark.parametrize("direction", [0, 1])
def test_refitting_gives_the_shipped_fit(name: str, direction: int) -> None:
    order, weight = SHIPPED_FITS[name]
    again, kept = fit_radiation(shipped(), direction, order, weight), shipped_fit(name)[direction]
    omega = np.linspace(0.0, 20.0, 200)
    size = np.max(np.abs(kept(omega)))
    assert np.max(np.abs(again(omega) - kept(omega))) < 1e-5 * size
    assert again.relative_rms == pytest.approx(kept.relative_rms, rel=1e-4)


@pytest.mark.parametrize("direction", [0, 1])
def test_paper_fit_is_the_unweighted_fit_of_second_over_third_order(direction: int) -> None:
    kept = shipped_fit("paper")[direction]
    assert np.array_equal(kept.p, PAPER_FIT[direction][0]) and np.array_equal(kept.q, PAPER_FIT[direction][1])
    again = fit_radiation(shipped(), direction, (2, 3), low_weight=1.0)
    assert kept.relative_rms == pytest.approx(again.relative_rms, abs=0.005)
    omega = np.linspace(0.2, 13.0, 129)
    gap = np.linalg.norm(kept(omega) - again(omega)) / np.linalg.norm(again(omega))
    assert gap < (0.01 if direction == 0 else 0.02)


def test_errors_and_low_frequency_damping_of_the_fits() -> None:
    accurate, paper, fine = (shipped_fit(n) for n in ("accurate", "paper", "fine"))
    assert accurate[0].relative_rms < 0.02 and accurate[1].relative_rms < 0.025
    assert fine[0].relative_rms < 0.002 and fine[1].relative_rms < 0.007
    table = accurate[0].damping_low_table
    assert table == pytest.approx(0.27, abs=0.01)
    assert accurate[0].damping_low == pytest.approx(table, abs=0.05)  # beside d1 = 2 Nms/rad
    assert accurate[1].damping_low == pytest.approx(accurate[1].damping_low_table, rel=0.02)
    assert paper[0].damping_low / table == pytest.approx(4.5, abs=0.3)  # the paper's order over-damps phi1


@pytest.mark.parametrize("name", ["accurate", "paper", "fine"])
@pytest.mark.parametrize("direction", [0, 1])
def test_every_shipped_fit_is_certified(name: str, direction: int) -> None:
    fit = shipped_fit(name)[direction]
    assert fit.passivity.passive and fit.passivity.stable and fit.passivity.crossings == 0
    assert fit(np.geomspace(1e-6, 1e6, 4000)).real.min() >= 0.0
    assert np.all(np.roots([1.0, *fit.q]).real < 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("order", [(0, 1), (1, 2), (2, 3), (3, 4), (4, 5), (5, 6)])
def test_any_order_is_passive_and_no_worse_than_the_one_below(order: tuple[int, int]) -> None:
    fit = fit_radiation(shipped(), 1, order, low_weight=1.0)
    assert fit.passivity.passive
    assert fit.relative_rms < 0.8  # the zero function has 1
    if order[1] > 1:
        lower = fit_radiation(shipped(), 1, (order[0] - 1, order[1] - 1), low_weight=1.0)
        assert fit.relative_rms <= lower.relative_rms * 1.001


def test_fit_of_a_rational_table_finds_its_coefficients() -> None:
    p, q = PAPER_FIT[1]
    hydro = shipped()
    h = response(p, q, hydro.omega)
    added = hydro.added_mass.copy()
    damping = hydro.damping.copy()
    added[1], damping[1] = hydro.added_mass_inf[1] + h.imag / hydro.omega, h.real
    fit = fit_radiation(dataclasses.replace(hydro, added_mass=added, damping=damping), 1, (2, 3))
    assert fit.relative_rms < 1e-3  # the spline through the table is all that is left
    assert fit.p == pytest.approx(p, rel=0.01) and fit.q == pytest.approx(q, rel=0.01)


@pytest.mark.slow
def test_descent_stays_passive_where_the_free_fit_is_not() -> None:
    """Damping bent below zero near 1.3 rad/s, as an unconstrained fit would follow it."""
    hydro = shipped()
    damping = hydro.damping.copy()
    damping[0] -= 3.0 * np.exp(-(((hydro.omega - 1.3) / 0.4) ** 2))
    fit = fit_radiation(dataclasses.replace(hydro, damping=damping), 0, (3, 4))
    assert fit.passivity.passive and fit.passivity.smallest >= 0.0


@settings(max_examples=150, deadline=None)
@given(p=st.tuples(coefficients, coefficients, coefficients), q=st.tuples(*[st.floats(0.05, 5.0)] * 3))
def test_certificate_agrees_with_the_closed_form_of_third_order(
    p: tuple[float, float, float], q: tuple[float, float, float]
) -> None:
    (p0, p1, p2), (q1, q2, q3) = p, q
    c2, c1, c0 = p0 * q1 - p1, p1 * q2 - p2 * q1 - p0 * q3, p2 * q3
    margin = c1 + 2.0 * np.sqrt(max(c0, 0.0) * max(c2, 0.0))
    if min(abs(c2), abs(c0), abs(margin), abs(q1 * q2 - q3)) < 1e-9:
        return  # on the boundary the floats of this test decide nothing
    expected = q1 * q2 > q3 and c2 > 0.0 and c0 > 0.0 and margin > 0.0
    assert certify(p, q).passive == expected


@settings(max_examples=100, deadline=None)
@example(g=[-0.1, 0.0], poles=[0.0] * 6)  # a factor of lower degree
@given(g=st.lists(coefficients, min_size=2, max_size=6), poles=st.lists(st.floats(-1.5, 1.5), min_size=6, max_size=6))
def test_the_parameters_of_the_fit_are_passive_by_construction(g: list[float], poles: list[float]) -> None:
    n = len(g)
    q = _poles_from(np.array(poles[:n]))
    factor = np.array(g) + 0.1 * np.eye(n)[0]
    p = _numerator(factor, q)
    verdict = certify(p, q)
    assert verdict.stable
    c = real_part(p, q)
    omega = np.geomspace(1e-2, 1e2, 60)
    square = np.abs(np.polyval(factor, 1j * omega)) ** 2
    assert np.allclose(np.polyval(c, omega**2), square, rtol=1e-5, atol=1e-7 * np.max(np.abs(c)))


def test_poles_survive_their_parameters() -> None:
    q = np.poly([-0.5, -2.0, -3.0, -1.0 + 4.0j, -1.0 - 4.0j]).real[1:]
    assert _poles_from(_poles_to(q)) == pytest.approx(q, rel=1e-9)


def test_unstable_and_active_functions_are_refused_a_certificate() -> None:
    assert not certify([1.0, 1.0], [-1.0, 1.0]).stable
    active = certify([1396.494, 4584.783, -724.177], [14.6833, 98.1761, 380.4675])
    assert active.stable and not active.passive and active.smallest < 0.0
    dip = certify(*PAPER_FIT[0])
    omega = np.linspace(0.0, 5.0, 5001)
    sampled = response(*PAPER_FIT[0], omega).real
    assert dip.passive and dip.smallest == pytest.approx(sampled.min(), rel=1e-4)
    assert dip.at == pytest.approx(omega[np.argmin(sampled)], abs=2e-3)


@pytest.mark.parametrize(("name", "direction"), [("accurate", 0), ("accurate", 1), ("paper", 0), ("paper", 1)])
def test_linear_matrix_inequality_of_the_positive_real_lemma_agrees(name: str, direction: int) -> None:
    fit = shipped_fit(name)[direction]
    assert lmi_margin(fit.p, fit.q) > -1e-7
    shifted = fit.p.copy()
    shifted[-1] = -0.3 * abs(shifted[-1])
    assert lmi_margin(shifted, fit.q) < -1e-5
    assert not certify(shifted, fit.q).passive


def lmi_margin(p: np.ndarray, q: np.ndarray) -> float:
    """Largest t with A'P + PA <= -t I, PB = C', P >= t I, |P| <= 1, in scaled time; negative when H is not passive."""
    import cvxpy as cp

    n, scale = len(q), 5.0
    powers = scale ** np.arange(1, n + 1)
    a = np.vstack([-(q / powers)[None, :], np.eye(n - 1, n)])
    b = np.eye(n)[:, :1]
    c = (p / powers)[None, :] / np.max(np.abs(p / powers))
    x, t = cp.Variable((n, n), symmetric=True), cp.Variable()
    scaled = cp.Variable(nonneg=True)
    constraints = [a.T @ x + x @ a << -t * np.eye(n), x >> t * np.eye(n), x @ b == scaled * c.T, cp.trace(x) == 1.0]
    problem = cp.Problem(cp.Maximize(t), constraints)
    problem.solve(solver=cp.CLARABEL)
    return float(problem.value) if problem.status in ("optimal", "optimal_inaccurate") else -1.0


@pytest.mark.parametrize(
    ("arguments", "field"),
    [
        ({"direction": 2}, "direction"),
        ({"direction": 0, "order": (1, 3)}, "order"),
        ({"direction": 0, "low_weight": 0.0}, "low_weight"),
    ],
)
def test_bad_requests_are_refused(arguments: dict[str, object], field: str) -> None:
    with pytest.raises(InputError, match=field):
        fit_radiation(shipped(), **arguments)  # type: ignore[arg-type]


def test_unknown_fit_names_the_known_ones() -> None:
    with pytest.raises(InputError, match="accurate"):
        shipped_fit("coarse")


def test_assessment_of_the_zero_function_is_total_error() -> None:
    fit = assess(shipped(), 0, np.zeros(3), np.array([14.0, 98.0, 380.0]))
    assert fit.relative_rms == pytest.approx(1.0)
    assert not fit.passivity.passive
