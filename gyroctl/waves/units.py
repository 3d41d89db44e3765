"""Units of what a file of waves holds: by its heading or by an option, converted or refused, never guessed."""

from __future__ import annotations

import math
import re

from gyroctl.errors import InputError

LENGTHS = {"m": 1.0, "dm": 0.1, "cm": 0.01, "mm": 0.001, "ft": 0.3048}
"""Units of an elevation. [m]"""

TIMES = {"s": 1.0, "sec": 1.0, "seconds": 1.0, "ms": 0.001, "min": 60.0, "h": 3600.0, "d": 86400.0}
"""Units of a time. [s]"""

FREQUENCIES = {"hz": 2.0 * math.pi, "mhz": 0.002 * math.pi, "rad/s": 1.0, "rads-1": 1.0, "rad_s": 1.0, "rad/sec": 1.0}
"""Units of a frequency. [rad/s]"""

ANGULAR = ("omega", "ω", "w")
"""Names that mean an angular frequency."""

_DENSITY = re.compile(r"(?P<length>m|cm|mm)2(?P<per>/hz|hz-1|s/rad|/\(rad/s\)|/rad/s|srad-1|s)")


def scale_of(field: str, given: str | None, heading: str, known: dict[str, float], usual: str) -> float:
    """Factor to the SI unit: of what is `given`, else of the heading's unit, else of the `usual` one.

    Raises
    ------
    InputError
        A unit that is not among the `known`, or another one than the heading names.
    """
    for unit in (given, heading):
        if unit and _plain(unit) not in known:
            mend = f"Give one of {', '.join(known)}" if unit == given else f"Convert it to one of {', '.join(known)}"
            raise InputError(field, unit, "is no unit that is known here", mend)
    if given and heading and known[_plain(given)] != known[_plain(heading)]:
        raise InputError(
            field, given, f"the heading of the file says {heading}", "Leave the option out, or mend the file"
        )
    return known[_plain(given or heading or usual)]


def of_spectrum(given: str | None, axis: tuple[str, str], density: tuple[str, str]) -> tuple[float, float, str]:
    """Factors of a spectrum to rad/s and to m^2 s, and what was taken for granted, "" for nothing.

    Parameters
    ----------
    given : str or None
        The option: "Hz" or "rad/s", for the frequency and for the density over it.
    axis, density : pair of str
        Name and unit as the heading has them, "" where it does not.

    Raises
    ------
    InputError
        Field ``sea.unit``: no unit of frequency at all, an unknown one, or one that contradicts the heading.
    """
    mend = 'Give unit = "Hz" or unit = "rad/s", or a heading such as f [Hz], S [m2/Hz]'
    heading = axis[1] or ("rad/s" if axis[0].lower() in ANGULAR else "")
    if _plain(axis[1]) in TIMES:
        raise InputError("sea.unit", axis[1], "the spectrum stands over the period", "Give it over the frequency")
    if not given and not heading:
        what = axis[0] or "no heading"
        raise InputError("sea.unit", what, "the file does not say the unit of its frequencies", mend)
    turn = scale_of("sea.unit", given, heading, FREQUENCIES, "rad/s")
    over_hz = turn != 1.0
    argument = _plain(density[1]) in ("f", *ANGULAR)  # S(f) names what it is a function of
    unit = "" if argument else density[1]
    found = _DENSITY.fullmatch(_plain(unit))
    if not unit:
        per, size = ("hz" if over_hz else "rad"), 1.0
    elif found is None:
        raise InputError("sea.unit", unit, "is no unit of a spectral density", "Give m2/Hz or m2 s/rad")
    else:
        size = LENGTHS[found["length"]] ** 2
        per = "hz" if "hz" in found["per"] else "rad" if "rad" in found["per"] else "hz" if over_hz else "rad"
    said = ""
    if not unit and not given:
        said = f"densities taken per {'Hz' if over_hz else 'rad/s'}, as the frequencies: the heading names no unit"
    return turn, size / (2.0 * math.pi) if per == "hz" else size, said


def _plain(unit: str) -> str:
    """Unit as it is compared: small letters, no blanks, powers as figures."""
    small = unit.lower().replace("²", "2").replace("⁻¹", "-1").replace("−", "-").replace("·", "").replace("*", "")
    return re.sub(r"[\s^.]", "", small)
