"""Robustness of a lock beyond the linear: how hard it may be hit before it breaks, by plain simulation of the loop.

A law is first brought to its steady regime in a regular wave; that regime is then disturbed again and again. A run is
judged by the ring angle against the wave: lock *holds* where the ring comes back without losing or gaining a turn, and
it *returns* where the ring turns once per wave at the end, whatever happened before.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.harness.actuation import Actuators
from gyroctl.harness.law_entry import CompiledLaw, PythonLaw, compile_law, why_it_stopped
from gyroctl.harness.laws import law as registered_law
from gyroctl.harness.loop import Kernel, closed_loop, compiled_loop
from gyroctl.harness.protocol import Law
from gyroctl.harness.sensing import Sensors
from gyroctl.nested import like
from gyroctl.orbits.orbit import Orbit
from gyroctl.plant import Plant
from gyroctl.plant.equations import PSI
from gyroctl.plant.kernel import rows
from gyroctl.plant.measurement import CHANNELS
from gyroctl.waves import Regular
from gyroctl.waves.channels import transfers

WAVES_DT = 0.05
"""Grid of the moments at the size of Table 1: 40 samples per wave at 3.14 rad/s, interpolated to 4e-10. [s]"""

SETTLING = 200
"""Waves in which a law finds its regime."""

WATCHED = 20
"""Waves at the end of a run over which lock is judged."""


@dataclass(frozen=True)
class Regime:
    """A law in lock with a regular wave, frozen at one instant.

    Parameters
    ----------
    plant, wave, law
        Device, regular wave, law.
    x : (n,) array
        State of the plant.
    phase : float
        Phase of the wave at that instant. [rad]
    law_state : object
        State of the law: its flat array where it is compiled.
    held : pair of float
        Controls that act. [Nms]
    angle : float
        Mean of the ring angle less the phase of the wave. [rad]
    power : float
        Mean electrical power over the last waves. [W]
    sense : {1, -1}
        Sense of rotation.
    """

    plant: Plant
    wave: Regular
    law: Law
    x: NDArray[np.float64]
    phase: float
    law_state: Any
    held: tuple[float, float]
    angle: float
    power: float
    sense: int
    actuators: Actuators
    machine: CompiledLaw | None

    @property
    def period(self) -> float:
        """Wave period. [s]"""
        return 2.0 * math.pi / self.wave.wp


class Outcome(NamedTuple):
    """What became of disturbed runs, arrays of bool (m,)."""

    holds: NDArray[np.bool_]
    returns: NDArray[np.bool_]


Excite = Callable[[NDArray[np.float64]], tuple[NDArray[np.float64], NDArray[np.float64]]]
"""Time (n,) [s] to signals (channels, n) [Nm, m/s], see `Plant.channels`, and phase of the wave (n,) [rad]."""


def settle(orbit: Orbit, wave: Regular, law: Law | None = None, actuators: Actuators | None = None) -> Regime:
    """Bring a law to its regime in a regular wave, with ideal sensors.

    Parameters
    ----------
    orbit : Orbit
        Where it starts.
    wave : Regular
        The wave of the orbit.
    law : Law, optional
        By default the constant controls of the orbit.
    actuators : Actuators, optional
        Between law and plant; by default those of the device's length, with room for the controls of the orbit.

    Raises
    ------
    InputError
        Where there is no orbit, or the law does not keep the lock.
    """
    if orbit.status == "no orbit":
        raise InputError("height", wave.height, "no locked orbit to start from", orbit.advice)
    law = law or registered_law("constant", device=orbit.plant, cc=orbit.cc, cg=orbit.cg)
    actuators = actuators or _roomy(orbit)
    machine = compile_law(law)
    state = machine.s.copy() if machine is not None else law.init()
    first = Regime(
        orbit.plant, wave, law, orbit.x, 0.0, state, (orbit.cc, orbit.cg), 0.0, 0.0, orbit.sense, actuators, machine
    )
    run = simulate(first, orbit.x, SETTLING)
    lag = _lag(first, run)
    watched = lag[-round(WATCHED * first.period / actuators.period) :]
    if not (np.all(np.isfinite(lag)) and np.ptp(watched) < math.pi and np.ptp(lag) < 2.0 * math.pi):
        problem = "does not keep the lock in this regular wave, so it has no margins"
        raise InputError("law", type(law).__name__, problem, "Choose another law, a higher wave or less load")
    n, span = orbit.x.size, watched.size
    power = float(run.record[-1, n + 4] - run.record[-1 - span, n + 4]) / (span * actuators.period)
    x = run.record[-1, :n].copy()
    phase = wave.wp * (run.record.shape[0] - 1) * actuators.period
    turns = orbit.sense * 2.0 * math.pi * math.floor(phase / (2.0 * math.pi))
    x[PSI] -= turns
    return replace(
        first,
        x=x,
        phase=phase % (2.0 * math.pi),
        law_state=run.law_state,
        held=run.held,
        angle=float(np.mean(watched)),
        power=power,
    )


class Run(NamedTuple):
    """One run: record (n + 1, rows) of state and ledger, phase of the wave (n + 1,), and where the loop ended."""

    record: NDArray[np.float64]
    phase: NDArray[np.float64]
    law_state: Any
    held: tuple[float, float]


def simulate(
    regime: Regime, start: NDArray[np.float64], periods: float, excite: Excite | None = None, law: Law | None = None
) -> Run:
    """Run the loop on from a regime.

    Parameters
    ----------
    regime : Regime
        Law state, controls and phase of the wave at the beginning.
    start : (n,) array
        State of the plant.
    periods : float
        Length in periods of the regime's wave.
    excite : callable, optional
        Other signals than those of the regime's wave, see `Excite`.
    law : Law, optional
        A law that stands before the regime's own, with the same state; run as plain Python.
    """
    tick = regime.actuators.period
    samples = math.ceil(periods * regime.period / tick)
    pace = regime.plant.parameters.time_scale
    dt = WAVES_DT * pace
    time: NDArray[np.float64] = np.arange(math.ceil(samples * tick / dt) + 9, dtype=np.float64) * dt
    moments, phase = (excite or steady(regime))(time)
    record = np.zeros((samples + 1, rows(regime.plant.coefficients)))
    record[0, : start.size] = start
    commands, controls, held = np.zeros((samples, 2)), np.zeros((samples, 2)), np.array(regime.held)
    moved = regime.actuators.room(samples)
    signals = np.ascontiguousarray(moments.T).ravel()
    kernel = Kernel(regime.plant.coefficients, signals, dt, regime.plant.step, None, pace)
    every, sensors, limits = max(round(regime.law.period / tick), 1), _ideal(samples), regime.actuators.arrays()
    saturations, seen = np.zeros(1, np.int64), np.zeros(len(CHANNELS))
    arguments = (every, kernel, sensors, limits, tick, record, commands, controls, moved, held, saturations, seen)
    state: Any
    if regime.machine is not None and law is None:
        state = regime.law_state.copy()
        bad = compiled_loop(regime.machine.entry, regime.machine.p, state, *arguments)
        if bad >= 0:
            raise why_it_stopped(regime.law, "law", bad * tick, seen, state)
    else:
        python, nothing = PythonLaw(law or regime.law, "law"), np.zeros(1)
        python.state = _unpacked(regime)
        closed_loop(python, nothing, nothing, *arguments)
        state = python.state
    at = np.interp(np.arange(samples + 1) * tick, time, phase)
    return Run(record, at, state, (float(held[0]), float(held[1])))


def steady(regime: Regime) -> Excite:
    """Return the signals of the regime's own wave."""
    wave = regime.wave
    amplitude = 0.5 * wave.height * transfers(regime.plant, np.array([wave.wp]), wave.heading)[:, 0]

    def excite(time: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        phase = regime.phase + wave.wp * time
        return np.real(amplitude[:, None] * np.exp(1j * phase)), phase

    return excite


def remembered(excite: Excite) -> Excite:
    """Return the same signals, worked out once for each number of instants: disturbed runs ask for the same ones."""
    known: dict[int, tuple[NDArray[np.float64], NDArray[np.float64]]] = {}

    def again(time: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        if time.size not in known:
            known[time.size] = excite(time)
        return known[time.size]

    return again


def judge(regime: Regime, starts: NDArray[np.float64], periods: float = 100.0) -> Outcome:
    """Say for each start (m, n) whether lock holds and whether it returns within `periods` waves."""
    excite = remembered(steady(regime))
    verdicts = [verdict(regime, simulate(regime, start, periods, excite)) for start in starts]
    return Outcome(np.array([v[0] for v in verdicts], bool), np.array([v[1] for v in verdicts], bool))


def verdict(regime: Regime, run: Run) -> tuple[bool, bool]:
    """Say whether lock held (no turn lost) and whether the ring turns once per wave at the end."""
    lag = _lag(regime, run)[-round(WATCHED * regime.period / regime.actuators.period) :]
    if not np.all(np.isfinite(lag)):
        return False, False
    locked = bool(np.ptp(lag) < math.pi)
    return locked and abs(float(np.mean(lag)) - regime.angle) < math.pi, locked


def _roomy(orbit: Orbit) -> Actuators:
    """Actuators of the device's length, whose limits leave room for the controls of an orbit."""
    usual = Actuators().at(orbit.plant.parameters.length_scale)
    return replace(usual, cg_max=max(usual.cg_max, 2.0 * orbit.cg), cc_max=max(usual.cc_max, orbit.cc))


def _lag(regime: Regime, run: Run) -> NDArray[np.float64]:
    return np.asarray(regime.sense * run.record[:, PSI] - run.phase)


@lru_cache(maxsize=1)
def _ideal(samples: int) -> Any:
    """Arrays of ideal sensors; drawn once per length, since every disturbed run asks for the same."""
    return Sensors.ideal().arrays(samples, 0)


def _unpacked(regime: Regime) -> Any:
    """State of the law as its own type."""
    if regime.machine is None:
        return regime.law_state
    return like(regime.law.init(), regime.law_state.tolist())
