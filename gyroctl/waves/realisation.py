"""One realisation of a sea: from a seed to the elevation and both excitation moments."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.faces.show import shown
from gyroctl.faces.waters import realisation_face
from gyroctl.waves.blending import blend_signals, check_blend
from gyroctl.waves.components import Sea
from gyroctl.waves.excitation import Excited, equivalent_amplitude
from gyroctl.waves.grid import TimeGrid
from gyroctl.waves.identity import content_hash
from gyroctl.waves.synthesis import Synthesis, prepare
from gyroctl.waves.wetted import held_moments

if TYPE_CHECKING:
    from gyroctl.plant import Plant
    from gyroctl.plant.held import Held


@shown(realisation_face)
@dataclass(frozen=True, eq=False)
class WaveRealisation:
    """Waves at the float and the moments they exert, at even instants.

    The arrays are not marked read-only, because compiled code would need a second compilation for such arrays; do
    not write into them.

    Attributes
    ----------
    sea : any sea of this package
    seed : int
    grid : TimeGrid
    elevation : ndarray, shape (n,)
        Elevation at the float centre. [m]
    moments : ndarray, shape (2, n)
        Excitation moments about x1 and x3. [Nm]
    phases : ndarray, shape (k,)
        Phases drawn from the seed. [rad]
    regular : ndarray, shape (2,), complex
        Moments of the equivalent regular wave, ``Re(regular exp(i wp t))``. [Nm]
    hydrodynamics : str
        Hash of the excitation.
    blend : float
        Length of the blend from the regular wave at the start. [s]
    synthesis : Synthesis, optional
        Gives the further signals that a plant asks for.
    whole : WaveRealisation, optional
        The realisation of which these waves are the last part, see `since`: it gives the further signals then.
    """

    sea: Sea
    seed: int
    grid: TimeGrid
    elevation: NDArray[np.float64]
    moments: NDArray[np.float64]
    phases: NDArray[np.float64]
    regular: NDArray[np.complex128]
    hydrodynamics: str
    blend: float = 0.0
    synthesis: Synthesis | None = field(default=None, repr=False)
    whole: WaveRealisation | None = field(default=None, repr=False)
    _further: dict[Any, Any] = field(default_factory=dict, repr=False, init=False)

    def __getstate__(self) -> dict[str, Any]:
        """Leave out the signals that can be made again."""
        return {**self.__dict__, "_further": {}}

    def signals(self, plant: Plant) -> NDArray[np.float64]:
        """All signals that a plant asks for; made when they are first asked for, and kept.

        Parameters
        ----------
        plant : Plant
            With the excitation of this realisation.

        Returns
        -------
        ndarray, shape (channels, n)
            In the order of `plant.channels`; the first two are `moments`.

        Raises
        ------
        InputError
            Where further signals are asked for and these waves know no components, or those of another excitation.
        """
        if len(plant.channels) == 2:
            return self.moments
        key = plant.channels, plant.depth, plant.geometry, plant.parameters.drag_height
        if key not in self._further:
            if self.whole is None:
                found = self._components().signals(plant, [self.seed], self.blend)[0]
                found[:2] = self.moments
            else:
                found = self.whole.signals(plant)[:, -self.grid.n :]
            self._further[key] = np.ascontiguousarray(found.T).T  # sample by sample, as the kernel reads them
        made: NDArray[np.float64] = self._further[key]
        return made

    def held(self, plant: Plant) -> Held | None:
        """Moments that a plant holds between its steps, None where it has none; see `wetted.held_moments`.

        Raises
        ------
        InputError
            As `signals`.
        """
        beyond = plant.coefficients.beyond
        if beyond is None or beyond.surface is None:
            return None
        key = "held", plant.depth, plant.geometry, beyond.position is not None
        if key not in self._further:
            found = self.whole.held(plant) if self.whole is not None else None
            if found is None:
                found = held_moments(plant, self._components(), [self.seed], blend=self.blend)
            else:
                rows = np.ascontiguousarray(found.fields.rows[:, -self.grid.n :])
                found = found._replace(fields=found.fields._replace(rows=rows))
            self._further[key] = found
        kept: Held = self._further[key]
        room = {name: np.empty_like(getattr(kept.fields, name)) for name in ("now", "weight", "work")}
        return kept.begun(
            kept.model, kept.fields._replace(**room), 1, kept.every
        )  # each run has working space of its own

    def _components(self) -> Synthesis:
        if self.synthesis is None:
            mend = "Realise the sea with gyroctl.realise, or leave position, drag and wetted out"
            raise InputError("waves", self.seed, "these moments come without the waves that belong to them", mend)
        return self.synthesis

    @property
    def dt(self) -> float:
        """Time step [s]."""
        return self.grid.dt

    @property
    def duration(self) -> float:
        """Time from the first instant to the last [s]."""
        return self.grid.duration

    @property
    def time(self) -> NDArray[np.float64]:
        """Instants, shape (n,), n = duration / dt + 1 [s]."""
        return self.grid.time

    @cached_property
    def sha256(self) -> str:
        """Content hash; see `content_hash`."""
        return content_hash(self.sea, self.phases, self.hydrodynamics, self.grid, self.blend)

    def since(self, begin: float) -> WaveRealisation:
        """Return these waves from an instant of their grid on: what acts then, acts at t = 0 of the part.

        Parameters
        ----------
        begin : float
            A multiple of `dt`. [s]

        Returns
        -------
        WaveRealisation
            The same numbers, those of the further signals included.
        """
        at = round(begin / self.dt)
        grid = self.grid._replace(duration=self.duration - at * self.dt, n=self.grid.n - at)
        moments = np.ascontiguousarray(self.moments[:, at:])
        return replace(self, grid=grid, moments=moments, elevation=self.elevation[at:], whole=self)

    def blended(self, blend: float = 100.0) -> WaveRealisation:
        """Return these waves led in from the equivalent regular wave; see `blend_signals`.

        Parameters
        ----------
        blend : float
            Length of the blend, 0 for none. [s]

        Returns
        -------
        WaveRealisation
            New arrays; the same from ``t = blend`` on.

        Raises
        ------
        InputError
            Field ``run.blend``: negative, or these waves are blended already. Field ``run.duration``: shorter than
            the blend.
        """
        length = check_blend(blend, self.duration)
        if self.blend != 0.0:
            mend = "Blend the realisation as `realise` returned it"
            raise InputError("run.blend", blend, f"these waves are blended already, over {self.blend:g} s", mend)
        if self.whole is not None:
            raise InputError("run.blend", blend, "these waves are the last part of others", "Blend them before")
        moments, elevation = self.moments.copy(), self.elevation[None, :].copy()
        crest = np.array([equivalent_amplitude(self.sea)], dtype=np.complex128)
        blend_signals(moments, self.regular, self.sea.wp, self.dt, length)
        blend_signals(elevation, crest, self.sea.wp, self.dt, length)
        return replace(self, moments=moments, elevation=elevation[0], blend=length)


def realise(plant: Excited, sea: Sea, seed: int, duration: float = 2000.0, dt: float | None = None) -> WaveRealisation:
    """Realise a sea: random phases on deterministic amplitudes, (41)-(43) with the complex He_j.

    Parameters
    ----------
    plant : Plant
        Gives the excitation.
    sea : any sea of this package
        The waves. An elevation record and a regular wave are the same for every seed.
    seed : int
        Seed of the phases. The same seed gives the same sea whatever `dt` and, up to 2000 s, `duration`.
    duration : float
        Time from the first instant to the last, a multiple of `dt`. [s]
    dt : float, optional
        Time step; it divides 2000 s and is below 0.25 s, 0.05 s where it is left out. These times, and the cut of the
        frequencies, are those of a device of the size of Table 1, see `Parameters.length_scale`. [s]

    Returns
    -------
    WaveRealisation
        Elevation, moments and hash.

    Raises
    ------
    InputError
        Fields ``sea``, ``sea.wp``, ``run.seeds``, ``run.duration``, ``run.dt``.
    """
    synthesis = _prepared(plant, sea, duration, dt)
    return WaveRealisation(
        sea=sea,
        seed=seed,
        grid=synthesis.grid,
        elevation=synthesis.elevation(seed),
        moments=synthesis.moments(seed),
        phases=synthesis.phases(seed),
        regular=synthesis.regular,
        hydrodynamics=synthesis.hydrodynamics,
        synthesis=synthesis,
    )


_latest: tuple[Excited, Sea, float, float | None, Synthesis] | None = None


def _prepared(plant: Excited, sea: Sea, duration: float, dt: float | None) -> Synthesis:
    """Synthesis of a sea; the one of the call before where it is the same: seed after seed is asked for."""
    global _latest
    last = _latest
    if last is not None and last[0] is plant and last[1] is sea and last[2:4] == (duration, dt):
        return last[4]
    synthesis = prepare(plant, sea, duration, dt)
    _latest = plant, sea, duration, dt, synthesis
    return synthesis
