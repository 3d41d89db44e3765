"""``python -m gyroctl.studies.forecast``: skill against the lead."""

from __future__ import annotations

import argparse
from pathlib import Path

from gyroctl.studies.forecast.report import forecast_report


def main() -> None:
    """Read the arguments, make the report, print the table."""
    parser = argparse.ArgumentParser(prog="python -m gyroctl.studies.forecast", description=__doc__)
    parser.add_argument("--seeds", default="100000:100004", help="first:end, the end not included")
    parser.add_argument("--duration", type=float, default=1000.0, help="of each realisation [s]")
    parser.add_argument("--law", default="coupling", help="registered law that moves the device")
    parser.add_argument("--out", type=Path, default=Path("forecast"))
    given = parser.parse_args()
    first, _, end = given.seeds.partition(":")
    seeds = range(int(first), int(end) if end else int(first) + 1)
    print(forecast_report(given.out, seeds, given.duration, given.law))


if __name__ == "__main__":
    main()
