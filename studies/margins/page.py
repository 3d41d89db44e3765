"""The page of a margin study: one HTML file that works without a network, from margins.json and the pictures by it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from gyroctl.errors import InputError
from gyroctl.reading import is_finite, read_json
from gyroctl.reports import page
from gyroctl.writing import write_text

MEND = "Give the folder that gyroctl margins wrote"

CAPTIONS = {
    "multipliers": ("Multipliers", "Floquet multipliers of the orbit and of the loop: inside the circle they die out"),
    "linear_error": ("How far the linear model holds", "Error of the linear model by the size of the disturbance"),
    "nyquist": ("Nyquist plot", "Harmonic Nyquist plot of the law with its disk: the nearer to -1, the less margin"),
    "robustness": ("Headroom, basin and shocks", "Room up to the loss of lock, disturbances survived, smallest shocks"),
    "lock_map": ("Lock map", "Where lock exists and is stable, over the coupling and the generator gain"),
    "tongue": ("Tongue", "Where lock exists and is stable, over the frequency and the height of the wave"),
    "heat_maps": ("Maps of margins", "Damping, reserve and share of disturbances survived over controls and waves"),
    "water": ("Real water", "What each choice beyond the linear model moves"),
}
"""Pictures of a study: heading and what is to be seen."""


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
    drawn = content.get("figures") or []
    names = [Path(str(name)).stem for name in drawn]
    figures = [
        {
            "anchor": name,
            "title": title,
            "caption": caption,
            "source": source,
            "width": page.width_of(folder / f"{name}.png"),
        }
        for name, (title, caption) in CAPTIONS.items()
        if name in names and (source := page.as_source(folder / f"{name}.png"))
    ]
    values = {
        "content": {"meaning": {}, "not_available": [], "date": "", **content},
        "file": "margins.json",
        "whose": f"the law {named}" if named else "constant controls",
        "point": _point(request),
        "rooms": list(_rooms(content)),
        "channels": list(_channels(content)),
        "figures": figures,
        "provenance": page.provenance(content),
    }
    return page.render("margins.html.j2", values)


def _point(request: Mapping[str, Any]) -> str:
    wave, controls = (request.get(part) or {} for part in ("wave", "controls"))
    told = [("height", wave.get("height_m"), "m"), ("ωp", wave.get("wp_rad_s"), "rad/s")]
    told += [("cc", controls.get("cc_nms"), "Nms"), ("cg", controls.get("cg_nms"), "Nms")]
    return ", ".join(f"{name} {value:g} {unit}" for name, value, unit in told if is_finite(value))


def _rooms(content: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Rows of headroom, of the constant controls and of the law."""
    for of, words in (("constant_controls", "constant controls"), ("law", "the law")):
        case = content.get(of)
        rooms = case.get("headroom") if isinstance(case, dict) else None
        for what, room in rooms.items() if isinstance(rooms, dict) else ():
            if isinstance(room, dict):
                numbers = {name: _number(room, name) for name in ("value", "limit", "decibel")}
                yield {"of": words, "what": what.replace("_", " "), "ending": str(room.get("ending", "")), **numbers}


def _channels(content: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    law = content.get("law")
    linear = law.get("linear") if isinstance(law, dict) else None
    channels = linear.get("channels") if isinstance(linear, dict) else None
    for name, one in channels.items() if isinstance(channels, dict) else ():
        if isinstance(one, dict):
            gain = one.get("gain")
            pair = gain if isinstance(gain, list) and len(gain) == 2 else [None, None]
            most, delay = (math.inf if value is None else _as_number(value) for value in (pair[1], one.get("delay_s")))
            numbers = [_as_number(pair[0]), most, _number(one, "phase"), delay, _number(one, "disk")]
            yield {"name": name, "values": numbers}


def _number(values: Mapping[str, Any], name: str) -> float:
    """Number by its name, with whatever unit stands behind it there."""
    found = next((value for key, value in values.items() if key == name or key.startswith(f"{name}_")), None)
    return _as_number(found)


def _as_number(value: Any) -> float:
    return float(value) if is_finite(value) else math.nan
