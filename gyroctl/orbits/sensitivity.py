"""Exact derivative of the flow with respect to any parameter of device, wave or controls, by complex step.

All constants and the wave go through the compiled kernel as complex numbers. The frequency of the wave is a change of
the unit of time: with tau = alpha t every rate is divided by alpha, stiffness and moments by alpha squared, damping and
controls by alpha, what acts beyond the linear model by its own powers (`choices`), and the terms that are quadratic in
rates keep their form. So the number of steps and the phase of
the wave at each of them stay as they are, and the derivative is that of the computed map to rounding.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.orbits.choices import TERMS, beyond_in_other_time, raised, signals_in_other_time, unit_term
from gyroctl.orbits.flow import STEP, Forcing, Stretch, Vector, run
from gyroctl.plant import Plant
from gyroctl.plant.equations import OMEGA_RATE, PHI1_RATE, PSI_RATE, RADIATION, Coefficients

DEVICE = ("d1", "k1", "N", *TERMS)
CONTROLS = ("cc", "cg")
WAVE = ("height", "wp", "phase")
PARAMETERS = CONTROLS + WAVE + DEVICE
"""Parameters in which an orbit can be continued."""


class Setting(NamedTuple):
    """Everything that the kernel needs, at one value of the parameters."""

    coefficients: Coefficients
    cc: float
    cg: float
    forcing: Forcing


def with_gear(k: Coefficients, change: Any, J13: float, rigid: bool) -> Coefficients:
    """Constants after a change of the gear ratio N; complex for derivatives."""
    N: Any = k.N + change
    if k.beyond is not None and k.beyond.losses is not None:  # the lever arm of the rolling resistance is over r2
        losses = k.beyond.losses._replace(rolling=k.beyond.losses.rolling * (k.N / N))
        k = k._replace(beyond=k.beyond._replace(losses=losses))
    along = 1.0 / k.Gpp - (k.N**2 * k.J4 if rigid else 0.0)  # J2 at the present N
    J2 = along + (N**2 - k.N**2) * J13
    column = 2.0 * N * k.J3
    if not rigid:
        gains: dict[str, Any] = dict(Gpp=1.0 / J2, Gpo=0.0, Goo=1.0 / k.J4, ap=column / J2, ao=1.0)
        return k._replace(N=N, kappa=k.K - column**2 / J2 - k.J4, **gains)
    total = J2 + N**2 * k.J4
    pull = column + N * k.J4
    geared: Any = dict(Gpp=1.0 / total, Gpo=N / total, Goo=N**2 / total, ap=pull / total, ao=N * pull / total)
    return k._replace(N=N, kappa=k.K - pull**2 / total, **geared)


def in_other_time(k: Coefficients, alpha: Any) -> Coefficients:
    """Constants with the unit of time changed, tau = alpha t."""
    (p1, q1), (p3, q3) = _slower(k.p1, k.q1, alpha), _slower(k.p3, k.q3, alpha)
    springs: Any = dict(k1=k.k1 / alpha**2, k3=k.k3 / alpha**2, d1=k.d1 / alpha, d3=k.d3 / alpha)
    return k._replace(p1=p1, q1=q1, p3=p3, q3=q3, beyond=beyond_in_other_time(k.beyond, alpha), **springs)


def _slower(p: tuple[float, ...], q: tuple[float, ...], alpha: Any) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    numerator = tuple(c * alpha ** (len(p) - 1 - j - len(q) - 1) for j, c in enumerate(p))
    return numerator, tuple(c / alpha ** (j + 1) for j, c in enumerate(q))


def time_scales(k: Coefficients, alpha: Any) -> NDArray[np.complex128]:
    """Factor of each state (n,) in the time tau = alpha t."""
    n1, n3 = len(k.q1), len(k.q3)
    out = np.ones(RADIATION + n1 + n3, complex)
    out[PHI1_RATE:RADIATION] = 1.0 / alpha
    out[RADIATION : RADIATION + n1] = [alpha ** (n1 - 1 - i) for i in range(n1)]
    out[RADIATION + n1 :] = [alpha ** (n3 - 1 - i) for i in range(n3)]
    return out


def state_units(plant: Plant) -> Vector:
    """Unit of each state (n,) over that at the size of Table 1, by Froude's law: angles 1, rates that of 1/s. [-]"""
    return np.asarray(time_scales(plant.coefficients, plant.parameters.time_scale).real)


def parameter_column(plant: Plant, setting: Setting, name: str, x: Vector, stretch: Stretch, change: Vector) -> Vector:
    """Derivative of the end state (n,) with respect to the parameter `name`.

    Parameters
    ----------
    plant : Plant
        For what the constants do not tell: inertia of the spin axis and kind of connection.
    setting : Setting
        Constants, controls and wave.
    name : str
        One of `PARAMETERS`.
    x : (n,) array
        Start.
    stretch : Stretch
        The time, with the moments on the grid.
    change : (samples * channels,) array
        Derivative of the signals with respect to the parameter at the same phase. [Nm, m/s]
    """
    eps = 1j * STEP
    k, forcing = setting.coefficients, setting.forcing
    cc, cg, moments = complex(setting.cc), complex(setting.cg), stretch.waves + eps * change
    scales = np.ones(x.size, complex)
    rigid = plant.parameters.connection == "rigid"
    if name == "cc":
        cc += eps
    elif name == "cg":
        cg += eps
    elif name in ("d1", "k1"):
        change_of: Any = {name: getattr(k, name) + eps}
        k = k._replace(**change_of)
    elif name in TERMS:
        k = raised(k, unit_term(plant, name), name, eps)
    elif name == "N":
        k = with_gear(k, eps, plant.parameters.J13, rigid)
    elif name == "wp":
        alpha = 1.0 + eps / forcing.wp
        k, scales = in_other_time(k, alpha), time_scales(k, alpha)
        cc, cg = cc / alpha, cg / alpha
        slower = signals_in_other_time(plant.channels, alpha)
        moments = (moments.reshape(-1, slower.size) * slower).ravel()
    start = x * scales
    if name == "N" and rigid:
        start[OMEGA_RATE] += eps * x[PSI_RATE]  # the flywheel stays geared to the ring
    end = run(complex_coefficients(k), start, cc, cg, stretch._replace(waves=moments))
    return np.asarray((end[: x.size] / scales).imag / STEP)


def complex_coefficients(k: Coefficients) -> Coefficients:
    """Return the same constants as complex numbers: one compiled kernel then serves every parameter."""
    return _complex(k)  # type: ignore[no-any-return]


def _complex(value: Any) -> Any:
    """Numbers as complex ones, in tuples of any depth; what is off stays off."""
    if isinstance(value, tuple):
        parts = map(_complex, value)
        return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)
    return value if value is None else complex(value)
