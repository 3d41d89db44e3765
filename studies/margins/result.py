"""Margins in Python: measured like those of the report, with the numbers as attributes and the pictures on request."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from gyroctl.errors import InputError, check_kind
from gyroctl.faces.locks import margins_face
from gyroctl.faces.show import shown
from gyroctl.harness.arguments import check_plant, law_of
from gyroctl.harness.protocol import Law
from gyroctl.linearisation import PeriodicOrbit
from gyroctl.linearisation.locked_orbit import REGULAR
from gyroctl.loop_margins.closed_loop_orbit import LoopOrbit
from gyroctl.loop_margins.margins import ChannelMargins
from gyroctl.plant import Plant
from gyroctl.robustness.headroom import Headroom
from gyroctl.robustness.shocks import Shock
from gyroctl.simulation.progress import Progress
from gyroctl.statistics import Share
from gyroctl.studies.margins.cells import DesignMargins, design_margins
from gyroctl.studies.margins.measures import LoopAnswer, Margins, orbit_record
from gyroctl.studies.margins.measuring import check_samples, measured, steps_of
from gyroctl.studies.margins.request import Request, find_orbit, request
from gyroctl.studies.margins.words import meanings
from gyroctl.waves import Regular
from gyroctl.writing import Kept, plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PICTURES = ("robustness", "multipliers", "linear_error", "nyquist")
"""What `MarginResult.plot` can draw."""


@shown(margins_face)
@dataclass(frozen=True)
class MarginResult:
    """Margins of a lock: of the law where there is one, else of the constant controls.

    Parameters
    ----------
    request : object
        Device, wave, controls and law.
    orbit : PeriodicOrbit
        The locked orbit of the constant controls, with its multipliers and modes.
    constant : Margins, optional
        Of the constant controls; None where their orbit is unstable.
    of_law : Margins, optional
        Of the law, by simulation.
    linear : LoopAnswer, optional
        Of the law, from the multipliers of the loop.
    failed : mapping of str to str
        What could not be measured, with the reason: "constant_controls", "law" or "law.linear".
    """

    request: Request = field(repr=False)
    orbit: PeriodicOrbit = field(repr=False)
    constant: Margins | None = field(repr=False)
    of_law: Margins | None = field(repr=False)
    linear: LoopAnswer | None = field(repr=False)
    failed: Mapping[str, str]

    @property
    def status(self) -> str:
        """Status of the orbit of the constant controls: "stable" or "unstable"."""
        return self.orbit.status

    @property
    def margins(self) -> Margins | None:
        """Those that the numbers below are of: the law's where there is one, else the constant controls'."""
        return self.of_law if self.request.law is not None else self.constant

    @property
    def power(self) -> float:
        """Mean electrical power in the regular wave, NaN where nothing is stable. [W]"""
        return self.margins.power if self.margins is not None else math.nan

    @property
    def loop_status(self) -> str:
        """Status of the law's own orbit in the loop, as of a `LoopOrbit`; empty without a law, or where that failed."""
        return self.linear.status if self.linear is not None else ""

    @property
    def load_angle(self) -> float:
        """Load angle on the law's own orbit, NaN where it has none; without a law on that of the controls. [rad]"""
        own = self._own_orbit()
        return own.load_angle if own is not None else math.nan

    @property
    def lock_share(self) -> float:
        """Part of what the wave can pull that the load takes, N cg/(J4 V); of a law with its mean cg, likewise. [1]"""
        own = self._own_orbit()
        return own.lock_share if own is not None else math.nan

    @property
    def lock_reserve(self) -> float:
        """Part of what the wave can pull that the load leaves, likewise; NaN where the orbit is unstable. [1]"""
        own = self._own_orbit()
        return own.lock_reserve if own is not None and own.status == "stable" else math.nan

    @property
    def decay_time(self) -> float:
        """Time in which the slowest mode falls by e, of the law's loop where there is one; negative: it grows. [s]"""
        if self.request.law is None:
            return self.orbit.modes[0].decay_time
        loop = self.linear.loop if self.linear is not None else None
        return loop.decay_time if loop is not None else math.nan

    @property
    def headroom(self) -> dict[str, Headroom]:
        """How far cg, height and frequency may move, by "cg", "height", "frequency_down" and "frequency_up"."""
        return dict(self.margins.headroom) if self.margins is not None else {}

    @property
    def cg_headroom(self) -> float:
        """Gain of the load up to the loss of lock, NaN where it is not known. [dB]"""
        return self.headroom["cg"].decibel if self.headroom else math.nan

    @property
    def height_headroom(self) -> float:
        """Fall of the wave height up to the loss of lock, NaN where it is not known. [dB]"""
        return self.headroom["height"].decibel if self.headroom else math.nan

    @property
    def basin(self) -> dict[float, Share]:
        """Share of random disturbances after which lock returns, by their size as a part of the largest."""
        return dict(self.margins.basin) if self.margins is not None else {}

    @property
    def shocks(self) -> tuple[Shock, ...]:
        """Smallest shocks along each state that lose or gain a turn."""
        return self.margins.shocks if self.margins is not None else ()

    @property
    def channels(self) -> dict[str, ChannelMargins]:
        """Gain, phase, delay and disk margins of the law by control and sensor; empty where there are none."""
        return dict(self.linear.margins.channels) if self.linear is not None and self.linear.margins else {}

    @property
    def gain(self) -> tuple[float, float]:
        """Gains between which the loop is stable whichever single channel has them; NaN where there are none."""
        found = self._single()
        if not found:
            return math.nan, math.nan
        return max(each.gain[0] for each in found), min(each.gain[1] for each in found)

    @property
    def phase(self) -> float:
        """Smallest phase margin of the single channels, NaN where there is none. [deg]"""
        return min((each.phase for each in self._single()), default=math.nan)

    @property
    def delay(self) -> float:
        """Smallest delay margin of the single channels, NaN where there is none. [s]"""
        return min((each.delay for each in self._single()), default=math.nan)

    @property
    def disk(self) -> float:
        """Smallest disk margin of the single channels, NaN where there is none. [1]"""
        return min((each.disk for each in self._single()), default=math.nan)

    @property
    def meaning(self) -> dict[str, str]:
        """What each number means, one paragraph each."""
        return meanings(self.request, self.orbit, self.margins, self.linear, self.cells)

    @property
    def cells(self) -> DesignMargins | None:
        """Margins that the law's design found at its operating points, with the schedule held; None of most laws."""
        return design_margins(self.request)

    def record(self) -> dict[str, Any]:
        """All numbers as in margins.json."""
        content: dict[str, Any] = {"request": self.request.record(), "orbit": orbit_record(self.orbit)}
        if self.constant is not None:
            content["constant_controls"] = self.constant.record()
        if self.request.law is not None:
            nonlinear = self.of_law.record() if self.of_law is not None else {}
            content["law"] = {**nonlinear, **({"linear": self.linear.record()} if self.linear is not None else {})}
            if (cells := self.cells) is not None:
                content["law"]["cells"] = cells.record()
        return dict(plain({**content, "meaning": self.meaning, "failed": dict(self.failed)}))

    def plot(self, picture: str = "robustness") -> Figure:
        """Draw one of `PICTURES`.

        Parameters
        ----------
        picture : str
            "robustness": headroom, basin and shocks; "multipliers": orbit and loop in the unit circle; "linear_error":
            how far the linear model holds; "nyquist": the harmonic Nyquist plot of the law with its disk.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InputError
            For another picture, or one whose numbers there are none of.
        """
        from gyroctl.studies.margins import draw_linear, draw_orbit, draw_robustness
        from gyroctl.studies.style import styled

        law, point = f"law {self.request.law_name}", f"{self.request.sea}; {self.request.controls}"
        law = law if self.request.law is not None else ""
        if picture not in PICTURES:
            raise InputError("picture", picture, "there is no such picture", f"Choose one of {', '.join(PICTURES)}")
        named = {"constant controls": self.constant, law: self.of_law}
        cases = {name: case for name, case in named.items() if case is not None}
        found: Figure | None = None
        with styled():
            if picture == "robustness" and cases:
                length = self.request.plant.parameters.length_scale
                found = draw_robustness.robustness(cases, point, length)
            elif picture == "multipliers":
                loop = self.linear.loop if self.linear is not None else None
                found = draw_orbit.multipliers(self.orbit, loop, law, point)
            elif picture == "linear_error":
                found, _ = draw_linear.linear_error(self.orbit, point)
            elif picture == "nyquist" and self.linear is not None:
                found = draw_orbit.nyquist(self.linear, law, point)
        if found is None:
            why = "; ".join(f"{name}: {reason}" for name, reason in self.failed.items()) or "nothing stable, or no law"
            raise InputError("picture", picture, f"has no numbers to show ({why})", "See .status, .failed and .meaning")
        return found

    def _own_orbit(self) -> PeriodicOrbit | LoopOrbit | None:
        """Orbit of the law in the loop; of the constant controls where there is no law."""
        if self.request.law is None:
            return self.orbit
        return self.linear.loop if self.linear is not None else None

    def _single(self) -> list[ChannelMargins]:
        return [found for _, found in self.linear.weakest()] if self.linear is not None else []


def margins(
    plant: Plant,
    wave: Regular,
    cc: float,
    cg: float,
    law: Law | str | None = None,
    sense: int = 1,
    samples: int = 128,
    quiet: bool = False,
) -> MarginResult:
    """Measure how far a lock is from breaking.

    Parameters
    ----------
    plant : Plant
        The device.
    wave : Regular
        The regular wave; that of equal energy to a sea has height Hs/sqrt 2.
    cc, cg : float
        Constant controls, and where a law starts. [Nms]
    law : Law or str, optional
        The law, or the name of a registered one with its shipped parameters; without it the constant controls alone.
        For a device of another length than that of Table 1 a name stands for the law in the units of its model.
    sense : {1, -1}
        Sense of rotation of the ring.
    samples : int
        Random disturbances per size: with 128 some twenty seconds, and as many again for a law.
    quiet : bool
        Show no progress.

    Returns
    -------
    MarginResult
        With its numbers as attributes, and ``.plot()``.

    Raises
    ------
    InputError
        For an argument that is not what it should be, where there is no locked orbit, or the law does not keep it.
    """
    check_plant(plant)
    check_kind("wave", wave, Regular, "a regular wave", REGULAR)
    check_samples(samples)
    name = law if isinstance(law, str) else type(law).__name__ if law is not None else ""
    scaled = plant.parameters.length_scale != 1.0
    named = name if isinstance(law, str) else ""
    asked = request(plant, wave.height, wave.wp, cc, cg, sense, named, own_device=scaled, heading=wave.heading)
    built = asked.law if law is None or isinstance(law, str) else law_of(law)
    asked = Request(plant, wave, cc, cg, sense, name, built)
    orbit, kept = find_orbit(asked), Kept({})
    with Progress("margins", steps_of(asked), quiet) as progress:
        found = measured(asked, orbit, samples, kept, progress.advance)
    return MarginResult(asked, orbit, *found, dict(kept.failed))
