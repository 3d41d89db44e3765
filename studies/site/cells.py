"""The sea states of a table as seas of the device, and which of them it is not run in."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

from gyroctl.errors import InputError
from gyroctl.harness.start import locked_start
from gyroctl.plant import Plant
from gyroctl.studies.site.periods import over_peak_period
from gyroctl.studies.site.scatter import YEAR, Bin
from gyroctl.waves import SeaState, prepare
from gyroctl.waves.energy import energy_flux
from gyroctl.waves.physical import BREAKING, wavelength

State = Literal["run", "no lock", "calm", "left out", "rare"]

MEANING: dict[State, str] = {
    "run": "simulated",
    "no lock": "no locked orbit to begin on: the device stands still, and counts as giving nothing",
    "calm": "no waves: counts as giving nothing",
    "left out": "the model cannot say: in no sum",
    "rare": "rarer than asked for: in no sum",
}

COUNTED: tuple[State, ...] = ("run", "no lock", "calm")
"""States of what is in the sums."""

SHALLOW = ("sea.hs", "plant")
"""Fields of the refusal to begin in lock."""


class Cell(NamedTuple):
    """A sea state of the site."""

    name: str
    bin: Bin
    tp: float  # peak period at the site [s]
    sea: SeaState | None  # as it acts on the plant, None where there is none
    flux: float  # power of the waves at the site [W/m]
    state: State
    why: str  # of what is not run

    @property
    def hours(self) -> float:
        """Hours in a mean year. [h]"""
        return YEAR * self.bin.share

    @property
    def counted(self) -> bool:
        """Whether it is in the sums."""
        return self.state in COUNTED


class Scaled(NamedTuple):
    """How the site and the plant belong together."""

    kind: str  # of the table's periods
    gamma: float
    scale: float
    depth: float  # of the site [m]
    duration: float  # of the runs [s]
    rarest: float


def cell_of(plant: Plant, one: Bin, on: Scaled) -> Cell:
    """Sea state of a bin.

    Raises
    ------
    InputError
        For whatever is not the fault of the sea state.
    """
    name = f"Hs {one.hs:.6g} m, {on.kind} {one.period:.6g} s"
    if one.hs == 0.0:
        return Cell(name, one, math.nan, None, 0.0, "calm", MEANING["calm"])
    tp = one.period / over_peak_period(on.kind, on.gamma)
    flux, sea, why = math.nan, None, ""
    try:
        full = SeaState(one.hs, 2.0 * math.pi / tp, on.gamma)
        flux = energy_flux(full, on.depth)
        why = _breaks(full, on.depth)
        sea = SeaState(one.hs / on.scale, full.wp * math.sqrt(on.scale), on.gamma)
        if not why:
            prepare(plant, sea, on.duration)
    except InputError as error:
        if not error.field.startswith("sea."):
            raise
        why = f"{error.problem}, at the plant's scale" if on.scale != 1.0 else error.problem
    if why:
        return Cell(name, one, tp, None, flux, "left out", why)
    if one.share < on.rarest:
        return Cell(name, one, tp, sea, flux, "rare", MEANING["rare"])
    assert sea is not None
    try:
        locked_start(plant, sea)
    except InputError as error:
        if error.field not in SHALLOW:
            raise
        return Cell(name, one, tp, sea, flux, "no lock", error.problem)
    return Cell(name, one, tp, sea, flux, "run", "")


def _breaks(sea: SeaState, depth: float) -> str:
    """Say why water cannot stand so steep at the site: judged by the regular wave of equal energy."""
    length = wavelength(sea.wp, depth)
    shallow = math.tanh(2.0 * math.pi / length * depth) if math.isfinite(depth) else 1.0
    most = math.sqrt(2.0) * BREAKING * length * shallow
    return f"breaks: higher than {most:.3g} m on waves {length:.3g} m long" if sea.hs > most else ""
