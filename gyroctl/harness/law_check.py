"""Whether a law keeps the protocol: what it returns, how it behaves under shocks, what a sample costs, in one table.

Each check says what it found and, where it failed, the mend. The runs are on tuning seeds: looking at a law is part of
designing it.
"""

from __future__ import annotations

import copy
import inspect
import math
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.harness.arguments import law_of
from gyroctl.harness.code_files import is_file, parted
from gyroctl.harness.law_entry import NotCompiled, compiled, line_of
from gyroctl.harness.law_trials import (
    BLEND,
    LONG,
    LONGEST,
    RUNS,
    SEED,
    SHORT,
    TURNING,
    Check,
    Ground,
    Subject,
    cost,
    dropout,
    pace,
    seen,
    shocks,
    step_size,
    too_slow,
)
from gyroctl.harness.laws import law
from gyroctl.harness.protocol import Law, LawError, Measurement, Previewing, innermost
from gyroctl.harness.registry import defined
from gyroctl.harness.run import Settings, run_law
from gyroctl.harness.sensing import measure
from gyroctl.harness.sight import informed, sight
from gyroctl.nested import leaves
from gyroctl.plant import Plant
from gyroctl.plant.given import check_plant
from gyroctl.plant.measurement import CHANNELS
from gyroctl.simulation.metrics import Record

LINES = 9
"""Steps of a check that take time: the run, and what is looked at after it."""


def check_law(name: str | Law, plant: Plant, runs: int = RUNS, tick: Callable[[], None] = lambda: None) -> list[Check]:
    """Check a law.

    Parameters
    ----------
    name : str or Law
        A law, its registered name, or "file.py:Name".
    plant : Plant
        The device it is run on; on one of another length than that of Table 1 a name stands for the law in the units
        of its model.
    runs : int
        Realisations of the check of the step, two at least.
    tick : callable
        Called after each of the `LINES` checks.

    Returns
    -------
    list of Check
        A failure of the law to build or to answer ends the list.

    Raises
    ------
    InputError
        For a file or law that does not exist.
    """
    check_plant(plant)
    if not isinstance(name, str):
        return _checked(law_of(name), type(name).__name__, plant, runs, tick)
    if is_file(name) and not Path(parted(name)[0]).is_file():
        law(name)  # says what is wrong
    try:
        built = law(name, device=None if plant.parameters.length_scale == 1.0 else plant)
    except InputError as error:
        return [Check("builds", False, f"{error.field}: {error.problem}", error.mend)]
    return _checked(built, name, plant, runs, tick)


def _checked(built: Law, name: str, plant: Plant, runs: int, tick: Callable[[], None]) -> list[Check]:
    """Check a law that is built."""
    checks = [Check("builds", True, type(built).__name__), _information(built)]
    ground = Ground(plant)
    settings = ground.settings(blend=BLEND)
    period = _period(built, settings)
    checks.append(period)
    waves = ground.waves(SEED, SHORT, settings)
    knowing, shutter = informed(built, waves, plant)
    if shutter is not None:
        shutter.open(waves.duration)  # what is run again outside the loop finds its window open
    answers = shape(knowing, ground.time)
    checks.append(answers)
    if not (period.passed and answers.passed):
        return checks
    each = pace(knowing, ground.time)
    if each * SHORT * ground.time / built.period > LONGEST:
        return [*checks, too_slow(each, built.period)]
    try:
        record, timing = run_law(plant, built, waves, settings, name)
    except (LawError, InputError) as error:
        return [*checks, Check("runs", False, str(error), "Correct its step")]
    tick()
    measurements = _seen(record, settings, waves.seed, built.period)
    subject = Subject(knowing, waves, record, timing, measurements, ground.time)
    whole = each * 2 * runs * LONG * ground.time / built.period  # what the check of the step would take [s]
    left = f"left out: its {2 * runs} runs would take {whole / 60.0:.0f} min at {1e3 * each:.3g} ms a sample"
    lines: tuple[Callable[[], Check], ...] = (
        lambda: _bounds(record, settings),
        lambda: pure(subject),
        lambda: repeats(subject),
        lambda: _compiled(subject),
        lambda: shocks(subject),
        lambda: dropout(ground, built, name),
        lambda: Check("step size", True, left) if whole > LONGEST else step_size(ground, built, name, runs),
        lambda: cost(subject),
    )
    for line in lines:
        checks.append(line())
        tick()
    return checks


def laws_of(file: Path) -> list[str]:
    """Names "file.py:Name" of the laws that a file defines.

    Raises
    ------
    InputError
        For a file that does not exist or defines no law.
    """
    names = [name for name, value in defined(file).items() if inspect.isclass(value) and _looks_like_a_law(value)]
    if not names:
        raise InputError(
            "law",
            str(file),
            "defines no class with init() and step(t, y, state)",
            "Name the function that builds the law, as file.py:Name",
        )
    return [f"{file}:{name}" for name in names]


def _looks_like_a_law(value: Any) -> bool:
    return callable(getattr(value, "init", None)) and callable(getattr(value, "step", None))


def _seen(record: Record, settings: Settings, seed: int, period: float) -> tuple[Measurement, ...]:
    """Measurements that the law got in a run, sample by sample."""
    sensors = settings.sensors.arrays(record.commands.shape[0], seed, record.period)
    every, y, rows = round(period / record.period), np.zeros(len(CHANNELS)), []
    for sample in range(record.commands.shape[0]):
        measure(sensors, sample, record.states, y)
        if sample % every == 0:
            rows.append(Measurement(*y.tolist()))
    return tuple(rows)


def _information(built: Law) -> Check:
    previews = isinstance(innermost(built), Previewing)
    if previews == (built.information in ("gauge", "forecast", "oracle")):
        seen = sight(built)
        judged = "" if seen.level == built.information else f", judged as {seen.level}: its preview covers its plan"
        ahead = f", {seen.preview:g} s ahead" if previews and math.isfinite(seen.preview) else ""
        return Check("information", True, f"{built.information}{ahead}{judged}")
    if previews:
        return Check(
            "information",
            False,
            f"says {built.information!r} but takes the waves by informed()",
            'Declare "gauge", "forecast" or "oracle"',
        )
    return Check(
        "information",
        False,
        f"says {built.information!r} but has no informed(waves)",
        'Declare "sensors", or write informed(waves) -> law',
    )


def _period(built: Law, settings: Settings) -> Check:
    tick = settings.actuators.period
    every = built.period / tick
    fits = round(every) >= 1 and math.isclose(round(every), every, rel_tol=1e-9)
    mend = f"Give a multiple of {tick:g} s"
    return Check("period", fits, f"{built.period:g} s, {every:g} of the actuators'", "" if fits else mend)


def shape(built: Law, time: float = 1.0) -> Check:
    """Check that it answers with two numbers and a state of the kind that it began with.

    `time` is the unit of time of the device over that of Table 1. [-]
    """
    name, y = "answer", seen(TURNING, time)
    form = "Return ((cc, cg), state) with two numbers"
    try:
        state = built.init()
        for sample in range(3):
            answer = built.step(sample * built.period, y, state)
            command, new = answer
            cc, cg = command
            if not (math.isfinite(cc) and math.isfinite(cg)):
                return Check(name, False, f"({cc}, {cg}) is not finite", "Guard divisions and square roots")
            if type(new) is not type(state) or _length(new) != _length(state):
                found = f"state of type {type(new).__name__}, init() gives {type(state).__name__}"
                return Check(name, False, found, "Return the kind of state that init() gives")
            state = new
    except AttributeError as error:  # a name that is not there, and no answer of another form
        return Check(name, False, f"{type(error).__name__}: {error}", f"Correct its step, {line_of(error)}")
    except Exception as error:  # whatever a user's code can do
        return Check(name, False, f"{type(error).__name__}: {error}", form)
    return Check(name, True, f"(cc, cg) and a state of {_length(state)} numbers")


def _length(state: Any) -> int:
    return len(leaves(state))


def _bounds(record: Record, settings: Settings) -> Check:
    limits = settings.actuators
    outside = (record.commands < 0.0) | (record.commands > [limits.cc_max, limits.cg_max])
    low, high = record.commands.min(axis=0), record.commands.max(axis=0)
    found = f"cc {low[0]:.3g} to {high[0]:.3g}, cg {low[1]:.3g} to {high[1]:.3g} Nms"
    if not outside.any():
        return Check("bounds", True, found)
    which = " and ".join(n for i, n in enumerate(("cc", "cg")) if outside[:, i].any())
    mend = f"Keep {which} within 0 to {limits.cc_max:g} and {limits.cg_max:g} by min and max: the actuators saturate"
    return Check("bounds", False, f"{found}; {outside.any(axis=1).mean():.1%} of the samples outside", mend)


class Question(NamedTuple):
    """A law, and the measurements that it is asked about, sample by sample."""

    law: Law
    measurements: tuple[Measurement, ...]

    def times(self) -> NDArray[np.float64]:
        """Times of its samples. [s]"""
        return np.arange(len(self.measurements), dtype=np.float64) * float(self.law.period)


def _replay(subject: Subject | Question, built: Law) -> NDArray[np.float64]:
    state, commands = built.init(), []
    for t, y in zip(subject.times(), subject.measurements, strict=True):
        command, state = built.step(float(t), y, state)
        commands.append(command)
    return np.array(commands, float)


def pure(subject: Subject | Question) -> Check:
    """Nothing but the returned state may change: the state and the law that went in stay as they are."""
    built, name = subject.law, "pure step"
    mend = "Return a new state instead of changing the old one, and keep nothing on the law or in the module"
    state = built.init()
    try:
        before = copy.deepcopy(_fields(built))
        for t, y in list(zip(subject.times(), subject.measurements, strict=True))[:50]:
            kept = copy.deepcopy(state)
            first, new = built.step(float(t), y, state)
            if not _same(kept, state):
                return Check(name, False, f"changes the state it is given at t = {t:.1f} s", mend)
            again, other = built.step(float(t), y, kept)
            if tuple(first) != tuple(again) or not _same(new, other):
                return Check(name, False, f"answers differently to the same question at t = {t:.1f} s", mend)
            state = new
        changed = not _same(before, _fields(built))
    except (copy.Error, AttributeError, TypeError, ValueError, NotImplementedError):
        return Check(name, True, "same question, same answer (a law that cannot be copied: its fields not compared)")
    return Check(
        name,
        not changed,
        "changes its own fields" if changed else "same question, same answer",
        mend if changed else "",
    )


def _fields(built: Law) -> list[Any]:
    """Values that a law holds: those of its fields, or all that it keeps where it declares none."""
    if isinstance(built, tuple):
        return list(built)
    if is_dataclass(built):
        return [getattr(built, field.name) for field in fields(built)]
    return list(getattr(built, "__dict__", {}).values())


def _same(a: Any, b: Any) -> bool:
    """Whether two values are the same as far as plain data goes; what else a law holds is its own affair."""
    if isinstance(a, tuple | list):
        return type(a) is type(b) and len(a) == len(b) and all(_same(x, y) for x, y in zip(a, b, strict=True))
    if isinstance(a, dict):
        return isinstance(b, dict) and a.keys() == b.keys() and all(_same(a[key], b[key]) for key in a)
    if isinstance(a, float | int | np.number | np.ndarray):
        return bool(np.array_equal(a, b, equal_nan=np.asarray(a).dtype.kind in "fc"))
    return bool(a == b) if isinstance(a, str | bytes | bool | None) else type(a) is type(b)


def repeats(subject: Subject | Question) -> Check:
    """Check that the same measurements give the same commands again."""
    first, second = _replay(subject, subject.law), _replay(subject, subject.law)
    differ = np.flatnonzero(np.any(first != second, axis=1))
    if differ.size:
        t = float(subject.times()[differ[0]])
        return Check(
            "repeatable",
            False,
            f"a second run differs from t = {t:.1f} s on",
            "Keep everything in the state; use no random numbers and no clock",
        )
    return Check("repeatable", True, f"two runs of {len(first)} samples alike to the last bit")


def _compiled(subject: Subject) -> Check:
    name = "compiled"
    try:
        compiled(subject.law)
    except NotCompiled as error:
        return Check(name, True, f"runs as plain Python: {error}")
    every = round(subject.law.period / subject.record.period)
    commands = subject.record.commands[::every]
    differ = np.flatnonzero(np.any(_replay(subject, subject.law) != commands, axis=1))
    if differ.size:
        at = differ[0]
        return Check(
            name,
            False,
            f"Python and machine code differ from t = {subject.times()[at]:.1f} s on",
            "Leave out what numba reads in its own way: integer division and powers, overflow",
        )
    return Check(name, True, f"as Python to the last bit over {len(commands)} samples")
