"""The planning law with perfect preview, by several habits: starts of the search in a plant beyond the linear one.

A plan of a whole window rests on the smooth design model; the law looks at the plant again at every sample. So its runs
lie where the plant can be held, and plans that begin with what it did do, too.
"""

from __future__ import annotations

from typing import Any

from gyroctl.harness.laws import law
from gyroctl.simulation.metrics import Record
from gyroctl.studies.bound.cut import Cut

HABITS: tuple[dict[str, Any], ...] = (
    {},
    {"horizon": 6.0, "limit1": 0.3, "sure": 0.0, "turns": 10.0},
    {"turns": 0.0, "lock": 5.0},
    {"horizon": 6.0, "limit1": 0.27, "sure": 0.0},
    {"limit1": 0.32, "limit3": 0.25, "sure": 0.0},
    {"horizon": 6.0},
)
"""Parameters of the law, in the order in which they are tried; the first are those that ship."""


def oracle_runs(cut: Cut, count: int) -> dict[str, Record]:
    """Runs of the law through the window and its tail, by name; the design model is the plant of the window."""
    runs = {}
    for habit in HABITS[:count]:
        words = " ".join(f"{key}={value:g}" for key, value in habit.items())
        planner = law("nmpc", information="oracle", plant=cut.plant, **habit)
        runs[f"perfect preview {words}".strip()] = cut.run(planner, "nmpc")
    return runs
