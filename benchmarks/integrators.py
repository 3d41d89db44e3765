"""The device in the same irregular waves by its own kernels and by other integrators: time and error of each.

Run ``python benchmarks/integrators.py`` (three minutes); it prints a table and writes it beside itself as
``integrators.json``. All get the same right-hand side, the one text of the equations, and the same moments,
interpolated by the same eight-point formula; adaptive ones get the loosest tolerance at which they are as accurate as
fixed steps of 10 ms. What is timed is a simulated second on one core once everything is compiled; what it takes to
compile stands beside it. Diffrax takes part where it is installed.
"""

from __future__ import annotations

import importlib.util
import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numba
import numpy as np
from clock import here, least
from scipy.integrate import solve_ivp

import gyroctl as gy
from gyroctl.harness.run import lead_in
from gyroctl.harness.start import locked_start
from gyroctl.plant import equations
from gyroctl.plant.instants import interpolate
from gyroctl.plant.kernel import LANES, hold_into, rows
from gyroctl.plant.lagrange import LAGRANGE, TAPS
from gyroctl.simulation.ensemble import run_ensemble

CC, CG = 0.052, 3.5e-4
LENGTH = 200.0
"""Of a run whose end is compared: in lock errors grow slowly. [s]"""

STEP = 0.01
"""Of the methods with a fixed step. [s]"""

TOLERANCES = 10.0 ** -np.arange(4.0, 12.0)
"""Tried from the loosest on."""

PLANT, SEA = gy.zhang2017(), gy.SeaState()
WAVES = lead_in(gy.realise(PLANT, SEA, 1, 2000.0), gy.Settings())
START = locked_start(PLANT, SEA)[0]
K, STATES = PLANT.coefficients, len(PLANT.labels)

End = Callable[[float, float], np.ndarray]
"""Length [s] and tolerance to the state at the end, (n,) or (n, runs)."""


class Peer(NamedTuple):
    """An integrator."""

    name: str
    end: End
    adaptive: bool
    runs: int = 1  # side by side


# --- its own kernels ---------------------------------------------------------------------------------------------


def single() -> Peer:
    """Runge-Kutta 4 of the package, one run."""
    flat, u = np.ascontiguousarray(WAVES.moments.T).ravel(), np.array([[CC], [CG]])

    def end(length: float, _: float) -> np.ndarray:
        y = np.zeros(rows(K))
        y[:STATES] = START
        work, moments, weight = np.empty((5, y.size)), np.empty(6), np.empty(TAPS)
        hold_into(y, work, moments, weight, K, u, 0.0, length, round(length / STEP), flat, WAVES.dt)
        return y[:STATES]

    return Peer("gyroctl, one run", end, adaptive=False)


def together(runs: int = 16 * LANES) -> Peer:
    """The ensemble of the package, statistics included; it returns no end, so its error is that of the single run."""

    def end(length: float, _: float) -> np.ndarray:
        blend = min(100.0, 0.5 * length)
        run_ensemble(PLANT, SEA, [(CC, CG)], range(1, runs + 1), START, length, blend, STEP, workers=1, quiet=True)
        return np.full(STATES, np.nan)

    return Peer(f"gyroctl, {runs} runs, waves and statistics included", end, adaptive=False, runs=runs)


# --- SciPy -------------------------------------------------------------------------------------------------------


def with_scipy(method: str, compiled: bool) -> Peer:
    """SciPy, with the public `Plant.derivative` or with the compiled text."""
    rhs = compiled_rhs() if compiled else numpy_rhs()

    def end(length: float, tolerance: float) -> np.ndarray:
        found = solve_ivp(rhs, (0.0, length), START, method, rtol=tolerance, atol=tolerance, max_step=0.5)
        return np.asarray(found.y[:, -1])

    return Peer(f"SciPy {method}, right-hand side {'compiled' if compiled else 'in NumPy'}", end, adaptive=True)


def numpy_rhs() -> Callable[[float, np.ndarray], np.ndarray]:
    """Right-hand side in NumPy."""
    scale, nodes = np.array(LAGRANGE), np.arange(TAPS)

    def rhs(t: float, x: np.ndarray) -> np.ndarray:
        first = min(max(int(t / WAVES.dt) - 3, 0), WAVES.moments.shape[1] - TAPS)
        offset = t / WAVES.dt - first - nodes
        offset[offset == 0.0] = 1e-300
        weights = scale * np.prod(offset) / offset
        return PLANT.derivative(x, (CC, CG), WAVES.moments[:, first : first + TAPS] @ weights)

    return rhs


def compiled_rhs() -> Callable[[float, np.ndarray], np.ndarray]:
    """The same, compiled."""
    flat, spacing, size, n = np.ascontiguousarray(WAVES.moments.T).ravel(), WAVES.dt, rows(K), STATES

    @numba.njit(error_model="numpy")
    def evaluate(t: float, x: np.ndarray, flat: np.ndarray, k: Any) -> np.ndarray:
        moments, weight, dx = np.empty(6), np.empty(TAPS), np.empty(size)
        interpolate(flat, 1, t / spacing, weight, moments, 0)
        equations.derivative(x, dx, 1, 0, k, CC, CG, moments[0], moments[1])
        return dx[:n]

    return lambda t, x: evaluate(t, x, flat, K)


# --- casadi ------------------------------------------------------------------------------------------------------


def casadi_rhs() -> tuple[Any, Any, Any]:
    """Time, state and right-hand side as casadi expressions."""
    import casadi

    t, x = casadi.MX.sym("t"), casadi.MX.sym("x", STATES)
    table = casadi.MX(casadi.DM(WAVES.moments[:, : round((LENGTH + 1.0) / WAVES.dt)]))
    position = t / WAVES.dt
    first = casadi.fmin(casadi.fmax(casadi.floor(position) - 3, 0), table.shape[1] - TAPS)
    offset = [position - first - j for j in range(TAPS)]
    moments = 0.0
    for j, scale in enumerate(LAGRANGE):
        weight = float(scale)
        for i, o in enumerate(offset):
            if i != j:
                weight = weight * o
        moments = moments + weight * table[:, first + j]
    return t, x, PLANT.casadi()(x, casadi.DM([CC, CG]), moments)


def with_cvodes() -> Peer:
    """Sundials' multistep method for non-stiff equations, out of casadi."""
    import casadi

    t, x, slope = casadi_rhs()
    made_for: dict[tuple[float, float], Any] = {}

    def end(length: float, tolerance: float) -> np.ndarray:
        if (length, tolerance) not in made_for:
            options = {"abstol": tolerance, "reltol": tolerance, "linear_multistep_method": "adams"}
            options |= {"nonlinear_solver_iteration": "functional", "max_num_steps": 10_000_000}
            problem = {"t": t, "x": x, "ode": slope}
            made_for[length, tolerance] = casadi.integrator("end", "cvodes", problem, 0.0, length, options)
        return np.asarray(made_for[length, tolerance](x0=START)["xf"]).ravel()

    return Peer("casadi CVODES (Adams)", end, adaptive=True)


def with_casadi_rk() -> Peer:
    """casadi's own Runge-Kutta 4: a step mapped along time, compiled by the system's compiler where there is one."""
    import casadi

    t, x, slope = casadi_rhs()
    f = casadi.Function("f", [t, x], [slope])
    k1 = f(t, x)
    k2 = f(t + 0.5 * STEP, x + 0.5 * STEP * k1)
    k3 = f(t + 0.5 * STEP, x + 0.5 * STEP * k2)
    k4 = f(t + STEP, x + STEP * k3)
    step = casadi.Function("step", [x, t], [x + STEP / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)])
    steps = round(1.0 / STEP)
    options = {}
    try:
        casadi.Importer.load_plugin("shell")
        options = {
            "jit": True,
            "compiler": "shell",
            "jit_options": {"flags": ["-O3", "-march=native"], "verbose": False},
        }
        second = step.mapaccum("second", steps, options)
    except Exception:  # no compiler: its virtual machine
        second = step.mapaccum("second", steps)
    within = np.arange(steps) * STEP

    def end(length: float, _: float) -> np.ndarray:
        state = casadi.DM(START)
        for begin in range(round(length)):
            state = second(state, within + begin)[:, -1]
        return np.asarray(state).ravel()

    how = "compiled to C" if options else "in its virtual machine"
    return Peer(f"casadi Runge-Kutta 4, {how}", end, adaptive=False)


# --- diffrax -----------------------------------------------------------------------------------------------------


def with_diffrax(runs: int) -> Peer:
    """Diffrax' Dopri8 on JAX, compiled, for one run or many side by side."""
    import diffrax
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)  # type: ignore[no-untyped-call]
    several = [
        lead_in(gy.realise(PLANT, SEA, seed, LENGTH + 20.0), gy.Settings()).moments for seed in range(1, runs + 1)
    ]
    tables = jnp.asarray(np.stack(several))
    nodes, scale = jnp.arange(TAPS), jnp.asarray(LAGRANGE)
    matrix = np.array([[i != j for i in range(TAPS)] for j in range(TAPS)])

    def slope(t: Any, x: Any, table: Any) -> Any:
        position = t / WAVES.dt
        first = jnp.clip(jnp.floor(position).astype(int) - 3, 0, table.shape[1] - TAPS)
        offset = position - first - nodes
        weights = scale * jnp.prod(jnp.where(matrix, offset[None, :], 1.0), axis=1)
        moments = jax.lax.dynamic_slice(table, (0, first), (2, TAPS)) @ weights
        dx: list[Any] = [0.0] * rows(K)
        plain, equations.cos_sin = equations.cos_sin, lambda angle: (jnp.cos(angle), jnp.sin(angle))
        try:
            equations.derivative(x, dx, 1, 0, K, CC, CG, moments[0], moments[1])
        finally:
            equations.cos_sin = plain
        return jnp.stack(dx[:STATES])

    @jax.jit
    def solve(length: Any, tolerance: Any) -> Any:
        control = diffrax.PIDController(rtol=tolerance, atol=tolerance)

        def one(table: Any) -> Any:
            return diffrax.diffeqsolve(
                diffrax.ODETerm(slope),
                diffrax.Dopri8(),
                0.0,
                length,
                0.01,
                jnp.asarray(START),
                args=table,
                stepsize_controller=control,
                max_steps=None,
                saveat=diffrax.SaveAt(t1=True),
            ).ys[0]

        return jax.vmap(one)(tables)

    def end(length: float, tolerance: float) -> np.ndarray:
        return np.asarray(solve(length, tolerance)).T

    return Peer(f"diffrax Dopri8, {'one run' if runs == 1 else f'{runs} runs'}", end, adaptive=True, runs=runs)


# --- measuring ---------------------------------------------------------------------------------------------------


def peers() -> list[Callable[[], Peer]]:
    """All that take part."""
    found: list[Callable[[], Peer]] = [single, together]
    for method in ("DOP853", "LSODA"):
        found += [lambda method=method, compiled=compiled: with_scipy(method, compiled) for compiled in (True, False)]
    found += [with_cvodes, with_casadi_rk]
    if importlib.util.find_spec("diffrax"):
        found += [lambda: with_diffrax(1), lambda: with_diffrax(LANES)]
    return found


def measured(make: Callable[[], Peer], reference: np.ndarray, goal: float) -> dict[str, Any]:
    """Time and error; an adaptive one has the loosest tolerance at which its error is at most `goal`."""
    size = np.maximum(np.abs(reference), 1e-2)
    begin = time.perf_counter()  # compilers run in processes of their own
    peer = make()
    peer.end(1.0, 1e-6)
    compiling = time.perf_counter() - begin

    def error(tolerance: float) -> float:
        end = peer.end(LENGTH, tolerance)
        first = end[:, 0] if end.ndim == 2 else end
        return float(np.max(np.abs(first - reference) / size))

    tolerance, reached = 0.0, error(1e-6)
    if peer.adaptive:
        for tolerance in map(float, TOLERANCES):
            reached = error(tolerance)
            if reached <= goal:
                break
    spent = least([lambda: peer.end(LENGTH, tolerance)], 3)[0]
    return {
        "name": peer.name,
        "us_per_simulated_second": spent / LENGTH / peer.runs * 1e6,
        "compile_s": compiling,
        "tolerance": tolerance or None,
        "error": None if np.isnan(reached) else reached,
    }


def table() -> dict[str, Any]:
    """Measure all peers."""
    reference = with_scipy("DOP853", compiled=True).end(LENGTH, 1e-13)
    own = measured(single, reference, np.inf)
    found = [own, *(measured(make, reference, 1.2 * own["error"]) for make in peers()[1:])]
    for row in found:
        row["times_of_one_run"] = row["us_per_simulated_second"] / own["us_per_simulated_second"]
    return {**here(), "length_s": LENGTH, "peers": found}


def main() -> None:
    """Measure and print."""
    content = table()
    print(f"{'':58} {'us per s':>10} {'times':>9} {'error':>9} {'compile s':>9}")
    for row in content["peers"]:
        error = "" if row["error"] is None else f"{row['error']:.1e}"
        numbers = f"{row['us_per_simulated_second']:10.2f} {row['times_of_one_run']:9.2f} {error:>9}"
        print(f"{row['name']:58} {numbers} {row['compile_s']:9.1f}")
    Path(__file__).with_suffix(".json").write_text(json.dumps(content, indent=1) + "\n")


if __name__ == "__main__":
    main()
