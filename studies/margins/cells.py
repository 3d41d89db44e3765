"""Margins that a law's design found at its operating points: those of the cells of a table, with the schedule held."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from gyroctl.froude import growth
from gyroctl.harness.for_device import InModelScale
from gyroctl.harness.protocol import Designed, innermost
from gyroctl.studies.margins.request import Request

GROUPS = ("controls", "sensors")
"""Signals that are perturbed together: their disk mixes units, so that the least of a cell is that of single ones."""


class Least(NamedTuple):
    """Smallest margin of one kind, and where it is."""

    value: float
    channel: str
    cell: int


@dataclass(frozen=True)
class Cell:
    """One operating point of a design, in the units of the device.

    Parameters
    ----------
    envelope, frequency : float
        Where it lies in the schedule. [rad/s]
    bandwidth : float
        Likewise. [-]
    height : float
        Height of its own regular wave. [m]
    share : float
        Share of the lock capacity that its load takes. [-]
    margins : dict
        By signal: gain (low, high), phase [deg], delay [s], disk.
    """

    envelope: float
    frequency: float
    bandwidth: float
    height: float
    share: float
    margins: dict[str, dict[str, Any]]

    def __str__(self) -> str:
        """Place in the schedule, in words."""
        return f"V {self.envelope:.3g} rad/s, {self.frequency:.3g} rad/s, bandwidth {self.bandwidth:.3g}"

    def least(self, kind: str) -> tuple[float, str]:
        """Smallest gain up, phase, delay or disk of the single signals, and the signal."""
        found = {name: one for name, one in self.margins.items() if name not in GROUPS}
        values = {name: float(one[kind][1] if kind == "gain" else one[kind]) for name, one in found.items()}
        weakest = min(values, key=lambda name: values[name])
        return values[weakest], weakest


@dataclass(frozen=True)
class DesignMargins:
    """Margins of all cells of a design.

    Parameters
    ----------
    plant, method : str
        What was designed for, and how.
    differs : dict
        Fields of the law that are not those of the design: the margins are then of the design, not of this law.
    cells : tuple of Cell
        In the order of the table.
    nearest : int
        The cell whose own wave is nearest to that of the report, of those of the smallest bandwidth: a regular wave
        has none.
    """

    plant: str
    method: str
    differs: dict[str, float]
    cells: tuple[Cell, ...]
    nearest: int

    def worst(self, kind: str) -> Least:
        """Smallest margin of a kind over all cells and single signals."""
        return min((Least(*cell.least(kind), i) for i, cell in enumerate(self.cells)), key=lambda one: one.value)

    def record(self) -> dict[str, Any]:
        """Numbers for JSON."""
        worst = {kind: self.worst(kind)._asdict() for kind in KINDS}
        head = {"schedule": "held", "design_plant": self.plant, "method": self.method, "differs": self.differs}
        return {**head, "nearest": self.nearest, "worst": worst, "cells": [_record(cell) for cell in self.cells]}


KINDS = ("gain", "phase", "delay", "disk")
"""Margins of a cell; of the gain the upper end."""


def design_margins(asked: Request) -> DesignMargins | None:
    """Margins that the law of a request brings; None where it brings none.

    Parameters
    ----------
    asked : Request
        Device, wave and law. Of a law in the units of a model the cells are turned into those of the device.
    """
    law = None if asked.law is None else innermost(asked.law)
    told = law.designed() if isinstance(law, Designed) else None
    if told is None:
        return None
    length = asked.plant.parameters.length_scale if isinstance(asked.law, InModelScale) else 1.0
    cells = tuple(_cell(one, length) for one in told["cells"])
    nearest = min(range(len(cells)), key=lambda i: (cells[i].bandwidth, _distance(cells[i], asked)))
    return DesignMargins(told["plant"], told["method"], dict(told["differs"]), cells, nearest)


def _cell(told: Mapping[str, Any], length: float) -> Cell:
    rate, metre, second = (growth(unit, length) for unit in ("rad/s", "m", "s"))
    margins = {name: {**one, "delay": second * one["delay"]} for name, one in told["margins"].items()}
    place = rate * told["envelope"], rate * told["frequency"], told["bandwidth"]
    return Cell(*place, metre * told["wave_height"], told["share"], margins)


def _distance(cell: Cell, asked: Request) -> float:
    """How far the wave of a cell is from that of a report, in ratios of height and frequency."""
    return math.hypot(math.log(cell.height / asked.wave.height), math.log(cell.frequency / asked.wave.wp))


def _record(cell: Cell) -> dict[str, Any]:
    margins = {
        name: {"gain": list(one["gain"]), "phase_deg": one["phase"], "delay_s": one["delay"], "disk_alpha": one["disk"]}
        for name, one in cell.margins.items()
    }
    return {
        "envelope_rad_s": cell.envelope,
        "frequency_rad_s": cell.frequency,
        "bandwidth": cell.bandwidth,
        "wave_height_m": cell.height,
        "lock_share": cell.share,
        "least": {kind: dict(zip(("value", "channel"), cell.least(kind), strict=True)) for kind in KINDS},
        "margins": margins,
    }
