"""Does the order of the laws change in real water, and which choice turns it? The answer as data and in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from gyroctl.reports.wording import listed, number
from gyroctl.studies.evaluation.order import HOLDS, Change, Lost, Order
from gyroctl.studies.evaluation.real_water import LINEAR, Water


@dataclass(frozen=True)
class Judged:
    """A case against the linear plant."""

    water: Water
    order: Order
    holding: tuple[str, ...]  # laws that hold lock
    changes: tuple[Change, ...]  # pairs of laws that stand to each other otherwise than in the linear plant
    lost: tuple[Lost, ...]  # laws that hold lock in fewer runs than there

    def record(self) -> dict[str, Any]:
        """For the JSON file."""
        return {
            "laws": list(self.order.laws),
            "words": self.order.words,
            "holding": list(self.holding),
            "pairs": [pair._asdict() for pair in self.order.pairs],
            "changes": [change._asdict() for change in self.changes],
            "lost": [lost._asdict() for lost in self.lost],
        }


def answer(judged: Mapping[str, Judged]) -> dict[str, Any]:
    """Name the cases that turn the order and those that take the lock.

    Returns
    -------
    dict
        ``linear``: the order there in words. Then lists of entries with the case and its laws. ``turned``: two laws
        that both hold lock stand the other way round, both differences told from chance; ``turned_lost``: the same
        where one of them does not hold lock; ``parted``, ``blurred``, ``exchanged``: see `order.Change`;
        ``takes_lock``: a law loses lock, told from chance; ``costs_lock``: within what chance explains.
    """
    lists = ("turned", "turned_lost", "parted", "blurred", "exchanged", "takes_lock", "costs_lock")
    found: dict[str, Any] = {name: [] for name in lists}
    for name, case in judged.items():
        for change in case.changes:
            kind = "turned_lost" if change.kind == "turned" and change.lost else change.kind
            found[kind].append({"case": name, "single": case.water.single, **change._asdict()})
        for lost in case.lost:
            where = "takes_lock" if lost.sure else "costs_lock"
            found[where].append({"case": name, "single": case.water.single, **lost._asdict()})
    return {"linear": judged[LINEAR].order.words, "cases": len(judged) - 1, **found}


def in_sentences(found: Mapping[str, Any]) -> list[str]:
    """Say the answer, a paragraph each; the names of cases in italics, since some have commas."""
    told = [f"In the linear plant: {found['linear']}."]
    held = f"that hold lock (in {100 * HOLDS:g} % of their runs)"
    if found["turned"]:
        told.append(f"The order of laws {held} turns: {_changed(found['turned'])}.")
    else:
        told.append(f"No choice turns the order of two laws {held} in a way that could be told from chance.")
    for name, words in (
        ("turned_lost", "It turns where lock is lost"),
        ("parted", "Told apart there and not in the linear plant"),
        ("blurred", "No longer told apart"),
        ("exchanged", "Exchanged within what chance explains"),
    ):
        if found[name]:
            told.append(f"{words}: {_changed(found[name])}.")
    if found["takes_lock"]:
        told.append(f"Lock is taken from {_lost(found['takes_lock'])}.")
    else:
        told.append("No choice takes the lock of a law in a way that could be told from chance.")
    if found["costs_lock"]:
        told.append(f"Fewer runs hold lock, within what chance explains, of {_lost(found['costs_lock'])}.")
    return told


def _changed(entries: Sequence[Mapping[str, Any]]) -> str:
    """Pairs of laws with their cases: the same two in many cases are one entry."""
    found: dict[str, list[str]] = {}
    for entry in entries:
        lost = [f"`{law}`" for law in entry["lost"]]
        without = ["", f", {''.join(lost)} without lock", ", both without lock"][len(lost)]
        words = f"*{entry['case']}* ({number(entry['here'].value, 2)} W{without})"
        found.setdefault(f"`{entry['first']}` before `{entry['second']}`", []).append(words)
    return "; ".join(f"{pair} in {listed(cases)}" for pair, cases in found.items())


def _lost(entries: Sequence[Mapping[str, Any]]) -> str:
    """Laws with the cases in which they lose lock."""
    found: dict[str, list[str]] = {}
    for entry in entries:
        before = "" if entry["held_before"] == entry["runs"] else f", linear {entry['held_before']}"
        words = f"*{entry['case']}* ({entry['held']} of {entry['runs']}{before})"
        found.setdefault(f"`{entry['law']}`", []).append(words)
    return "; ".join(f"{law} in {listed(cases)}" for law, cases in found.items())
