"""Numbers that can be run and are more often a slip of the unit than a wish: remarks before the runs, few refusals."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from gyroctl.errors import InputError
from gyroctl.harness.actuation import Actuators
from gyroctl.harness.registry import registered
from gyroctl.plant import Plant
from gyroctl.waves import DirectionalSpectrum, ElevationRecord, Sea, SpreadSea, TabulatedSpectrum
from gyroctl.waves.excitation import band
from gyroctl.waves.physical import check_sea

USUAL = 3.14
"""Peak frequency that the device of Table 1 is made for. [rad/s]"""

FAR = 2.0
"""Factor from it from which on a peak is told. [-]"""

LAG_SAID, LAG_MAX = 1.0, 5.0
"""Peak periods of the sea from which on a lag of an actuator is told, and refused: nothing is controlled there. [-]"""

CUT = 0.95
"""Commands that were cut to a limit over all samples of a run, from which on it is told. [-]"""

ANGLE = 0.005
"""Difference from a multiple of a right angle in radians that is rounding to three digits. [rad]"""


PARTS = ("share", "eased", "spared")
"""Parameters of the laws of this package that are a part of something, from 0 to 1."""


def remarks(
    plant: Plant, sea: Sea, laws: Mapping[str, Any] | None = None, actuators: Actuators | None = None
) -> list[str]:
    """What is odd about sea, laws and actuators for a device, a sentence without a full stop each.

    Parameters
    ----------
    plant : Plant
        The device; its length sets what is usual.
    sea : any sea of this package
        The waves.
    laws : mapping of str to Law, optional
        Laws by the names that they have in the run.
    actuators : Actuators, optional
        Between laws and plant.

    Returns
    -------
    list of str
        Empty where nothing is odd.
    """
    said = [*_of_peak(plant, sea), *_of_heading(sea)]
    if actuators is not None:
        said += _of_lags(actuators, sea)
        for name, law in (laws or {}).items():
            said += _of_constants(name, law, actuators)
    return said


def is_far(plant: Plant, wp: float) -> bool:
    """Whether a peak frequency [rad/s] is far from the one that a device of this length is made for."""
    return not 1.0 / FAR <= wp * plant.parameters.time_scale / USUAL <= FAR


def far_seas(plant: Plant, seas: Sequence[Sea], shares: Sequence[float]) -> list[str]:
    """Tell of a site most of whose sea states, by their shares of the year, are far from what a device is made for."""
    far = [(sea.wp, share) for sea, share in zip(seas, shares, strict=True) if is_far(plant, sea.wp)]
    part = sum(share for _, share in far)
    if not part > 0.5 * sum(shares):
        return []
    usual = USUAL / plant.parameters.time_scale
    mean = sum(wp * share for wp, share in far) / part
    told = (
        f"in most of the sea states that occur the peak, {mean:.3g} rad/s in the mean, is more than {FAR:g} times off "
    )
    return [
        f"{told}the {usual:.3g} rad/s that the plant is made for. --scale tells how much larger the site's device is"
    ]


def check_lags(actuators: Actuators, sea: Sea) -> None:
    """Refuse a lag that lasts for many waves.

    Raises
    ------
    InputError
        Field ``actuators.cc_lag`` or ``actuators.cg_lag``.
    """
    for name, lag, periods in _lags(actuators, sea):
        if periods > LAG_MAX:
            problem = f"lasts {periods:.3g} peak periods of the sea: the control would follow nothing"
            mend = f"Give a time constant in seconds of at most {LAG_MAX:g} periods; {lag:g} ms are {1e-3 * lag:g}"
            raise InputError(f"actuators.{name}", lag, problem, mend)


def check_parts(name: str, parameters: Mapping[str, Any], label: str = "") -> None:
    """Refuse a part outside 0 to 1 among parameters that somebody typed; a search may try what it likes.

    Parameters
    ----------
    name : str
        Registered name; laws in files of users are not looked at, nor are those of other packages.
    parameters : mapping
        Of the law; those of a law that it wraps may stand within.
    label : str
        Name of the law in the message, where it has another one.

    Raises
    ------
    InputError
        Field ``laws.NAME.share`` or another of `PARTS`.
    """
    label, points = label or name, registered()
    wraps = parameters.get("wraps")
    if isinstance(wraps, Mapping):
        check_parts(str(wraps.get("law", "")), wraps, f"{label}.wraps")
    if name not in points or not points[name].value.startswith("gyroctl."):
        return
    for key in PARTS:
        value = parameters.get(key)
        if isinstance(value, float | int) and not 0.0 <= value <= 1.0:
            mend = f"Give it from 0 to 1; {value:g} per cent are {0.01 * value:g}" if value > 1.0 else "Give 0 or more"
            raise InputError(f"laws.{label}.{key}", value, "is a part, and must be from 0 to 1", mend)


def cut_all_the_time(name: str, cut: float, samples: float) -> list[str]:
    """Tell of a law whose commands were beyond the limits in nearly all samples of its runs, one channel or both."""
    if not cut >= CUT * samples:
        return []
    return [
        f"laws.{name}: in {samples:.0f} samples of a run at least {cut:.0f} commands were cut to the limits, which "
        "were in control and not the law. Its commands are to be in Nms, as actuators.cc_max and cg_max"
    ]


def _of_peak(plant: Plant, sea: Sea) -> list[str]:
    wp, made_for = sea.wp, USUAL / plant.parameters.time_scale
    if not is_far(plant, wp) or _refused(plant, sea):
        return []
    ratio, side = (made_for / wp, "below") if wp < made_for else (wp / made_for, "above")
    still = sea.sea if isinstance(sea, SpreadSea) else sea
    if isinstance(still, TabulatedSpectrum | DirectionalSpectrum | ElevationRecord):
        mend = "Are its times or frequencies in the unit that is said? A sea of another size is brought here by scale"
    elif not is_far(plant, 2.0 * math.pi * wp):
        mend = f"If it is meant in Hz, give wp = {2.0 * math.pi * wp:.4g}"
    elif not is_far(plant, 2.0 * math.pi / wp):
        mend = f"If it is a period in seconds, give tp = {wp:.4g}"
    else:
        mend = "Give wp in rad/s, or the peak period as tp in seconds, at the size of this device"
    told = (
        f"sea.wp = {wp:.4g} rad/s (Tp {2.0 * math.pi / wp:.3g} s) is {ratio:.2g} times {side} the {made_for:.3g} rad/s"
    )
    return [f"{told} that a device of this length is made for. {mend}"]


def _refused(plant: Plant, sea: Sea) -> bool:
    """Whether a run refuses the sea by an error of its own: beyond the excitation's table, or higher than can be."""
    low, high = band(plant.excitation)
    try:
        check_sea(plant, sea)
    except InputError:
        return True
    return not low <= sea.wp <= high


def _of_heading(sea: Sea) -> list[str]:
    heading = float(sea.heading)
    quarters = round(heading / (0.5 * math.pi))
    typed = not isinstance(sea, DirectionalSpectrum)
    if not typed or not 1 <= abs(quarters) <= 4 or abs(heading - 0.5 * math.pi * quarters) > ANGLE:
        return []
    degrees = 90 * quarters - (math.copysign(360, quarters) if abs(quarters) > 2 else 0)
    return [f"sea.heading = {heading:g} is in degrees. If radians are meant, give heading = {degrees:g}"]


def _of_lags(actuators: Actuators, sea: Sea) -> list[str]:
    return [
        f"actuators.{name} = {lag:g} s lasts {periods:.3g} peak periods of the sea. For ms give {1e-3 * lag:g}"
        for name, lag, periods in _lags(actuators, sea)
        if periods > LAG_SAID
    ]


def _lags(actuators: Actuators, sea: Sea) -> list[tuple[str, float, float]]:
    """Both lags by name: time constant [s], and in peak periods of the sea."""
    own = {"cc_lag": actuators.cc_lag, "cg_lag": actuators.cg_lag}
    return [(name, lag, lag * sea.wp / (2.0 * math.pi)) for name, lag in own.items()]


def _of_constants(name: str, law: Any, actuators: Actuators) -> list[str]:
    """Tell of a constant control of a law that is beyond its limit: it is cut to it at every sample."""
    said = []
    for control, limit in (("cc", actuators.cc_max), ("cg", actuators.cg_max)):
        value = getattr(law, control, None)
        if isinstance(value, float | int) and value > limit:
            end = f"actuators.{control}_max = {limit:g} Nms: it acts as {control} = {limit:g}"
            said.append(f"laws.{name}.{control} = {value:g} Nms is always cut to {end}")
    return said
