"""Rational passive approximation of the radiation function, poles free.

    H(iw) ~ K(w) = B(w) + i w (A(w) - A_inf),    H(s) = (p0 s^m + .. + pm) / (s^n + q1 s^(n-1) + .. + qn)

The start is Sanathanan and Koerner's iteration (IEEE Trans. Automatic Control 8, 1963). The descent then moves only
among passive functions: every strictly proper passive H of order n has H(s) + H(-s) = 2 g(s) g(-s) / (Q(s) Q(-s))
with a real g of degree n - 1, the spectral factor of the positive-real lemma; conversely a stable Q and any g give P
by a linear system. So Q, as a product of stable factors, and g are free parameters of an unconstrained least-squares
problem, and nothing has to be sampled or penalised. `passivity.certify` then judges the result on its own.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.database import Coefficients, Hydrodynamics, shipped
from gyroctl.hydrodynamics.interpolation import spline
from gyroctl.hydrodynamics.passivity import Passivity, certify, real_part

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

#: Frequency of the free phi1 mode, where the damping decides whether lock holds. [rad/s]
LOW_FREQUENCY = 1.2
#: Frequencies below this carry `low_weight` in the fit. [rad/s]
LOW_BAND = 2.0
#: Upper end of the fitted band: nothing of waves or motion is left beyond. [rad/s]
HIGH_BAND = 13.0
#: The fits kept in a database: order and low-frequency weight.
SHIPPED_FITS: dict[str, tuple[tuple[int, int], float]] = {"accurate": ((2, 3), 10.0), "fine": ((3, 4), 10.0)}
#: The unweighted (2,3) coefficients of the preset "paper": fixed, so that the preset does not move with the table.
PAPER_FIT: tuple[Coefficients, Coefficients] = (
    (np.array([1396.494, 4584.783, 724.177]), np.array([14.6833, 98.1761, 380.4675])),
    (np.array([636.360, 6278.714, 1293.411]), np.array([11.6028, 83.0018, 134.1893])),
)
_FREQUENCY_SCALE = 5.0  # [rad/s], keeps the coefficients of the fit near one
_STEP = 0.1  # [rad/s], even grid of the fit, so that the tabulated frequencies do not weight it


@dataclass(frozen=True)
class RadiationFit:
    """One direction of the radiation function as P(s)/Q(s).

    Parameters
    ----------
    p : ndarray (m + 1,)
        Numerator, highest power first.
    q : ndarray (n,)
        Denominator without its leading 1.
    relative_rms : float
        Root of sum |H - K|^2 / sum |K|^2 over the band, unweighted. [-]
    damping_low : float
        Re H at 1.2 rad/s. [Nms/rad]
    damping_low_table : float
        The tabulated damping there. [Nms/rad]
    passivity : Passivity
        Certificate of stability and passivity.
    """

    p: Floats
    q: Floats
    relative_rms: float
    damping_low: float
    damping_low_table: float
    passivity: Passivity

    def __call__(self, omega: Floats) -> Complexes:
        """H(iw). (n,)."""
        return _evaluate(self.p, self.q, omega)


def radiation_function(hydro: Hydrodynamics, direction: int) -> tuple[Floats, Complexes]:
    """Return an even frequency grid [rad/s] and K(w) [Nms/rad] on it, for direction 0 (phi1) or 1 (phi3)."""
    low, high = hydro.omega[0], min(hydro.omega[-1], HIGH_BAND)
    omega = np.linspace(low, high, max(64, round((high - low) / _STEP) + 1))
    damping = spline(hydro.omega, hydro.damping[direction], omega)
    added = spline(hydro.omega, hydro.added_mass[direction], omega)
    return omega, damping + 1j * omega * (added - hydro.added_mass_inf[direction])


def assess(hydro: Hydrodynamics, direction: int, p: Floats, q: Floats) -> RadiationFit:
    """Attach error, low-frequency damping and certificate to given coefficients."""
    omega, target = radiation_function(hydro, direction)
    error = _evaluate(p, q, omega) - target
    at = np.array([LOW_FREQUENCY])
    return RadiationFit(
        p=p,
        q=q,
        relative_rms=float(np.linalg.norm(error) / np.linalg.norm(target)),
        damping_low=float(_evaluate(p, q, at)[0].real),
        damping_low_table=float(spline(hydro.omega, hydro.damping[direction], at)[0]),
        passivity=certify(p, q),
    )


def fit_radiation(
    hydro: Hydrodynamics, direction: int, order: tuple[int, int] = (2, 3), low_weight: float = 10.0
) -> RadiationFit:
    """Fit a passive rational function to the tabulated radiation.

    Parameters
    ----------
    hydro : Hydrodynamics
        The table.
    direction : {0, 1}
        0 is phi1, 1 is phi3.
    order : tuple of int
        Degrees (m, n) of numerator and denominator. A strictly proper passive function has m = n - 1.
    low_weight : float
        Weight of the squared error below 2 rad/s; 1 weighs all frequencies alike. At 1.2 rad/s lies the lightly damped
        phi1 mode: there a small absolute error of the damping decides over the stability of the locked orbit.

    Returns
    -------
    RadiationFit

    Raises
    ------
    InputError
        When the order admits no passive function, or the weight is not positive.
    """
    m, n = order
    if direction not in (0, 1):
        raise InputError("direction", direction, "must be 0 (phi1) or 1 (phi3)", "Choose one of the two rotations")
    if n < 1 or m != n - 1:
        raise InputError("order", order, "admits no passive function", "Choose (n - 1, n), for example (2, 3)")
    if not low_weight > 0.0:
        raise InputError("low_weight", low_weight, "must be positive", "Use 1 for no weighting, 10 as the default")
    omega, target = radiation_function(hydro, direction)
    weight = np.where(omega < LOW_BAND, np.sqrt(low_weight), 1.0)
    size = float(np.max(np.abs(target)))
    best = _descend(omega / _FREQUENCY_SCALE, target / size, weight, n)
    scale = _FREQUENCY_SCALE ** np.arange(1, n + 1)
    for lift in _LIFTS:
        p, q = _coefficients(best, lift)
        p, q = p * scale * size, q * scale
        if certify(p, q).passive:
            break
    return assess(hydro, direction, p, q)


def fit_all(hydro: Hydrodynamics) -> dict[str, tuple[Coefficients, Coefficients]]:
    """Return the coefficients of all `SHIPPED_FITS` for a table, to be kept with it."""
    out: dict[str, tuple[Coefficients, Coefficients]] = {}
    for name, (order, weight) in SHIPPED_FITS.items():
        first, second = (fit_radiation(hydro, j, order, weight) for j in range(2))
        out[name] = ((first.p, first.q), (second.p, second.q))
    return out


def shipped_fit(name: str = "accurate") -> tuple[RadiationFit, RadiationFit]:
    """Return a pair of fits kept with the shipped database, without any optimisation.

    Parameters
    ----------
    name : str
        "accurate" (weighted passive (2,3), the default), "paper" (unweighted (2,3): over-damps phi1 at 1.2 rad/s more
        than fourfold, as the paper's own low-order fit does) or "fine" (weighted passive (3,4)).

    Returns
    -------
    tuple of RadiationFit
        For phi1 and phi3.

    Raises
    ------
    InputError
        When there is no fit of that name.
    """
    hydro = shipped()
    if name not in hydro.fits:
        raise InputError("radiation", name, f"is not one of {', '.join(hydro.fits)}", "Choose one of these fits")
    first, second = hydro.fits[name]
    return assess(hydro, 0, *first), assess(hydro, 1, *second)


def _evaluate(p: Floats, q: Floats, omega: Floats) -> Complexes:
    s = 1j * omega
    return np.asarray(np.polyval(p, s) / np.polyval(np.concatenate([[1.0], q]), s), dtype=np.complex128)


def _sanathanan_koerner(omega: Floats, target: Complexes, weight: Floats, n: int) -> tuple[Floats, Floats]:
    """Solve weight (P - K Q)/|last Q| by linear least squares, fifteen times; unstable zeros of Q are mirrored."""
    s = 1j * omega
    powers = s[:, None] ** np.arange(n - 1, -1, -1)
    denominator = np.ones_like(s)
    p: Floats = np.zeros(n)
    q: Floats = np.zeros(n)
    for _ in range(15):
        rows = np.concatenate([powers, -target[:, None] * powers], axis=1)
        w = (weight / np.abs(denominator))[:, None]
        right = (target * s**n)[:, None] * w
        stacked, rhs = rows * w, right[:, 0]
        solution = np.linalg.lstsq(
            np.concatenate([stacked.real, stacked.imag]), np.concatenate([rhs.real, rhs.imag]), rcond=None
        )[0]
        p, q = solution[:n], solution[n:]
        zeros = np.roots(np.concatenate([[1.0], q]))
        q = np.asarray(np.poly(-np.abs(zeros.real) + 1j * zeros.imag).real[1:], dtype=np.float64)
        denominator = np.polyval(np.concatenate([[1.0], q]), s)
    return p, q


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
    return np.asarray(
        np.sqrt(c[0]) * np.atleast_1d(np.poly(-np.abs(zeros.real) + 1j * zeros.imag).real), dtype=np.float64
    )


def _poles_from(parameters: NDArray[Any]) -> NDArray[Any]:
    """Q without its leading 1 from logarithms of the coefficients of its stable first- and second-order factors."""
    q: NDArray[Any] = np.ones(1)
    rest = np.exp(
        np.clip(parameters.real, -30.0, 30.0) + (1j * parameters.imag if np.iscomplexobj(parameters) else 0.0)
    )
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
    square = np.polymul(g, g * (-1.0) ** np.arange(n - 1, -1, -1))[::2]
    square[[0, -1]] += lift * float(np.max(np.abs(square)))
    return np.asarray(np.linalg.solve(matrix, square))


#: The optimum often has a zero of g at w = 0 or at infinity, where rounding decides the sign of Re H. Then g(s) g(-s) is
#: lifted there, relative to its largest coefficient, by the least of these that earns the certificate.
_LIFTS = (0.0, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4)
_COMPLEX_STEP = 1e-30


def _coefficients(x: NDArray[Any], lift: float = 0.0) -> tuple[NDArray[Any], NDArray[Any]]:
    """(p, q) of the free parameters: n of the poles, n of the spectral factor."""
    n = len(x) // 2
    q = _poles_from(x[:n])
    return _numerator(x[n:], q, lift), q


def _descend(omega: Floats, goal: Complexes, weight: Floats, n: int) -> Floats:
    """Best free parameters (2n,) over starts from several weightings of the Sanathanan-Koerner iteration."""
    from scipy.optimize import least_squares

    powers = (1j * omega)[:, None] ** np.arange(n - 1, -1, -1)

    def residual(x: Floats) -> Floats:
        error = weight * (_evaluate(*_coefficients(x), omega) - goal)
        return np.concatenate([error.real, error.imag])

    def jacobian(x: Floats) -> Floats:
        """Exact: by complex step through the coefficients, in closed form from there."""
        p, q = _coefficients(x)
        steps = [_coefficients(x + 1j * _COMPLEX_STEP * e) for e in np.eye(2 * n)]
        dp, dq = (np.array([step[k].imag for step in steps]).T / _COMPLEX_STEP for k in range(2))
        scaled = weight[:, None] * powers / np.polyval(np.concatenate([[1.0], q]), 1j * omega)[:, None]
        slope = scaled @ dp - _evaluate(p, q, omega)[:, None] * (scaled @ dq)
        return np.concatenate([slope.real, slope.imag])

    best: tuple[float, Floats] | None = None
    for exponent in (1.0, 0.0, 0.5, 2.0):
        p, q = _sanathanan_koerner(omega, goal, weight**exponent, n)
        start = np.concatenate([_poles_to(q), _spectral_factor(p, q)])
        found = least_squares(
            residual, start, jacobian, method="lm", x_scale="jac", xtol=1e-13, ftol=1e-13, gtol=1e-13, max_nfev=600
        )
        if best is None or found.cost < best[0]:
            best = (float(found.cost), found.x)
    assert best is not None
    return best[1]
