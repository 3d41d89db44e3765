"""Certificate that a rational radiation function H = P/Q is stable and passive: exact arithmetic, no sampling.

Re H(iw) = c(w^2) / |Q(iw)|^2, where c is a polynomial. Floats are rational numbers, so c is formed exactly, Sturm's
theorem counts its zeros on (0, inf) and Routh's scheme decides the stability of Q, both in ratios of integers: the
answer is a proof about the very coefficients that the simulation uses, not a statement up to rounding.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Exact = list[Fraction]


class Passivity(NamedTuple):
    """Certificate for one direction of motion."""

    stable: bool
    """All zeros of Q lie in the open left half plane (Routh)."""
    passive: bool
    """Stable, and Re H(iw) >= 0 for all w in [0, inf) (Sturm)."""
    crossings: int
    """Distinct zeros of c(x), x = w^2, on (0, inf); 0 in a strict certificate."""
    smallest: float
    """Smallest Re H(iw) over its stationary points and w = 0. [Nms/rad]"""
    at: float
    """Frequency of that minimum. [rad/s]"""


def certify(p: Sequence[float] | NDArray[np.float64], q: Sequence[float] | NDArray[np.float64]) -> Passivity:
    """Decide stability and passivity of H(s) = (p0 s^m + .. + pm) / (s^n + q1 s^(n-1) + .. + qn).

    Parameters
    ----------
    p : array_like (m + 1,)
        Numerator.
    q : array_like (n,)
        Denominator without its leading 1.

    Returns
    -------
    Passivity
    """
    numerator = [Fraction(float(v)) for v in p]
    denominator = [Fraction(1), *(Fraction(float(v)) for v in q)]
    c = _real_part(numerator, denominator)
    stable = _hurwitz(denominator)
    crossings, sign = _positive_zeros(c)
    at, smallest = _minimum(np.asarray(p, dtype=np.float64), np.asarray(q, dtype=np.float64))
    # without a zero on (0, inf) one value settles the sign everywhere; c(0) >= 0 follows by continuity
    passive = stable and crossings == 0 and sign > 0
    return Passivity(stable, passive, crossings, smallest, at)


def real_part(p: NDArray[np.float64], q: NDArray[np.float64]) -> NDArray[np.float64]:
    """Coefficients of c(x) with Re H(iw) = c(w^2)/|Q(iw)|^2, highest power first. (n,)."""
    c = _real_part([Fraction(float(v)) for v in p], [Fraction(1), *(Fraction(float(v)) for v in q)])
    return np.array([float(v) for v in c])


def _real_part(p: Exact, q: Exact) -> Exact:
    """Even part of P(s) Q(-s) in x = -s^2, highest power first."""
    n = len(q) - 1
    mirrored = [v * (-1) ** (n - k) for k, v in enumerate(q)]  # Q(-s), highest power first
    product = [Fraction(0)] * (len(p) + n)
    for i, a in enumerate(p):
        for j, b in enumerate(mirrored):
            product[i + j] += a * b
    ascending = product[::-1][::2]
    return _trim([v * (-1) ** k for k, v in enumerate(ascending)][::-1])


def _trim(a: Exact) -> Exact:
    """Drop leading zeros."""
    while len(a) > 1 and a[0] == 0:
        a = a[1:]
    return a


def _remainder(a: Exact, b: Exact) -> Exact:
    """Remainder of the polynomial division a / b."""
    a = list(a)
    while len(a) >= len(b):
        factor = a[0] / b[0]
        for k in range(len(b)):
            a[k] -= factor * b[k]
        a = a[1:]
    return _trim(a) if a else [Fraction(0)]


def _positive_zeros(c: Exact) -> tuple[int, int]:
    """Count the distinct zeros of c on (0, inf) by Sturm's theorem; return also the sign of c at infinity."""
    while len(c) > 1 and c[-1] == 0:  # zeros at x = 0 itself do no harm
        c = c[:-1]
    sign = (c[0] > 0) - (c[0] < 0)
    degree = len(c) - 1
    chain = [c, _trim([v * (degree - k) for k, v in enumerate(c[:-1])])] if degree else [c]
    while len(chain[-1]) > 1:
        rest = _remainder(chain[-2], chain[-1])
        if rest == [0]:
            break
        chain.append([-v for v in rest])
    at_zero = _changes([a[-1] for a in chain])
    at_infinity = _changes([a[0] for a in chain])
    return at_zero - at_infinity, sign


def _changes(values: Exact) -> int:
    """Count changes of sign along a sequence, zeros left out."""
    kept = [v > 0 for v in values if v != 0]
    return sum(a != b for a, b in pairwise(kept))


def _hurwitz(q: Exact) -> bool:
    """Routh's criterion: all zeros of q in the open left half plane."""
    upper, lower = list(q[::2]), list(q[1::2])
    while lower:
        if upper[0] * lower[0] <= 0:
            return False
        factor = upper[0] / lower[0]
        following = [v - factor * (lower[k + 1] if k + 1 < len(lower) else 0) for k, v in enumerate(upper[1:])]
        upper, lower = lower, following
    return True


def _minimum(p: NDArray[np.float64], q: NDArray[np.float64]) -> tuple[float, float]:
    """Frequency and value of the smallest Re H(iw) at w = 0 or a stationary point (for information, in floats)."""
    c = real_part(p, q)
    full = np.concatenate([[1.0], q])
    even, odd = ((half * (-1.0) ** np.arange(len(half)))[::-1] for half in (full[::-1][::2], full[::-1][1::2]))
    size = np.polyadd(np.polymul(even, even), np.polymul([1.0, 0.0], np.polymul(odd, odd)))  # |Q|^2 in x
    stationary = np.roots(np.polysub(np.polymul(np.polyder(c), size), np.polymul(c, np.polyder(size))))
    real = np.abs(stationary.imag) < 1e-9 * (1.0 + np.abs(stationary))
    x = np.concatenate([[0.0], stationary.real[real & (stationary.real > 0)]])
    values = np.polyval(c, x) / np.polyval(size, x)
    k = int(np.argmin(values))
    return float(np.sqrt(x[k])), float(values[k])
