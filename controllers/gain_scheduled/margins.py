"""Margins of a cell's loop, and what is demanded of them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from gyroctl.controllers.gain_scheduled.cell import Cell, Filters, frozen
from gyroctl.loop_margins.closed_loop_orbit import LoopOrbit, close_loop
from gyroctl.loop_margins.margins import ChannelMargins, channel_margins
from gyroctl.orbits.wave import Wave
from gyroctl.plant import Plant

CHANNELS = ("cc", "cg", "controls", "psi", "psi_rate", "omega_rate", "phi1", "phi1_rate", "phi3_rate")
"""Signals at which a cell's margins are given; phi3 itself is not used."""


@dataclass(frozen=True)
class Demand:
    """Margins that every cell must have at each of `CHANNELS`.

    The disk is not demanded at both controls together: they have different units, and the disk mixes them.

    Parameters
    ----------
    gain : float
        The feedback may be raised by this factor, and lowered by it. [-]
    phase : float
        Constant phase. [deg]
    delay : float
        At each signal. [s]
    disk : float
        Disk margin alpha. [-]
    """

    gain: float = 2.5
    phase: float = 60.0
    delay: float = 0.3
    disk: float = 0.7

    def shortfall(self, margins: Mapping[str, ChannelMargins]) -> tuple[float, str]:
        """Least ratio of a margin to its demand, and which it is; at least 1 where all are met."""
        worst = (math.inf, "")
        for channel, found in margins.items():
            low, high = found.gain
            entries = {
                "gain": (min(high, 1.0 / low if low > 0.0 else math.inf), self.gain),
                "phase": (found.phase, self.phase),
            }
            if channel != "controls":
                entries |= {"delay": (found.delay, self.delay), "disk": (found.disk, self.disk)}
            for kind, (value, wanted) in entries.items():
                ratio = value / wanted if wanted > 0.0 else math.inf
                if ratio < worst[0]:
                    worst = (ratio, f"{kind} {value:.3g} at {channel} where {wanted:g} is demanded")
        return worst


def cell_loop(plant: Plant, height: float, frequency: float, row: list[float], filters: Filters) -> LoopOrbit:
    """Loop of a cell in its own wave, with the schedule held at the cell."""
    law = frozen(row, filters, frequency)
    return close_loop(plant, Wave(height, frequency), law, settle=150)


def cell_margins(loop: LoopOrbit, channels: tuple[str, ...] = CHANNELS) -> dict[str, ChannelMargins]:
    """Margins of a stable loop at the given signals."""
    return {name: channel_margins(loop, name) for name in channels}


def loop_of(cell: Cell, row: list[float], filters: Filters) -> LoopOrbit:
    """Loop of a cell that has just been designed, begun at its own orbit."""
    law = frozen(row, filters, cell.node.frequency)
    return close_loop(cell.orbit.plant, Wave(cell.height, cell.node.frequency), law, start=cell.orbit, settle=150)
