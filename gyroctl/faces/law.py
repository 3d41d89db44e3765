"""Face of a law: what it looks at, how often, its first numbers; pictured as a block with its signals."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from gyroctl.faces.show import Face, number
from gyroctl.faces.svg import block

CHANNELS = ("psi", "psi_rate", "omega_rate", "phi1", "phi3", "phi1_rate", "phi3_rate")
AHEAD = {"gauge": ["gauge up-wave"], "forecast": ["moments ahead"], "oracle": ["true waves"]}
"""What a law is told beside its sensors."""

NUMBERS = 8
"""Most parameters that are shown."""


def law_face(law: Any) -> Face:
    """Tell a law."""
    name, looks = name_of(law), str(law.information)
    reads = [] if looks == "none" else list(getattr(law, "sensors", CHANNELS))
    facts = [("looks at", looks), ("every", number(law.period, "s"))]
    facts += [("reads", ", ".join(reads) if reads != list(CHANNELS) else "all sensors")] if reads else []
    within = getattr(law, "law", None)
    facts += [("around", name_of(within))] if within is not None else []
    found = list(law.facts if hasattr(law, "facts") else _numbers(law))
    facts += found[:NUMBERS]
    facts += [("and", f"{len(found) - NUMBERS} more numbers")] if len(found) > NUMBERS else []
    into = [*reads, *AHEAD.get(looks, [])]
    return Face(f"Law {name}", facts, lambda: block(name, into, ("cc", "cg"), f"{name}: {', '.join(into)} to cc, cg"))


def name_of(law: Any) -> str:
    """Name of a law: of its class, or of the function that it was made of."""
    return str(getattr(type(law), "called", type(law).__name__))


def _numbers(value: Any) -> Iterator[tuple[str, str]]:
    """Parameters one by one; tables by their length."""
    fields = value._asdict() if hasattr(value, "_asdict") else dict(vars(value))
    for name, part in fields.items():
        if name in ("period", "information", "law", "first") or name.startswith("_"):
            continue
        if isinstance(part, bool | int | float | str):
            yield name, number(part) if isinstance(part, int | float) and not isinstance(part, bool) else str(part)
        elif hasattr(part, "_asdict"):
            yield from _numbers(part)
        elif isinstance(part, tuple):
            short = len(part) <= 3 and all(isinstance(entry, int | float) for entry in part)
            yield name, ", ".join(number(entry) for entry in part) if short else f"{len(part)} numbers"
        elif part is not None:
            yield name, str(getattr(part, "name", type(part).__name__))
