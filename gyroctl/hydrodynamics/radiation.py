"""Rational passive approximation of the radiation function, poles free.

    H(iw) ~ K(w) = B(w) + i w (A(w) - A_inf),    H(s) = (p0 s^m + .. + pm) / (s^n + q1 s^(n-1) + .. + qn)

The search (`passive_descent`) moves among passive functions only; `passivity.certify` then judges its result alone.
Bands are those of the shipped float; for another one they turn with its own unit of frequency (`scale`), so that a fit
knows no size.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.database import shipped
from gyroctl.hydrodynamics.interpolation import spline
from gyroctl.hydrodynamics.passive_descent import coefficients, descend, evaluate
from gyroctl.hydrodynamics.passivity import Passivity, certify
from gyroctl.hydrodynamics.scale import frequency_ratio, natural
from gyroctl.hydrodynamics.table import Coefficients, Complexes, Fits, Floats, Hydrodynamics

#: Frequency of the free phi1 mode of the shipped float, where the damping decides whether lock holds. [rad/s]
LOW_FREQUENCY = 1.2
#: Frequencies below this carry `low_weight` in the fit; half a step off the grid, so that rounding moves none across.
#: [rad/s], shipped float
LOW_BAND = 1.95
#: Upper end of the fitted band: nothing of waves or motion is left beyond. [rad/s], shipped float
HIGH_BAND = 13.0
#: Radiation below this share of added inertia times frequency is none.
NO_WAVES = 1e-9
#: The fits kept in a database: order and low-frequency weight.
SHIPPED_FITS: dict[str, tuple[tuple[int, int], float]] = {"accurate": ((2, 3), 10.0), "fine": ((3, 4), 10.0)}
#: The unweighted (2,3) coefficients of the preset "paper": fixed, so that the preset does not move with the table.
PAPER_FIT: tuple[Coefficients, Coefficients] = (
    (np.array([1396.494, 4584.783, 724.177]), np.array([14.6833, 98.1761, 380.4675])),
    (np.array([636.360, 6278.714, 1293.411]), np.array([11.6028, 83.0018, 134.1893])),
)
_FREQUENCY_SCALE = 5.0  # [rad/s], shipped float, keeps the coefficients of the fit near one
_STEP = 0.1  # [rad/s], shipped float, even grid of the fit, so that the tabulated frequencies do not weight it
#: The optimum often has a zero of g at w = 0 or at infinity, where rounding decides the sign of Re H. Then g(s) g(-s)
#: is lifted there, relative to its largest coefficient, by the least of these that earns the certificate.
_LIFTS = (0.0, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4)


@dataclass(frozen=True)
class RadiationFit:
    """One direction of the radiation function as P(s)/Q(s).

    Parameters
    ----------
    p : ndarray (m + 1,)
        Numerator, highest power first. [Nms/rad] with s in [rad/s]
    q : ndarray (n,)
        Denominator without its leading 1. [rad/s] to its power
    relative_rms : float
        Root of sum |H - K|^2 / sum |K|^2 over the band, unweighted. [-]
    damping_low : float
        Re H at the frequency of the slow mode. [Nms/rad]
    damping_low_table : float
        The tabulated damping there; where the table begins above, that of its lowest frequency. [Nms/rad]
    passivity : Passivity
        Certificate of stability and passivity.
    low_frequency : float
        Frequency of the slow mode: 1.2 rad/s of the shipped float, in units of sqrt(g / L) elsewhere. [rad/s]
    """

    p: Floats
    q: Floats
    relative_rms: float
    damping_low: float
    damping_low_table: float
    passivity: Passivity
    low_frequency: float = LOW_FREQUENCY

    def __call__(self, omega: Floats) -> Complexes:
        """H(iw). (n,)."""
        return evaluate(self.p, self.q, omega)


def slow_mode(hydro: Hydrodynamics) -> float:
    """Return the frequency of the slow phi1 mode, as the float's own unit has it. [rad/s]"""
    return LOW_FREQUENCY * frequency_ratio(hydro)


def radiation_function(hydro: Hydrodynamics, direction: int) -> tuple[Floats, Complexes]:
    """Return an even frequency grid [rad/s] and K(w) [Nms/rad] on it, for direction 0 (phi1) or 1 (phi3)."""
    ratio = frequency_ratio(hydro)
    low, high = hydro.omega[0], max(min(hydro.omega[-1], HIGH_BAND * ratio), hydro.omega[1])
    steps = (high - low) / (_STEP * ratio)
    omega = np.linspace(low, high, max(64, math.floor(steps + 0.501) + 1))
    damping = spline(hydro.omega, hydro.damping[direction], omega)
    added = spline(hydro.omega, hydro.added_mass[direction], omega)
    return omega, damping + 1j * omega * (added - hydro.added_mass_inf[direction])


def makes_none(hydro: Hydrodynamics, direction: int) -> bool:
    """Whether a rotation makes no waves, as yaw of a body of revolution: there is nothing to fit then."""
    size = float(np.max(np.abs(radiation_function(hydro, direction)[1])))
    return size <= NO_WAVES * natural(hydro) * float(np.sum(hydro.added_mass_inf))


def assess(hydro: Hydrodynamics, direction: int, p: Floats, q: Floats) -> RadiationFit:
    """Attach error, low-frequency damping and certificate to given coefficients."""
    omega, target = radiation_function(hydro, direction)
    error, size = evaluate(p, q, omega) - target, float(np.linalg.norm(target))
    slow, found = slow_mode(hydro), certify(p, q)
    at, tabulated = np.array([slow]), np.array([max(slow, float(hydro.omega[0]))])
    return RadiationFit(
        p=p,
        q=q,
        relative_rms=float(np.linalg.norm(error) / size) if size > 0.0 else 0.0,
        damping_low=float(evaluate(p, q, at)[0].real),
        damping_low_table=float(spline(hydro.omega, hydro.damping[direction], tabulated)[0]),
        passivity=found._replace(passive=found.stable) if not np.any(p) and makes_none(hydro, direction) else found,
        low_frequency=slow,
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
        Weight of the squared error at low frequencies, below 2 rad/s for the shipped float; 1 weighs all frequencies
        alike. At 1.2 rad/s lies its lightly damped phi1 mode: there a small absolute error of the damping decides over
        the stability of the locked orbit. [-]

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
    ratio = frequency_ratio(hydro)
    weight = np.where(omega < LOW_BAND * ratio, np.sqrt(low_weight), 1.0)
    size = float(np.max(np.abs(target)))
    unit = _FREQUENCY_SCALE * ratio
    if makes_none(hydro, direction):
        return assess(hydro, direction, np.zeros(n), np.asarray(np.poly(np.full(n, -unit))[1:], dtype=np.float64))
    best = descend(omega / unit, target / size, weight, n)
    scale = unit ** np.arange(1, n + 1)
    for lift in _LIFTS:
        p, q = coefficients(best, lift)
        p, q = p * scale * size, q * scale
        if certify(p, q).passive:
            break
    return assess(hydro, direction, p, q)


def fit_all(hydro: Hydrodynamics) -> Fits:
    """Return the coefficients of all `SHIPPED_FITS` for a table, to be kept with it."""

    def fitted(direction: int, order: tuple[int, int], weight: float) -> Coefficients:
        fit = fit_radiation(hydro, direction, order, weight)
        return fit.p, fit.q

    return {name: (fitted(0, *choice), fitted(1, *choice)) for name, choice in SHIPPED_FITS.items()}


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
