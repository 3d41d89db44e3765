"""What a law goes through in its check: shocks, missing samples, another step, and the clock."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.froude import growth
from gyroctl.harness.law_entry import compile_law
from gyroctl.harness.protocol import Law, LawError, Measurement
from gyroctl.harness.run import LawTiming, Settings, lead_in, run_law
from gyroctl.harness.sensing import Sensors
from gyroctl.plant import Plant
from gyroctl.plant.measurement import CHANNELS
from gyroctl.simulation.metrics import Record, evaluate
from gyroctl.waves import SeaState, WaveRealisation, realise

SEED, RUNS = 100200, 8
"""First seed, and realisations of the check of the step."""

SHORT, LONG = 150.0, 500.0
"""Lengths of the run of the law and of those of the check of the step, at the size of Table 1. [s]"""

BLEND = 50.0
"""Blend of the short runs, at the size of Table 1. [s]"""

STEPS = (0.01, 0.005)
"""Steps that are compared, at the size of Table 1. [s]"""

RATES = ("psi_rate", "omega_rate", "phi1_rate", "phi3_rate")

TOLERANCE, SIGMAS = 0.02, 3.0
"""The mean power may differ between the steps by 2 %, or by three standard errors of the paired differences."""


LONGEST = 300.0
"""What one part of a check may take; a law that is slower is measured, and not simulated in full. [s]"""

PACES = 20
"""Samples by which the pace of a law is told before it is simulated."""


class Check(NamedTuple):
    """One line of the table.

    Parameters
    ----------
    name : str
        What was checked.
    passed : bool
        Whether it holds.
    found : str
        What was seen.
    mend : str
        What to do, where it does not hold.
    """

    name: str
    passed: bool
    found: str
    mend: str = ""


class Ground(NamedTuple):
    """A device on which a law is tried, with the default sea and settings at its length."""

    plant: Plant

    @property
    def length(self) -> float:
        """Its length over that of Table 1. [-]"""
        return self.plant.parameters.length_scale

    @property
    def time(self) -> float:
        """Its unit of time over that of Table 1. [-]"""
        return self.plant.parameters.time_scale

    def settings(self, **changes: Any) -> Settings:
        """Return settings, told in the units of Table 1, in those of the device."""
        return Settings(**changes).at(self.length)

    def waves(self, seed: int, duration: float, settings: Settings) -> WaveRealisation:
        """Realise the default sea over a `duration` at the size of Table 1 [s], blended in."""
        sea = SeaState(SeaState.hs * self.length, SeaState.wp * growth("rad/s", self.length))
        return lead_in(realise(self.plant, sea, seed, duration * self.time), settings)


def seen(y: Measurement, time: float) -> Measurement:
    """Return what a device measures whose model at the size of Table 1 measures `y`: rates by its unit of time."""
    return y._replace(**{name: getattr(y, name) / time for name in RATES})


@dataclass(frozen=True)
class Subject:
    """A law with one run of it, the measurements that it saw, and the device's unit of time over that of Table 1."""

    law: Law
    waves: WaveRealisation
    record: Record
    timing: LawTiming
    measurements: tuple[Measurement, ...]
    time: float = 1.0

    def times(self) -> NDArray[np.float64]:
        """Times of its samples. [s]"""
        return np.arange(len(self.measurements), dtype=np.float64) * float(self.law.period)


TURNING = Measurement(0.0, 3.14, 65.0, 0.05, 0.05, 0.1, 0.1)
"""A device in lock, at the size of Table 1."""

SHOCKS: dict[str, tuple[Measurement, ...]] = {
    "all zero": (Measurement(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),) * 20,
    "standing ring": (Measurement(1.0, 0.0, 65.0, 0.1, 0.1, 0.2, -0.3),) * 50,
    "standing flywheel": (Measurement(1.0, 3.14, 0.0, 0.1, 0.1, 0.2, -0.3),) * 50,
    "turning backwards": (Measurement(-20.0, -3.14, -65.0, -0.1, 0.1, 0.2, 0.3),) * 50,
    "a frozen sensor": (Measurement(2.0, 3.0, 64.0, 0.2, -0.1, 0.5, 0.4),) * 200,
    "huge values": (Measurement(1e6, 1e4, 1e5, 1e3, -1e3, 1e4, -1e4),) * 5,
    "tiny values": (Measurement(1e-300, 1e-300, 1e-300, 1e-300, 1e-300, 1e-300, 1e-300),) * 5,
}
"""Measurements that a law must survive, at the size of Table 1."""


def shocks(subject: Subject) -> Check:
    """Check that measurements that no law expects leave no trace that is not finite."""
    mend = "Guard divisions, square roots and exponentials, and bound what the state adds up"
    calm = list(zip(subject.times(), subject.measurements, strict=True))[:100]
    for shock, of_model in SHOCKS.items():
        rows = [seen(y, subject.time) for y in of_model]
        state, built = subject.law.init(), subject.law
        for t, y in [*calm, *((calm[-1][0] + built.period * (1 + i), y) for i, y in enumerate(rows)), *calm]:
            try:
                command, state = built.step(float(t), y, state)
                numbers = [float(value) for value in (*command, *_numbers(state))]
            except Exception as error:
                return Check("shocks", False, f"{shock}: {type(error).__name__}: {error}", mend)
            if not all(math.isfinite(value) for value in numbers):
                return Check("shocks", False, f"{shock}: a command or the state is no longer finite", mend)
    return Check("shocks", True, f"finite under {', '.join(SHOCKS)}, and after them")


def _numbers(state: Any) -> list[float]:
    if isinstance(state, float | int) and not isinstance(state, bool):
        return [float(state)]
    if isinstance(state, np.ndarray) and np.issubdtype(state.dtype, np.number):
        return [float(value) for value in state.ravel()]
    if isinstance(state, tuple | list):
        return [number for part in state for number in _numbers(part)]
    return []


def dropout(ground: Ground, built: Law, name: str) -> Check:
    """Check a run in which three samples in ten of every sensor are missing."""
    holes = Sensors(*(replace(getattr(Sensors(), c), dropout=0.3) for c in CHANNELS))
    settings = ground.settings(blend=BLEND, sensors=holes)
    try:
        run_law(ground.plant, built, ground.waves(SEED + 1, SHORT, settings), settings, name)
    except LawError as error:
        return Check("dropout", False, str(error), "Expect the last measurement again where one is missing")
    return Check("dropout", True, "finite with three samples in ten missing")


def step_size(ground: Ground, built: Law, name: str, runs: int) -> Check:
    """Compare power and lock with those of half the step, on the same waves and with the same noise of the sensors."""
    powers, locked = [], []
    for dt in STEPS:
        settings = ground.settings(dt=dt)
        found = [_evaluated(ground, built, name, SEED + 2 + i, settings) for i in range(max(runs, 2))]
        powers.append(np.array([entry["mean_power"] for entry in found]))
        locked.append(np.array([entry["locked"] for entry in found]))
    off = powers[1] - powers[0]
    mean, error = float(abs(off.mean())), float(off.std(ddof=1) / math.sqrt(off.size))
    scale = float(max(abs(powers[0].mean()), 1e-6 * growth("W", ground.length)))
    flips = int(np.sum(locked[0] != locked[1]))
    lost = abs(int(locked[0].sum() - locked[1].sum()))
    coarse, fine = (dt * ground.time for dt in STEPS)
    text = f"step {coarse:.3g} to {fine:.3g} s: power {mean / scale:.2%} apart ({error / scale:.2%} standard error), "
    text += f"{flips} of {off.size} verdicts on lock change"
    passed = mean <= max(TOLERANCE * scale, SIGMAS * error) and lost <= max(1, off.size // 8)
    mend = "" if passed else "Its outcome hangs on the integration step: use a shorter run.dt for it"
    return Check("step size", passed, text, mend)


def _evaluated(ground: Ground, built: Law, name: str, seed: int, settings: Settings) -> dict[str, float]:
    waves = ground.waves(seed, LONG, settings)
    record, _ = run_law(ground.plant, built, waves, settings, name)
    return evaluate(ground.plant, record, waves.moments[1], waves.dt, waves.sea.wp, settings.blend, np.nan)


def pace(built: Law, time_scale: float = 1.0) -> float:
    """Time that a sample of a law takes as plain Python, the median of a few; none where it stops. [s]

    `time_scale` is the unit of time of the device over that of Table 1. [-]
    """
    y, state, spent = seen(TURNING, time_scale), built.init(), [0.0]
    for sample in range(PACES):
        begin = time.perf_counter()
        try:
            _, state = built.step(sample * built.period, y._replace(psi=y.psi_rate * sample * built.period), state)
        except Exception:  # the run that follows says what it is
            break
        spent.append(time.perf_counter() - begin)
        if sum(spent) > LONGEST:
            break
    return float(np.median(spent[1:] or spent))


def too_slow(each: float, period: float) -> Check:
    """Say that a law is too slow to be run here."""
    found = f"{_duration(1e3 * each)} a sample, of {1e3 * period:g} ms; it was not simulated"
    return Check("cost", False, found, "Sample less often, or compute less in step")


def cost(subject: Subject) -> Check:
    """Check that a sample is computed within the sampling period."""
    median, p99 = subject.timing.median, subject.timing.p99
    if compile_law(subject.law) is None:
        spent = _clocked(subject)
        median, p99 = float(np.median(spent)), float(np.quantile(spent, 0.99))
    fits = p99 < 1e3 * subject.law.period
    found = f"{_duration(median)} a sample, p99 {_duration(p99)}, of {1e3 * subject.law.period:g} ms"
    return Check("cost", fits, found, "" if fits else "Sample less often, or compute less in step")


def _clocked(subject: Subject, clock: Callable[[], float] = time.perf_counter) -> Sequence[float]:
    state, spent = subject.law.init(), []
    for t, y in zip(subject.times(), subject.measurements, strict=True):
        begin = clock()
        _, state = subject.law.step(float(t), y, state)
        spent.append(1e3 * (clock() - begin))
    return spent


def _duration(ms: float) -> str:
    return f"{1e3 * ms:.2g} us" if ms < 1.0 else f"{ms:.3g} ms"
