"""Least squares among passive rational functions: the parameters, the starts and the descent.

Every strictly proper passive H of order n has H(s) + H(-s) = 2 g(s) g(-s) / (Q(s) Q(-s)) with a real g of degree
n - 1, the spectral factor of the positive-real lemma; conversely a stable Q and any g give P by a linear system. So Q,
as a product of stable factors, and g are free parameters of an unconstrained problem, and nothing has to be sampled or
penalised.
The start is Sanathanan and Koerner's iteration (IEEE Trans. Automatic Control 8, 1963).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.hydrodynamics.passivity import real_part
from gyroctl.hydrodynamics.table import Complexes, Floats


def evaluate(p: Floats, q: Floats, omega: Floats) -> Complexes:
    """Return H(iw). (n,)."""
    s = 1j * omega
    return np.asarray(np.polyval(p, s) / np.polyval(np.concatenate([[1.0], q]), s), dtype=np.complex128)


def _polynomial(zeros: NDArray[Any]) -> Floats:
    """Real monic polynomial with the given zeros; 1 when there are none."""
    return np.atleast_1d(np.asarray(np.poly(zeros).real, dtype=np.float64))


def _sanathanan_koerner(omega: Floats, target: Complexes, weight: Floats, n: int) -> tuple[Floats, Floats]:
    """Solve weight (P - K Q)/|last Q| by linear least squares, fifteen times; unstable zeros of Q are mirrored."""
    s = 1j * omega
    powers = s[:, None] ** np.arange(n - 1, -1, -1)
    denominator = np.ones_like(s)
    p: Floats = np.zeros(n)
    q: Floats = np.zeros(n)
    for _ in range(15):
        rows = np.concatenate([powers, -target[:, None] * powers], axis=1)
        w = weight / np.abs(denominator)
        rows, right = rows * w[:, None], target * s**n * w
        p, q = np.split(np.linalg.lstsq(_real(rows), _real(right), rcond=None)[0], 2)
        zeros = np.roots(np.concatenate([[1.0], q]))
        q = _polynomial(-np.abs(zeros.real) + 1j * zeros.imag)[1:]
        denominator = np.polyval(np.concatenate([[1.0], q]), s)
    return p, q


def _real(equations: NDArray[Any]) -> Floats:
    """Real parts of complex equations, then their imaginary parts."""
    return np.concatenate([equations.real, equations.imag])


def _spectral_factor(p: Floats, q: Floats) -> Floats:
    """Stable real g of degree n - 1 with g(s) g(-s) near the real part of P(s) Q(-s); negative stretches are lifted."""
    c = real_part(p, q)
    n = len(q)
    c = np.concatenate([np.zeros(n - len(c)), c])
    if c[0] <= 0.0:
        c[0] = 1e-3 * np.max(np.abs(c))
    grid = np.concatenate([[0.0], np.geomspace(1e-4, 1e2, 400)])
    values = np.polyval(c, grid)
    if values.min() < 0.0:
        c[-1] -= 1.01 * values.min()
    zeros = np.sqrt(np.roots(c).astype(complex) * -1.0)  # x = -s^2
    return np.asarray(np.sqrt(c[0]) * _polynomial(-np.abs(zeros.real) + 1j * zeros.imag), dtype=np.float64)


def _poles_from(parameters: NDArray[Any]) -> NDArray[Any]:
    """Q without its leading 1 from logarithms of the coefficients of its stable first- and second-order factors."""
    q: NDArray[Any] = np.ones(1)
    turn = 1j * parameters.imag if np.iscomplexobj(parameters) else 0.0
    rest = np.exp(np.clip(parameters.real, -30.0, 30.0) + turn)
    if len(rest) % 2:
        q, rest = np.array([1.0, rest[0]]), rest[1:]
    for a, b in rest.reshape(-1, 2):
        q = np.polymul(q, np.array([1.0, a, b]))
    return q[1:]


def _poles_to(q: Floats) -> Floats:
    """Inverse of `_poles_from`: real zeros in pairs, the odd one out first."""
    zeros = np.roots(np.concatenate([[1.0], q]))
    zeros = -np.abs(zeros.real) + 1j * zeros.imag
    zeros = zeros - 1e-3 * (np.abs(zeros.real) < 1e-3)
    pairs = [z for z in zeros if z.imag > 1e-9 * abs(z)]
    real = sorted(-z.real for z in zeros if abs(z.imag) <= 1e-9 * abs(z))
    out = [real.pop()] if len(real) % 2 else []
    for z in pairs:
        out += [-2.0 * z.real, abs(z) ** 2]
    for a, b in zip(real[::2], real[1::2], strict=True):
        out += [a + b, a * b]
    return np.asarray(np.log(out), dtype=np.float64)


def _numerator(g: NDArray[Any], q: NDArray[Any], lift: float = 0.0) -> NDArray[Any]:
    """P with (P(s) Q(-s) + P(-s) Q(s))/2 = g(s) g(-s), lifted at both ends: a linear system, regular for stable Q."""
    n = len(q)
    mirror = np.concatenate([[1.0], q]) * (-1.0) ** np.arange(n, -1, -1)
    matrix = np.zeros((n, n), dtype=mirror.dtype)
    for k in range(n):  # the numerator s^(n-1-k): even powers 2n-2, .., 0 of s^(n-1-k) Q(-s)
        product = np.zeros(2 * n, dtype=mirror.dtype)
        product[k : k + n + 1] = mirror
        matrix[:, k] = product[1::2]
    square = np.convolve(g, g * (-1.0) ** np.arange(n - 1, -1, -1))[::2]  # `polymul` drops leading zeros
    square[[0, -1]] += lift * float(np.max(np.abs(square)))
    return np.asarray(np.linalg.solve(matrix, square))


_COMPLEX_STEP = 1e-30


def coefficients(x: NDArray[Any], lift: float = 0.0) -> tuple[NDArray[Any], NDArray[Any]]:
    """(p, q) of the free parameters: n of the poles, n of the spectral factor."""
    n = len(x) // 2
    q = _poles_from(x[:n])
    return _numerator(x[n:], q, lift), q


def descend(omega: Floats, goal: Complexes, weight: Floats, n: int) -> Floats:
    """Best free parameters (2n,) over starts from several weightings of the Sanathanan-Koerner iteration."""
    from scipy.optimize import least_squares

    powers = (1j * omega)[:, None] ** np.arange(n - 1, -1, -1)

    def residual(x: Floats) -> Floats:
        return _real(weight * (evaluate(*coefficients(x), omega) - goal))

    def jacobian(x: Floats) -> Floats:
        """Exact: by complex step through the coefficients, in closed form from there."""
        p, q = coefficients(x)
        steps = [coefficients(x + 1j * _COMPLEX_STEP * e) for e in np.eye(2 * n)]
        dp, dq = (np.array([step[k].imag for step in steps]).T / _COMPLEX_STEP for k in range(2))
        scaled = weight[:, None] * powers / np.polyval(np.concatenate([[1.0], q]), 1j * omega)[:, None]
        return _real(scaled @ dp - evaluate(p, q, omega)[:, None] * (scaled @ dq))

    starts = []
    for exponent in (1.0, 0.0, 0.5, 2.0):
        p, q = _sanathanan_koerner(omega, goal, weight**exponent, n)
        starts.append(np.concatenate([_poles_to(q), _spectral_factor(p, q)]))
    # g = 0 is stationary, so a start too active to have a spectral factor of any size would stay there
    poles = _polynomial(-np.arange(1.0, n + 1.0))[1:]
    starts.append(np.concatenate([_poles_to(poles), _polynomial(-np.arange(1.0, n))]))
    fine = {"x_scale": "jac", "xtol": 1e-13, "ftol": 1e-13, "gtol": 1e-13, "max_nfev": 600}
    ends = [least_squares(residual, start, jacobian, method="lm", **fine) for start in starts]
    return np.asarray(min(ends, key=lambda end: float(end.cost)).x)
