"""The yardstick of a comparison: the best constant pair, and for which sea and device it was searched."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass

from gyroctl.errors import InputError
from gyroctl.froude import growth
from gyroctl.harness.laws import law
from gyroctl.harness.protocol import Law
from gyroctl.harness.registry import build, tuned_sets

BASELINE = "best_constant"
"""Name of the yardstick in every comparison: no other law may bear it."""

PAIR = "constant"
"""The registered law that holds a pair."""

PERIOD = 0.1
"""Its period, for a device of the size of Table 1. [s]"""


@dataclass(frozen=True)
class Yardstick:
    """A constant pair that laws are measured against.

    Parameters
    ----------
    cc, cg : float
        The pair. [Nms]
    searched : bool
        Whether it is the result of a search for the very sea, device and actuators of the comparison.
    words : str
        How it was found, or why it was not searched for; a clause without a full stop.
    key : str
        Hash of all that the search depends on; empty where there was none.
    """

    cc: float
    cg: float
    searched: bool
    words: str
    key: str = ""

    @property
    def law(self) -> Law:
        """The pair as a law."""
        return self.on(1.0)

    def on(self, length: float) -> Law:
        """The pair as a law, whose period is that of a device of a `length` over that of Table 1."""
        period = {} if length == 1.0 else {"period": PERIOD * growth("s", length)}
        return build(PAIR, {"cc": self.cc, "cg": self.cg, **period})

    def record(self) -> str:
        """As JSON, for the attributes of a dataset."""
        return json.dumps(asdict(self))


def shipped_pairs() -> dict[str, tuple[float, float]]:
    """Constant pairs (cc, cg) [Nms] that ship, by the name of their set."""
    sets = tuned_sets(PAIR)
    return {name: (entry["parameters"]["cc"], entry["parameters"]["cg"]) for name, entry in sets.items()}


def with_yardstick(
    laws: Mapping[str, Law], yardstick: Yardstick | None, length: float = 1.0
) -> tuple[dict[str, Law], Yardstick | None]:
    """Put the yardstick among the laws, in the place of a shipped pair that stands there under its name.

    `length` is that of the device over that of Table 1: a shipped pair is then as large as the device.

    Returns
    -------
    laws : dict of str to Law
        As they are compared.
    yardstick : Yardstick or None
        The one among them; without one that was given, what is known of a shipped pair of that name.

    Raises
    ------
    InputError
        For another law under the name of the yardstick.
    """
    taken = laws.get(BASELINE)
    if taken is None:
        return (dict(laws), None) if yardstick is None else ({**laws, BASELINE: yardstick.on(length)}, yardstick)
    if type(taken) is not type(law(PAIR)):
        _refuse(type(taken).__name__)
    pair = (float(taken.cc), float(taken.cg))  # type: ignore[attr-defined]  # the type of the registered law has both
    known = _ships(pair, length) or (yardstick is not None and pair == (yardstick.cc, yardstick.cg))
    if not known:
        _refuse(pair)
    if yardstick is None:
        yardstick = Yardstick(*pair, searched=False, words="the pair that ships for the default device was taken")
    return {**laws, BASELINE: yardstick.on(length)}, yardstick


def _ships(pair: tuple[float, float], length: float) -> bool:
    """Whether a pair is one that ships, at the size of the device."""
    unit, pairs = growth("Nms", length), shipped_pairs().values()
    if length == 1.0:
        return pair in pairs
    return any(all(math.isclose(a, unit * b, rel_tol=1e-9) for a, b in zip(pair, one, strict=True)) for one in pairs)


def _refuse(value: object) -> None:
    problem = "this name is that of the yardstick, the best constant pair that is searched for the sea and the device"
    raise InputError(f"laws.{BASELINE}", value, problem, "Give the law another name; the yardstick is added by itself")
