"""A window cut out of a sea: waves, the state in which it begins, and what a run through it is worth.

Every run of a window, planned or by a law, begins in the same state, in full irregular waves: the device is led in from
the locked start by a cautious constant pair. All that follows is counted, the change of stored energy included.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.harness.protocol import Law
from gyroctl.harness.registry import law
from gyroctl.harness.run import Settings, lead_in, run_law
from gyroctl.plant import Plant
from gyroctl.plant.equations import OMEGA_RATE
from gyroctl.simulation.lock import WINDOW
from gyroctl.simulation.metrics import Record, evaluate
from gyroctl.waves import SeaState, WaveRealisation, realise

LEAD = 100.0
"""Length of the lead-in, in which the sea is blended in. [s]"""

TAIL = 10.0
"""What a plan sees beyond the window, so that it does not end it in a state that is worth nothing. [s]"""

AHEAD = 2.0 * TAIL
"""Waves beyond the window, for whoever looks ahead. [s]"""

SETTINGS = Settings(blend=LEAD)

CAUTIOUS = ((0.104, 1.5e-4), (0.104, 5e-5), (0.052, 5e-5))
"""Controls of the lead-in, in the order in which they are tried. [Nms]"""


@dataclass(frozen=True)
class Cut:
    """A window of a realisation.

    Parameters
    ----------
    plant : Plant
        The device.
    waves : WaveRealisation
        From the start of the window to its end, and `AHEAD` beyond.
    start : (n,) array
        State at the start.
    duration : float
        What is counted. [s]
    sha256 : str
        Hash of the realisation that it was cut from.
    settings : Settings
        Steps, sensors, actuators.
    """

    plant: Plant
    waves: WaveRealisation
    start: NDArray[np.float64]
    duration: float
    sha256: str
    settings: Settings = SETTINGS

    @property
    def intervals(self) -> int:
        """Control intervals that are counted."""
        return round(self.duration / self.settings.actuators.period)

    def run(self, law: Law, name: str) -> Record:
        """Run a law through the window and the waves beyond its end."""
        return run_law(self.plant, law, self.waves, self.settings, name, start=self.start)[0]

    def counted(self, record: Record) -> Record:
        """Leave out what lies beyond the window."""
        return _begin(record, self.intervals)

    def worth(self, record: Record) -> dict[str, float]:
        """Metrics of a run, and its `harvest_w`: generated power and change of the flywheel's energy. [W]

        The float's energy is not counted: little of it can be had. It is `stored_w` less `flywheel_w`.
        """
        values = _metrics(self.plant, record, self.waves)
        speed = record.states[:, OMEGA_RATE]
        gained = 0.5 * self.plant.parameters.J4 * (speed[-1] ** 2 - speed[0] ** 2) / self.duration
        values |= {"flywheel_w": float(gained), "harvest_w": float(values["generated_w"] + gained)}
        return {**values, "flywheel_max": float(speed.max())}


def cut(plant: Plant, sea: SeaState, seed: int, duration: float) -> Cut:
    """Cut a window out of a realisation: the first `duration` after the lead-in.

    Parameters
    ----------
    plant : Plant
        The device.
    sea : SeaState
        The sea.
    seed : int
        Of the realisation.
    duration : float
        Length of the window. [s]

    Raises
    ------
    InputError
        Field ``duration``: too short to judge lock, or longer than can be planned. Field ``hs``: where a cautious
        constant pair does not keep the lock in the lead-in.
    """
    if not 2.0 * WINDOW <= duration <= 1000.0:
        mend = "Give seconds, for example 200; several windows need several seeds"
        raise InputError("duration", duration, "a window is from 20 to 1000 s long", mend)
    whole = lead_in(realise(plant, sea, seed, LEAD + duration + AHEAD), SETTINGS)
    start, at = _led_in(plant, whole), round(LEAD / whole.dt)
    grid = whole.grid._replace(duration=duration + AHEAD, n=whole.grid.n - at)
    moments = np.ascontiguousarray(whole.moments[:, at:])
    waves = dataclasses.replace(whole, grid=grid, moments=moments, elevation=whole.elevation[at:])
    return Cut(plant, waves, start, duration, whole.sha256)


def _led_in(plant: Plant, whole: WaveRealisation) -> NDArray[np.float64]:
    """State at the end of the lead-in, under the first cautious pair that keeps the lock."""
    for cc, cg in CAUTIOUS:
        record, _ = run_law(plant, law("constant", cc=cc, cg=cg), whole, SETTINGS)
        first = round(LEAD / record.period)
        if _metrics(plant, _begin(record, first), whole)["locked"]:
            return record.states[first, : len(plant.labels)].copy()
    problem = f"no constant pair keeps the lock through the lead-in of seed {whole.seed}"
    raise InputError("hs", whole.sea.hs, problem, "Choose another seed, or a higher Hs")


def _begin(record: Record, n: int) -> Record:
    """First n samples of a run."""
    moved = None if record.moved is None else record.moved[:n]
    return Record(record.states[: n + 1], record.commands[:n], record.controls[:n], record.period, 0, moved)


def _metrics(plant: Plant, record: Record, waves: WaveRealisation) -> dict[str, float]:
    return evaluate(plant, record, waves.moments[1], waves.dt, waves.sea.wp, 0.0, np.nan)
