"""One run in a process that is started for it: python -m gyroctl.comparison.alone ASKED TOLD, both of them files.

A worker of a cluster may have no child of its own that shares its memory; a program of its own it may start.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

import cloudpickle

from gyroctl.comparison.execution import GRACE, how_it_ended, perform_sent
from gyroctl.comparison.items import Item, Outcome, failed


def in_a_process(item: Item, law: bytes) -> list[Outcome]:
    """Run an item whose law is packed; one that takes too long is ended, and whatever it does its run fails alone."""
    with tempfile.TemporaryDirectory(prefix="gyroctl-run-") as place:
        asked, told = Path(place) / "asked", Path(place) / "told"
        asked.write_bytes(cloudpickle.dumps((item, law)))
        command = [sys.executable, "-m", __name__, str(asked), str(told)]
        try:
            done = subprocess.run(command, stdin=subprocess.DEVNULL, timeout=item.time_limit + GRACE, check=False)
        except subprocess.TimeoutExpired:
            what = f"took longer than {item.time_limit:g} s: compute less in step, or allow more with run.time_limit"
            return [failed(item, f"law {item.name!r} {what}")]
        if done.returncode != 0 or not told.is_file():
            return [failed(item, f"law {item.name!r} {how_it_ended(done.returncode)}")]
        found: list[Outcome] = cloudpickle.loads(told.read_bytes())
        return found


def main() -> None:
    """Run what is asked in a file, and tell it in another one."""
    asked, told = (Path(word) for word in sys.argv[1:])
    item, law = cloudpickle.loads(asked.read_bytes())
    told.write_bytes(cloudpickle.dumps(perform_sent(item, law)))


if __name__ == "__main__":
    main()
