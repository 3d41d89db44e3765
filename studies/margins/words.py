"""What each margin means, in one paragraph with the number at hand."""

from __future__ import annotations

import math

from gyroctl.linearisation import PeriodicOrbit
from gyroctl.robustness.headroom import Headroom
from gyroctl.robustness.shocks import Shock
from gyroctl.studies.margins.cells import DesignMargins
from gyroctl.studies.margins.measures import LoopAnswer, Margins
from gyroctl.studies.margins.request import Request

APART = 0.02
"""Part of the power from which on the law does not run on its own orbit: sampling alone moves it by a thousandth."""

INSTEAD = "Those of its table's cells, which hold with the schedule held, are given as cell margins."

CELL_WORDS = (
    ("gain", "gain up to", ""),
    ("phase", "phase", " degrees"),
    ("delay", "delay", " s"),
    ("disk", "disk margin", ""),
)
"""Margins of a cell: kind, words, unit."""


def meanings(
    asked: Request,
    orbit: PeriodicOrbit,
    margins: Margins | None,
    answer: LoopAnswer | None,
    cells: DesignMargins | None = None,
) -> dict[str, str]:
    """One paragraph per margin, by name; each says whose it is.

    Parameters
    ----------
    asked : Request
        Operating point.
    orbit : PeriodicOrbit
        Of the constant controls.
    margins : Margins, optional
        Those of the law where there is one, else of the constant controls; None where there are none.
    answer : LoopAnswer, optional
        Linear margins of the law, and its own orbit.
    cells : DesignMargins, optional
        Margins that the law's design found.
    """
    whose = f"Law {asked.law_name}" if asked.law is not None else "Constant controls"
    said = _of_orbit(orbit) if asked.law is None else _of_loop(answer, margins is not None)
    if margins is not None:
        said["power"] = _power(margins, answer)
        said["cg_headroom"] = _gain(margins.headroom["cg"])
        said["height_headroom"] = _height(margins.headroom["height"])
        said["frequency_headroom"] = _frequency(margins.headroom["frequency_down"], margins.headroom["frequency_up"])
        said["basin_stability"] = _basin(margins)
        said["smallest_shock"] = _shock(margins.shocks)
    if answer is not None:
        said["loop_margins"] = _loop(answer, cells)
    if cells is not None:
        said["cell_margins"] = _cells(cells)
    said = {name: f"{whose}: {text}" for name, text in said.items()}
    if asked.law is not None:
        pair = {**_of_orbit(orbit), "power": f"The mean power on it is {orbit.power:.3g} W."}
        said["constant_controls"] = f"Beside the law, the constant controls {asked.controls}: {' '.join(pair.values())}"
    return said


def _of_orbit(orbit: PeriodicOrbit) -> dict[str, str]:
    """What the orbit of the constant controls says."""
    said = {"stability": _stability(orbit)}
    if orbit.status == "stable":
        said["lock_reserve"] = _reserve(orbit.lock_share, orbit.load_angle, "its cg")
    return said


def _of_loop(answer: LoopAnswer | None, settled: bool) -> dict[str, str]:
    """What the law's own orbit in the loop says, or that it has none; a law that `settled` keeps the lock."""
    keeps = " It keeps the lock in this wave, by simulation." if settled else ""
    if answer is None or answer.loop is None:
        why = "its loop could not be looked at" if answer is None else f"its loop is {answer.status} in this wave"
        without = f"Not known: {why}, so that it has no orbit of its own, and no"
        return {
            "stability": f"{without} multipliers.{keeps}",
            "lock_reserve": f"{without} load angle or share. Those of the constant controls are not the law's.",
        }
    loop = answer.loop
    waves = abs(loop.decay_time) / (loop.flow.samples * loop.flow.period)
    if answer.status != "stable":
        return {
            "stability": (
                f"The loop's own orbit of one cycle per wave is UNSTABLE, largest multiplier "
                f"{abs(loop.multipliers[0]):.3g}: its slowest mode grows by e in {-loop.decay_time:.3g} s, {waves:.3g} "
                f"waves.{keeps}"
            ),
            "lock_reserve": "None is given: the load angle and the share of an unstable orbit are not the law's.",
        }
    return {
        "stability": (
            "The loop's own orbit of one cycle per wave is stable: a small disturbance dies out. The slowest of its "
            f"modes falls by e in {loop.decay_time:.3g} s, {waves:.3g} waves."
        ),
        "lock_reserve": _reserve(loop.lock_share, loop.load_angle, f"its mean cg of {loop.mean_controls[1]:.3g} Nms"),
    }


def _power(margins: Margins, answer: LoopAnswer | None) -> str:
    said = f"The mean electrical power in this regular wave is {margins.power:.3g} W."
    loop = answer.loop if answer is not None else None
    if loop is None or abs(loop.power - margins.power) <= APART * abs(margins.power):
        return said
    return f"{said} On the loop's own orbit it would be {loop.power:.3g} W: the law swings about it, or runs elsewhere."


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


def _reserve(share: float, angle: float, load: str) -> str:
    near = "; pull-out comes at about -90 or beyond."
    if abs(angle) > 0.5 * math.pi:
        near = ", beyond -90: pull-out is near, and the share, |sin| of the angle, no longer tells how near."
    return (
        f"The load, {load}, takes {100 * share:.3g} % of what the wave can pull at this motion, N cg/(J4 V), like "
        f"the torque of a synchronous machine against its pull-out; {100 * (1.0 - share):.3g} % is in reserve. "
        f"The load angle is {math.degrees(angle):.3g} degrees{near}"
    )


def _gain(room: Headroom) -> str:
    what = "The law's cg" if room.relative else f"cg = {room.value:.3g} Nms"
    if not math.isfinite(room.decibel):
        return f"{what} may be raised as far as was tried without losing lock."
    to = f"{room.limit:.3g} times as much" if room.relative else f"{room.limit:.4g} Nms"
    return (
        f"{what} may be raised by {room.decibel:.1f} dB, to {to}, before lock ends "
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


def _loop(answer: LoopAnswer, cells: DesignMargins | None) -> str:
    if answer.margins is None:
        said = f"Gain, phase, delay and disk margins are not available. {_capital(answer.unavailable)}."
        return said if cells is None else f"{said} {INSTEAD}"
    worst, found = answer.weakest()[0]
    low, high = found.guaranteed_gain
    gain = f"a gain up to {found.gain[1]:.3g}" if math.isfinite(found.gain[1]) else "any gain"
    delay = f"{found.delay:.3g} s of delay" if math.isfinite(found.delay) else "any delay that was tried"
    return (
        f"It is weakest at {worst}: what it adds to its periodic course there stands {gain}, "
        f"{found.phase:.3g} degrees of phase, or {delay}. The disk margin {found.disk:.3g} guarantees any gain from "
        f"{low:.3g} to {high:.3g} without phase, or {found.guaranteed_phase:.3g} degrees without gain, even if it "
        "changes from sample to sample."
    )


def _cells(found: DesignMargins) -> str:
    """Least margins of the cells, of all and of the nearest."""
    near = found.cells[found.nearest]
    worst = [f"{what} {_at(found, kind, unit)}" for kind, what, unit in CELL_WORDS]
    own = [f"{what} {_value(kind, near.least(kind)[0], unit)}" for kind, what, unit in CELL_WORDS]
    other = ""
    if found.differs:
        changed = ", ".join(f"{name} {value:.3g}" for name, value in found.differs.items())
        other = f" They are those of the design, and not of this law, which runs with {changed}."
    return (
        f"Its table carries margins of each of its {len(found.cells)} cells, from the loop of law and plant "
        f"({found.plant}) about the cell's own orbit, with the schedule held at the cell.{other} Least over all cells "
        f"and single signals: {'; '.join(worst)}. Nearest to this wave is the cell {near}, of a wave of "
        f"{near.height:.3g} m; the least of it: {'; '.join(own)}."
    )


def _at(found: DesignMargins, kind: str, unit: str) -> str:
    least = found.worst(kind)
    said = _value(kind, least.value, unit)
    return said if math.isinf(least.value) else f"{said} at {least.channel} ({found.cells[least.cell]})"


def _value(kind: str, value: float, unit: str) -> str:
    if math.isinf(value):
        return "none met" if kind != "gain" else "without end"
    return f"{value:.3g}{unit}"


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]
