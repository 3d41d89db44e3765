"""Face of settings: what differs from the default, and the numbers that everybody asks for."""

from __future__ import annotations

from dataclasses import MISSING, fields, is_dataclass
from typing import Any

from gyroctl.faces.show import Face, number


def settings_face(settings: Any) -> Face:
    """Tell settings: numbers and choices, and of what is within only that which is not the default."""
    facts = []
    for f in fields(settings):
        value = getattr(settings, f.name)
        if is_dataclass(value):
            changed = [_told(part.name, getattr(value, part.name)) for part in fields(value) if _other(part, value)]
            facts.append((f.name, ", ".join(changed) or "as by default"))
        elif isinstance(value, int | float) and not isinstance(value, bool):
            facts.append((f.name, number(value)))
        else:
            facts.append((f.name, str(value)))
    return Face(type(settings).__name__, facts)


def _other(part: Any, value: Any) -> bool:
    default = part.default_factory() if part.default_factory is not MISSING else part.default
    return bool(getattr(value, part.name) != default)


def _told(name: str, value: Any) -> str:
    if is_dataclass(value):
        within = [_told(part.name, getattr(value, part.name)) for part in fields(value) if _other(part, value)]
        return f"{name} ({', '.join(within) or 'as by default'})"
    return f"{name} {number(value)}" if isinstance(value, int | float) else f"{name} {value}"
