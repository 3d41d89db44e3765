"""The pressure of a realisation for plants whose wetted surface is followed: what the kernel holds between steps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gyroctl.waves.blending import blend_signals, check_blend
from gyroctl.waves.excitation import equivalent_amplitude
from gyroctl.waves.physical import check_headings
from gyroctl.waves.pressure import pressure_rows, wetted_surface
from gyroctl.waves.synthesis import Synthesis
from gyroctl.waves.turning import TurningSea

if TYPE_CHECKING:
    from gyroctl.plant import Plant
    from gyroctl.plant.held import Held


def held_moments(
    plant: Plant, synthesis: Synthesis, seeds: Sequence[int], of_run: Sequence[int] = (0,), blend: float = 0.0
) -> Held | None:
    """Moments of the wetted surface, ready for the kernel; None where a plant does not follow it.

    The polynomials come from the components of the realisation, and are blended in like the moments.

    Parameters
    ----------
    plant : Plant
        Choices and float.
    synthesis : Synthesis
        The sea.
    seeds : sequence of int
        Realisations, each once.
    of_run : sequence of int
        Index in `seeds` of each run side by side.
    blend : float
        Length of the blend from the regular wave. [s]
    """
    from gyroctl.plant.held import EVERY, Held
    from gyroctl.plant.wetted import ROWS, Pressure, WettedSurface

    beyond, geometry = plant.coefficients.beyond, plant.geometry
    if beyond is None or beyond.surface is None or geometry is None:
        return None
    check_headings(synthesis.waves.bearings)
    sea, length = synthesis.sea, check_blend(blend, synthesis.grid.duration)
    own = plant.parameters
    surface = wetted_surface(geometry.hull, plant.depth, sea.heading, geometry.rho, geometry.g, own.length_scale)

    def rows_of(omega: NDArray[np.float64], heading: float) -> NDArray[np.complex128]:
        facing = np.deg2rad(heading)
        turned = surface._replace(along=float(np.cos(facing)), across=float(np.sin(facing)))
        return pressure_rows(turned, omega, geometry.g)

    of_wave = synthesis.waves.in_direction(rows_of, sea.heading)
    regular = pressure_rows(surface, np.array([sea.wp]), geometry.g)[:, 0] * equivalent_amplitude(sea)
    rows, signals = np.empty((len(seeds), synthesis.grid.n, ROWS)), np.empty((ROWS, synthesis.grid.n))
    for seed, target in zip(seeds, rows, strict=True):
        synthesis.superposed(of_wave, seed, signals)
        blend_signals(signals, regular, sea.wp, synthesis.grid.dt, length)
        target[:] = signals.T
    turning = None
    if isinstance(sea, TurningSea):
        turning = np.array([np.deg2rad(sea.heading), np.deg2rad(sea.heading_end), sea.over])
    fields = Pressure.of(surface, rows, synthesis.grid.dt, np.array(of_run, dtype=np.int64), turning)
    every = EVERY * own.time_scale
    return Held.begun(WettedSurface(surface, float(beyond.position is not None)), fields, len(of_run), every)
