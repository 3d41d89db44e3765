"""The frequency response of a periodic model as a slow observer sees it, drawn beside that of its averaged model."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.linearisation.harmonic import HarmonicTransfer
from gyroctl.linearisation.periodic import PeriodicMatrices
from gyroctl.plots.bode import bode_figure, frequencies

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHOWN = {"inputs": ("cc", "cg"), "outputs": ("psi", "power")}
"""Signals that are drawn where none are named."""


def draw_bode(
    model: PeriodicMatrices,
    inputs: Sequence[str] | None,
    outputs: Sequence[str] | None,
    omega: NDArray[np.float64] | None,
    averaged: Any,
) -> Figure:
    """Draw the responses of a periodic model and of its averaged one.

    Raises
    ------
    InputError
        For a signal that the model does not have, or frequencies that are none.
    """
    taken, given = (_chosen(model, kind, names) for kind, names in (("inputs", inputs), ("outputs", outputs)))
    at = _band(model, averaged) if omega is None else np.asarray(omega, dtype=np.float64)
    if at.ndim != 1 or at.size < 2 or not np.all(np.isfinite(at)) or at[0] <= 0.0 or np.any(np.diff(at) <= 0.0):
        raise InputError("omega", omega, "are no rising positive frequencies", "Give them in rad/s, 0.01 and more")
    cut = np.ix_(range(at.size), [model.outputs.index(o) for o in given], [model.inputs.index(i) for i in taken])
    responses = {"averaged model": averaged.response(at)[cut], "exact": HarmonicTransfer(model).baseband(at)[cut]}
    cc, cg = (float(value) for value in model.controls)
    note = (
        f"about the locked orbit at cc {cc:g}, cg {cg:g} Nms under a wave of {model.wave_period:.4g} s; the averaged "
        f"model holds up to {averaged.valid_frequency:.3g} rad/s (psi by cg within a tenth), shaded beyond"
    )
    return bode_figure(at, responses, taken, given, note, averaged.valid_frequency)


def _chosen(model: PeriodicMatrices, kind: str, names: Sequence[str] | None) -> tuple[str, ...]:
    """Signals to draw, by default the leading ones that the model has."""
    known: tuple[str, ...] = getattr(model, kind)
    if names is None:
        return tuple(name for name in SHOWN[kind] if name in known) or known[:2]
    names = [names] if isinstance(names, str) else list(names)
    for name in names or [""]:
        if name not in known:
            raise InputError(kind, name, "the model does not have it", f"Choose from {', '.join(known)}")
    return tuple(names)


def _band(model: PeriodicMatrices, averaged: Any) -> NDArray[np.float64]:
    """From below the slowest mode up to half the wave's frequency, beyond which an average over a wave says nothing."""
    return frequencies(float(np.min(np.abs(averaged.poles))), np.pi / model.wave_period)
