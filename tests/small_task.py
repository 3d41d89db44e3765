"""A small task: the example law in two seas, for tunings of some seconds."""

from __future__ import annotations

from pathlib import Path
from typing import Any

EXAMPLE = Path(__file__).parents[1] / "docs" / "examples" / "my_law.py"

SMALL: dict[str, Any] = {
    "law": f"{EXAMPLE}:MyLaw",
    "knobs": {"cg": {"start": 4e-4, "width": 0.5}, "gain": {"start": 3e-4, "width": 1.0}},
    "seas": {
        "mild": {"hs": 0.25, "gamma": 5.0, "power": 2.0, "runs": 1},
        "tall": {"hs": 0.3, "gamma": 50.0, "runs": 1},
    },
    "search": {"population": 4, "window": 160.0, "confirm": 200.0, "runs": 1},
    "seeds": {"first": 100128, "count": 2},
}
