"""Elevation records from a text file: stamps, units, gaps, drift, each by a named rule and told."""

from __future__ import annotations

import math
import os
from datetime import datetime
from os import PathLike

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import NOT_GIVEN, InputError
from gyroctl.waves.checks import finite, positive
from gyroctl.waves.columns import FIELD, Column, read_columns
from gyroctl.waves.plausible import SLOW, check_content, content_of
from gyroctl.waves.record import ElevationRecord, check_times
from gyroctl.waves.units import LENGTHS, TIMES, scale_of

GAPS = ("linear", "spline")
DETREND = ("linear", "high-pass")

SCALE_MAX = 1000.0
"""Largest length of a prototype over that of its model."""

COUNTS = ("n", "i", "k", "#", "no", "no.", "nr", "number", "index", "sample", "samples", "count", "row")
"""Names of columns that count."""

STILL = 8
"""Fewest equal elevations in a row, over a quarter of a wave at least, that are told: a probe that stood still."""

_WHAT = "time [s], elevation [m]"


def read_record(
    path: str | PathLike[str],
    heading: float = 0.0,
    *,
    unit: str | None = None,
    clock: str | None = None,
    column: str | None = None,
    gaps: str | None = None,
    longest: float | None = None,
    detrend: str | None = None,
    cutoff: float | None = None,
    scale: float = 1.0,
) -> ElevationRecord:
    """Read an elevation record from a text file of columns, see `read_columns`.

    What is done to the numbers, and what is notable about them, stands in `notes` of the record.

    Parameters
    ----------
    path : str or Path
        The file: times in seconds or another unit of the heading, or as ISO 8601 stamps; elevations in metres or
        another unit of the heading.
    heading : float
        Direction the waves travel to. [deg]
    unit : str, optional
        Unit of the elevations, where the heading does not say it: m, dm, cm, mm or ft. Metres without both.
    clock, column : str, optional
        Names of the columns of times and of elevations; without them the first, and the second of two.
    gaps : str, optional
        How times without a number are filled: "linear" between the neighbours, or by a cubic "spline" through the
        record. Without it a gap is refused.
    longest : float, optional
        Longest gap that is filled, from sample to sample; needed with `gaps`. [s]
    detrend : str, optional
        Drift to take off: a "linear" trend, or all that is slower than `cutoff`, by a "high-pass" (Butterworth, fourth
        order, forwards and backwards).
    cutoff : float, optional
        Without it a fifth of the peak frequency. [rad/s]
    scale : float
        Length of what was measured over that of the model, by Froude: elevations shrink by it, times by its root. [-]

    Returns
    -------
    ElevationRecord

    Raises
    ------
    InputError
        Field ``sea.file`` for the file and its lines, ``sea.unit``, ``sea.clock``, ``sea.column``, ``sea.gaps``,
        ``sea.longest``, ``sea.detrend``, ``sea.cutoff``, ``sea.scale`` for the options; ``sea.time`` for gaps, times
        that do not rise and a sampling that cuts the waves, ``sea.eta`` for drift.
    """
    _check_choices(gaps, longest, detrend, cutoff)
    shrink = scale_factor(scale)
    first, second = read_columns(path, _WHAT, (clock, column))
    mend = f"Give a text file with two columns of numbers: {_WHAT}"
    factor = scale_of("sea.unit", unit, second.unit, LENGTHS, "m")
    eta = second.numbers(os.fspath(path), mend, missing=True) * factor / shrink
    time = _times(first, os.fspath(path), mend) / math.sqrt(shrink)
    notes = [*first.notes, *second.notes]
    if factor != 1.0:
        notes.append(f"elevations converted from {unit or second.unit} to m")
    time, eta = _filled(time, eta, second, gaps, longest, str(path), notes)
    record = _without_drift(ElevationRecord(time, eta, heading), detrend, cutoff, notes)
    told = (*check_content(record.surface, record.step), *_standing(record))
    return record.noted((*notes, *record.notes, *told))


def _standing(record: ElevationRecord) -> tuple[str, ...]:
    """Tell the longest stretch in which the elevation does not change at all: a probe that is stuck, or dry."""
    changes = np.flatnonzero(np.append(np.diff(record.eta) != 0.0, True))
    lengths = np.diff(np.insert(changes, 0, -1))
    longest = int(np.argmax(lengths))
    count, last = int(lengths[longest]), int(changes[longest])
    if count < STILL or (count - 1) * record.step < 0.25 * 2.0 * math.pi / record.wp:
        return ()
    begin = float(record.time[last - count + 1])
    return (f"the elevation stands still for {(count - 1) * record.step:.3g} s from {begin:.6g} s on",)


def scale_factor(scale: object) -> float:
    """Return a scale by Froude.

    Raises
    ------
    InputError
        Field ``sea.scale``.
    """
    mend = "Give the length of the prototype over that of the model, for example 20"
    number = positive("sea.scale", scale, mend)
    if not 1.0 / SCALE_MAX <= number <= SCALE_MAX:
        raise InputError("sea.scale", scale, f"must be between {1.0 / SCALE_MAX:g} and {SCALE_MAX:g}", mend)
    return number


def _check_choices(gaps: object, longest: object, detrend: object, cutoff: object) -> None:
    for field, value, known in (("sea.gaps", gaps, GAPS), ("sea.detrend", detrend, DETREND)):
        if value is not None and value not in known:
            raise InputError(field, value, "unknown rule", f"Choose one of {', '.join(known)}, or leave it out")
    if longest is not None:
        positive("sea.longest", longest, "Give the longest gap that may be filled, in seconds, for example 1")
    if (gaps is None) != (longest is None):
        field, problem = ("sea.gaps", "no rule") if gaps is None else ("sea.longest", "no length")
        mend = 'Give gaps = "linear" and longest = the longest gap to fill [s]'
        raise InputError(field, NOT_GIVEN, f"{problem} is given to fill gaps by", mend)
    if cutoff is not None:
        positive("sea.cutoff", cutoff, "Give a frequency in rad/s, below that of the waves")
        if detrend != "high-pass":
            mend = 'Give detrend = "high-pass" too, or leave it out'
            raise InputError("sea.cutoff", cutoff, "is of no use without a high-pass", mend)


def _times(column: Column, path: str, mend: str) -> NDArray[np.float64]:
    """Times in seconds: numbers in the heading's unit, or ISO 8601 stamps, counted from the first."""
    if column.name.lower() in COUNTS:
        problem = "counts samples: their time is not said"
        raise InputError("sea.clock", column.name, problem, "Give clock = the name of a column of times")
    if "-" not in column.cells[0][1:] or "e-" in column.cells[0].lower():
        return column.numbers(path, mend) * scale_of("sea.clock", None, column.unit, TIMES, "s")
    stamps: list[datetime] = []
    for line, cell in zip(column.lines, column.cells, strict=True):
        try:
            stamps.append(datetime.fromisoformat(cell))
        except ValueError:
            problem = f"line {line} has no time stamp: {cell[:60]!r}"
            raise InputError(FIELD, path, problem, "Give seconds, or stamps such as 2024-05-01T12:00:00.25") from None
    if len({stamp.tzinfo is None for stamp in stamps}) > 1:
        raise InputError(FIELD, path, "some stamps have a time zone and some have none", "Give all in one time zone")
    return np.array([(stamp - stamps[0]).total_seconds() for stamp in stamps])


def _filled(
    time: NDArray[np.float64],
    eta: NDArray[np.float64],
    column: Column,
    gaps: str | None,
    longest: float | None,
    path: str,
    notes: list[str],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Record without times that have no elevation, its gaps filled by the rule that was asked for."""
    known = np.isfinite(eta)
    if not np.all(known) and gaps is None:
        line = column.lines[int(np.argmin(known))]
        problem = f"line {line} is not two finite numbers: {np.count_nonzero(~known)} elevations are missing"
        mend = f'Give gaps = "linear" and longest = the longest gap to fill [s], or a file with two columns: {_WHAT}'
        raise InputError(FIELD, path, problem, mend)
    time, eta = time[known], eta[known]
    if time.size < 2 or gaps is None or longest is None:
        return time, eta
    steps = np.diff(time)
    check_times(time, gaps=True)
    usual = float(np.median(steps))
    wide = np.flatnonzero(steps > 1.5 * usual)
    if not wide.size:
        return time, eta
    worst = int(wide[np.argmax(steps[wide])])
    if steps[worst] > longest + 1e-9:
        problem = f"a gap of {steps[worst]:.4g} s follows, longer than the longest that is filled, {longest:g} s"
        raise InputError("sea.time", float(time[worst]), problem, "Give the part of the record before or after it")
    new = np.concatenate([np.linspace(time[i], time[i + 1], round(steps[i] / usual) + 1)[1:-1] for i in wide])
    if gaps == "spline":
        from scipy.interpolate import CubicSpline

        values = CubicSpline(time, eta)(new)
    else:
        values = np.interp(new, time, eta)
    many = "1 gap" if wide.size == 1 else f"{wide.size} gaps"
    rule = {"linear": "linearly", "spline": "by a cubic spline"}[gaps]
    notes.append(f"{many} of up to {steps[worst]:.4g} s filled {rule}, {new.size} samples of {time.size + new.size}")
    order = np.argsort(np.concatenate((time, new)), kind="stable")
    return np.concatenate((time, new))[order], np.concatenate((eta, values))[order]


def _without_drift(
    record: ElevationRecord, detrend: str | None, cutoff: float | None, notes: list[str]
) -> ElevationRecord:
    even = record.time[0] + record.step * np.arange(record.time.size)
    if detrend == "linear":
        trend = np.polyfit(even - even[0], record.surface, 1)
        notes.append(f"linear trend of {trend[0] * record.duration:.3g} m over the record taken off")
        return ElevationRecord(even, record.surface - np.polyval(trend, even - even[0]), record.heading)
    if detrend == "high-pass":
        from scipy.signal import butter, sosfiltfilt

        trend = np.polyfit(even - even[0], record.surface, 1)
        level = record.surface - np.polyval(trend, even - even[0])  # ends that meet: less for the filter to ring on
        peak = content_of(level, record.step).peak
        limit = finite("sea.cutoff", cutoff or 2.0 * SLOW * peak, "Give rad/s")
        if limit >= min(peak, math.pi / record.step):
            mend = f"Give rad/s, less than the waves at {peak:.3g} rad/s"
            raise InputError("sea.cutoff", limit, "would take off the waves", mend)
        high = sosfiltfilt(butter(4, limit, "highpass", fs=2.0 * math.pi / record.step, output="sos"), level)
        notes.append(f"all slower than {limit:.3g} rad/s taken off, {np.std(record.surface - high):.2g} m of deviation")
        return ElevationRecord(even, np.asarray(high), record.heading)
    return record
