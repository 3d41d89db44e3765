"""Laws of one's own with modules beside them, on their way to a process: as they run here, so they run there."""

from __future__ import annotations

from pathlib import Path

import pytest

import gyroctl as gy
from gyroctl.comparison.alone import in_a_process
from gyroctl.comparison.execution import execute
from gyroctl.comparison.items import Realisations, work_items
from gyroctl.comparison.parcels import parcels
from gyroctl.harness.run import Settings
from gyroctl.harness.travelling import by_value
from gyroctl.writing import write_text

LAW = """
import functools
{imports}

@functools.lru_cache(maxsize=3)
def kept(): return 2e-4

class Mine:
    period, information = 0.1, "none"
    def init(self): return None
    def step(self, t, y, state): return (0.05, float({gain})), None
"""

WAYS = {
    "module": ("import gains_a as g", "g.GAIN"),
    "module through a module": ("import gains_b", "gains_b.gain()"),
    "function that uses a module": ("from gains_b import gain", "gain()"),
    "package": ("from gains_p import inner", "inner.GAIN"),
    "function that keeps its results": ("", "kept()"),
    "value": ("from gains_a import GAIN", "GAIN"),
}


@pytest.mark.parametrize("beside_a_worker", [False, True])
@pytest.mark.parametrize("way", WAYS)
def test_modules_travel_with_a_law(device: gy.Plant, tmp_path: Path, way: str, beside_a_worker: bool) -> None:
    own = f"gains{list(WAYS).index(way)}{beside_a_worker:d}"  # a name of its own: Python imports a name once
    imports, gain = WAYS[way]
    files = {
        "gains_a.py": "GAIN = 2e-4\n",
        "gains_b.py": "import gains_a\n\ndef gain():\n    return gains_a.GAIN\n",
        "gains_p/__init__.py": "",
        "gains_p/inner.py": "from gains_a import GAIN\n",
        "mine.py": LAW.format(imports=imports, gain=gain),
    }
    for name, text in files.items():
        write_text(tmp_path / name.replace("gains", own), text.replace("gains", own))
    laws = {"mine": gy.law(f"{tmp_path}/mine.py:Mine"), "constant": gy.law("constant", cc=0.05, cg=2e-4)}
    items = work_items(device, laws, Realisations(gy.SeaState(), (1,), 60.0), Settings(blend=40.0), 60.0)
    mine, here = items if items[0].name == "mine" else items[::-1]
    if beside_a_worker:
        (outcome,) = in_a_process(*parcels([mine], by_value(mine.law)))
    else:
        outcome = execute([mine], 2, None, True)["mine", 1]
    assert outcome.failure == ""
    assert outcome.values["mean_power"] == execute([here], 1, None, True)["constant", 1].values["mean_power"]
