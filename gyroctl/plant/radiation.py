"""Radiation moment as a rational function of the rate: H(s) = P(s)/Q(s), (27)-(28)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyroctl.errors import InputError


@dataclass(frozen=True)
class Radiation:
    """Rational radiation function of one direction.

    Parameters
    ----------
    p : tuple of m + 1 floats
        Numerator, highest power first: p0 s^m + ... + pm, with m < n. [Nms/rad] with s in [rad/s]
    q : tuple of n floats
        Denominator without its leading one: s^n + q1 s^(n-1) + ... + qn. [rad/s] to its power

    Raises
    ------
    InputError
        If the function is improper, unstable, or not passive: Re H(iw) < 0 somewhere. A radiation model that gives
        energy at low frequency makes phi1 grow without a word.
    """

    p: tuple[float, ...]
    q: tuple[float, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "p", tuple(float(value) for value in self.p))
        object.__setattr__(self, "q", tuple(float(value) for value in self.q))
        if not 1 <= len(self.p) <= len(self.q) or not all(map(math.isfinite, self.p + self.q)):
            mend = "Give finite coefficients, len(p) <= len(q)"
            raise InputError("radiation.p", self.p, "numerator order must be below the denominator's", mend)
        if np.max(np.roots([1.0, *self.q]).real) >= 0.0:
            problem = "the denominator has a root that is not in the left half plane"
            raise InputError("radiation.q", self.q, problem, "Refit with stable poles")
        if not self.is_passive():
            mend = "Refit with the passivity constraint, see hydrodynamics.fit_radiation"
            raise InputError("radiation.p", self.p, "the function is not passive: Re H(iw) < 0 at some frequency", mend)

    def response(self, omega: ArrayLike) -> NDArray[np.complex128]:
        """H(i omega) [Nms/rad] at angular frequencies `omega` [rad/s], of the same shape."""
        s = 1j * np.asarray(omega, float)
        return np.asarray(np.polyval(self.p, s) / np.polyval([1.0, *self.q], s))

    def is_passive(self) -> bool:
        """Whether Re H(iw) >= 0 on the whole axis: by the roots of Re P(iw)Q(-iw), a polynomial in x = w^2."""
        full = np.array([1.0, *self.q])
        product = np.polymul(self.p, full * (-1.0) ** np.arange(len(self.q), -1, -1))
        # a passive fit often ends on the boundary, where a coefficient is nothing but the rounding of its terms
        product[np.abs(product) <= 1e-14 * len(full) * np.polymul(np.abs(self.p), np.abs(full))] = 0.0
        powers = np.arange(len(product))[::-1]
        even = powers % 2 == 0
        x = np.trim_zeros(product[even] * np.real(1j ** powers[even]), "f")  # coefficients in x, highest first
        if len(x) == 0:
            return True
        scale = np.max(np.abs(x))
        if x[0] < 0.0 or x[-1] < -1e-12 * scale:
            return False
        # the sign can change only at a positive root of odd multiplicity: look between neighbouring roots
        roots = np.roots(x)
        positive = np.sort(roots.real[(np.abs(roots.imag) < 1e-9 * (1 + np.abs(roots))) & (roots.real > 0)])
        between = np.concatenate([[0.0], positive, [2.0 * positive[-1] + 1.0 if positive.size else 1.0]])
        middles = 0.5 * (between[1:] + between[:-1])
        return bool(np.all(np.polyval(x, middles) >= -1e-9 * scale))
