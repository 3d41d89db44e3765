"""Witnesses of a study that is killed again and again: what was stored, when and how often, and what ran.

Neither asks the study: the system tells each file that gets its name, a journal in the processes each run.
"""

from __future__ import annotations

import ctypes
import os
import struct
import threading
import time
from collections import Counter
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from gyroctl.comparison.verification import CLOCKS
from gyroctl.engine.store import read, stored

MOVED_TO, MODIFIED, DELETED = 0x80, 0x2, 0x200
EVENT = struct.Struct("iIII")


class Witness:
    """Told by the system (inotify) each time a file of a folder gets its name, is written to or goes away."""

    def __init__(self, folder: Path) -> None:
        self.at: dict[str, list[int]] = {}  # by key, when a file got its name [ns]
        self.other: Counter[str] = Counter()  # results that were written to in place, or went away, and how often
        self.libc = ctypes.CDLL(None, use_errno=True)
        self.handle = self.libc.inotify_init1(0)
        if self.libc.inotify_add_watch(self.handle, os.fsencode(folder), MOVED_TO | MODIFIED | DELETED) < 0:
            raise OSError(ctypes.get_errno(), "the folder cannot be watched")
        threading.Thread(target=self._watch, daemon=True).start()

    def _watch(self) -> None:
        while True:
            events, now, at = os.read(self.handle, 1 << 16), time.time_ns(), 0
            while at < len(events):
                _, kind, _, length = EVENT.unpack_from(events, at)
                name = events[at + EVENT.size : at + EVENT.size + length].rstrip(b"\0").decode()
                at += EVENT.size + length
                if not name.endswith(".run") or name.startswith("."):
                    continue
                if kind & MOVED_TO:
                    self.at.setdefault(name.removesuffix(".run"), []).append(now)
                else:
                    self.other[name] += 1

    @property
    def count(self) -> int:
        """Results that are there."""
        return len(self.at)


class Ran(NamedTuple):
    """What the journal says."""

    begun: dict[str, list[int]]  # by key, when a run began [ns]
    ended: Counter[str]


def journal(path: Path) -> Ran:
    """Read the journal."""
    ran = Ran({}, Counter())
    for line in path.read_text(encoding="utf-8").splitlines():
        word, key, at, _ = line.split(" ")
        if word == "begin":
            ran.begun.setdefault(key, []).append(int(at))
        else:
            ran.ended[key] += 1
    return ran


def found(witness: Witness, ran: Ran, folder: Path, serial: Path) -> dict[str, Any]:
    """What became of a study in `folder`, beside the same one that nobody disturbed."""
    here, there = ({path.stem: path for path in stored(place / "runs")} for place in (folder, serial))
    same = [key for key in here if key in there and _bits(here[key]) == _bits(there[key])]
    late = {key: sum(at > min(witness.at[key]) for at in ran.begun.get(key, ())) for key in witness.at}
    return {
        "items": len(there),
        "stored": len(here),
        "lost": len(set(there) - set(here)),
        "never_asked_for": len(set(here) - set(there)),
        "other_bits": len(here) - len(same),
        "other_results": _other_results(folder, serial),
        "stored_twice": sum(len(times) > 1 for times in witness.at.values()),
        "written_in_place_or_gone": len(witness.other),
        "unseen": len(set(here) - set(witness.at)),
        "computed_again_though_stored": sum(late.values()),
        "runs_begun": sum(map(len, ran.begun.values())),
        "runs_ended": sum(ran.ended.values()),
        "most_begun_of_one": max(map(len, ran.begun.values())),
        "half_written": len([path for path in folder.rglob("*.part*")]),
    }


WRONG = ("lost", "never_asked_for", "other_bits", "other_results", "stored_twice", "written_in_place_or_gone")
WRONG += ("unseen", "computed_again_though_stored", "half_written")
"""What is to be none."""


def _bits(path: Path) -> dict[str, Any]:
    record = read(path)
    values = {name: np.float64(x).tobytes() for name, x in record.content["values"].items() if name not in CLOCKS}
    arrays = {f"array {name}": array.tobytes() for name, array in record.arrays.items()}
    return {**values, **arrays, "waves": record.content["sha256"]}


def _other_results(folder: Path, serial: Path) -> int:
    """Variables of results.nc that are not the same bits."""
    import xarray as xr

    one, two = (xr.load_dataset(place / "results.nc", engine="h5netcdf") for place in (folder, serial))
    names = {*map(str, one.variables), *map(str, two.variables)} - {*CLOCKS}
    return sum(name not in one or name not in two or not _same(one[name].values, two[name].values) for name in names)


def _same(one: Any, two: Any) -> bool:
    if one.dtype.hasobject or two.dtype.hasobject:
        return bool(one.tolist() == two.tolist())
    return bool(one.dtype == two.dtype and one.shape == two.shape and one.tobytes() == two.tobytes())
