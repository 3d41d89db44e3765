"""Numbers as text: the same rounding in the report, the figures and the table."""

from __future__ import annotations

import math

from gyroctl.statistics import Estimate

NOTHING = "–"


def number(value: float | None, digits: int = 3) -> str:
    """`value` rounded to significant digits, no exponent between 1e-4 and 1e6; an en dash for NaN, a sign for infinity.

    Parameters
    ----------
    value : float or None
        Number to print.
    digits : int
        Significant digits.
    """
    if value is None or math.isnan(value):
        return NOTHING
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    if value == 0.0:
        return "0"
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    if not 1e-4 <= abs(value) < 1e6:
        return f"{mantissa}e{int(exponent)}".replace("-", "−")
    rounded = float(f"{mantissa}e{exponent}")
    # Decimals from the rounded exponent: 9.999 becomes 10.0, not 10.00.
    return f"{rounded:.{max(digits - 1 - int(exponent), 0)}f}".replace("-", "−")


def watts(value: float) -> str:
    """Power flow with two decimals, so that a column adds up by eye; never a negative zero."""
    return NOTHING if not math.isfinite(value) else f"{round(value, 2) + 0.0:.2f}".replace("-", "−")


def percent(share: float) -> str:
    """Percentage with one decimal, empty for NaN; never a negative zero."""
    return "" if not math.isfinite(share) else f"{round(share, 1) + 0.0:.1f} %".replace("-", "−")


def interval(estimate: Estimate, digits: int = 3) -> str:
    """Interval as ``low to high``, empty where there is none, ``> low`` where it is open above."""
    if math.isnan(estimate.low):
        return ""
    if math.isinf(estimate.high):
        return f"> {number(estimate.low, digits)}"
    return f"{number(estimate.low, digits)} to {number(estimate.high, digits)}"


def signed(value: float, digits: int = 3) -> str:
    """`value` with its sign written out."""
    return f"+{number(value, digits)}" if value > 0 else number(value, digits)


def listed(items: list[str]) -> str:
    """English enumeration: ``a``, ``a and b``, ``a, b and c``."""
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} and {items[-1]}" if items else "none"


def seed_ranges(seeds: tuple[int, ...]) -> str:
    """Seeds in ascending order with runs shortened: ``1 to 8, 12``."""
    ordered, parts = sorted(set(seeds)), []
    start = 0
    for end in range(1, len(ordered) + 1):
        if end == len(ordered) or ordered[end] != ordered[end - 1] + 1:
            first, last = ordered[start], ordered[end - 1]
            parts.append(
                str(first) if first == last else f"{first}, {last}" if last == first + 1 else f"{first} to {last}"
            )
            start = end
    return ", ".join(parts) if parts else "none"


def sees(information: str, preview: float) -> str:
    """Say what a law sees, and how far ahead where it is told some seconds of the waves: ``forecast 2 s``."""
    ahead = information in ("forecast", "oracle") and math.isfinite(preview)
    return f"{information} {plain(preview)} s" if ahead else information


def plain(value: float) -> str:
    """Write a given value (a setting, not a result) as short as can be: ``600``, ``0.35``."""
    return f"{value:g}"


def integer(count: int | None) -> str:
    """Write a count, an en dash where nothing was counted."""
    return NOTHING if count is None else str(count)


def minutes(seconds: float) -> str:
    """Time in minutes, the one unit of time to lose lock in tables, so that rows compare at a glance."""
    return number(seconds / 60.0)


def minutes_interval(estimate: Estimate) -> str:
    """Interval of a time [s] in minutes, empty where there is none, ``> low`` where it is open above."""
    return interval(Estimate(estimate.value / 60.0, estimate.low / 60.0, estimate.high / 60.0))
