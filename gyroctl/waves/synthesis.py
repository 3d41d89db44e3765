"""Everything of a realisation that does not depend on the seed, computed once for a whole ensemble."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, get_args

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError, check_kind
from gyroctl.plant.given import check_plant
from gyroctl.waves.blending import blend_signals, check_blend
from gyroctl.waves.channels import Response, response
from gyroctl.waves.components import Components, Sea, components
from gyroctl.waves.excitation import Excited, band, regular_amplitude
from gyroctl.waves.grid import TimeGrid, time_grid
from gyroctl.waves.identity import content_hash
from gyroctl.waves.phases import random_phases
from gyroctl.waves.physical import Sized, check_headings, check_sea
from gyroctl.waves.record import ElevationRecord

if TYPE_CHECKING:
    from gyroctl.plant import Excitation, Plant

LOST_SHARE_MAX = 0.2
"""Greatest share of the wave variance that may lie where no moment is known [-]."""


@dataclass(frozen=True, eq=False)
class Synthesis:
    """A sea on a plant and a time grid, ready to give moments for any seed.

    Each seed is worked out alone and always in the same way, so its bits depend neither on the batch it is in, nor on
    the order, nor on the number of workers. (Another type of processor may round the last bit differently.)

    Attributes
    ----------
    sea : any sea of this package
    grid : TimeGrid
    waves : Components
        Frequencies and amplitudes of the elevation.
    response : ndarray, shape (2, k), complex
        Moments of those waves, before the random phases. [Nm]
    regular : ndarray, shape (2,), complex
        Moments of the equivalent regular wave; see `regular_amplitude`. [Nm]
    hydrodynamics : str
        Hash of the excitation.
    """

    sea: Sea
    grid: TimeGrid
    waves: Components
    response: NDArray[np.complex128]
    regular: NDArray[np.complex128]
    hydrodynamics: str

    def phases(self, seed: int) -> NDArray[np.float64]:
        """Phases of the waves, shape (k,), or (0,) where the sea fixes them [rad]."""
        return random_phases(seed, self.waves.random)

    def sha256(self, seed: int, blend: float = 0.0) -> str:
        """Content hash of the realisation of `seed`; see `content_hash`."""
        return content_hash(self.sea, self.phases(seed), self.hydrodynamics, self.grid, blend)

    def elevation(self, seed: int) -> NDArray[np.float64]:
        """Elevation at the float centre, shape (n,) [m]."""
        out = np.empty(self.grid.n)
        self.waves.superpose(self._turned(self.waves.amplitude[None, :], seed), out[None, :])
        return out

    def moments(self, seed: int, out: NDArray[np.float64] | None = None) -> NDArray[np.float64]:
        """Excitation moments about x1 and x3, shape (2, n), into `out` where it is given [Nm]."""
        result = np.empty((2, self.grid.n)) if out is None else out
        self.waves.superpose(self._turned(self.response, seed), result)
        return result

    def moments_batch(
        self, seeds: Sequence[int], blend: float = 0.0, out: NDArray[np.float64] | None = None
    ) -> NDArray[np.float64]:
        """Excitation moments of many seeds.

        Parameters
        ----------
        seeds : sequence of int
            Seeds, in any order.
        blend : float
            Length of the blend from the regular wave, 0 for none. [s]
        out : ndarray, shape (len(seeds), 2, n), optional
            Array to overwrite. Fresh memory costs up to three times the FFTs: work in chunks of seeds and reuse one.

        Returns
        -------
        ndarray, shape (len(seeds), 2, n)
            Moments about x1 and x3. [Nm]

        Raises
        ------
        InputError
            Fields ``run.seeds``, ``run.blend``, ``run.duration`` (shorter than the blend).
        ValueError
            `out` has another shape or type.
        """
        length = check_blend(blend, self.grid.duration)
        shape = (len(seeds), 2, self.grid.n)
        if out is not None and (out.shape != shape or out.dtype != np.float64):
            raise ValueError(f"out must be float64 of shape {shape}, not {out.dtype} of shape {out.shape}")
        result = np.empty(shape) if out is None else out
        for seed, rows in zip(seeds, result, strict=True):
            self.moments(seed, rows)
        blend_signals(result, self.regular, self.sea.wp, self.grid.dt, length)
        return result

    def signals(self, plant: Plant, seeds: Sequence[int], blend: float = 0.0) -> NDArray[np.float64]:
        """All signals that a plant asks for, of many seeds, see `Plant.channels`.

        Returns
        -------
        ndarray, shape (len(seeds), channels, n)

        Raises
        ------
        InputError
            Field ``plant.excitation``: another one than that of this synthesis. Else as `moments_batch`.
        """
        return np.stack(list(self.each_signals(plant, seeds, blend)))

    def each_signals(
        self, plant: Plant, seeds: Sequence[int], blend: float = 0.0, prepared: Response | None = None
    ) -> Iterator[NDArray[np.float64]]:
        """Signals of one seed after the other, (channels, n), see `signals`: many would not stay in a cache.

        `prepared` is what `prepared` returns, for whoever asks more than once.
        """
        length = check_blend(blend, self.grid.duration)
        amplitudes, regular = prepared or self.prepared(plant)
        for seed in seeds:
            result = np.empty((len(plant.channels), self.grid.n))
            self.waves.superpose(self._turned(amplitudes, seed), result)
            blend_signals(result, regular, self.sea.wp, self.grid.dt, length)
            yield result

    def prepared(self, plant: Plant) -> Response:
        """Signals of a plant before the phases of a seed, with the amplitudes of the sea in its components.

        Raises
        ------
        InputError
            See `signals`.
        """
        if plant.excitation.sha256 != self.hydrodynamics:
            problem = "the waves were made for another excitation, beyond the linear model it must be the same"
            raise InputError("plant.excitation", plant.name, problem, "Realise the waves with this plant")
        found = response(plant, self.sea, self.waves)
        return found._replace(components=found.components * self.waves.amplitude)

    def superposed(self, of_wave: NDArray[np.complex128], seed: int, out: NDArray[np.float64]) -> None:
        """Write signals of the waves into `out` (rows, n): `of_wave` (rows, k) per metre of each component."""
        self.waves.superpose(self._turned(of_wave * self.waves.amplitude, seed), out)

    def _turned(self, amplitudes: NDArray[np.complex128], seed: int) -> NDArray[np.complex128]:
        phases = self.phases(seed)
        if not phases.size:
            return amplitudes
        turned: NDArray[np.complex128] = np.exp(1j * phases)
        if self.waves.headings:  # a sea that turns has the same waves at each heading
            turned = np.tile(turned, len(self.waves.headings))
        return amplitudes * turned


def prepare(plant: Excited, sea: Sea, duration: float = 2000.0, dt: float | None = None) -> Synthesis:
    """Prepare the synthesis of `sea` on `plant`.

    Parameters
    ----------
    plant : Plant
        Gives the excitation.
    sea : any sea of this package
        The waves.
    duration : float
        Time from the first instant to the last, a multiple of `dt`. [s]
    dt : float, optional
        Time step; it divides 2000 s and is below 0.25 s, 0.05 s where it is left out. These times, and the cut of the
        frequencies, are those of a device of the size of Table 1, see `Parameters.length_scale`. [s]

    Returns
    -------
    Synthesis
        Gives moments, elevation and hash for any seed.

    Raises
    ------
    InputError
        Fields ``sea``, ``sea.wp``, ``run.duration``, ``run.dt``.
    """
    check_plant(plant, kind=Excited)
    check_kind("sea", sea, get_args(Sea), "a sea", f"Give one of {', '.join(kind.__name__ for kind in get_args(Sea))}")
    if isinstance(sea, ElevationRecord):
        sea.check()
    grid = time_grid(duration, dt, plant.parameters.time_scale if isinstance(plant, Sized) else 1.0)
    waves = components(sea, grid)
    regular = regular_amplitude(plant, sea)
    _check_share(sea, waves, plant.excitation)
    if isinstance(plant, Sized):
        check_sea(plant, sea)
        if plant.parameters.wetted == "surface":
            check_headings(waves.bearings)
    moments = waves.in_direction(plant.excitation, sea.heading) * waves.amplitude
    return Synthesis(sea, grid, waves, moments, regular, plant.excitation.sha256)


def _check_share(sea: Sea, waves: Components, excitation: Excitation) -> None:
    """Refuse a sea of which much lies outside the table or that the harmonics resolve poorly."""
    low, high = band(excitation)
    power = np.abs(waves.amplitude) ** 2
    inside = (waves.omega >= low) & (waves.omega <= high)
    share = waves.captured * float(power[inside].sum() / power.sum())
    if share < 1.0 - LOST_SHARE_MAX or waves.captured > 1.0 + LOST_SHARE_MAX:
        problem = f"{share:.0%} of the wave energy is where the excitation is known"
        mend = f"Give a sea with its energy between {max(low, waves.omega[0]):.3g} and {high:.3g} rad/s"
        raise InputError("sea.wp", sea.wp, problem, mend)
