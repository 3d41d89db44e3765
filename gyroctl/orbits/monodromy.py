"""The monodromy matrix in three independent ways, to be held against each other.

- complex step: the derivative of the very Runge-Kutta map that simulates;
- variational: the equations and Phi' = A(t) Phi integrated by SciPy's DOP853 with the plant's own Jacobian;
- casadi: the derivative of a symbolic Runge-Kutta step, built from the casadi form of the equations.

They share the text of the equations, and neither integrator nor differentiation.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.orbits.flow import flow_jacobian
from gyroctl.orbits.orbit import Orbit
from gyroctl.orbits.symmetry import free_rows

Method = Literal["complex step", "variational", "casadi"]
METHODS: tuple[Method, ...] = ("complex step", "variational", "casadi")


def monodromy(orbit: Orbit, method: Method = "complex step", steps: int = 800) -> NDArray[np.float64]:
    """Derivative (m, m) of the flow over one period, in the unknowns of the orbit.

    Parameters
    ----------
    orbit : Orbit
        Where.
    method : {"complex step", "variational", "casadi"}
        See above.
    steps : int
        Runge-Kutta steps per period of the casadi way.

    Raises
    ------
    InputError
        For another method, an orbit that is none, or a rigid connection in a way that does not know it.
    """
    if method not in METHODS:
        raise InputError("method", method, "is not known", f"Choose one of {', '.join(METHODS)}")
    if orbit.status == "no orbit":
        raise InputError("orbit", orbit.status, "has no monodromy matrix", orbit.advice)
    if method == "complex step":
        _, full = flow_jacobian(orbit.plant, orbit.x, orbit.cc, orbit.cg, orbit.forcing, 1.0, orbit.dt)
    elif orbit.plant.parameters.connection == "rigid":
        raise InputError("method", method, "holds for the magnetic connection only", 'Choose "complex step"')
    else:
        full = _variational(orbit) if method == "variational" else _casadi(orbit, steps)
    free = free_rows(orbit.plant)
    return np.asarray(full[np.ix_(free, free)])


def _moments(orbit: Orbit) -> Callable[[float], NDArray[np.float64]]:
    forcing = orbit.forcing
    return lambda t: np.real(np.exp(1j * forcing.wp * t) * forcing.amplitude)


def _variational(orbit: Orbit) -> NDArray[np.float64]:
    from scipy.integrate import solve_ivp

    n, plant, u, moments = orbit.x.size, orbit.plant, (orbit.cc, orbit.cg), _moments(orbit)

    def rate(t: float, y: NDArray[np.float64]) -> NDArray[np.float64]:
        A, _ = plant.jacobians(y[:n], u, moments(t))
        return np.concatenate([plant.derivative(y[:n], u, moments(t)), (A @ y[n:].reshape(n, n)).ravel()])

    start = np.concatenate([orbit.x, np.eye(n).ravel()])
    end = solve_ivp(rate, (0.0, orbit.period), start, method="DOP853", rtol=1e-10, atol=1e-12).y[:, -1]
    return np.asarray(end[n:].reshape(n, n))


def _casadi(orbit: Orbit, steps: int) -> NDArray[np.float64]:
    import casadi

    n, h, moments = orbit.x.size, orbit.period / steps, _moments(orbit)
    f = orbit.plant.casadi()
    x, m = casadi.SX.sym("x", n), [casadi.SX.sym(f"m{i}", f.numel_in(2)) for i in range(3)]
    u = casadi.DM([orbit.cc, orbit.cg])
    k1 = f(x, u, m[0])
    k2 = f(x + 0.5 * h * k1, u, m[1])
    k3 = f(x + 0.5 * h * k2, u, m[1])
    k4 = f(x + h * k3, u, m[2])
    end = x + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    step = casadi.Function("step", [x, *m], [end, casadi.jacobian(end, x)])
    state, total = orbit.x, np.eye(n)
    for i in range(steps):
        at = [orbit.plant.near(state, moments((i + part) * h)) for part in (0.0, 0.5, 1.0)]
        new, jacobian = step(state, *at)
        state, total = np.asarray(new).ravel(), np.asarray(jacobian) @ total
    return total
