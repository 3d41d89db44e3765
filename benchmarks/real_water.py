"""How true the reduced wetted surface and the smoothed friction are: runs against their references.

Run ``python -P benchmarks/real_water.py``; it prints what it finds and writes it beside itself as
``real_water.json``. The references are the panels, run by run on the same waves, and a stick-slip integration of dry
friction event by event (`tests/oracles/stick_slip.py`).
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

import gyroctl as gy
from gyroctl.harness.arguments import law_of
from gyroctl.harness.run import run_law
from gyroctl.harness.start import locked_start
from gyroctl.provenance import made

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

SEA = gy.SeaState()
SEEDS = range(1, 17)
PAIRS = {"rest": (0.052, 5e-4), "moving": (0.052, 3.5e-4)}
"""The best of twelve constant pairs with the wetted surface and drag. [Nms]"""

TRACTIONS, RUNS = (0.3, 0.4, 0.5, 0.6), range(1, 11)


def surfaces(position: str) -> dict[str, Any]:
    """Mean power [W] and 98 % of phi1 [rad] on the panels and on the polynomials, with drag."""
    found: dict[str, Any] = {}
    for choice in ("surface", "reduced"):
        plant = gy.zhang2017(wetted=choice, position=position, drag=0.5)
        cc, cg = PAIRS[position]
        laws = {"constant": gy.law("constant", cc=cc, cg=cg), "load_angle": gy.law("load_angle")}
        waves = [gy.realise(plant, SEA, seed, 600.0) for seed in SEEDS]
        table = gy.compare(plant, laws, waves, quiet=True)
        for law in laws:
            own = table.sel(law=law)
            means: dict[str, Any] = {name: float(own[name].mean()) for name in ("mean_power", "phi1_p98")}
            means |= {"locked": int(own["locked"].sum()), "runs": len(SEEDS)}
            found.setdefault(law, {})[choice] = means
    return found


def contacts(traction: float) -> dict[str, Any]:
    """Verdict on reversals, and the power that the smoothed friction loses more, with a constant pair over 300 s."""
    from oracles.stick_slip import run as stick_slip

    device, agreed, crept, reversed_ = gy.zhang2017(contact="friction", traction=traction), 0, [], 0
    for seed in RUNS:
        waves = gy.realise(device, SEA, seed, 300.0)
        record, _ = run_law(device, law_of("constant"), waves, gy.Settings(blend=0.0), "constant")
        cc, cg = record.controls[1]
        start, _ = locked_start(device, SEA)
        dry = stick_slip(device, start, waves, lambda t, x, cc=cc, cg=cg: (cc, cg))
        smooth, sharp = (_entries(side) for side in (record.states[:, 6] * record.states[:, 14] < 0.0, dry.side < 0.0))
        agreed += (smooth > 0) == (sharp > 0)
        reversed_ += sharp > 0
        if smooth == 0:
            crept.append(float((record.states[-1, -1] - dry.rubbed) / waves.duration))
    creep = {"creep_w": [min(crept), max(crept)] if crept else None, "runs_without_reversal": len(crept)}
    return {"runs": len(RUNS), "agreed": int(agreed), "reversed": int(reversed_), **creep}


def _entries(backwards: Any) -> int:
    return int(np.count_nonzero(backwards[1:] & ~backwards[:-1]))


def main() -> None:
    """Measure and write."""
    found: dict[str, Any] = {**made(), "seeds": list(SEEDS), "duration_s": 600.0, "drag": 0.5, "pairs_nms": PAIRS}
    found["wetted"] = {position: surfaces(position) for position in PAIRS}
    for position, laws in found["wetted"].items():
        for law, each in laws.items():
            print(position, law, {choice: {k: round(v, 3) for k, v in row.items()} for choice, row in each.items()})
    found["friction"] = {f"{traction:g}": contacts(traction) for traction in TRACTIONS}
    for traction, row in found["friction"].items():
        print(f"friction {traction}: {row}")
    Path(__file__).with_suffix(".json").write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
