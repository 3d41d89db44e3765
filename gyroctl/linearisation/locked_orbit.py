"""The locked orbit as users meet it: the orbit, and the names of what stands above it, its modes and linear models."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError, check_kind
from gyroctl.faces.locks import orbit_face
from gyroctl.faces.show import shown
from gyroctl.linearisation.model import PeriodicModel, linearise
from gyroctl.linearisation.periodic import DEFAULT_OUTPUTS
from gyroctl.orbits.modes import Mode, find_modes
from gyroctl.orbits.nearest_orbit import find_orbit
from gyroctl.orbits.orbit import Orbit
from gyroctl.orbits.search import search_orbit
from gyroctl.orbits.wave import RegularWave
from gyroctl.plant import Plant
from gyroctl.plant.given import check_plant
from gyroctl.waves.checks import finite
from gyroctl.waves.physical import check_wave

if TYPE_CHECKING:
    from matplotlib.figure import Figure

REGULAR = "Give gyroctl.Regular(height, wp); for a sea that of equal energy, height = Hs / 1.414"


@shown(orbit_face)
@dataclass(frozen=True)
class PeriodicOrbit(Orbit):
    """A locked orbit under a regular wave: the fields of `gyroctl.orbits.orbit.Orbit`, its modes, its linear model."""

    @cached_property
    def modes(self) -> tuple[Mode, ...]:
        """Modes by name, slowest decay first: libration, horizontal, vertical, slip, radiation."""
        return find_modes(self)

    def mode(self, name: str) -> Mode:
        """Return the slowest mode of that name.

        Raises
        ------
        InputError
            If the orbit has no mode of that name.
        """
        for mode in self.modes:
            if mode.name == name:
                return mode
        have = ", ".join(dict.fromkeys(mode.name for mode in self.modes))
        raise InputError("mode", name, "this orbit has no mode of that name", f"Choose one of {have}")

    def linearise(self, outputs: Sequence[str] = DEFAULT_OUTPUTS, period: float = 0.1) -> PeriodicModel:
        """Periodic linear model about the orbit, see `gyroctl.linearisation.model.linearise`.

        Parameters
        ----------
        outputs : sequence of str
            Names of the outputs.
        period : float
            Sampling period. [s]
        """
        return linearise(self, outputs, period)

    def plot(self) -> Figure:
        """Draw ring and float over a wave, and the multipliers in the unit circle.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InputError
            Where there is no orbit.
        """
        from gyroctl.plots.orbit import orbit_figure

        if self.status == "no orbit":
            raise InputError("orbit", self.status, "there is nothing to draw", self.advice)
        return orbit_figure(self)


PeriodicOrbit.__doc__ = f"{PeriodicOrbit.__doc__}\n\n{(Orbit.__doc__ or '').partition('.')[2].lstrip()}"  # its fields


def lock_orbit(
    plant: Plant,
    wave: RegularWave,
    cc: float,
    cg: float,
    sense: int = 1,
    dt: float | None = None,
    guess: NDArray[np.float64] | None = None,
    nearest: bool = True,
) -> PeriodicOrbit:
    """Find the locked orbit.

    Parameters
    ----------
    plant : Plant
        The device.
    wave : Regular
        Height [m], angular frequency [rad/s] and heading [deg].
    cc, cg : float
        Controls. [Nms]
    sense : {1, -1}
        Sense of rotation of the ring.
    dt : float, optional
        Longest step; 0.01 s at the size of Table 1. [s]
    guess : (n,) array, optional
        State at phase zero; by default from harmonic balance. [rad], [rad/s]
    nearest : bool
        Where there is no orbit, look for the nearest wave height that has one (some 0.2 s).

    Returns
    -------
    PeriodicOrbit
        The stable orbit if there is one; else an unstable one; else the status "no orbit" with advice.

    Raises
    ------
    InputError
        If an argument is not what it should be, height, frequency or a control is out of range, the wave breaks, or
        the excitation is not known at the frequency.
    """
    check_plant(plant)
    check_kind("wave", wave, RegularWave, "a regular wave", REGULAR)
    for name, value in (("cc", cc), ("cg", cg)):
        finite(name, value, f"Give {name} in Nms")
    low, high = plant.excitation.omega[[0, -1]]
    if wave.height > 0.0 and low <= wave.wp <= high:
        check_wave(plant, wave)
    search = find_orbit if nearest else search_orbit
    return PeriodicOrbit(**vars(search(plant, wave, cc, cg, sense, dt, guess)))
