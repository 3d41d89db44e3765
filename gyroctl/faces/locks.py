"""Faces of what is known of a lock: orbit, modes, linear models, branches, maps, margins."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from gyroctl.faces.show import Face, number
from gyroctl.faces.svg import bars, circle, curves

LAW = "#8C3A8C"


def orbit_face(orbit: Any) -> Face:
    """Tell a locked orbit; pictured by its multipliers in the unit circle."""
    wave = orbit.wave
    facts = [("status", orbit.status)]
    facts += [("wave", f"height {wave.height:g} m, {wave.wp:g} rad/s, heading {wave.heading:g} deg")]
    facts += [("controls", f"cc {orbit.cc:g}, cg {orbit.cg:g} Nms")]
    if orbit.status != "no orbit":
        facts += [
            ("power", number(orbit.power, "W")),
            ("load angle", number(orbit.load_angle, "rad")),
            ("lock share", number(orbit.lock_share)),
            ("largest multiplier", number(np.abs(orbit.multipliers[0]))),
        ]
    facts += [("advice", orbit.advice)] if orbit.advice else []
    facts += [("plant", orbit.plant.name)]
    told = "Floquet multipliers in the unit circle"
    return Face(type(orbit).__name__, facts, lambda: circle(orbit.multipliers, told))


def mode_face(mode: Any) -> Face:
    """Tell a mode."""
    facts = [
        ("decay time", number(mode.decay_time, "s")),
        ("frequency", number(mode.frequency, "rad/s")),
        ("modulus of the multiplier", number(abs(mode.multiplier))),
        ("share", number(mode.share)),
    ]
    pair = [mode.multiplier, mode.multiplier.conjugate()]
    return Face(f"Mode {mode.name}", facts, lambda: circle(pair, f"multipliers of the mode {mode.name}"))


def model_face(model: Any) -> Face:
    """Tell a linear model: its signals, its time, where it holds."""
    facts = [("states", str(len(model.states))), ("inputs", _names(model.inputs)), ("outputs", _names(model.outputs))]
    if hasattr(model, "samples"):
        facts += [("samples", f"{model.samples} of {model.period:.4g} s to a wave of {model.wave_period:.4g} s")]
    elif hasattr(model, "valid_frequency"):
        facts += [("holds up to", f"{model.valid_frequency:.4g} rad/s and {model.valid_angle:.3g} rad of libration")]
        facts += [("poles", ", ".join(f"{p.real:.3g}{p.imag:+.3g}j" for p in model.poles if p.imag >= 0.0) + " 1/s")]
    else:
        facts += [("sampled at", number(model.period, "s"))]
    return Face(type(model).__name__, facts, lambda: _model(model))


def harmonic_face(transfer: Any) -> Face:
    """Tell a harmonic transfer function."""
    model = transfer.model
    facts = [("harmonics", str(model.samples)), ("inputs", _names(model.inputs)), ("outputs", _names(model.outputs))]
    return Face(type(transfer).__name__, facts, lambda: _model(model))


def point_face(point: Any) -> Face:
    """Tell a point of a branch where stability changes."""
    facts = [(point.parameter, number(point.value)), ("frequency", number(point.frequency, "rad/s"))]
    facts += [("multiplier", f"{point.multiplier.real:.4g}{point.multiplier.imag:+.4g}j")]
    return Face(f"SpecialPoint {point.kind}", facts)


def branch_face(branch: Any) -> Face:
    """Tell a branch of orbits; pictured by its power."""
    name = branch.parameter
    facts = [
        ("orbits", f"{branch.values.size}, {int(np.count_nonzero(branch.stable))} of them stable"),
        (name, f"from {branch.values.min():.4g} to {branch.values.max():.4g}"),
        ("power", f"up to {np.nanmax(branch.power):.4g} W"),
        ("changes of stability", _names([point.kind for point in branch.points]) or "none"),
    ]
    return Face(f"Branch over {name}", facts, lambda: curves(branch.values, {"power": branch.power}, name, "power [W]"))


def curve_face(curve: Any) -> Face:
    """Tell a curve of bifurcations; pictured in its two parameters."""
    one, two = curve.parameters
    facts = [("points", str(curve.first.size))]
    for name, values in ((one, curve.first), (two, curve.second)):
        facts += [(name, f"from {values.min():.4g} to {values.max():.4g}")]
    facts += [("ends by", _names(curve.ends))]
    return Face(f"Curve of {curve.kind}", facts, lambda: curves(curve.second, {one: curve.first}, two, one))


def map_face(found: Any) -> Face:
    """Tell a map of lock; pictured by its fold."""
    fold = found.fold
    facts = [
        ("cc", f"from {found.cc.min():.4g} to {found.cc.max():.4g} Nms"),
        ("largest cg", f"up to {fold.first.max():.4g} Nms"),
        ("curves of growing oscillation", str(len(found.neimark_sacker))),
        ("slices", str(len(found.slices))),
    ]
    return Face("LockMap", facts, lambda: curves(fold.second, {"fold": fold.first}, "cc [Nms]", "largest cg [Nms]"))


def margins_face(found: Any) -> Face:
    """Tell the margins of a lock; pictured by its headroom."""
    alone = found.request.law is None
    of = "constant controls" if alone else f"law {found.request.law_name}"
    status = found.status if alone else found.loop_status or "not known"
    facts = [("controls", found.request.controls)] if alone else []
    facts += [("in a", found.request.sea), ("own orbit", status), ("power", number(found.power, "W"))]
    if math.isfinite(found.lock_reserve):
        facts += [("load share", number(found.lock_share)), ("lock reserve", number(found.lock_reserve))]
        facts += [("load angle", number(found.load_angle, "rad", 3))]
    rooms = {name: room.decibel for name, room in found.headroom.items()}
    facts += [(f"headroom of {name.replace('_', ' ')}", number(value, "dB", 3)) for name, value in rooms.items()]
    if found.channels:
        facts += [("gain", f"{found.gain[0]:.3g} to {found.gain[1]:.3g}"), ("phase", number(found.phase, "deg", 3))]
        facts += [("delay", number(found.delay, "s", 3)), ("disk", number(found.disk, "", 3))]
    if found.cells is not None:
        worst = ((kind, found.cells.worst(kind).value) for kind in ("gain", "phase", "delay", "disk"))
        least = ", ".join(f"{kind} {value:.3g}" for kind, value in worst)
        facts += [("least of its table's cells, schedule held", least)]
    facts += [(f"not measured, {name}", why) for name, why in found.failed.items()]
    if not alone:
        pair = found.orbit
        beside = f"{found.request.controls}: orbit {pair.status}, power {number(pair.power, 'W')}"
        if pair.status == "stable":
            beside += f", lock reserve {number(pair.lock_reserve)}"
        facts += [("beside it constant controls", beside)]
    sizes = {name.replace("_", " "): abs(value) for name, value in rooms.items() if math.isfinite(value)}
    return Face(f"Margins of {of}", facts, lambda: bars(sizes, "headroom [dB]", [LAW]) if sizes else "")


def _names(names: Any) -> str:
    words = [str(name) for name in names]
    return ", ".join(words) if len(words) <= 8 else f"{', '.join(words[:8])} and {len(words) - 8} more"


def _model(model: Any) -> str:
    """Poles of a model over a wave, or over a time of its own, in the unit circle."""
    if hasattr(model, "multipliers"):
        values = model.multipliers
    elif hasattr(model, "poles"):
        values = np.exp(model.poles * model.model.wave_period)
    else:
        values = np.linalg.eigvals(model.A)
    return circle(values, "multipliers over a wave in the unit circle")
