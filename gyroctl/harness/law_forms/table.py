"""A table of commands over one to three measured quantities, linear between its nodes and held beyond its edges."""

from __future__ import annotations

from typing import Any, Literal, NamedTuple

from gyroctl.faces.law import law_face
from gyroctl.faces.show import shown
from gyroctl.harness.law_forms.entries import with_entry
from gyroctl.harness.law_forms.signals import SIGNALS, channels_of, heard
from gyroctl.plant.compiled import inlined


class TableState(NamedTuple):
    """Quantities of the table as they are looked up, and 1 after the first sample."""

    at: tuple[float, ...]
    begun: float


@shown(law_face)
class TableLaw(NamedTuple):
    """Commands from a table."""

    cc_nodes: tuple[float, ...]  # commands at the nodes, the last quantity runs fastest [Nms]
    cg_nodes: tuple[float, ...]  # [Nms]
    nodes: tuple[float, ...]  # of the quantities, one after the other
    counts: tuple[float, ...]  # how many nodes each has
    reads: tuple[float, ...]  # numbers of the quantities in `SIGNALS`
    smooth: float  # time constant with which they are filtered before, 0 for none [s]
    most: tuple[float, ...]  # limits of the command, from 0 to these [Nms]
    N: float  # gear ratio [-]
    period: float  # [s]

    @property
    def information(self) -> Literal["sensors"]:
        """What the law looks at."""
        return "sensors"

    @property
    def sensors(self) -> tuple[str, ...]:
        """Channels of the measurement that its command goes by."""
        return channels_of(tuple(SIGNALS[int(which)] for which in self.reads))

    @property
    def facts(self) -> list[tuple[str, str]]:
        """What its repr tells."""
        begin, axes = 0, []
        for which, count in zip(self.reads, self.counts, strict=True):
            part = self.nodes[begin : begin + int(count)]
            axes.append(f"{SIGNALS[int(which)]} from {part[0]:.4g} to {part[-1]:.4g}, {len(part)} nodes")
            begin += int(count)
        spans = [
            (name, f"{min(values):.4g} to {max(values):.4g} Nms")
            for name, values in (("cc", self.cc_nodes), ("cg", self.cg_nodes))
        ]
        return [("over", "; ".join(axes)), *spans, ("filtered over", f"{self.smooth:.4g} s")]

    def init(self) -> TableState:
        """Return the first nodes, until the first sample fills the filters."""
        first, begin = [], 0
        for count in self.counts:
            first.append(float(self.nodes[begin]))
            begin += int(count)
        return TableState(tuple(first), 0.0)

    def step(self, t: float, y: Any, state: TableState) -> tuple[tuple[float, float], TableState]:
        """Filter, look up."""
        part = self.period / (self.period + self.smooth)  # implicit Euler: stable whatever the time constant
        at = state.at
        for j in range(len(self.reads)):
            value = heard(self.reads[j], y, self.N, state.at[j])
            if state.begun != 0.0:
                value = state.at[j] + part * (value - state.at[j])
            at = with_entry(at, j, value)
        cc, cg = looked_up(self, at)
        command = min(max(cc, 0.0), self.most[0]), min(max(cg, 0.0), self.most[1])
        return command, TableState(at, 1.0)


@inlined
def looked_up(law: Any, at: Any) -> Any:
    """Both commands at the quantities `at`: the corners of the cell around them, each with its share. [Nms]"""
    cc, cg = 0.0, 0.0
    axes = len(law.counts)
    for corner in range(1 << axes):
        share, place, begin = 1.0, 0, 0
        for j in range(axes):
            count = int(law.counts[j])
            left, along = cell(law.nodes, begin, count, at[j])
            upper = (corner >> j) & 1
            share = share * (along if upper == 1 else 1.0 - along)
            place = place * count + left + (upper if count > 1 else 0)
            begin += count
        cc += share * law.cc_nodes[place]
        cg += share * law.cg_nodes[place]
    return cc, cg


@inlined
def cell(nodes: Any, begin: int, count: int, value: Any) -> Any:
    """Left node of the interval that a value lies in, counted from `begin`, and the way along it from 0 to 1."""
    left = 0
    while left < count - 2 and nodes[begin + left + 1] <= value:
        left += 1
    if count < 2:
        return left, 0.0 * value
    low, high = nodes[begin + left], nodes[begin + left + 1]
    return left, min(max((value - low) / (high - low), 0.0), 1.0)
