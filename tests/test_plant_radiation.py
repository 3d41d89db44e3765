"""The plant's radiation: a rational function of any order, accepted where it is passive."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import gyroctl as gy


def test_radiation_of_any_order_is_its_rational_function() -> None:
    """The (3, 4) fit: moment of the water on the float over its rate, read off the Jacobian."""
    plant = gy.zhang2017(radiation="fine")
    x = np.zeros(16)
    x[2] = 0.4
    A, B = plant.jacobians(x, (0.0, 0.0), (0.0, 0.0))
    for j, rows in enumerate((slice(8, 12), slice(12, 16))):
        output = -A[4 + j, rows] / B[4 + j, 2 + j]
        fit = plant.radiation[j]
        for w in (0.2, 1.2, 3.14, 9.0, 40.0):
            gain = output @ np.linalg.solve(1j * w * np.eye(4) - A[rows, rows], A[rows, 4 + j])
            expected = np.polyval(fit.p, 1j * w) / np.polyval([1.0, *fit.q], 1j * w)
            assert gain == pytest.approx(expected, rel=1e-9)
            assert fit.response(w) == pytest.approx(expected, rel=1e-12)


def test_radiation_of_first_order_and_of_none() -> None:
    assert gy.Radiation((2.0,), (3.0,)).response(0.0) == pytest.approx(2.0 / 3.0)
    still = gy.Radiation((0.0,), (1.0,))
    plant = gy.zhang2017(radiation=(still, still))
    assert plant.labels[-2:] == ("z1_1", "z3_1")
    assert plant.powers(np.ones(10), (0.0, 0.0), (0.0, 0.0))["radiated"] == 0.0


# --- passivity ---------------------------------------------------------------------------------------------------


def smallest_real_part(p: list[float], q: list[float]) -> float:
    """Least value over x = w^2 >= 0 of Re P(iw)Q(-iw) for n = 3 (DESIGN, closed form)."""
    a, b, c = p[0] * q[0] - p[1], p[1] * q[1] - p[2] * q[0] - p[0] * q[2], p[2] * q[2]
    if a < 0.0:
        return -math.inf
    if b >= 0.0:
        return c
    return c - b * b / (4.0 * a) if a > 0.0 else -math.inf


@given(
    p=st.lists(st.floats(-3.0, 10.0), min_size=3, max_size=3), q=st.lists(st.floats(0.1, 10.0), min_size=3, max_size=3)
)
@settings(max_examples=300, deadline=None)
def test_passivity_is_decided_as_by_the_closed_form_of_third_order(p: list[float], q: list[float]) -> None:
    margin = q[0] * q[1] - q[2]  # Routh
    least = smallest_real_part(p, q)
    scale = max(1.0, *(abs(v) for v in p)) * max(1.0, *q)
    assume(abs(margin) > 1e-6 and (abs(least) > 1e-6 * scale or least == -math.inf))
    assume(abs(p[0] * q[0] - p[1]) > 1e-6 * scale)
    if margin < 0.0:
        with pytest.raises(gy.InputError, match=r"radiation\.q"):
            gy.Radiation(tuple(p), tuple(q))
    elif least < 0.0:
        with pytest.raises(gy.InputError, match=r"radiation\.p.*not passive"):
            gy.Radiation(tuple(p), tuple(q))
    else:
        assert np.min(gy.Radiation(tuple(p), tuple(q)).response(np.geomspace(1e-3, 1e3, 200)).real) >= -1e-9 * scale


@pytest.mark.parametrize(
    ("p", "q", "field"),
    [
        ((1396.494, 4584.783, -1.0), (14.6833, 98.1761, 380.4675), "radiation.p"),  # active at rest
        ((1396.494, 4584.783, 724.177), (14.6833, -98.1761, 380.4675), "radiation.q"),  # unstable
        ((1.0, 2.0, 3.0, 4.0), (14.6833, 98.1761, 380.4675), "radiation.p"),  # improper
        ((1.0, math.nan, 3.0), (14.6833, 98.1761, 380.4675), "radiation.p"),
        ((), (1.0,), "radiation.p"),
        ((-1.0,), (1.0,), "radiation.p"),
        # p2 = 0 without the constraint: negative just above w = 0 because p1 q2 < p0 q3
        ((2000.0, 100.0, 0.0), (14.6833, 98.1761, 380.4675), "radiation.p"),
    ],
)
def test_radiation_that_gives_energy_is_refused(p: tuple[float, ...], q: tuple[float, ...], field: str) -> None:
    with pytest.raises(gy.InputError) as caught:
        gy.Radiation(p, q)
    assert caught.value.field == field
    assert caught.value.mend


def test_a_fit_on_the_boundary_of_passivity_is_accepted() -> None:
    """Where the constraint binds, p0 q1 = p1 but for rounding; such a fit came out of the deep-water database."""
    from gyroctl.hydrodynamics.passivity import certify

    p = (568.2501898362123, 12775.80214857314, 8.247167822143346e-05)
    q = (22.48270634, 147.10695184, 485.998964)
    p = (p[0], p[0] * q[0], p[2])
    for exact in (p, (p[0], np.nextafter(p[1], 0.0), p[2]), (p[0], p[1], 0.0)):
        assert certify((*exact[:1], exact[1] * (1 - 1e-15), exact[2]), q).passive
        assert gy.Radiation(exact, q).p == exact
    with pytest.raises(gy.InputError, match="not passive"):
        gy.Radiation((p[0], p[1] * (1 + 1e-9), p[2]), q)
