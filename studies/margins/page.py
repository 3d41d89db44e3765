"""The page of a margin study: one HTML file that works without a network, from margins.json and the pictures by it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from gyroctl.errors import InputError
from gyroctl.reading import is_finite, read_json
from gyroctl.reports import page
from gyroctl.studies.margins.cells import GROUPS
from gyroctl.writing import write_text

MEND = "Give the folder that gyroctl margins wrote"

CONSTANT, LAW, BOTH = "the constant controls", "the law", "both"

CAPTIONS = {
    "multipliers": ("Multipliers", BOTH, "Floquet multipliers: inside the circle they die out"),
    "linear_error": (
        "How far the linear model holds",
        CONSTANT,
        "Error of the linear model about their orbit by the size of the disturbance",
    ),
    "nyquist": (
        "Nyquist plot",
        LAW,
        "Harmonic Nyquist plot of its loop with the disk: the nearer to -1, the less margin",
    ),
    "robustness": (
        "Headroom, basin and shocks",
        BOTH,
        "Room up to the loss of lock, disturbances survived, smallest shocks",
    ),
    "lock_map": ("Lock map", CONSTANT, "Where lock exists and is stable, over the coupling and the generator gain"),
    "tongue": ("Tongue", CONSTANT, "Where lock exists and is stable, over the frequency and the height of the wave"),
    "heat_maps": (
        "Maps of margins",
        CONSTANT,
        "Damping, reserve and share of disturbances survived over controls and waves",
    ),
    "water": ("Real water", CONSTANT, "What each choice beyond the linear model moves"),
}
"""Pictures of a study: heading, of whom it is, and what is to be seen."""

UNITS = {"cg": "Nms", "height": "m", "frequency_down": "rad/s", "frequency_up": "rad/s"}
"""Of what moves."""

KINDS = ("gain", "phase", "delay", "disk")
"""Margins of a cell."""


def write_page(content: Mapping[str, Any], folder: Path) -> Path:
    """Write margins.html, whole or not at all.

    Parameters
    ----------
    content : mapping
        What margins.json holds.
    folder : Path
        Where its pictures are, and where the page goes.
    """
    return write_text(folder / "margins.html", render(content, folder))


def page_again(folder: Path, out: Path) -> Path:
    """Make the page again from the files of a study.

    Raises
    ------
    InputError
        Field ``results``, for a margins.json that is none.
    """
    path = folder / "margins.json"
    content = read_json("results", path, MEND)
    wanted = ("request", "orbit", "meaning")
    missing = [name for name in wanted if not isinstance(content, dict) or not isinstance(content.get(name), dict)]
    if missing:
        raise InputError("results", str(path), f"is no margin study; missing: {', '.join(missing)}", MEND)
    return write_text(out / "margins.html", render(content, folder))


def render(content: Mapping[str, Any], folder: Path) -> str:
    """HTML text of the page; equal files give equal text."""
    request = content["request"]
    law = request.get("law")
    named = law.get("name") if isinstance(law, dict) else law
    whose = f"the law {named}" if named else ""
    drawn = content.get("figures") or []
    names = [Path(str(name)).stem for name in drawn]
    figures = [
        {
            "anchor": name,
            "title": title,
            "caption": _caption(name, of, caption, whose, content),
            "source": source,
            "width": page.width_of(folder / f"{name}.png"),
        }
        for name, (title, of, caption) in CAPTIONS.items()
        if name in names and (source := page.as_source(folder / f"{name}.png"))
    ]
    cells = _part(content, "law", "cells")
    found = cells.get("cells")
    every = [one for one in found if isinstance(one, dict)] if isinstance(found, list) else []
    nearest = cells.get("nearest")
    near = every[nearest] if isinstance(nearest, int) and 0 <= nearest < len(every) else {}
    values = {
        "content": {"meaning": {}, "not_available": [], "date": "", **content},
        "file": "margins.json",
        "law": whose,
        "whose": whose or "constant controls",
        "point": _point(request),
        "sea": {name: str(value) for name, value in _part(content, "sea").items()},
        "here": list(_here(content, bool(named))),
        "rooms": list(_rooms(content, whose)),
        "channels": list(_channels(_part(content, "law", "linear").get("channels"))),
        "cells": [_cell(one, one is near) for one in every],
        "design": {name: cells.get(name) for name in ("design_plant", "method")},
        "differs": ", ".join(
            f"{name} {value:g}" for name, value in _part(cells, "differs").items() if is_finite(value)
        ),
        "near": list(_channels(near.get("margins"))),
        "figures": figures,
        "provenance": page.provenance(content),
    }
    return page.render("margins.html.j2", values)


def _part(content: Mapping[str, Any], *names: str) -> Mapping[str, Any]:
    """Table within tables by its names, empty where there is none."""
    for name in names:
        inner = content.get(name)
        content = inner if isinstance(inner, dict) else {}
    return content


def _caption(name: str, of: str, text: str, whose: str, content: Mapping[str, Any]) -> str:
    """What is to be seen in a picture, and of whom."""
    if of == BOTH:
        of = f"{CONSTANT} and {whose}" if whose else CONSTANT
    elif of == LAW:
        of = whose or of
    said = f"Of {of}. {text}"
    loop = _part(content, "law", "linear").get("loop")
    if name != "multipliers" or not isinstance(loop, dict):  # of an older file, or without a law
        return said
    if "power_w" in loop:
        return f"Dots: the orbit of {CONSTANT}; crosses: the loop with {whose} about its own orbit. {text}"
    return f"Of {CONSTANT} alone: the loop with {whose} is {loop.get('status')} here, and none is drawn. {text}"


def _point(request: Mapping[str, Any]) -> str:
    wave, controls = (request.get(part) or {} for part in ("wave", "controls"))
    told = [("regular wave of height", wave.get("height_m"), "m"), ("ωp", wave.get("wp_rad_s"), "rad/s")]
    told += [("constant controls cc", controls.get("cc_nms"), "Nms"), ("cg", controls.get("cg_nms"), "Nms")]
    return ", ".join(f"{name} {value:.4g} {unit}" for name, value, unit in told if is_finite(value))


def _here(content: Mapping[str, Any], named: bool) -> Iterator[dict[str, Any]]:
    """Rows of what is known at this wave: of the law, where there is one, and of the constant controls."""
    orbit, loop = _part(content, "orbit"), _part(content, "law", "linear", "loop")
    modes = orbit.get("modes")
    slowest = modes[0] if isinstance(modes, list) and modes and isinstance(modes[0], dict) else {}
    pair = {
        **orbit,
        "decay_time_s": slowest.get("decay_time_s"),
        "mean_controls": _part(content, "request", "controls"),
    }
    law = {**loop, "power_w": _part(content, "law").get("power_w")}
    both = [law, pair] if named else [pair]
    texts = [str(one.get("status", "not known")) for one in both]
    yield {"what": "Own orbit", "unit": "", "texts": texts, "values": []}
    degrees = 180.0 / math.pi
    for what, unit, name, factor in (
        ("Mean power", "W", "power_w", 1.0),
        ("Mean cc", "Nms", "cc_nms", 1.0),
        ("Mean cg", "Nms", "cg_nms", 1.0),
        ("Load share", "%", "lock_share", 100.0),
        ("Lock reserve", "%", "lock_reserve", 100.0),
        ("Load angle", "deg", "load_angle_rad", degrees),
        ("Slowest mode falls by e", "s (negative: grows)", "decay_time_s", 1.0),
    ):
        values = []
        for one in both:
            of_orbit = name in ("lock_share", "load_angle_rad") and one.get("status") != "stable"
            found = math.nan if of_orbit else _as_number({**one, **_part(one, "mean_controls")}.get(name))
            values.append(factor * found)
        yield {"what": what, "unit": unit, "texts": [], "values": values}


def _rooms(content: Mapping[str, Any], whose: str) -> Iterator[dict[str, Any]]:
    """Rows of headroom, of the law and of the constant controls."""
    for of, words in (("law", whose or LAW), ("constant_controls", CONSTANT)):
        for what, room in _part(content, of, "headroom").items():
            if isinstance(room, dict):
                numbers = {name: _number(room, name) for name in ("value", "limit", "decibel")}
                unit = "times its own cg" if (of, what) == ("law", "cg") else UNITS.get(what, "")
                told = {"what": what.replace("_", " "), "unit": unit, "ending": str(room.get("ending", ""))}
                yield {"of": words, **told, **numbers}


def _channels(channels: Any) -> Iterator[dict[str, Any]]:
    """Rows of gain, phase, delay and disk by channel; no number stands for no end."""
    for name, one in channels.items() if isinstance(channels, dict) else ():
        if isinstance(one, dict):
            gain = one.get("gain")
            pair = gain if isinstance(gain, list) and len(gain) == 2 else [None, None]
            most, delay = (math.inf if value is None else _as_number(value) for value in (pair[1], one.get("delay_s")))
            delay = math.nan if name in GROUPS else delay
            numbers = [_as_number(pair[0]), most, _number(one, "phase"), delay, _number(one, "disk")]
            yield {"name": name, "values": numbers}


def _cell(one: Mapping[str, Any], nearest: bool) -> dict[str, Any]:
    """Row of a cell: where it is, and the least of its margins with the signal at which it is."""
    place = [_as_number(one.get(name)) for name in ("envelope_rad_s", "frequency_rad_s", "bandwidth", "wave_height_m")]
    place.append(100.0 * _as_number(one.get("lock_share")))
    least = []
    for kind in KINDS:
        found = _part(one, "least", kind)
        value = found.get("value")
        free = value is None and bool(found)
        least.append((math.inf if free else _as_number(value), "" if free else str(found.get("channel", ""))))
    return {"place": place, "least": least, "nearest": nearest}


def _number(values: Mapping[str, Any], name: str) -> float:
    """Number by its name, with whatever unit stands behind it there."""
    found = next((value for key, value in values.items() if key == name or key.startswith(f"{name}_")), None)
    return _as_number(found)


def _as_number(value: Any) -> float:
    return float(value) if is_finite(value) else math.nan
