"""A window cut out of a sea: waves, the state in which it begins, and what a run through it is worth.

Every run of a window, planned or by a law, begins in the same state, in full irregular waves: the device is led in from
the locked start by a cautious constant pair. All that follows is counted, the change of stored energy included.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.froude import at_length
from gyroctl.harness.actuation import Actuators
from gyroctl.harness.laws import law
from gyroctl.harness.protocol import Law
from gyroctl.harness.run import Settings, lead_in, run_law
from gyroctl.plant import Plant
from gyroctl.plant.equations import OMEGA_RATE, PHI1
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

LAG = 0.02
"""Lag of the coupling where the plant is more than the linear model, unless another one is asked for, at the size of
Table 1. [s]"""

LENGTHS = (2.0 * WINDOW, 1000.0)
"""Shortest window, to judge lock, and longest, to plan, at the size of Table 1. [s]"""

LIMIT = 0.35
"""Limit of the 98 % motion of the linear plant, and the least of |phi1| beyond it. [rad]"""

LIMIT3 = 0.25
"""Limit of the 98 % of |phi3| where the plant is more than the linear model. [rad]"""

CAUTIOUS = ((0.104, 1.5e-4), (0.104, 5e-5), (0.052, 5e-5))
"""Controls of the lead-in, in the order in which they are tried. [Nms]"""


class Motion(NamedTuple):
    """Limits of the 98 % motion. [rad]"""

    phi1: float
    phi3: float

    def room(self, values: Mapping[str, float]) -> float:
        """What the metrics of a run leave of the limits, negative beyond them. [rad]"""
        return float(min(self.phi1 - values["phi1_p98"], self.phi3 - values["phi3_p98"]))


WITHIN = Motion(LIMIT, LIMIT)
"""Limits in the linear plant."""


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
        State at the start. [rad], [rad/s]
    duration : float
        What is counted. [s]
    sha256 : str
        Hash of the realisation that it was cut from.
    settings : Settings
        Steps, sensors, actuators.
    motion : Motion
        Limits of the motion, the same for all runs.
    """

    plant: Plant
    waves: WaveRealisation
    start: NDArray[np.float64]
    duration: float
    sha256: str
    settings: Settings = SETTINGS
    motion: Motion = WITHIN

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


def cut(
    plant: Plant, sea: SeaState, seed: int, duration: float, lag: float | None = None, motion: float | None = None
) -> Cut:
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
    lag : float, optional
        Time constant of the coupling; none in the linear plant, `LAG` beyond it. [s]
    motion : float, optional
        Limit of the 98 % of |phi1| and |phi3|. By default `LIMIT` in the linear plant. Beyond it the float surges with
        the waves whatever the law does: |phi1| is then limited to that of the lead-in's constant pair through the same
        window, or `LIMIT` where that is more, and |phi3| to `LIMIT3`. [rad]

    Raises
    ------
    InputError
        Field ``duration``: too short to judge lock, or longer than can be planned. Field ``hs``: where a cautious
        constant pair does not keep the lock in the lead-in. Field ``motion``: no angle that can be planned for.
    """
    check_duration(plant, duration)
    if motion is not None and not 0.1 <= motion <= 1.0:
        raise InputError("motion", motion, "a limit of motion is from 0.1 to 1 rad", "Leave it out for the default")
    linear = plant.coefficients.beyond is None
    settings = replace(SETTINGS, actuators=Actuators(cc_lag=lag_of(plant, lag)))
    whole = lead_in(realise(plant, sea, seed, LEAD + duration + AHEAD), settings)
    record = _led_in(plant, whole, settings)
    first = round(LEAD / record.period)
    start = record.states[first, : len(plant.labels)].copy()
    made = Cut(plant, whole.since(LEAD), start, duration, whole.sha256, settings)
    if motion is not None:
        return replace(made, motion=Motion(motion, motion))
    if linear:
        return made
    after = np.abs(record.states[first : first + made.intervals + 1, PHI1])
    return replace(made, motion=Motion(max(LIMIT, float(np.quantile(after, 0.98))), LIMIT3))


def lag_of(plant: Plant, lag: float | None) -> float:
    """Lag of the coupling in a window, see `cut`. [s]"""
    if lag is not None:
        return lag
    return 0.0 if plant.coefficients.beyond is None else LAG * plant.parameters.time_scale


def check_duration(plant: Plant, duration: float) -> None:
    """Refuse a window that is too short, or too long, for a device of this length."""
    low, high = at_length(LENGTHS, "s", plant.parameters.length_scale)
    if not low <= duration <= high:
        mend = (
            f"Give seconds, for example {200.0 * plant.parameters.time_scale:.3g}; several windows need several seeds"
        )
        raise InputError("duration", duration, f"a window is from {low:.4g} to {high:.4g} s long", mend)


def _led_in(plant: Plant, whole: WaveRealisation, settings: Settings) -> Record:
    """Run of the first cautious pair that keeps the lock through the lead-in."""
    for cc, cg in CAUTIOUS:
        record, _ = run_law(plant, law("constant", cc=cc, cg=cg), whole, settings)
        if _metrics(plant, _begin(record, round(LEAD / record.period)), whole)["locked"]:
            return record
    problem = f"no constant pair keeps the lock through the lead-in of seed {whole.seed}"
    raise InputError("hs", whole.sea.hs, problem, "Choose another seed, or a higher Hs")


def _begin(record: Record, n: int) -> Record:
    """First n samples of a run."""
    moved = None if record.moved is None else record.moved[:n]
    return Record(record.states[: n + 1], record.commands[:n], record.controls[:n], record.period, 0, moved, record.lag)


def _metrics(plant: Plant, record: Record, waves: WaveRealisation) -> dict[str, float]:
    return evaluate(plant, record, waves.moments[1], waves.dt, waves.sea.wp, 0.0, np.nan)
