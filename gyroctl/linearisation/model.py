"""The periodic linear model about a locked orbit: A_k, B_k, C_k, D_k from sample to sample of a wave period."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gyroctl.errors import InputError
from gyroctl.faces.locks import model_face
from gyroctl.faces.show import shown
from gyroctl.linearisation.averaged import AveragedModel, average
from gyroctl.linearisation.bode import draw_bode
from gyroctl.linearisation.exchange import save_matlab
from gyroctl.linearisation.harmonic import HarmonicTransfer
from gyroctl.linearisation.held_flow import INPUTS, HeldFlow, samples_per_wave
from gyroctl.linearisation.lifted import LiftedModel, lift
from gyroctl.linearisation.periodic import DEFAULT_OUTPUTS, DERIVED, PeriodicMatrices, output
from gyroctl.orbits.choices import of_moment
from gyroctl.orbits.flow import STEP, Matrix, Vector
from gyroctl.orbits.orbit import Orbit

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@shown(model_face)
@dataclass(frozen=True)
class PeriodicModel(PeriodicMatrices):
    """A periodic model: the fields of `PeriodicMatrices`, and the models that are made from it.

    Parameters
    ----------
    A, B, C, D : arrays
        (N, n, n), (N, n, 4), (N, p, n) and (N, p, 4): x[k+1] = A_k x[k] + B_k u[k],
        y[k] = C_k x[k] + D_k u[k], in the units of the states, inputs and outputs.
    states, inputs, outputs : tuple of str
        Their names.
    asked : float
        Control period that was asked for; the one that divides the wave's is used. [s]
    orbit : (N + 1, n) array
        States of the plant at the samples. [rad], [rad/s]
    controls : (2,) array
        cc and cg. [Nms]
    flow : object
        The plant between two samples.
    """

    def select(self, inputs: Sequence[str] | None = None, outputs: Sequence[str] | None = None) -> PeriodicModel:
        """Return the model with fewer inputs and outputs, by name.

        Raises
        ------
        InputError
            For a name that the model does not have.
        """
        i = _places("inputs", self.inputs, inputs)
        o = _places("outputs", self.outputs, outputs)
        B, C, D = self.B[:, :, i], self.C[:, o], self.D[:, o][:, :, i]
        chosen, seen = tuple(self.inputs[j] for j in i), tuple(self.outputs[j] for j in o)
        return replace(self, B=B, C=C, D=D, inputs=chosen, outputs=seen)

    def continuous(self) -> tuple[Matrix, Matrix]:
        """A(t) (N, n, n) and B(t) (N, n, 4) of the continuous-time model x' = A(t) x + B(t) u at the samples."""
        flow, a, b, channels = self.flow, [], [], self.flow.plant.channels
        added = np.zeros((len(channels), 2))  # a moment is added at rest and at every position alike
        for i, moment in enumerate(INPUTS[2:]):
            added[of_moment(channels, moment), i] = 1.0
        for k, x in enumerate(self.orbit[:-1]):
            moments = np.real(np.exp(2j * np.pi * k / self.samples) * flow.forcing.amplitude)
            full, entry = flow.plant.jacobians(x, tuple(self.controls), moments)
            a.append((full @ flow.embedding)[flow.free])
            b.append(np.hstack([entry[:, :2], entry[:, 2:] @ added])[flow.free])
        return np.array(a), np.array(b)

    def lifted(self) -> LiftedModel:
        """Time-invariant model over one wave period: inputs and outputs of all its samples stacked."""
        return lift(self)

    def averaged(self) -> AveragedModel:
        """Low-order model of the slow modes: libration and horizontal mode, with its range of validity."""
        return average(self)

    def bode(
        self, inputs: Sequence[str] | None = None, outputs: Sequence[str] | None = None, omega: Vector | None = None
    ) -> Figure:
        """Draw the response at the input's own frequency, exact, and that of the averaged model beside it.

        Parameters
        ----------
        inputs, outputs, omega
            As for `AveragedModel.bode`.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InputError
            As `AveragedModel.bode`.
        """
        return draw_bode(self, inputs, outputs, omega, self.averaged())

    def harmonic(self) -> HarmonicTransfer:
        """Harmonic transfer function: what a harmonic of an input does to each harmonic of an output."""
        return HarmonicTransfer(self)

    def to_mat(self, path: str | Path) -> None:
        """Write matrices, names and orbit to a MATLAB file; the sample is the last index there."""
        more = {name: getattr(self, name) for name in ("period", "wave_period", "orbit", "controls", "note")}
        save_matlab(path, self, **more)


def linearise(
    orbit: Orbit, outputs: Sequence[str] = DEFAULT_OUTPUTS, period: float = 0.1, dt: float = 0.01
) -> PeriodicModel:
    """Linearise the plant about a locked orbit, exactly, by complex step through the kernel.

    Parameters
    ----------
    orbit : Orbit
        A locked orbit, stable or not.
    outputs : sequence of str
        Names of states, or of `DERIVED`.
    period : float
        Control period; the nearest one that divides the wave period is used, see `PeriodicModel.note`. [s]
    dt : float
        Longest Runge-Kutta step. [s]

    Returns
    -------
    PeriodicModel

    Raises
    ------
    InputError
        Where there is no orbit, for an unknown output, or for a period that is not positive or longer than the wave's.
    """
    if orbit.status == "no orbit":
        raise InputError("orbit", orbit.status, "there is nothing to linearise about", orbit.advice)
    if not (np.isfinite(period) and 0.0 < period <= orbit.period):
        raise InputError("period", period, "must be positive and at most the wave period", "Give it in s, e.g. 0.1")
    known = (*orbit.plant.labels, *DERIVED)
    for name in outputs:
        if name not in known:
            raise InputError("outputs", name, "unknown output", f"Choose from {', '.join(known)}")
    u = (orbit.cc, orbit.cg)
    flow = HeldFlow(orbit.plant, orbit.forcing, samples_per_wave(orbit.period, period), orbit.cc, dt)
    course = flow.close(orbit.x, *u, orbit.sense)
    A, B = map(np.array, zip(*(flow.jacobian(x, *u, k) for k, x in enumerate(course[:-1])), strict=True))
    C, D = map(np.array, zip(*(_measure(flow, x, u, outputs) for x in course[:-1]), strict=True))
    states = tuple(orbit.plant.labels[row] for row in flow.free)
    return PeriodicModel(A, B, C, D, states, INPUTS, tuple(outputs), period, course, np.array(u), flow)


def _measure(flow: HeldFlow, x: Vector, u: tuple[float, float], outputs: Sequence[str]) -> tuple[Matrix, Matrix]:
    """C (p, free) and D (p, 4) at one sample."""
    c, d = np.zeros((len(outputs), flow.free.size)), np.zeros((len(outputs), len(INPUTS)))
    points = x[:, None] + 1j * STEP * flow.embedding
    for i, name in enumerate(outputs):
        c[i] = np.imag(output(flow.plant, name, points, u)) / STEP
        for j in range(2):
            moved = [complex(value) for value in u]
            moved[j] += 1j * STEP
            d[i, j] = np.imag(output(flow.plant, name, x.astype(complex), moved)) / STEP
    return c, d


def _places(field_name: str, known: tuple[str, ...], wanted: Sequence[str] | None) -> list[int]:
    for name in wanted or ():
        if name not in known:
            raise InputError(field_name, name, "the model does not have it", f"Choose from {', '.join(known)}")
    return [known.index(name) for name in (known if wanted is None else wanted)]
