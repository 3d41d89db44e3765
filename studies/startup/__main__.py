"""``python -m gyroctl.studies.startup``: the two ensembles."""

from __future__ import annotations

import argparse
from pathlib import Path

from gyroctl.studies.startup.report import LAWS, startup_report, table


def main() -> None:
    """Read the arguments, make the report, print the table."""
    parser = argparse.ArgumentParser(prog="python -m gyroctl.studies.startup", description=__doc__)
    parser.add_argument("--seeds", default="100000:100100", help="first:end, the end not included")
    parser.add_argument("--laws", nargs="+", default=list(LAWS), help="registered laws that are wrapped")
    parser.add_argument("--gamma", type=float, default=5.0)
    parser.add_argument("--hs", type=float, default=0.283, help="significant wave height [m]")
    parser.add_argument("--dt", type=float, default=0.01, help="longest step [s]")
    parser.add_argument("--out", type=Path, default=Path("startup"))
    given = parser.parse_args()
    first, _, end = given.seeds.partition(":")
    seeds = range(int(first), int(end) if end else int(first) + 1)
    print(table(startup_report(given.out, seeds, given.laws, given.gamma, given.hs, dt=given.dt)))


if __name__ == "__main__":
    main()
