"""What laws are to reach in real water, as data, and whether they do: met, not met, or open."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

from gyroctl.harness.registry import REAL
from gyroctl.statistics import Estimate
from gyroctl.studies.evaluation.entrants import ALL, Kind
from gyroctl.studies.evaluation.real_lines import SINGLE_CV, SINGLE_POWER, TIMES, Line

Verdict = Literal["met", "not met", "open"]

MET, NOT_MET, OPEN = "met", "not met", "open"

MEASURES: Mapping[str, Callable[[Line], Estimate]] = {
    "mean power [W]": lambda line: line.row.power,
    f"power less {TIMES:g} times the best constant pair's [W]": lambda line: line.over,
    "CV of power": lambda line: line.row.cv,
    "share of runs locked": lambda line: line.row.lock,
    "share of runs in step": lambda line: line.row.step,
    "share of runs without a reversal": lambda line: line.forward,
    f"share of runs with {SINGLE_POWER:g} W at CV {SINGLE_CV:g}": lambda line: line.single,
    "98 % of φ1 less the pair's [rad]": lambda line: line.phi1_less,
    "98 % of φ3 [rad]": lambda line: line.phi3,
}
"""What is measured, by its name in the tables."""

POWER, OVER, CV, LOCKED, IN_STEP, FORWARD, SINGLE, PHI1_LESS, PHI3 = MEASURES


class Demand(NamedTuple):
    """A limit of a measure."""

    measure: str  # of `MEASURES`
    limit: float
    most: bool = False  # the limit is the largest value that is allowed; else the least

    @property
    def words(self) -> str:
        """The limit as it is read."""
        return f"{'at most' if self.most else 'at least'} {self.limit:g}"

    def keeps(self, value: float) -> bool:
        """Whether a value keeps the limit; what is no number does not."""
        return value <= self.limit if self.most else value >= self.limit

    def gap(self, value: float) -> float:
        """How far a value is from the limit, in parts of it where it has a size; 0 where it keeps it."""
        far = abs(value - self.limit) / (abs(self.limit) or 1.0)
        return 0.0 if self.keeps(value) else far if math.isfinite(far) else 1.0


def least(measure: str, limit: float) -> Demand:
    """Demand that a measure is no smaller."""
    return Demand(measure, limit)


def most(measure: str, limit: float) -> Demand:
    """Demand that a measure is no larger."""
    return Demand(measure, limit, most=True)


@dataclass(frozen=True)
class Target:
    """Demands that one law of a kind, from its sensors, is to keep all at once."""

    name: str
    gamma: float  # sea
    kind: Kind
    demands: tuple[Demand, ...]
    one_set: bool = False  # only with parameters that are the same in all seas

    def concerns(self, line: Line) -> bool:
        """Whether the line may answer the target."""
        row = line.row
        same = row.tuning in (ALL, REAL) or not self.one_set
        return row.kind == self.kind and row.information == "sensors" and same

    def missed(self, line: Line) -> list[str]:
        """Measures whose limits a line does not keep."""
        return [demand.measure for demand in self.demands if not demand.keeps(_value(demand, line))]

    def shortfall(self, line: Line) -> float:
        """How far a line is from the target, the gaps of all demands together."""
        return sum(demand.gap(_value(demand, line)) for demand in self.demands)


class Finding(NamedTuple):
    """A demand and what was found of it."""

    demand: Demand
    found: Estimate | None
    verdict: Verdict
    sure: bool  # whether every value of the interval gives the same verdict

    def record(self) -> dict[str, Any]:
        """For the JSON file."""
        told = {"measure": self.demand.measure, "demand": self.demand.words}
        return {**told, "found": self.found, "verdict": self.verdict, "sure": self.sure}


class Answer(NamedTuple):
    """Answer to a target: the law that meets it or comes nearest, empty where none was run, and each demand."""

    target: Target
    law: str
    findings: tuple[Finding, ...]

    @property
    def verdict(self) -> Verdict:
        """Of the whole target."""
        told = {finding.verdict for finding in self.findings}
        return "not met" if NOT_MET in told else "open" if OPEN in told else "met"

    def record(self) -> dict[str, Any]:
        """For the JSON file."""
        head = {"name": self.target.name, "gamma": self.target.gamma, "law": self.law, "verdict": self.verdict}
        return {**head, "demands": [finding.record() for finding in self.findings]}


def _targets() -> tuple[Target, ...]:
    whole = (least(LOCKED, 0.99), least(IN_STEP, 0.99))
    planning = (least(POWER, 11.0), most(CV, 0.20), *whole, least(FORWARD, 0.95), least(SINGLE, 0.95))
    motion = (most(PHI1_LESS, 0.0), most(PHI3, 0.25))
    abroad = (least(OVER, 0.0), least(LOCKED, 0.98), least(FORWARD, 0.90))
    simple = (least(POWER, 4.5), *whole, least(FORWARD, 0.95))
    smooth = (least(POWER, 3.5), most(CV, 0.35), *whole)
    return (
        Target("planning law", 5.0, "planning", (*planning, *motion), one_set=True),
        Target("planning law, same parameters", 1.0, "planning", abroad, one_set=True),
        Target("planning law, same parameters", 50.0, "planning", abroad, one_set=True),
        Target("a simple law, most power", 5.0, "simple", simple),
        Target("a simple law, smooth", 5.0, "simple", smooth),
    )


TARGETS = _targets()
"""In the default sea and in two others."""


def answers(tables: Mapping[float, Sequence[Line]]) -> list[Answer]:
    """Answers to all targets; those of a sea that was not run are open."""
    return [answer(target, tables.get(target.gamma, ())) for target in TARGETS]


def answer(target: Target, table: Sequence[Line]) -> Answer:
    """Answer from the lines of the target's sea: the strongest law that meets it, or the one that comes nearest."""
    concerned = [line for line in table if target.concerns(line)]
    if not concerned:
        return Answer(target, "", tuple(Finding(demand, None, "open", sure=False) for demand in target.demands))
    meeting = [line for line in concerned if not target.missed(line)]
    best = max(meeting, key=lambda line: line.row.power.value) if meeting else min(concerned, key=target.shortfall)
    return Answer(target, best.row.law, tuple(finding(demand, best) for demand in target.demands))


def finding(demand: Demand, line: Line) -> Finding:
    """Judge a demand by the number of the table; what is no number leaves it open."""
    found = MEASURES[demand.measure](line)
    if not math.isfinite(found.value):
        return Finding(demand, found, "open", sure=False)
    met = demand.keeps(found.value)
    ends = (found.low, found.high)
    sure = all(math.isfinite(end) and demand.keeps(end) == met for end in ends)
    return Finding(demand, found, "met" if met else "not met", sure)


def _value(demand: Demand, line: Line) -> float:
    return MEASURES[demand.measure](line).value
