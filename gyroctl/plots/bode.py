"""Bode plots that can be read: few signals, magnitudes in their units, phases without jumps, where the model holds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.palette import MUTED
from gyroctl.plots.style import label, sheet, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

UNITS = {"psi": "rad", "phi1": "rad", "phi3": "rad", "omega": "rad", "power": "W", "cc": "Nms", "cg": "Nms"}
UNITS |= {"Me1": "Nm", "Me3": "Nm"}
"""Units of signals; rad/s of those that are rates."""

LOOKS: tuple[dict[str, Any], ...] = ({"color": "#0072B2", "lw": 1.8}, {"color": "#D55E00", "lw": 1.2, "ls": "--"})
POINTS = 80
"""Frequencies."""


def frequencies(slowest: float, highest: float) -> NDArray[np.float64]:
    """Frequencies from well below the slowest mode up to `highest`, evenly on a logarithmic axis. [rad/s]"""
    low = min(max(0.03 * slowest, 1e-4 * highest), 0.1 * highest)
    return np.geomspace(low, highest, POINTS)


def bode_figure(
    omega: NDArray[np.float64],
    responses: Mapping[str, NDArray[np.complex128]],
    inputs: Sequence[str],
    outputs: Sequence[str],
    note: str,
    holds: float = np.inf,
) -> Figure:
    """Draw frequency responses: a column for each input, magnitude and phase for each output.

    Parameters
    ----------
    omega : (n,) array
        Frequencies. [rad/s]
    responses : mapping of str to (n, p, m) array
        By what they are of; the first one is drawn strongly.
    inputs, outputs : sequence of str
        Their m and p names.
    note : str
        What the model is of.
    holds : float
        Where the model ends: beyond, the picture is shaded. [rad/s]
    """
    rows, columns = 2 * len(outputs), len(inputs)
    with styled():
        size = (1.2 + 4.4 * columns, 1.3 + 1.75 * rows)
        figure, axes = sheet(rows, columns, size, "Frequency response of the averaged motion", note, sharex=True)
        grid = np.array(axes, dtype=object).reshape(rows, columns)
        for i, given in enumerate(outputs):
            for j, taken in enumerate(inputs):
                upper, lower = grid[2 * i, j], grid[2 * i + 1, j]
                for look, (name, values) in zip(LOOKS, responses.items(), strict=False):
                    upper.loglog(omega, np.abs(values[:, i, j]), label=name, **look)
                    phase = np.degrees(np.unwrap(np.angle(values[:, i, j])))
                    lower.semilogx(omega, phase - 360.0 * np.round(phase[0] / 360.0), **look)
                _a_decade(upper)
                label(upper, f"{taken} to {given}", "", f"[{_unit(given)} per {_unit(taken)}]")
                label(lower, "", "", "phase [deg]")
                lower.yaxis.set_major_locator(_right_angles())
                for panel in (upper, lower):
                    if holds < omega[-1]:
                        panel.axvspan(holds, omega[-1], color=MUTED, alpha=0.12, lw=0)
                    panel.set_xlim(omega[0], omega[-1])
        for panel in grid[-1]:
            panel.set_xlabel("frequency [rad/s]")
        if len(responses) > 1:
            grid[0, 0].legend(loc="lower left")
    return figure


def _a_decade(axes: Any) -> None:
    """Let a magnitude that hardly changes look like one: the axis is a decade high at least."""
    low, high = axes.get_ylim()
    widen = (max(10.0 / (high / low), 1.0)) ** 0.5
    axes.set_ylim(low / widen, high * widen)


def _right_angles() -> Any:
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(nbins=5, steps=[1, 1.5, 3, 4.5, 9, 10])


def _unit(name: str) -> str:
    return UNITS.get(name, "rad/s")
