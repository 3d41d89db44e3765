"""One law on one realisation: set up, run the loop, record."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.devices.identity import device_record
from gyroctl.errors import InputError, check_kind
from gyroctl.faces.settings import settings_face
from gyroctl.faces.show import shown
from gyroctl.froude import growth
from gyroctl.harness.actuation import Actuators
from gyroctl.harness.arguments import check_plant, law_of
from gyroctl.harness.law_entry import CompiledLaw, PythonLaw, compile_law, last_state, why_it_stopped
from gyroctl.harness.loop import Kernel, closed_loop, compiled_calls, compiled_loop
from gyroctl.harness.protocol import Counting, Law, Machined, Motoring
from gyroctl.harness.registry import describe
from gyroctl.harness.run_size import DT, run_size
from gyroctl.harness.sensing import Sensors
from gyroctl.harness.sight import informed, sight
from gyroctl.harness.start import STARTS, locked_start, rest_start
from gyroctl.plant import Plant
from gyroctl.plant.kernel import rows
from gyroctl.plant.measurement import CHANNELS
from gyroctl.provenance import provenance
from gyroctl.simulation.ensemble import check_step
from gyroctl.simulation.metrics import Record
from gyroctl.simulation.trajectory import trajectory
from gyroctl.simulation.validity import validity
from gyroctl.waves import WaveRealisation
from gyroctl.waves.checks import DURATION_MAX, positive, within
from gyroctl.writing import plain

if TYPE_CHECKING:
    from gyroctl.simulation.labelled import Trajectory


@shown(settings_face)
@dataclass(frozen=True)
class Settings:
    """How runs are made, common to all laws of a comparison.

    Parameters
    ----------
    dt : float
        Longest Runge-Kutta step. [s]
    blend : float
        Length of the blend from the regular wave at the start; scoring begins after it. [s]
    sensors : Sensors
        Between plant and law.
    actuators : Actuators
        Between law and plant.
    start : {"locked", "rest"}
        On the locked orbit of the equivalent regular wave, with the blend; or at rest in the irregular sea, where the
        scoring begins at once.

    Raises
    ------
    InputError
        For an unknown start, or a value out of its bounds.
    """

    dt: float = 0.01
    blend: float = 100.0
    sensors: Sensors = field(default_factory=Sensors)
    actuators: Actuators = field(default_factory=Actuators)
    start: str = "locked"

    def __post_init__(self) -> None:
        if self.start not in STARTS:
            raise InputError("run.start", self.start, "unknown start", f"Choose one of {', '.join(STARTS)}")
        positive("run.dt", self.dt, "Give the longest step in seconds, for example 0.01")
        within("run.dt", self.dt, *DT, "Give the longest step in seconds, for example 0.01")
        within("run.blend", self.blend, 0.0, DURATION_MAX, "Give its length in seconds, 0 for none, for example 100")
        check_kind("sensors", self.sensors, Sensors, "sensors", "Give gyroctl.Sensors(), or leave it out")
        check_kind("actuators", self.actuators, Actuators, "actuators", "Give gyroctl.Actuators(), or leave it out")

    def at(self, length: float) -> Settings:
        """Return what serves a device that is `length` times as long, in that device's units by Froude's law."""
        if length == 1.0:
            return self
        time = growth("s", length)
        sensors, actuators = self.sensors.at(length), self.actuators.at(length)
        return replace(self, dt=self.dt * time, blend=self.blend * time, sensors=sensors, actuators=actuators)

    @property
    def score_from(self) -> float:
        """Start of the scoring: the end of the blend, or the beginning where there is none. [s]"""
        return self.blend if self.start == "locked" else 0.0


@dataclass(frozen=True)
class LawTiming:
    """Time that one sample of the law took [ms], and what the law counted while it ran.

    A law may have a method ``counters(state) -> dict``, asked once with its last state: deadline_misses, fallbacks,
    clamped, or counts of its own.
    """

    median: float
    p99: float
    counters: Mapping[str, int] = field(default_factory=dict)


def run_law(
    plant: Plant,
    law: Law,
    waves: WaveRealisation,
    settings: Settings,
    name: str = "law",
    compiled: bool = True,
    start: NDArray[np.float64] | None = None,
    time_limit: float = math.inf,
    progress: Callable[[], None] | None = None,
) -> tuple[Record, LawTiming]:
    """Run a law on a realisation.

    Parameters
    ----------
    plant : Plant
        The device.
    law : Law
        The law.
    waves : WaveRealisation
        As it acts on the plant: blended already where a blend is wanted.
    settings : Settings
        Steps, sensors, actuators.
    name : str
        For messages.
    compiled : bool
        Compile the law where that is possible; the results are the same to the last bit, for laws that write whole
        powers as products.
    start : (n,) array, optional
        State at t = 0; by default as the settings say.
    time_limit : float
        Time that a law which runs as plain Python may take in all. [s]
    progress : callable, optional
        Called at each sample of a law that runs as plain Python; a compiled one is done before it could tell.

    Raises
    ------
    InputError
        For a period that does not fit the actuators', or an unstable step.
    LawError
        Where the law fails: it raises, ends the program, takes too long, or returns something else than two finite
        numbers and a state.
    """
    actuators = settings.actuators
    every = checked_run(plant, law, waves, settings, name)
    n, samples = len(plant.labels), math.floor(waves.duration / actuators.period + 1e-9)
    states = np.zeros((samples + 1, rows(plant.coefficients)))
    first, controls_before = beginning(plant, waves, settings)
    states[0, :n] = first if start is None else start
    commands, controls, moved = np.zeros((samples, 2)), np.zeros((samples, 2)), actuators.room(samples)
    held, saturations = np.array(controls_before), np.zeros(1, np.int64)
    signals, wetted = np.ascontiguousarray(waves.signals(plant).T).ravel(), waves.held(plant)
    kernel = Kernel(plant.coefficients, signals, waves.dt, settings.dt, wetted, plant.parameters.time_scale)
    law, shutter = informed(law, waves, plant)
    machine = compile_law(law) if compiled else None
    arguments = (
        every,
        kernel,
        settings.sensors.arrays(samples, waves.seed, actuators.period),
        actuators.arrays(isinstance(law, Motoring) and law.motors),
        actuators.period,
        states,
        commands,
        controls,
        moved,
        held,
        saturations,
        seen := np.zeros(len(CHANNELS)),
    )
    if machine is not None:
        state = machine.s.copy()
        bad = compiled_loop(machine.entry, machine.p, state, *arguments)
        if bad >= 0:
            raise why_it_stopped(law, name, bad * actuators.period, seen, state)
        last = last_state(law, state)
        timing = timing_of(law, machine, last)
    else:
        opening = shutter.open if shutter else None
        python, nothing = PythonLaw(law, name, limit=time_limit, opening=opening), np.zeros(1)
        closed_loop(_told(python, progress), nothing, nothing, *arguments)
        spent = np.array(python.seconds) * 1e3
        timing = LawTiming(float(np.median(spent)), float(np.quantile(spent, 0.99)))
        last = python.state
    if isinstance(law, Counting):
        timing = replace(timing, counters=dict(law.counters(last)))
    record = Record(states, commands, controls, actuators.period, int(saturations[0]), moved, float(actuators.cc_lag))
    return record, timing


def checked_run(plant: Plant, law: Law, waves: WaveRealisation, settings: Settings, name: str) -> int:
    """Refuse a run that is too large or of an unstable step; return the samples between two calls of the law.

    Raises
    ------
    InputError
        As `run_law`.
    """
    actuators = settings.actuators
    actuators.fit(plant.parameters.length_scale)
    run_size(waves.duration, settings.dt, actuators.period, plant.parameters.time_scale)
    every = ticks_of(law, name, actuators)
    largest = describe(law).get("cc", actuators.cc_max)  # a law that fixes cc, or else all that the actuator can give
    check_step(plant, min(float(largest), actuators.cc_max), settings.dt)
    if actuators.moves or actuators.delay > 0:  # the coupling of the start acts for a while
        check_step(plant, beginning(plant, waves, settings)[1][0], settings.dt)
    return every


def beginning(
    plant: Plant, waves: WaveRealisation, settings: Settings
) -> tuple[NDArray[np.float64], tuple[float, float]]:
    """State (n,) at t = 0 and the controls before it [Nms], as the settings say."""
    if settings.start == "rest":
        return rest_start(plant, waves.seed), (0.0, 0.0)
    return locked_start(plant, waves.sea)


def ticks_of(law: Law, name: str, actuators: Actuators) -> int:
    """Samples of the actuators between two of the law.

    Raises
    ------
    InputError
        For a period of the law that is no multiple of the actuators'.
    """
    every = round(law.period / actuators.period) if math.isfinite(law.period) else 0
    if every < 1 or not math.isclose(every * actuators.period, law.period, rel_tol=1e-9):
        raise InputError(
            f"laws.{name}.period",
            law.period,
            f"must be a multiple of actuators.period = {actuators.period}",
            "Change one of the two",
        )
    return every


def simulate(
    plant: Plant,
    law: Law | str,
    waves: WaveRealisation,
    settings: Settings | None = None,
    name: str = "law",
    compiled: bool = True,
    progress: Callable[[], None] | None = None,
) -> Trajectory:
    """Run a law on a realisation and label the result.

    Parameters
    ----------
    plant : Plant
        The device.
    law : Law or str
        The law, e.g. ``gy.law("constant", cc=0.052, cg=3.5e-4)``, or the name of a registered one.
    waves : WaveRealisation
        The sea, from `realise`; the start is blended in here unless that was done already.
    settings : Settings, optional
        Steps, blend, sensors, actuators; by default those of `Settings` in the units of the device, see `Settings.at`.
    name : str
        Kept in the result.
    compiled : bool
        Compile the law where possible.
    progress : callable, optional
        Called at each sample of a law that runs as plain Python.

    Returns
    -------
    Trajectory
        An `xarray.Dataset` with a short repr and ``.plot(begin, end)``, see `gyroctl.simulation.trajectory`; its
        attribute ``validity`` is the card of `gyroctl.simulation.validity`.

    Raises
    ------
    InputError
        For an argument that is not what it should be, and whatever a run refuses.
    LawError
        Where the law breaks the protocol.
    """
    check_plant(plant)
    settings = checked_settings(settings, plant)
    name = law if isinstance(law, str) and name == "law" else name
    built = law_of(law)
    check_kind("waves", waves, WaveRealisation, "a realisation", "Give gyroctl.realise(plant, sea, seed)")
    acting = lead_in(waves, settings)
    record, timing = run_law(plant, built, acting, settings, name, compiled, progress=progress)
    time_out = np.arange(record.states.shape[0]) * record.period
    signals = {
        "elevation": np.interp(time_out, waves.time, acting.elevation),
        "Me1": np.interp(time_out, waves.time, acting.moments[0]),
        "Me3": np.interp(time_out, waves.time, acting.moments[1]),
    }
    attributes: dict[str, Any] = {
        "law": name,
        "information": sight(built).level,
        "preview": sight(built).preview,
        "parameters": describe(built),
        "seed": waves.seed,
        "sha256": acting.sha256,
        "blend": acting.blend,
        "dt": settings.dt,
        "plant": plant.name,
        "device": json.dumps(device_record(plant)),
        "wp": waves.sea.wp,
        "hs": waves.sea.hs,
        "saturations": record.saturations,
        "step_ms_median": timing.median,
        "start": settings.start,
        "validity": plain(validity(plant, record, acting, settings.score_from, settings.start == "rest")),
        **provenance(),
    }
    return trajectory(plant, record, signals, attributes)


def checked_settings(settings: Settings | None, plant: Plant) -> Settings:
    """Return the settings, the default ones in the units of the device where there are none."""
    settings = Settings().at(plant.parameters.length_scale) if settings is None else settings
    check_kind("settings", settings, Settings, "settings", "Give gyroctl.Settings(...), or leave it out")
    return settings


def _told(entry: Callable[..., None], progress: Callable[[], None] | None) -> Callable[..., None]:
    """Entry of a law that also tells that it was called."""
    if progress is None:
        return entry

    def told(*arguments: Any) -> None:
        entry(*arguments)
        progress()

    return told


def lead_in(waves: WaveRealisation, settings: Settings) -> WaveRealisation:
    """Blend the start of a realisation in from the regular wave, unless it has been done or is not wanted."""
    if waves.blend > 0.0 or settings.blend == 0.0 or settings.start == "rest":
        return waves
    return waves.blended(settings.blend)


def timing_of(law: Law, machine: CompiledLaw, last: Any) -> LawTiming:
    """Times of a compiled law: as it noted them itself up to its `last` state, or by calls of it."""
    if isinstance(law, Machined):
        median, p99 = law.spent(last)
        return LawTiming(1e3 * median, 1e3 * p99)
    return time_compiled(machine)


def time_compiled(machine: CompiledLaw, calls: int = 2000) -> LawTiming:
    """Time a compiled law outside the loop, where a clock at every sample would cost more than the law."""
    y, u, s = np.zeros(len(CHANNELS)), np.zeros(2), machine.s.copy()
    y[1], y[2] = 3.14, 70.0
    compiled_calls(machine.entry, machine.p, s, y, u, 1)
    begin = time.perf_counter()
    compiled_calls(machine.entry, machine.p, s, y, u, calls)
    each = (time.perf_counter() - begin) / calls * 1e3
    return LawTiming(each, each)
