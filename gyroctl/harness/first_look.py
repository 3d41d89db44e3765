"""A first look at a law that was made in a line: its answers to a ring in lock, without a run."""

from __future__ import annotations

import math
from collections.abc import Callable

from gyroctl.errors import InputError
from gyroctl.harness.law_check import Question, pure, repeats, shape
from gyroctl.harness.law_trials import Check
from gyroctl.harness.protocol import Law, Measurement

SAMPLES = 60
"""Samples that are looked at, three waves of 2 s at 0.1 s."""

WP = 3.14
"""Speed of the ring. [rad/s]"""


def first_look(law: Law) -> None:
    """Refuse a law that does not answer, not with numbers, or differently to the same question.

    The machinery is that of ``gyroctl laws check``, which beyond it runs the law and puts shocks to it.

    Raises
    ------
    InputError
        Field ``law_from.source``, with what was found.
    """
    asked = Question(law, tuple(in_lock(law.period)))
    looks: tuple[Callable[[], Check], ...] = (lambda: shape(law), lambda: pure(asked), lambda: repeats(asked))
    for look in looks:
        try:
            found = look()
        except Exception as error:  # whatever a user's code can do
            found = Check("answers", False, f"{type(error).__name__}: {error}", "Correct what the law is made of")
        if not found.passed:
            raise InputError("law_from.source", type(law).__name__, f"{found.name}: {found.found}", found.mend)


def in_lock(period: float) -> list[Measurement]:
    """Measurements of a ring that turns with the wave, and of a float that swings with it."""
    rows = []
    for sample in range(SAMPLES):
        angle = WP * period * sample
        c, s = math.cos(angle), math.sin(angle)
        rows.append(Measurement(angle, WP + 0.1 * c, 70.0 + s, 0.1 * s, 0.06 * c, 0.1 * WP * c, -0.06 * WP * s))
    return rows
