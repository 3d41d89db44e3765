"""A law that wraps any law: start from rest, unloading, re-lock, hand-over. See `rules` for what it does."""

from __future__ import annotations

from importlib.metadata import entry_points
from typing import Any, NamedTuple

from gyroctl.controllers.supervisor.rules import MODES, PULL, Rules, Watch, command, counted, first_watch, observe
from gyroctl.faces.law import law_face
from gyroctl.faces.show import shown
from gyroctl.plant.compiled import begun, stepped
from gyroctl.plant.measurement import CHANNELS
from gyroctl.plant.readings import Readings, believed, unread

GROUP = "gyroctl.controllers"
COUNTED = ("starts", "pulls", "catches", "unloads", "clipped", *(f"time_{mode}" for mode in MODES))
WATCHED = ("psi", "psi_rate", "omega_rate", "phi1_rate", "phi3_rate")
"""What the rules read of a measurement."""


class SupervisorState(NamedTuple):
    """What the supervisor remembers, the state of the law within, the last readings."""

    watch: Watch
    inner: Any
    seen: Readings


@shown(law_face)
class Supervisor(NamedTuple):
    """Start-up, unloading and re-lock around any law; build it with `wrap`. It compiles where the law within does."""

    rules: Rules  # what the supervisor goes by
    law: Any  # has the controls while the device is locked
    first: Any  # its state before the first sample, where it begins again: () for a law that does not compile
    period: float  # sampling period, that of the law within [s]

    @property
    def motors(self) -> bool:
        """Whether the law may use the generator as a motor."""
        return True

    @property
    def information(self) -> Any:
        """What the law within looks at; sensors at least."""
        return "sensors" if self.law.information == "none" else self.law.information

    @property
    def sensors(self) -> tuple[str, ...]:
        """Channels that its rules go by, and the law within: all of them where that does not say."""
        within = getattr(self.law, "sensors", CHANNELS)
        return tuple(name for name in CHANNELS if name in WATCHED or name in within)

    def init(self) -> SupervisorState:
        """Nothing seen yet."""
        return SupervisorState(first_watch(), begun(self.law, self.first), unread())

    def step(self, t: float, y: Any, state: SupervisorState) -> tuple[tuple[float, float], SupervisorState]:
        """Watch, decide on the mode, command."""
        good, seen = believed(self.period, self.rules.N, y, state.seen)
        watch, inner = observe(self.rules, self.period, good, state.watch), state.inner
        if watch.fresh > 0.0:
            inner = begun(self.law, self.first)
        cc, cg = 0.0, 0.0
        if watch.mode >= PULL:
            (cc, cg), inner = stepped(self.law, t, y, inner)
            watch = counted(watch, cg)
        return command(self.rules, good, watch, cc, cg), SupervisorState(watch, inner, seen)

    def informed(self, waves: Any) -> Supervisor:
        """Let the law within see the waves."""
        return wrap(self.law.informed(waves), self.rules)

    def counters(self, state: SupervisorState) -> dict[str, float]:
        """Counts from the state at the end of a run: those of the law within, where it counts, and of the modes."""
        counters = getattr(self.law, "counters", None)  # a law may have it or not
        counts: dict[str, float] = dict(counters(state.inner)) if counters else {}
        return counts | {name: float(getattr(state.watch, name)) for name in COUNTED}


def wrap(law: Any, rules: Rules | None = None) -> Supervisor:
    """Put a law under supervision.

    Parameters
    ----------
    law : Law
        Any law.
    rules : Rules, optional
        What the supervisor goes by.

    Raises
    ------
    ValueError
        For a rule out of range.
    """
    rules = rules or Rules()
    for name, value in rules._asdict().items():
        least = "positive" if name in ("window", "handover", "wp", "N") else "zero or positive"
        if not value >= 0.0 or (value == 0.0 and least == "positive"):
            raise ValueError(f"{name} = {value!r} must be {least}")
    return Supervisor(rules, law, law.init() if hasattr(law, "_fields") else (), float(law.period))


def supervisor(wraps: Any = "load_angle", rules: Rules = Rules()) -> Supervisor:
    """Wrap a law: start from rest with the generator as motor, unload and re-lock where lock is lost.

    Parameters
    ----------
    wraps : str or Law
        A registered law by its name, with its shipped tuning, or a law.
    rules : Rules
        What the supervisor goes by.

    Raises
    ------
    ValueError
        For an unknown law, or the supervisor itself.
    """
    if isinstance(wraps, str):  # laws know nothing of the harness: a table with parameters is built there
        points = {point.name: point for point in entry_points(group=GROUP)}
        if wraps not in points or wraps == "supervisor":
            known = ", ".join(sorted(set(points) - {"supervisor"}))
            raise ValueError(f"wraps = {wraps!r} is no law to wrap: choose one of {known}, or give a law")
        wraps = points[wraps].load()()
    if not hasattr(wraps, "period"):
        raise ValueError(f"wraps = {wraps!r} is no law to wrap: give its name, or a law")
    return wrap(wraps, rules)
