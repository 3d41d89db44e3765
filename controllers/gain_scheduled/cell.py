"""One cell of the schedule: its wave, its locked orbit, and the exact linear model of plant and law's filters about it.

A cell is asked for by envelope, frequency and bandwidth. The wave height is found at which the orbit that carries the
wanted share of the lock capacity has that envelope. The filters of the law are part of the linear model, so that a
gain is designed for what it will be fed with. Irregular waves enter as a random modulation of the regular moments,
amplitude and phase, that is as slow as the bandwidth says.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.controllers.gain_scheduled.scheduled import POINT, ROW, SIGNALS, Scheduled, ScheduledState, losses
from gyroctl.controllers.gain_scheduled.table import lost_by
from gyroctl.errors import InputError
from gyroctl.linearisation.held_flow import HeldFlow
from gyroctl.loop_margins.closed_loop_orbit import LoopOrbit, close_loop
from gyroctl.loop_margins.dual_numbers import step_jacobian
from gyroctl.orbits import Orbit, continue_orbit, search_orbit
from gyroctl.orbits.wave import Wave
from gyroctl.plant import Plant
from gyroctl.plant.equations import OMEGA_RATE, PSI, PSI_RATE
from gyroctl.plant.measurement import read

Matrices = NDArray[np.float64]

OFFSET, SLOPE = 0.05, 1.7
"""First guess of the height: envelope = SLOPE (height - OFFSET), since the ring moves the float too. [m, rad/s/m]"""

SOLVER_STEPS = 40


@dataclass(frozen=True)
class Node:
    """Where a cell lies in the schedule."""

    envelope: float  # V [rad/s]
    frequency: float  # peak frequency [rad/s]
    bandwidth: float  # variance of the envelope over its squared mean [-]

    def __str__(self) -> str:
        """Name of the cell in messages."""
        return f"V = {self.envelope:g} rad/s, w = {self.frequency:g} rad/s, bandwidth {self.bandwidth:g}"


@dataclass(frozen=True)
class Filters:
    """Time constants of the law that the design must know, see `Scheduled`. [s]"""

    slow: float = 5.0
    brisk: float = 1.2
    fast: float = 0.2
    memory: float = 60.0
    notch: float = 5.0


@dataclass(frozen=True)
class Cell:
    """Orbit and linear model x_{k+1} = A_k x_k + B_k u_k + G_k w_k of plant, filters and wave modulation."""

    node: Node  # where it lies
    height: float  # of the wave [m]
    orbit: Orbit  # with the controls of the operating point
    fold: float  # largest cg with an orbit at this wave and cc [Nms]
    point: NDArray[np.float64]  # (7,) operating point, in the order of `POINT`
    A: Matrices = field(repr=False)  # (N, n, n); the last two states are the modulation
    B: Matrices = field(repr=False)  # (N, n, 2)
    G: Matrices = field(repr=False)  # (N, n, 2)
    C: Matrices = field(repr=False)  # (N, 10, n) signals of the law, in the order of `SIGNALS`
    rows: dict[str, int] = field(repr=False)  # of the plant's states by name
    loop: LoopOrbit = field(repr=False)  # plant and filters without feedback

    @property
    def share(self) -> float:
        """Generator gain as a part of that at the fold."""
        return self.orbit.cg / self.fold


def operating_orbit(plant: Plant, node: Node, cc: float, share: float) -> Orbit:
    """Orbit of the wave height with the node's envelope; cg and losses take a share of the lock capacity J4 V/N.

    Raises
    ------
    InputError
        Where there is none: the message names the cell.
    """
    capacity = plant.parameters.J4 * node.envelope / plant.parameters.N
    lost = lost_by(plant)
    cg = share * capacity - losses(lost["bearing"], lost["windage"], plant.parameters.N * node.frequency)
    if not cg > 0.0:
        problem = f"a share of {share:.3g} of the lock capacity is less than the losses take"
        raise InputError("cell", str(node), problem, "Leave out the lowest envelope, or raise the share")
    height, slope, guess, before = OFFSET + node.envelope / SLOPE, SLOPE, None, (np.nan, np.nan)
    for _ in range(SOLVER_STEPS):
        orbit = search_orbit(plant, Wave(height, node.frequency), cc, cg, guess=guess)
        if orbit.status == "no orbit" or abs(orbit.load_angle) > 0.5 * np.pi:  # behind pull-out: from above again
            height, guess = height + 0.02, None
            continue
        envelope = node.envelope * (cg / capacity) / orbit.lock_share
        if abs(envelope / node.envelope - 1.0) < 1e-8:
            return orbit
        if np.isfinite(before[0]) and abs(height - before[0]) > 1e-12:
            slope = float(np.clip((envelope - before[1]) / (height - before[0]), 0.2 * SLOPE, 3.0 * SLOPE))
        before = (height, envelope)
        height = max(height + (node.envelope - envelope) / slope, 0.6 * height)
        guess = orbit.x
    problem = f"has no locked orbit at a share of {share:.3g} of the lock capacity"
    raise InputError("cell", str(node), problem, "Lower the share of this cell")


def build_cell(
    plant: Plant, node: Node, cc: float, share: float, filters: Filters, decorrelation: float, scatter: float = 0.5
) -> Cell:
    """Find orbit and linear model of a cell.

    The operating point has the coupling `cc` [Nms] and takes a `share` of the lock capacity J4 V/N [-]; the waves
    forget amplitude and phase at the rate `decorrelation` [1/s], and deviate by `scatter` from the regular wave [-].

    Raises
    ------
    InputError
        Where the cell has no orbit, or none that is stable without feedback.
    """
    orbit = operating_orbit(plant, node, cc, share)
    if orbit.status != "stable":
        raise InputError("cell", str(node), "its orbit is unstable without feedback", "Raise cc of the operating point")
    capacity = plant.parameters.J4 * node.envelope / plant.parameters.N
    folds = continue_orbit(orbit, "cg", (0.0, 4.0 * capacity)).folds
    fold = max(point.value for point in folds) if folds else float("nan")
    law = frozen([orbit.cc, share, *[0.0] * (ROW - 2)], filters, node.frequency, **lost_by(plant))
    loop = close_loop(plant, orbit.wave, law, start=orbit, settle=60)
    if loop.status != "stable":
        raise InputError("cell", str(node), f"its open loop is {loop.status}", "Raise cc of the operating point")
    point = _operating_point(loop, share)
    rows = {plant.labels[row]: i for i, row in enumerate(loop.flow.free)}
    A, B, G = _model(loop, decorrelation, scatter)
    return Cell(node, orbit.wave.height, orbit, fold, point, A, B, G, _signals(loop, point, filters), rows, loop)


def frozen(row: Sequence[float], filters: Filters, frequency: float, **limits: float) -> Scheduled:
    """Law with a table of one cell: its schedule does not move."""
    return Scheduled((1.0,), (1.0,), (1.0,), tuple(float(v) for v in row), wp=frequency, **vars(filters), **limits)


def _operating_point(loop: LoopOrbit, share: float) -> NDArray[np.float64]:
    """Means of the law's signals on the orbit, and the part of the ring speed at twice the ring angle."""
    after: tuple[ScheduledState, ...] = (*loop.law_states[1:], loop.law_states[0])  # the period's end is its beginning
    brisk = np.array([complex(s.V1, s.V3) for s in after])
    mean = np.mean(brisk / np.abs(brisk))
    mean = mean / abs(mean)
    x, plant = loop.states[:-1], loop.flow.plant
    harmonics = np.stack([np.ones_like(x[:, PSI]), np.cos(2 * x[:, PSI]), np.sin(2 * x[:, PSI])], axis=1)
    ripple = np.linalg.lstsq(harmonics, np.array([s.speed for s in after]), rcond=None)[0]
    flywheel = np.mean(x[:, OMEGA_RATE]) / plant.parameters.N / np.mean(x[:, PSI_RATE])
    return np.array([loop.controls[0, 0], share, mean.real, mean.imag, ripple[1], ripple[2], flywheel])


def _model(loop: LoopOrbit, decorrelation: float, scatter: float) -> tuple[Matrices, Matrices, Matrices]:
    """A and B of plant and filters from the controls, and G from the random modulation of the wave.

    The modulation is the last two states, in phase with the wave and a quarter period away.
    """
    flow, samples, n = loop.flow, loop.flow.samples, loop.A.shape[1]
    end = n + loop.by_state.shape[2]
    A, B, G = np.zeros((samples, end + 2, end + 2)), np.zeros((samples, end + 2, 2)), np.zeros((samples, end + 2, 2))
    A[:, :n, :n] = loop.A + loop.B @ loop.by_measurement[:, :2] @ loop.sensing
    A[:, :n, n:end] = loop.B @ loop.by_state[:, :2]  # the share is one of the live envelope
    A[:, n:end, :n] = loop.by_measurement[:, 2:] @ loop.sensing
    A[:, n:end, n:end] = loop.by_state[:, 2:]
    B[:, :n] = loop.B
    decay = np.exp(-decorrelation * flow.period)
    A[:, end, end] = A[:, end + 1, end + 1] = decay
    for k in range(samples):
        A[k, :n, end:] = modulation(flow, loop.states[k], loop.controls[k], k)
    G[:, end:] = scatter * np.sqrt(1.0 - decay**2) * np.eye(2)
    return A, B, G


def modulation(flow: HeldFlow, x: NDArray[np.float64], controls: NDArray[np.float64], sample: int) -> Matrices:
    """Derivative (free, 2) of a sample's end by the wave's amplitude: in phase with it, and a quarter period away.

    In the linear model the moments are held at the middle of the sample. Beyond it all that the wave does to the float,
    at every position and by the water's motion, is modulated alike.
    """
    cc, cg = (float(value) for value in controls)
    if flow.plant.coefficients.beyond is not None:
        return flow.by_amplitude(x, cc, cg, sample)
    _, entry = flow.jacobian(x, cc, cg, sample)
    turned = flow.forcing.amplitude * np.exp(2j * np.pi * (sample + 0.5) / flow.samples)
    moved: Matrices = entry[:, 2:] @ np.stack([turned.real, -turned.imag], axis=1)
    return moved


def _signals(loop: LoopOrbit, point: NDArray[np.float64], filters: Filters) -> Matrices:
    """Derivative C of each signal of the law by the states of the model."""
    samples, n = loop.flow.samples, loop.A.shape[1]
    end = n + loop.by_state.shape[2]
    C = np.zeros((samples, len(SIGNALS), end + 2))
    for i in range(len(SIGNALS)):
        row = np.zeros(ROW)
        row[: len(POINT)] = point
        row[0], row[len(POINT) + i] = 100.0, 1.0  # the signal itself, well inside the limits
        probe: Any = frozen(row.tolist(), filters, loop.law.wp, cc_max=1e3)._replace(period=loop.flow.period)
        for k in range(samples):
            _, by_y, by_s = step_jacobian(probe, 0.0, read(loop.states[k]), loop.law_states[k])
            C[k, i, :n], C[k, i, n:end] = by_y[0] @ loop.sensing, by_s[0]
    return C
