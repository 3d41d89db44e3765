"""Faces of seas and realisations."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np

from gyroctl.faces.show import Face, number
from gyroctl.faces.svg import curves

UNITS = {"hs": "m", "height": "m", "wp": "rad/s", "wp_end": "rad/s", "wp_second": "rad/s", "heading": "deg"}
UNITS |= {"heading_end": "deg", "over": "s", "heights": "m", "frequencies": "rad/s", "gamma": "", "width": "deg"}
WAVES = 3.0
"""Waves of a regular sea in its picture."""

LINES = {"Regular": ("height", "wp"), "Bichromatic": ("heights", "frequencies")}
"""Seas of single lines, and where their heights and frequencies stand."""


def sea_face(sea: Any) -> Face:
    """Tell a sea; pictured by its spectrum, its record, or its elevation where it is made of lines."""
    facts = [(f.name, _value(getattr(sea, f.name), UNITS.get(f.name, ""))) for f in fields(sea) if f.repr]
    for name in ("hs", "wp"):
        if name not in dict(facts) and isinstance(getattr(sea, name, None), float):
            facts.append((name, number(getattr(sea, name), UNITS[name])))
    return Face(type(sea).__name__, facts, lambda: _sea(sea))


def realisation_face(waves: Any) -> Face:
    """Tell a realisation; pictured by its elevation."""
    facts = [
        ("of", repr(waves.sea)),
        ("seed", str(waves.seed)),
        ("duration", number(waves.duration, "s", 6)),
        ("step", number(waves.dt, "s")),
        ("elevation", f"{float(np.std(waves.elevation)):.4g} m standard deviation"),
        ("blended in over", number(waves.blend, "s")),
        ("hash", waves.sha256[:12]),
    ]
    rows = {"elevation": waves.elevation}
    return Face("WaveRealisation", facts, lambda: curves(waves.time, rows, "time [s]", "elevation [m]"))


def _sea(sea: Any) -> str:
    density, time = getattr(sea, "density", None), getattr(sea, "time", None)
    if type(sea).__name__ in LINES:
        heights, frequencies = (np.atleast_1d(getattr(sea, name)) for name in LINES[type(sea).__name__])
        at = np.linspace(0.0, WAVES * 2.0 * np.pi / float(frequencies.min()), 200)
        eta = sum(0.5 * h * np.cos(w * at) for h, w in zip(heights, frequencies, strict=True))
        return curves(at, {"elevation": eta}, "time [s]", "elevation [m]")
    if time is not None and hasattr(sea, "eta"):
        return curves(time, {"elevation": sea.eta}, "time [s]", "elevation [m]")
    if density is not None:
        one = np.asarray(density)
        directions = tuple(i for i in range(one.ndim) if one.shape[i] != sea.omega.size)
        one = one.sum(axis=directions) if one.ndim > 1 else one
        one = one / (float(one.max()) or 1.0)
        return curves(sea.omega, {"spectrum": one}, "frequency [rad/s]", "density over its peak [-]")
    known = getattr(sea, "sea", sea)
    if not hasattr(known, "spectrum"):
        return _change(sea)
    omega = np.linspace(0.2 * float(known.wp), 3.0 * float(known.wp), 200)
    return curves(omega, {"spectrum": known.spectrum(omega)}, "frequency [rad/s]", "density [m^2 s]")


def _change(sea: Any) -> str:
    """What goes from one value to another while the sea lasts."""
    for name in (f.name for f in fields(sea) if hasattr(sea, f"{f.name}_end")):
        title = {"wp": "peak frequency [rad/s]"}.get(name, f"{name} [{UNITS.get(name) or '-'}]")
        course = [getattr(sea, name), getattr(sea, f"{name}_end")]
        return curves([0.0, float(sea.over)], {name: course}, "time [s]", title)
    return ""


def _value(value: Any, unit: str) -> str:
    if isinstance(value, tuple) and all(isinstance(part, int | float) for part in value):
        return f"{', '.join(number(part) for part in value)} {unit}".rstrip()
    return number(value, unit) if isinstance(value, int | float) else str(value)
