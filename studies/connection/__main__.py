"""``python -m gyroctl.studies.connection``: the two devices, sea by sea."""

from __future__ import annotations

import argparse
from pathlib import Path

from gyroctl.studies.connection.report import connection_report
from gyroctl.tuning.yardstick import BUDGET


def main() -> None:
    """Read the arguments, make the report, print the table."""
    parser = argparse.ArgumentParser(prog="python -m gyroctl.studies.connection", description=__doc__)
    parser.add_argument("--seeds", default="1:65", help="first:end, the end not included")
    parser.add_argument("--gammas", nargs="+", type=float, default=[1.0, 5.0, 50.0], help="peak enhancements")
    parser.add_argument("--heights", nargs="+", type=float, default=[0.2, 0.283, 0.36], help="significant heights [m]")
    parser.add_argument("--duration", type=float, default=2000.0, help="length of a run [s]")
    parser.add_argument("--budget", type=float, default=BUDGET, help="simulated time of a search [s]")
    parser.add_argument("--out", type=Path, default=Path("connection"))
    given = parser.parse_args()
    first, _, end = given.seeds.partition(":")
    seeds = range(int(first), int(end) if end else int(first) + 1)
    connection_report(given.out, seeds, given.gammas, given.heights, given.duration, given.budget)
    print((given.out / "connection.md").read_text(encoding="utf-8"))


if __name__ == "__main__":
    main()
