"""A law that wraps any law: start from rest, unloading, re-lock, hand-over. See `rules` for what it does.

Around a law that compiles, the whole is one NamedTuple again: rules, wrapped law and its first state in a row; so it
compiles as well. Around any other law it is plain Python with the same rules.
"""

from __future__ import annotations

import inspect
from collections import namedtuple
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache
from importlib.metadata import entry_points
from typing import Any

from gyroctl.controllers.supervisor.rules import MODES, PULL, Rules, Watch, command, counted, first_watch, observe
from gyroctl.plant.compiled import inlined

GROUP = "gyroctl.controllers"
RULES, WATCH = len(Rules._fields), len(Watch._fields)


@dataclass(frozen=True)
class Supervisor:
    """Start-up, unloading and re-lock around any law, in plain Python.

    Parameters
    ----------
    law : Law
        The law that has the controls while the device is locked.
    rules : Rules
        What the supervisor goes by.
    """

    law: Any
    rules: Rules = field(default_factory=Rules)

    @property
    def motors(self) -> bool:
        """Whether the law may use the generator as a motor."""
        return True

    @property
    def period(self) -> float:
        """Sampling period, that of the wrapped law. [s]"""
        return float(self.law.period)

    @property
    def information(self) -> Any:
        """What the wrapped law looks at; sensors at least."""
        return _information(self.law)

    def init(self) -> tuple[Watch, Any]:
        """Nothing seen yet."""
        return first_watch(), self.law.init()

    def step(self, t: float, y: Any, state: tuple[Watch, Any]) -> tuple[tuple[float, float], tuple[Watch, Any]]:
        """Watch, decide on the mode, command."""
        watch, inner = state
        watch = observe(self.rules, self.period, y, watch)
        if watch.fresh > 0.0:
            inner = self.law.init()
        cc, cg = 0.0, 0.0
        if watch.mode >= PULL:
            (cc, cg), inner = self.law.step(t, y, inner)
            watch = counted(watch, cg)
        return command(self.rules, y, watch, cc, cg), (watch, inner)

    def informed(self, waves: Any) -> Supervisor:
        """Let the wrapped law see the waves."""
        return Supervisor(self.law.informed(waves), self.rules)

    def counters(self, state: tuple[Watch, Any]) -> dict[str, float]:
        """Counts from the state at the end of a run: those of the modes, and those of the wrapped law."""
        return _counters(self.law, state[1], state[0])


def wrap(law: Any, rules: Rules | None = None) -> Any:
    """Put a law under supervision.

    Parameters
    ----------
    law : Law
        Any law.
    rules : Rules, optional
        What the supervisor goes by.

    Returns
    -------
    Law
        One NamedTuple where the law is one and its state a tuple of floats, else a `Supervisor`.

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
    start, period = law.init(), float(law.period)
    if not (isinstance(law, tuple) and hasattr(law, "_fields") and _is_floats(start)):
        return Supervisor(law, rules)
    compose: Any = _composed
    return compose(type(law), type(start), len(law), len(start))(*rules, *law, *start, period)


def supervisor(wraps: Any = "load_angle", **rules: float) -> Any:
    """Wrap a law: start from rest with the generator as motor, unload and re-lock where lock is lost.

    Parameters
    ----------
    wraps : str or Law
        A registered law by its name, with its shipped tuning, or a law.
    **rules
        Fields of `Rules`.

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
    return wrap(wraps, Rules(**rules))


supervisor.__signature__ = inspect.Signature(
    [  # type: ignore[attr-defined]  # what may be given, for the check of names
        inspect.Parameter("wraps", inspect.Parameter.KEYWORD_ONLY, default="load_angle"),
        *(
            inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=value)
            for name, value in Rules._field_defaults.items()
        ),
    ]
)


@lru_cache(maxsize=256)
def _composed(law_type: type[Any], state_type: type[Any], fields: int, states: int) -> Any:
    """NamedTuple of rules, the fields of a law and its first state, with the members of a law."""
    inner_step = inlined(law_type.step)
    pack = inlined(_pack_plain) if state_type is tuple else _pack_named(state_type)
    end = RULES + fields

    def step(self: Any, t: float, y: Any, state: Any) -> Any:
        """Watch, decide on the mode, command."""
        rules, law = Rules(*self[:RULES]), law_type(*self[RULES:end])
        watch, inner = Watch(*state[:WATCH]), pack(state[WATCH:])
        watch = observe(rules, self.period, y, watch)
        if watch.fresh > 0.0:
            inner = pack(self[end:-1])
        cc, cg = 0.0, 0.0
        if watch.mode >= PULL:
            (cc, cg), inner = inner_step(law, t, y, inner)
            watch = counted(watch, cg)
        return command(rules, y, watch, cc, cg), state_kind(*(watch[:] + inner[:]))

    first = [f"first_{i}" for i in range(states)]
    make: Any = namedtuple  # its fields are those of another law each time: no type checker can follow
    state_kind = make(f"Supervised{state_type.__name__}", [*Watch._fields, *first])
    names = [*Rules._fields, *(f"law_{name}" for name in law_type._fields), *first]
    kind = make(f"Supervised{law_type.__name__}", [*names, "period"])
    kind.__doc__ = f"Start-up, unloading and re-lock around {law_type.__name__}."
    kind.wraps = (law_type,)
    kind.motors = True
    kind.law = property(lambda self: law_type(*self[RULES:end]))
    kind.information = property(lambda self: _information(self.law))
    kind.init = lambda self: state_kind(*first_watch(), *self[end:-1])
    kind.step = step
    kind.informed = lambda self, waves: wrap(self.law.informed(waves), Rules(*self[:RULES]))
    kind.counters = lambda self, state: _counters(self.law, pack(state[WATCH:]), Watch(*state[:WATCH]))
    kind.__reduce__ = lambda self: (wrap, (self.law, Rules(*self[:RULES])))
    return kind


def _pack_plain(values: Any) -> Any:
    return values


def _pack_named(state_type: type[Any]) -> Callable[[Any], Any]:
    def pack(values: Any) -> Any:
        return state_type(*values)

    return inlined(pack)


def _is_floats(value: Any) -> bool:
    return isinstance(value, tuple) and all(isinstance(v, float | int) and not isinstance(v, bool) for v in value)


def _information(law: Any) -> Any:
    return "sensors" if law.information == "none" else law.information


def _counters(law: Any, state: Any, watch: Watch) -> dict[str, float]:
    counts: dict[str, float] = dict(law.counters(state)) if hasattr(law, "counters") else {}
    counts |= {name: float(getattr(watch, name)) for name in ("starts", "pulls", "catches", "unloads", "clipped")}
    return counts | {f"time_{mode}": float(getattr(watch, f"time_{mode}")) for mode in MODES}
