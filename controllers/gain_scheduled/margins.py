"""Margins of a cell's loop, and what is demanded of them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from gyroctl.controllers.gain_scheduled.cell import Cell, Filters, frozen
from gyroctl.controllers.gain_scheduled.table import lost_by
from gyroctl.loop_margins.closed_loop_orbit import LoopOrbit, close_loop
from gyroctl.loop_margins.margins import ChannelMargins, channel_margins
from gyroctl.orbits import Orbit
from gyroctl.orbits.wave import Wave
from gyroctl.plant import Plant

CHANNELS = ("cc", "cg", "controls", "psi", "psi_rate", "omega_rate", "phi1", "phi1_rate", "phi3_rate")
"""Signals at which a cell's margins are given; phi3 itself is not used."""


@dataclass(frozen=True)
class Demand:
    """Margins that every cell must have at each of `CHANNELS`.

    The disk is not demanded at both controls together: they have different units, and the disk mixes them.
    """

    gain: float = 2.5  # the feedback may be raised by this factor, and lowered by it [-]
    phase: float = 60.0  # constant phase [deg]
    delay: float = 0.3  # at each signal [s]
    disk: float = 0.7  # disk margin alpha [-]

    def shortfall(self, margins: Mapping[str, ChannelMargins]) -> tuple[float, str]:
        """Least ratio of a margin to its demand, and which it is; at least 1 where all are met."""
        worst = (math.inf, "")
        for channel, found in margins.items():
            low, high = found.gain
            values = {"gain": min(high, 1.0 / low if low > 0.0 else math.inf), "phase": found.phase}
            if channel != "controls":
                values |= {"delay": found.delay, "disk": found.disk}
            for kind, value in values.items():
                wanted = getattr(self, kind)
                ratio = value / wanted if wanted > 0.0 else math.inf
                if ratio < worst[0]:
                    worst = (ratio, f"{kind} {value:.3g} at {channel} where {wanted:g} is demanded")
        return worst


def cell_loop(
    plant: Plant, height: float, frequency: float, row: list[float], filters: Filters, start: Orbit | None = None
) -> LoopOrbit:
    """Loop of a cell in its own wave, with the schedule held at the cell."""
    law = frozen(row, filters, frequency, **lost_by(plant))
    return close_loop(plant, Wave(height, frequency), law, start=start, settle=150)


def loop_of(cell: Cell, row: list[float], filters: Filters) -> LoopOrbit:
    """Loop of a cell that has just been designed, begun at its own orbit."""
    return cell_loop(cell.orbit.plant, cell.height, cell.node.frequency, row, filters, cell.orbit)


def cell_margins(loop: LoopOrbit) -> dict[str, ChannelMargins]:
    """Margins of a stable loop at all `CHANNELS`."""
    return {name: channel_margins(loop, name) for name in CHANNELS}
