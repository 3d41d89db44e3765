"""The averaged model: the slow modes of a periodic model as seen by a slow observer.

The transfer from an input to an output at the input's own frequency is a sum over Floquet modes (the baseband of the
harmonic transfer function). Two terms are kept, the libration of the ring phase and the horizontal mode of the float;
of the others only their static part. Where this is good enough is measured, not assumed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.faces.locks import model_face
from gyroctl.faces.show import shown
from gyroctl.linearisation.bode import draw_bode
from gyroctl.linearisation.exchange import control_system, save_matlab
from gyroctl.linearisation.harmonic import HarmonicTransfer
from gyroctl.linearisation.periodic import PeriodicMatrices
from gyroctl.plant.equations import PSI

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SLOW = 1e-4
"""Modes whose multiplier is below this are gone within a period."""

TOLERANCE = 0.1
"""Relative error at which the range of validity ends."""

WATCHED = 8
"""Wave periods over which the nonlinear libration is compared with the linear one."""

GROUPS = {"libration": ("psi", "psi_rate"), "horizontal": ("phi1", "phi1_rate")}


@shown(model_face)
@dataclass(frozen=True)
class AveragedModel:
    """Continuous-time model x' = A x + B u, y = C x + D u of the slow modes, for deviations averaged over a wave.

    Parameters
    ----------
    A, B, C, D : arrays
        Order four: libration in the mean ring phase [rad] and its rate, horizontal mode in phi1 [rad] and its rate.
    states, inputs, outputs : tuple of str
        Names.
    valid_frequency : float
        Up to here the response of psi to cg is within `TOLERANCE` of the exact baseband response; at most half the
        wave's frequency, beyond which an average over the wave says nothing. [rad/s]
    valid_angle : float
        Largest libration from which the nonlinear plant swings back within `TOLERANCE` of the linear one, in the worse
        direction; zero where the libration grows. [rad]
    """

    A: NDArray[np.float64]
    B: NDArray[np.float64]
    C: NDArray[np.float64]
    D: NDArray[np.float64]
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    valid_frequency: float
    valid_angle: float
    model: PeriodicMatrices = field(repr=False)

    @property
    def poles(self) -> NDArray[np.complex128]:
        """Floquet exponents of the kept modes: those of the libration, then those of the horizontal mode. [1/s]"""
        blocks = (slice(0, 2), slice(2, 4))
        return np.concatenate([np.linalg.eigvals(self.A[block, block]).astype(complex) for block in blocks])

    def response(self, omega: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Frequency response (len(omega), p, m)."""
        eye = np.eye(self.A.shape[0])
        return np.array([self.C @ np.linalg.solve(1j * w * eye - self.A, self.B) + self.D for w in omega])

    def bode(
        self,
        inputs: Sequence[str] | None = None,
        outputs: Sequence[str] | None = None,
        omega: NDArray[np.float64] | None = None,
    ) -> Figure:
        """Draw the frequency response, and beside it the exact one that it stands for.

        Parameters
        ----------
        inputs, outputs : sequence of str, optional
            Signals to draw; by default cc and cg, psi and power, as far as the model has them.
        omega : (n,) array, optional
            Frequencies, rising; by default from well below the slowest mode up to half the wave's. [rad/s]

        Returns
        -------
        matplotlib.figure.Figure
            A column for each input, magnitude [unit of the output per unit of the input] and phase [deg] for each
            output; shaded beyond `valid_frequency`.

        Raises
        ------
        InputError
            For a signal that the model does not have, or frequencies that are none.
        """
        return draw_bode(self.model, inputs, outputs, omega, self)

    def to_control(self) -> Any:
        """Return a `control.StateSpace` with named signals."""
        return control_system(self, "averaged")

    def to_scipy(self) -> Any:
        """Return a `scipy.signal.lti` of the same matrices."""
        from scipy.signal import lti

        return lti(self.A, self.B, self.C, self.D)

    def to_mat(self, path: str | Path) -> None:
        """Write matrices, names and range of validity to a MATLAB file."""
        save_matlab(path, self, valid_frequency=self.valid_frequency, valid_angle=self.valid_angle)


class Floquet(NamedTuple):
    """The slow modes of a periodic model, i of them."""

    exponents: NDArray[np.complex128]  # (i,) [1/s]
    right: NDArray[np.complex128]  # periodic vectors (N, n, i)
    left: NDArray[np.complex128]  # and their duals (N, i, n)


def average(model: PeriodicMatrices) -> AveragedModel:
    """Keep the libration and the horizontal mode of a periodic model.

    Raises
    ------
    InputError
        Where two such modes cannot be told apart.
    """
    floquet = _floquet(model)
    exponents, right, left = floquet
    h, chosen = model.period, _choose(model, floquet)
    bases, blocks = {}, []
    entry = np.einsum("kin,knm->im", np.roll(left, -1, 0), model.B) / model.samples
    seen = np.einsum("kpn,kni->pi", model.C, right) / model.samples
    mean = right.mean(0)
    for name, states in GROUPS.items():
        pair = chosen[name]
        basis = bases[name] = mean[np.ix_([model.states.index(s) for s in states], pair)]
        rates = exponents[pair]
        hold = np.where(np.abs(rates) > 1e-12, rates / np.expm1(rates * h), 1.0 / h)
        back = np.linalg.inv(basis)
        a = np.real(basis @ np.diag(rates) @ back)
        b = np.real(basis @ (hold[:, None] * entry[pair]))
        blocks.append((a, b, np.real(seen[:, pair] @ back)))
    (a1, b1, c1), (a3, b3, c3) = blocks
    A = np.block([[a1, np.zeros((2, 2))], [np.zeros((2, 2)), a3]])
    B, C = np.vstack([b1, b3]), np.hstack([c1, c3])
    static = np.real(HarmonicTransfer(model).baseband(np.zeros(1))[0])
    D = static + C @ np.linalg.solve(A, B)
    names = tuple(f"{group}_{state}" for group, states in GROUPS.items() for state in states)
    plain = AveragedModel(A, B, C, D, names, model.inputs, model.outputs, np.nan, np.nan, model)
    one_radian = np.linalg.solve(bases["libration"], np.array([1.0, 0.0]))
    shape = np.real(right[0][:, chosen["libration"]] @ one_radian)
    return replace(plain, valid_frequency=_valid_frequency(plain), valid_angle=_valid_angle(model, shape))


def _floquet(model: PeriodicMatrices) -> Floquet:
    values, vectors = np.linalg.eig(model.monodromy)
    duals = np.linalg.inv(vectors)
    slow = np.flatnonzero(np.abs(values) > SLOW)
    exponents = np.log(values[slow].astype(complex)) / model.wave_period
    step = np.exp(exponents * model.period)
    right, left = [vectors[:, slow].astype(complex)], [duals[slow].astype(complex)]
    for k in range(model.samples - 1):
        right.append(model.A[k] @ right[-1] / step)
    for k in reversed(range(1, model.samples)):
        left.append((left[-1] @ model.A[k]) / step[:, None])
    return Floquet(exponents, np.array(right), np.array([left[0], *left[:0:-1]]))


def _choose(model: PeriodicMatrices, floquet: Floquet) -> dict[str, list[int]]:
    """Two exponents for each group, closed under conjugation, by the part its states take in them."""
    exponents = floquet.exponents
    share = np.abs(floquet.left.transpose(0, 2, 1) * floquet.right).mean(0)
    share = share / share.sum(0)
    pairs = [
        (i, j)
        for i in range(exponents.size)
        for j in range(i + 1, exponents.size)
        if abs(exponents[i] - exponents[j].conj()) < 1e-9 * abs(exponents[i])
        or max(abs(exponents[i].imag), abs(exponents[j].imag)) < 1e-12
    ]
    chosen: dict[str, list[int]] = {}
    for name, states in (("horizontal", GROUPS["horizontal"]), ("libration", (*GROUPS["libration"], "omega_rate"))):
        rows = [model.states.index(s) for s in states if s in model.states]
        free = [p for p in pairs if not any(i in other for other in chosen.values() for i in p)]
        if not free:
            raise InputError("model", name, "has no such pair of slow modes", "Use the lifted model")
        chosen[name] = list(max(free, key=lambda p: float(share[np.ix_(rows, list(p))].sum())))
    return chosen


def _valid_frequency(averaged: AveragedModel) -> float:
    """Highest frequency with a relative error below `TOLERANCE` from cg to psi, on a grid. [rad/s]"""
    model = averaged.model
    grid = np.linspace(0.0, np.pi / model.wave_period, 101)
    row, nothing = np.zeros((model.samples, 1, len(model.states))), np.zeros((model.samples, 1, 1))
    row[:, 0, model.states.index("psi")] = 1.0
    single = replace(model, B=model.B[:, :, 1:2], C=row, D=nothing, inputs=("cg",), outputs=("psi",))
    exact = HarmonicTransfer(single).baseband(grid)[:, 0, 0]
    eye, b = np.eye(2), averaged.B[:2, 1]
    near = np.array([np.linalg.solve(1j * w * eye - averaged.A[:2, :2], b)[0] for w in grid])
    near = near + np.real(exact[0] - near[0])
    good = np.abs(near - exact) <= TOLERANCE * np.abs(exact)
    return float(grid[-1] if good.all() else grid[max(int(np.argmin(good)) - 1, 0)])


def _valid_angle(model: PeriodicMatrices, shape: NDArray[np.float64]) -> float:
    """Largest libration [rad] that the linear model follows within `TOLERANCE`, by bisection on nonlinear runs."""
    if float(np.abs(model.multipliers[0])) >= 1.0:
        return 0.0
    psi = model.states.index("psi")
    linear = [shape]
    for _ in range(WATCHED):
        linear.append(model.monodromy @ linear[-1])
    course = np.array(linear)[:, psi]
    turn_of_ring = model.orbit[-1, PSI] - model.orbit[0, PSI]
    cc, cg = model.controls

    def follows(angle: float) -> bool:
        x = model.orbit[0] + model.flow.embedding @ (angle * shape)
        for turn in range(1, WATCHED + 1):
            for k in range(model.samples):
                x = model.flow.advance(x, cc, cg, k)
            gap = x[PSI] - model.orbit[0, PSI] - turn * turn_of_ring
            if not abs(gap - angle * course[turn]) <= TOLERANCE * abs(angle) * abs(course[0]):
                return False
        return True

    limits = []
    for sign in (1.0, -1.0):
        low, high = 0.0, np.pi
        for _ in range(9):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if follows(sign * middle) else (low, middle)
        limits.append(low)
    return min(limits)
