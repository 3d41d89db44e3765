"""A study in a script of one's own: no guard is asked for, and what failed is said."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import gyroctl as gy

ROOT = Path(__file__).resolve().parents[1]

SCRIPT = """
import gyroctl as gy

print("begun")

GAIN = 4e-4


class Mine:
    period = 0.1
    information = "sensors"

    def init(self):
        return ()

    def step(self, t, y, state):
        return (0.06, GAIN * (1.0 + 0.1 * y.phi1)), state


plant = gy.zhang2017()
waves = [gy.realise(plant, gy.SeaState(), seed=seed, duration=260.0) for seed in (1, 2)]
found = gy.compare(plant, {"mine": Mine()}, waves, workers=2, quiet=True)
print("power", *found.mean_power.values.ravel())
"""


@pytest.mark.parametrize("by", ["file", "input"])
def test_script_without_a_guard_is_run_once(tmp_path: Path, by: str) -> None:
    """Processes that import the script would each begin the study anew."""
    file = tmp_path / "study.py"
    file.write_text(SCRIPT)
    done = subprocess.run(
        [sys.executable, str(file) if by == "file" else "-"],
        input=None if by == "file" else SCRIPT,
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        timeout=300,
        check=False,
    )
    assert done.returncode == 0 and done.stdout.count("begun") == 1, done.stderr
    powers = [float(word) for word in done.stdout.rpartition("power")[2].split()]
    assert len(powers) == 2 and all(1.0 < power < 5.0 for power in powers)


class Lost:
    """A law that fails at once."""

    period = 0.1
    information = "none"

    def init(self) -> tuple[()]:
        return ()

    def step(self, t: float, y: object, state: object) -> tuple[tuple[float, float], object]:
        raise ZeroDivisionError("no way")


def test_law_of_which_every_run_failed_is_warned_of() -> None:
    plant = gy.zhang2017()
    waves = [gy.realise(plant, gy.SeaState(), seed=seed, duration=260.0) for seed in (1, 2)]
    with pytest.warns(UserWarning, match="every run of lost failed: .*no way"):
        gy.compare(plant, {"lost": Lost(), "constant": "constant"}, waves, workers=1, quiet=True)
