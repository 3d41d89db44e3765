"""Peak periods in tables and options: ``tp`` [s] may stand in place of the peak frequency ``wp`` [rad/s]."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

from gyroctl.errors import InputError
from gyroctl.waves.checks import FREQUENCY_MAX, within

PERIODS = {"tp": "wp", "tp_end": "wp_end", "tp_second": "wp_second"}
"""Entries in seconds and those in rad/s for which they stand."""

LONGEST = 1000.0
"""Longest peak period: a tide is no wave. [s]"""


def with_periods(names: Iterable[str]) -> list[str]:
    """Names of entries, the period behind each peak frequency among them."""
    periods = {frequency: period for period, frequency in PERIODS.items()}
    return [each for name in names for each in (name, periods.get(name)) if each is not None]


def peak_frequency(field: str, period: object) -> float:
    """Frequency of a peak period [s]. [rad/s]

    Raises
    ------
    InputError
        Field `field`: no period of a wave.
    """
    least = 2.0 * math.pi / FREQUENCY_MAX
    return 2.0 * math.pi / within(field, period, least, LONGEST, "Give the peak period in seconds, for example 2")


def in_frequencies(path: str, table: Mapping[str, Any]) -> dict[str, Any]:
    """Entries of the table `path` of a sea, its peak periods as peak frequencies.

    Raises
    ------
    InputError
        Field ``PATH.tp`` and the like: no period, or one beside the frequency for which it stands.
    """
    found = {}
    for name, value in table.items():
        frequency = PERIODS.get(name)
        if frequency is None:
            found[name] = value
            continue
        if frequency in table:
            problem = f"stands beside {frequency}, which says the same"
            raise InputError(f"{path}.{name}", value, problem, f"Give {name} in seconds or {frequency} in rad/s")
        found[frequency] = peak_frequency(f"{path}.{name}", value)
    return found
