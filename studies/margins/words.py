"""What each margin means, in one paragraph with the number at hand."""

from __future__ import annotations

import math

from gyroctl.linearisation import PeriodicOrbit
from gyroctl.robustness.headroom import Headroom
from gyroctl.robustness.shocks import Shock
from gyroctl.studies.margins.measures import LoopAnswer, Margins
from gyroctl.studies.margins.request import Request


def meanings(
    asked: Request, orbit: PeriodicOrbit, margins: Margins | None, answer: LoopAnswer | None
) -> dict[str, str]:
    """One paragraph per margin, by name.

    Parameters
    ----------
    asked : Request
        Operating point.
    orbit : PeriodicOrbit
        Of the constant controls.
    margins : Margins, optional
        Those of the law where there is one, else of the constant controls; None where nothing is stable.
    answer : LoopAnswer, optional
        Linear margins of the law.
    """
    said = {"stability": _stability(orbit)}
    if orbit.status == "stable":
        said["lock_reserve"] = _reserve(orbit)
    if margins is not None:
        whose = f"law {asked.law_name}" if asked.law_name else "constant controls"
        said["cg_headroom"] = _gain(margins.headroom["cg"], whose)
        said["height_headroom"] = _height(margins.headroom["height"])
        said["frequency_headroom"] = _frequency(margins.headroom["frequency_down"], margins.headroom["frequency_up"])
        said["basin_stability"] = _basin(margins)
        said["smallest_shock"] = _shock(margins.shocks)
    if answer is not None:
        said["loop_margins"] = _loop(answer, asked.law_name)
    return said


def _stability(orbit: PeriodicOrbit) -> str:
    slowest = orbit.modes[0]
    cycle = f" with a period of {slowest.period:.3g} s" if math.isfinite(slowest.period) else ""
    if orbit.status == "stable":
        return (
            f"The locked orbit is stable: a small disturbance dies out. The {slowest.name} mode is the slowest{cycle}; "
            f"it falls by e in {slowest.decay_time:.3g} s, {slowest.decay_time / orbit.period:.3g} waves."
        )
    return (
        f"The locked orbit is UNSTABLE: the {slowest.name} mode grows by e in {-slowest.decay_time:.3g} s{cycle}. "
        f"It has no margins, and none are given. {orbit.advice}."
    )


def _reserve(orbit: PeriodicOrbit) -> str:
    near = "; pull-out comes at about -90 or beyond."
    if abs(orbit.load_angle) > 0.5 * math.pi:
        near = ", beyond -90: pull-out is near, and the share, |sin| of the angle, no longer tells how near."
    return (
        f"The load takes {100 * orbit.lock_share:.3g} % of what the wave can pull at this motion, N cg/(J4 V), like "
        f"the torque of a synchronous machine against its pull-out; {100 * orbit.lock_reserve:.3g} % is in reserve. "
        f"The load angle is {math.degrees(orbit.load_angle):.3g} degrees{near}"
    )


def _gain(room: Headroom, whose: str) -> str:
    what = "the law's cg" if room.relative else f"cg = {room.value:.3g} Nms"
    if not math.isfinite(room.decibel):
        return f"{_capital(whose)}: {what} may be raised as far as was tried without losing lock."
    to = f"{room.limit:.3g} times as much" if room.relative else f"{room.limit:.4g} Nms"
    return (
        f"{_capital(whose)}: {what} may be raised by {room.decibel:.1f} dB, to {to}, before lock ends "
        f"({room.ending}). Raising the load slowly to that point loses lock; a sudden rise loses it earlier."
    )


def _height(room: Headroom) -> str:
    if not math.isfinite(room.decibel):
        return f"The wave may fall from {room.value:.3g} m as far as was tried without losing lock."
    part = f"{room.decibel:.1f} dB or {100 * (room.limit / room.value):.3g} % of its height"
    return (
        f"The wave may fall from {room.value:.3g} m to {room.limit:.3g} m, {part}, before it can no longer carry the "
        f"load ({room.ending}). A lull of a sea below that for longer than the libration takes is a danger."
    )


def _frequency(down: Headroom, up: Headroom) -> str:
    def side(room: Headroom) -> str:
        if not (math.isfinite(room.limit) and room.limit > 0.0) or room.ending in ("none in range", "end of the table"):
            return "as far as was tried"
        return f"to {room.limit:.3g} rad/s ({100 * (room.limit / room.value - 1):+.3g} %, {room.ending})"

    return f"The frequency of the wave may move from {down.value:.3g} rad/s down {side(down)} and up {side(up)}."


def _basin(margins: Margins) -> str:
    size, share = list(margins.basin.items())[1]
    return (
        f"Of {share.runs} random disturbances of all states at once, each up to {100 * size:.3g} % of its largest, "
        f"{100 * share.value:.3g} % lock again (95 % interval {100 * share.low:.3g} to {100 * share.high:.3g} %). "
        "The multipliers cannot say this: they know only disturbances without size."
    )


def _shock(shocks: tuple[Shock, ...]) -> str:
    breaking = [shock for shock in shocks if not math.isnan(shock.size)]
    if not breaking:
        return "No shock along a single state, up to the largest that was tried, makes the ring lose a turn."
    worst = min(breaking, key=lambda shock: shock.size / shock.largest)
    unit = "rad" if worst.state in ("phi1", "phi3", "psi") else "rad/s"
    return (
        f"The weakest side is {worst.state}: a sudden change of {worst.sign * worst.size:+.3g} {unit} "
        f"({100 * worst.size / worst.largest:.3g} % of the largest tried) makes the ring lose or gain a turn; every "
        f"smaller one that was tried does not. {len(shocks) - len(breaking)} of {len(shocks)} directions have no such "
        "shock in range."
    )


def _loop(answer: LoopAnswer, name: str) -> str:
    if answer.margins is None:
        reason = _capital(answer.unavailable)
        return f"Gain, phase, delay and disk margins of the law {name} are not available. {reason}."
    worst, found = answer.weakest()[0]
    low, high = found.guaranteed_gain
    gain = f"a gain up to {found.gain[1]:.3g}" if math.isfinite(found.gain[1]) else "any gain"
    delay = f"{found.delay:.3g} s of delay" if math.isfinite(found.delay) else "any delay that was tried"
    return (
        f"The law {name} is weakest at {worst}: what it adds to its periodic course there stands {gain}, "
        f"{found.phase:.3g} degrees of phase, or {delay}. The disk margin {found.disk:.3g} guarantees any gain from "
        f"{low:.3g} to {high:.3g} without phase, or {found.guaranteed_phase:.3g} degrees without gain, even if it "
        "changes from sample to sample."
    )


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]
