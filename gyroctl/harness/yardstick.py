"""The yardstick of a comparison: the best constant pair, and for which sea and device it was searched."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass

from gyroctl.errors import InputError
from gyroctl.harness.protocol import Law
from gyroctl.harness.registry import law, tuned_sets

BASELINE = "best_constant"
"""Name of the yardstick in every comparison: no other law may bear it."""

PAIR = "constant"
"""The registered law that holds a pair."""


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
        return law(PAIR, cc=self.cc, cg=self.cg)

    def record(self) -> str:
        """As JSON, for the attributes of a dataset."""
        return json.dumps(asdict(self))


def shipped_pairs() -> dict[str, tuple[float, float]]:
    """Constant pairs (cc, cg) [Nms] that ship, by the name of their set."""
    sets = tuned_sets(PAIR)
    return {name: (entry["parameters"]["cc"], entry["parameters"]["cg"]) for name, entry in sets.items()}


def with_yardstick(laws: Mapping[str, Law], yardstick: Yardstick | None) -> tuple[dict[str, Law], Yardstick | None]:
    """Put the yardstick among the laws, in the place of a shipped pair that stands there under its name.

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
        return (dict(laws), None) if yardstick is None else ({**laws, BASELINE: yardstick.law}, yardstick)
    if type(taken) is not type(law(PAIR)):
        _refuse(type(taken).__name__)
    pair = (float(taken.cc), float(taken.cg))  # type: ignore[attr-defined]  # the type of the registered law has both
    known = pair in shipped_pairs().values() or (yardstick is not None and pair == (yardstick.cc, yardstick.cg))
    if not known:
        _refuse(pair)
    if yardstick is None:
        yardstick = Yardstick(*pair, searched=False, words="the pair that ships for the default device was taken")
    return {**laws, BASELINE: yardstick.law}, yardstick


def _refuse(value: object) -> None:
    problem = "this name is that of the yardstick, the best constant pair that is searched for the sea and the device"
    raise InputError(f"laws.{BASELINE}", value, problem, "Give the law another name; the yardstick is added by itself")
