"""A year at a site of 40 sea states: time of the whole command, and that it takes when all is stored.

Run ``python -P benchmarks/site.py`` on an idle machine; it prints the times and writes ``site.json`` beside itself. The
bar is ten minutes on two cores for 16 realisations of 600 s and two compiled laws, the search of the constant pairs
included. ``--cells`` and ``--realisations`` make it smaller, to try it; then nothing is written.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import platform
import tempfile
import time
from pathlib import Path
from typing import Any

from gyroctl.provenance import made
from gyroctl.studies.site import Bin, Scatter, site_report, site_request

BAR = 600.0
"""Longest time of the command. [s]"""

HEIGHTS = (2.6, 3.0, 3.4, 3.8, 4.2)
PERIODS = (7.5, 8.0, 8.5, 9.0, 9.5, 10.0, 10.5, 11.0)
SCALE, LAWS, DURATION = 20.0, "coupling,load_angle", 600.0


def table() -> Scatter:
    """Forty sea states that all are run, the middle ones most often."""
    weight = {(hs, tp): math.exp(-((hs - 3.0) ** 2) - 0.5 * (tp - 9.0) ** 2) for hs in HEIGHTS for tp in PERIODS}
    total = sum(weight.values())
    return Scatter(tuple(sorted(Bin(hs, tp, w / total) for (hs, tp), w in weight.items())), "Tp")


def timed(scatter: Scatter, out: Path, seeds: int) -> dict[str, float]:
    """Wall and processor time of a year. [s]"""
    begin, cpu = time.monotonic(), time.process_time()
    found = site_report(site_request(scatter, out, LAWS, scale=SCALE, seeds=(f"1:{seeds}",), duration=DURATION))
    assert all(cell["state"] == "run" for cell in found["cells"]), "every sea state is to be run"
    return {"wall_s": time.monotonic() - begin, "processor_s": time.process_time() - cpu}


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cells", type=int, default=40, help="so many of the sea states")
    parser.add_argument("--realisations", type=int, default=16)
    asked = parser.parse_args()
    whole = table()
    scatter = Scatter(whole.bins[: asked.cells], whole.kind)
    load = os.getloadavg()[0]
    with tempfile.TemporaryDirectory() as place:
        first = timed(scatter, Path(place) / "site", asked.realisations)
        again = timed(scatter, Path(place) / "site", asked.realisations)
    content: dict[str, Any] = {
        **made(),
        "machine": f"{platform.processor() or platform.machine()}, {os.cpu_count()} cores",
        "sea_states": len(scatter.bins),
        "realisations": asked.realisations,
        "duration_s": DURATION,
        "laws": LAWS,
        "load_before": load,
        "first": first,
        "all_stored": again,
        "bar_s": BAR,
    }
    print(
        f"{first['wall_s']:.0f} s of {BAR:g}, processor {first['processor_s']:.0f} s; "
        f"all stored {again['wall_s']:.1f} s"
    )
    if (asked.cells, asked.realisations) == (40, 16):
        Path(__file__).with_suffix(".json").write_text(json.dumps(content, indent=1) + "\n")


if __name__ == "__main__":
    main()
