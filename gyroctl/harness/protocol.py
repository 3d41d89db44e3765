"""What a law is: measurements in, commands out, state passed through."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, Protocol, runtime_checkable

from gyroctl.plant.measurement import Measurement as Measurement

Information = Literal["none", "sensors", "gauge", "forecast", "oracle"]
INFORMATION: tuple[Information, ...] = ("none", "sensors", "gauge", "forecast", "oracle")


@runtime_checkable
class Law(Protocol):
    """A semi-active law.

    Best written as a NamedTuple of floats whose `step` uses only arithmetic, `math` and `min`/`max`, with a NamedTuple
    of floats as its state: it is then compiled. Any other object with these members runs as plain Python, with the
    same results: to the last bit where whole powers are written as products, which machine code makes of them.

    Attributes
    ----------
    period : float
        Sampling period, a multiple of the actuators' period. [s]
    information : {"none", "sensors", "gauge", "forecast", "oracle"}
        What the law looks at; shown in every table.
    """

    @property
    def period(self) -> float:
        """Sampling period. [s]"""
        ...

    @property
    def information(self) -> Information:
        """What the law looks at."""
        ...

    def init(self) -> Any:
        """Return the state before the first sample: a NamedTuple of floats."""
        ...

    def step(self, t: float, y: Measurement, state: Any) -> tuple[tuple[float, float], Any]:
        """Return ((cc, cg) [Nms], new state) for time `t` [s], measurement `y` and state."""
        ...


@runtime_checkable
class Previewing(Protocol):
    """A law that is told of the waves, with the information "gauge", "forecast" or "oracle"."""

    def informed(self, waves: Any) -> Law:
        """Return the law with what it may look into: for "oracle" the realisation itself.

        For "forecast" a window on it (`gyroctl.waves.window.Window`), open as far as the member ``preview`` says; for
        "gauge" what was read up to now of the gauge that its member ``gauge`` describes (`gyroctl.waves.gauge`).
        """
        ...


@runtime_checkable
class Sensing(Protocol):
    """A law that says which of the sensors it reads."""

    @property
    def sensors(self) -> tuple[str, ...]:
        """Channels of the measurement that its command goes by; the others it needs only where one of these is lost."""
        ...


@runtime_checkable
class Counting(Protocol):
    """A law that counts while it runs: deadline_misses, fallbacks, clamped, or counts of its own.

    Counts in its state never come back to themselves after a wave: for its linear margins a method `uncounted` returns
    the law without them.
    """

    def counters(self, state: Any) -> dict[str, Any]:
        """Return the counts of a run from its last state."""
        ...


@runtime_checkable
class Motoring(Protocol):
    """A law that may use the generator as a motor, where the actuators let it: `motors` says whether it does."""

    @property
    def motors(self) -> bool:
        """Whether the generator may be a motor."""
        ...


@runtime_checkable
class Preparing(Protocol):
    """A law that compiles long on a new installation, in parts that need not wait for one another."""

    def preparations(self) -> Sequence[Callable[[], None]]:
        """Return the parts; each may be called in a process of its own, which leaves the machine code on disk."""
        ...


@runtime_checkable
class Machined(Protocol):
    """A law that brings its own machine code, for what the harness cannot compile out of its `step`.

    Runs of it then need no interpreter: they go side by side on threads of one process.
    """

    def machine(self) -> tuple[Any, Any, Any] | None:
        """Return ``entry(t, y, p, s, u)``, p and the first s, or None where these settings need Python.

        The entry is a numba cfunc of a time [s] and four rows of floats: it writes the command to `u` (2,) and changes
        `s` in place, gives what `step` gives to the last bit, and a command that is no number where it fails.
        """
        ...

    def state_of(self, s: Any) -> Any:
        """Return the state, as `step` knows it, of a row that the entry has left."""
        ...

    def spent(self, state: Any) -> tuple[float, float]:
        """Return median and 99 % of the times that the samples so far took, NaN where that is not known. [s]"""
        ...


@runtime_checkable
class Designed(Protocol):
    """A law that brings the margins which its design found at its operating points."""

    def designed(self) -> Mapping[str, Any] | None:
        """Return plant, method, what `differs` from the design, and `cells` with margins; None where nothing is known.

        A cell has ``envelope`` [rad/s], ``frequency`` [rad/s], ``bandwidth``, ``wave_height`` [m], ``share`` and
        ``margins``: gain (low, high), phase [deg], delay [s] and disk by the name of the signal.
        """
        ...


@runtime_checkable
class Wrapping(Protocol):
    """A law around a law."""

    @property
    def law(self) -> Law:
        """The law within."""
        ...


def innermost(law: Law) -> Law:
    """Return the law within all laws that wrap it."""
    while isinstance(law, Wrapping):
        law = law.law
    return law


Failure = Literal["raised", "ended the program", "not finite", "wrong answer", "too slow", "died"]
"""How a run of a law fails."""


class LawError(ValueError):
    """A law that failed while it ran.

    Parameters
    ----------
    message : str
        The law, the sample and what came back, and the mend.
    kind : str
        See `Failure`.
    time : float
        Of the sample, NaN where it is not known. [s]
    """

    def __init__(self, message: str, kind: Failure = "raised", time: float = math.nan) -> None:
        self.kind, self.time = kind, time
        super().__init__(message)

    def __reduce__(self) -> tuple[type[LawError], tuple[str, Failure, float]]:
        """Keep kind and time when the error crosses a process boundary."""
        return LawError, (str(self), self.kind, self.time)
