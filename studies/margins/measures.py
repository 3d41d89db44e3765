"""The numbers of a margin report: orbit, modes, headroom, basin, shocks, and the margins of the law in the loop."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from gyroctl.errors import InputError
from gyroctl.linearisation import PeriodicOrbit
from gyroctl.loop_margins.closed_loop_orbit import LoopOrbit, close_loop
from gyroctl.loop_margins.margins import ChannelMargins, LoopMargins, loop_margins
from gyroctl.robustness.headroom import Headroom, Quantity, headroom, ramp
from gyroctl.robustness.regime import Regime, settle
from gyroctl.robustness.shocks import Shock, basin_stability, smallest_shocks
from gyroctl.statistics import Share
from gyroctl.studies.margins.request import Request

SIZES = (0.25, 0.5, 0.75, 1.0)
"""Sizes of the random disturbances, as parts of the largest."""

DIRECTIONS: tuple[tuple[str, Quantity, bool], ...] = (
    ("cg", "cg", True),
    ("height", "height", False),
    ("frequency_down", "wp", False),
    ("frequency_up", "wp", True),
)
"""Name of each headroom, what is moved, and whether upwards."""

REACH = {"cg": 10.0, "height": 0.05, "frequency_down": 0.5, "frequency_up": 1.6}
"""How far a ramp goes for a law in the loop, as a factor."""

HAVE_AN_ORBIT = ("stable", "unstable")
"""Statuses of a loop with an orbit of its own."""

NOTHING_FED_BACK = "the law feeds nothing back: no gain or delay of it can break the lock"

Tick = Callable[[], None]


@dataclass(frozen=True)
class Margins:
    """Margins beyond the linear, of constant controls or of a law."""

    headroom: dict[str, Headroom]  # by the names of `DIRECTIONS`
    basin: dict[float, Share]  # share of random disturbances after which lock returns, by their size
    shocks: tuple[Shock, ...]  # smallest along each state
    power: float  # mean in the regime [W]

    def record(self) -> dict[str, Any]:
        """Numbers for JSON."""
        rooms, basin = {}, []
        for name, room in self.headroom.items():
            rooms[name] = {"value": room.value, "limit": room.reached, "decibel": room.decibel, "ending": room.ending}
        for size, share in self.basin.items():
            basin.append({"size": size, "share": share.value, "ci95": [share.low, share.high], "runs": share.runs})
        names = ("state", "sign", "size", "tried_up_to")
        shocks = [dict(zip(names, shock, strict=True)) for shock in self.shocks]
        return {"power_w": self.power, "headroom": rooms, "basin_stability": basin, "smallest_shocks": shocks}


def constant_margins(orbit: PeriodicOrbit, asked: Request, samples: int, tick: Tick) -> Margins:
    """Margins of the stable orbit of constant controls; where it ends by exact multipliers."""
    rooms = {}
    for name, quantity, upwards in DIRECTIONS:
        rooms[name] = headroom(orbit, asked.wave, quantity, upwards)
        tick()
    return Margins(rooms, *_hit(settle(orbit, asked.wave), samples, tick), orbit.power)


def law_regime(orbit: PeriodicOrbit, asked: Request) -> Regime:
    """Regime of the law, started on the orbit of the constant controls.

    Raises
    ------
    InputError
        Where the law does not keep the lock.
    """
    try:
        return settle(orbit, asked.wave, asked.law)
    except InputError as error:
        raise InputError("law", asked.law_name, error.problem, error.mend) from None


def law_margins(regime: Regime, samples: int, tick: Tick) -> Margins:
    """Margins of a law in lock, by plain simulation of the loop."""
    wave, rooms = regime.wave, {}
    for name, quantity, _ in DIRECTIONS:
        value = {"cg": 1.0, "height": wave.height, "wp": wave.wp}[quantity]
        last = REACH[name] * value
        if quantity == "wp":
            low, high = regime.plant.excitation.omega[[0, -1]]
            last = min(max(last, 1.01 * float(low)), 0.99 * float(high))
        limit = ramp(regime, quantity, value, last)
        room = Headroom(quantity, value, limit, "lost in a slow ramp")
        if math.isnan(limit):
            room = Headroom(quantity, value, math.inf if last > value else 0.0, "none in range")
        rooms[name] = room
        tick()
    return Margins(rooms, *_hit(regime, samples, tick), regime.power)


@dataclass(frozen=True)
class LoopAnswer:
    """The law's own orbit in the loop and its linear margins, or why there are none."""

    loop: LoopOrbit | None
    margins: LoopMargins | None
    unavailable: str
    status: str  # of the loop, see `LoopOrbit`

    def weakest(self) -> list[tuple[str, ChannelMargins]]:
        """Single channels by name, the one with the smallest disk first."""
        channels = self.margins.channels.items() if self.margins else ()
        return sorted(((n, c) for n, c in channels if len(c.channels) == 1), key=lambda pair: pair[1].disk)

    def record(self) -> dict[str, Any]:
        """Numbers for JSON."""
        found = {} if self.margins is None else self.margins.channels
        status = "not available" if self.margins is None else self.margins.status
        head: dict[str, Any] = {"status": status, "reason": self.unavailable, "loop": self._loop_record()}
        if self.loop is not None:
            head["multipliers"] = list(self.loop.multipliers)
        return {**head, "channels": {name: _channel_record(each) for name, each in found.items()}}

    def _loop_record(self) -> dict[str, Any]:
        """Orbit of the loop, as far as there is one."""
        if self.loop is None:
            return {"status": self.status}
        cc, cg = self.loop.mean_controls
        return {
            "status": self.status,
            "power_w": self.loop.power,
            "load_angle_rad": self.loop.load_angle,
            "lock_share": self.loop.lock_share,
            "lock_reserve": self.loop.lock_reserve if self.status == "stable" else None,
            "decay_time_s": self.loop.decay_time,
            "mean_controls": {"cc_nms": cc, "cg_nms": cg},
        }


def _channel_record(found: ChannelMargins) -> dict[str, Any]:
    return {
        "gain": list(found.gain),
        "gain_db": [_decibel(g) for g in found.gain],
        "phase_deg": found.phase,
        "delay_s": found.delay,
        "disk_alpha": found.disk,
        "guaranteed_gain": list(found.guaranteed_gain),
        "guaranteed_phase_deg": found.guaranteed_phase,
    }


def linear_margins(orbit: PeriodicOrbit, asked: Request) -> LoopAnswer:
    """Gain, phase, delay and disk margins of the law in the loop; a status other than stable has none."""
    blind = asked.law is not None and asked.law.information == "none"
    if blind and not 0.0 < asked.law.period <= orbit.period:  # type: ignore[union-attr]
        return LoopAnswer(None, None, NOTHING_FED_BACK, "not periodic")
    loop = close_loop(asked.plant, asked.wave, asked.law, orbit)
    if blind:
        return LoopAnswer(loop if loop.status in HAVE_AN_ORBIT else None, None, NOTHING_FED_BACK, loop.status)
    if loop.status == "stable":
        return LoopAnswer(loop, loop_margins(loop), "", loop.status)
    if loop.status not in HAVE_AN_ORBIT:
        return LoopAnswer(None, None, f"{loop.status}: {loop.advice}", loop.status)
    missing = (
        f"the loop's solution of one cycle per wave is unstable, largest multiplier {abs(loop.multipliers[0]):.3g}: "
        "in this wave the law keeps the lock while it swings about that solution, which has no linear margins"
    )
    return LoopAnswer(loop, None, missing, loop.status)


def orbit_record(orbit: PeriodicOrbit) -> dict[str, Any]:
    """Orbit and modes for JSON."""
    modes = []
    for m in orbit.modes:
        mode = {"name": m.name, "multiplier": m.multiplier, "decay_time_s": m.decay_time}
        modes.append({**mode, "frequency_rad_s": m.frequency, "period_s": m.period})
    return {
        "status": orbit.status,
        "advice": orbit.advice,
        "power_w": orbit.power,
        "load_angle_rad": orbit.load_angle,
        "lock_share": orbit.lock_share,
        "lock_reserve": orbit.lock_reserve if orbit.status == "stable" else None,
        "residual": orbit.residual,
        "half_against_full_map": orbit.error,
        "period_s": orbit.period,
        "x": orbit.x,
        "multipliers": list(orbit.multipliers),
        "modes": modes,
    }


def _hit(regime: Regime, samples: int, tick: Tick) -> tuple[dict[float, Share], tuple[Shock, ...]]:
    basin = {}
    for size in SIZES:
        basin[size] = basin_stability(regime, size, samples)
        tick()
    shocks = smallest_shocks(regime)
    tick()
    return basin, shocks


def _decibel(gain: float) -> float:
    return 20.0 * math.log10(gain) if gain > 0.0 and math.isfinite(gain) else math.copysign(math.inf, gain - 0.5)
