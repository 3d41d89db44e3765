"""Histories of a study under faults, each played again from its number: python benchmarks/faults.py --histories 100000.

The store, the plan and the hands of a cluster are the real ones; disk, processes and scheduler are played
(`faults_disk`), with short writes, full disks, power cuts that leave what was not synced in any state, kills of driver,
scheduler and workers, results that come twice and late, files that are damaged. What must hold stands in
`faults_history`. Numbers that failed once are kept in ``faults_seeds.json``, and the tests play them again.
"""

from __future__ import annotations

import argparse
import collections
import json
import sys
import time
import traceback
from pathlib import Path
from typing import Any

KEPT = Path(__file__).with_name("faults_seeds.json")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--histories", type=int, default=100_000)
    parser.add_argument("--first", type=int, default=0, help="number of the first one")
    parser.add_argument("--only", type=int, help="play this one, and show where it breaks")
    parser.add_argument("--json", type=Path, help="file of figures")
    parser.add_argument("--kept", type=Path, default=KEPT, help="file to which numbers that fail are added")
    asked = parser.parse_args()
    from faults_history import played

    if asked.only is not None:
        print(played(asked.only))
        return 0
    begin, clock = time.monotonic(), time.process_time()
    seen: collections.Counter[str] = collections.Counter()
    broken: dict[int, str] = {}
    seed = asked.first
    for seed in range(asked.first, asked.first + asked.histories):
        try:
            seen.update(played(seed))
        except BaseException as error:
            if isinstance(error, KeyboardInterrupt):
                raise
            broken[seed] = f"{type(error).__name__}: {error}"
            print(seed, broken[seed], file=sys.stderr, flush=True)
            if len(broken) == 1:
                traceback.print_exc()
            keep(asked.kept, seed)
            if len(broken) >= 20:
                break
        if asked.json and (seed + 1 - asked.first) % 1000 == 0:
            write(asked.json, figures(asked.first, seed, broken, begin, clock, seen))
    found = figures(asked.first, seed, broken, begin, clock, seen)
    print(json.dumps(found, indent=1))
    if asked.json:
        write(asked.json, found)
    return int(bool(broken))


def figures(
    first: int, last: int, broken: dict[int, str], begin: float, clock: float, seen: collections.Counter[str]
) -> dict[str, Any]:
    """What was played, what broke, what it took, and what happened in the histories."""
    return {
        "first": first,
        "histories": last + 1 - first,
        "broken": {str(seed): why for seed, why in broken.items()},
        "seconds": round(time.monotonic() - begin),
        "processor_s": round(time.process_time() - clock, 1),
        "events": dict(sorted(seen.items())),
    }


def write(path: Path, found: dict[str, Any]) -> None:
    """Keep the figures so far."""
    path.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


def keep(path: Path, seed: int) -> None:
    """Add a number to those that are played again for ever."""
    kept = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else []
    path.write_text(json.dumps(sorted({*kept, seed})) + "\n", encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
