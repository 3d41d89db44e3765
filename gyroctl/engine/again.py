"""Stored work computed again by the command that made it: a random sample is withheld from it, and the bits compared.

The command runs on a copy of the folder, in which the sample is missing: what it then makes goes the way that every
result goes, and nothing in the folder is touched.
"""

from __future__ import annotations

import json
import math
import random
import shutil
import stat
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gyroctl.engine.plan import in_force, plans
from gyroctl.engine.record import Damaged, Record
from gyroctl.engine.state import RUNS, changed
from gyroctl.engine.store import Store, differences, read


@dataclass(frozen=True)
class Again:
    """What became of a stored result that was computed again."""

    about: Mapping[str, Any]  # what it is of, and what made it
    differs: tuple[str, ...]  # numbers and arrays that are not the same bits, or why there are none


@dataclass(frozen=True)
class Sample:
    """Results that were withheld."""

    records: tuple[Record, ...]
    stored: int  # of all that this installation would make
    apart: Mapping[str, int]  # results that other libraries or processors made, by what differs


def withhold(folder: Path, into: Path, share: float, count: int | None, seed: int | None) -> Sample:
    """Copy a study's folder but for a sample of its results.

    Parameters
    ----------
    folder : Path
        Of the study, with its results in ``runs``.
    into : Path
        New folder.
    share : float
        Part of the results that are withheld, one at least. [1]
    count : int, optional
        How many instead.
    seed : int, optional
        Of the sample, to draw it again.
    """
    store, apart, good = Store(folder / RUNS), dict[str, int](), list[Path]()
    wanted = {item.key for plan in in_force(plans(folder / RUNS)) for item in plan.items}
    for path in store.files():
        try:
            record = read(path)
        except (Damaged, OSError):
            continue  # it is computed again in any case
        if other := differences(record.about):
            apart[other] = apart.get(other, 0) + 1
        elif not changed(record) and (not wanted or record.key in wanted):
            good.append(path)
    many = count if count is not None else math.ceil(share * len(good))
    sample = random.Random(seed).sample(good, min(many, len(good)))
    held = {path.name for path in sample}
    copy_study(folder, into, held)
    return Sample(tuple(read(path) for path in sample), len(good), apart)


def copy_study(folder: Path, into: Path, but: Collection[str] = ()) -> None:
    """Copy a folder without some names, into one that may be written to.

    What has no end stays, as a pipe or a device; so do links to folders but those at the top: they may lead in circles.
    """

    def left(place: str, names: list[str]) -> set[str]:
        deeper = Path(place) != folder
        return {name for name in names if name in but or _strange(Path(place, name), deeper)}

    shutil.copytree(folder, into, ignore=left)
    for place in (into, *into.rglob("*")):
        place.chmod(place.stat().st_mode | (stat.S_IRWXU if place.is_dir() else stat.S_IWUSR))


def _strange(path: Path, deeper: bool) -> bool:
    try:
        mode = path.stat().st_mode
    except OSError:
        return True
    return not (stat.S_ISREG(mode) or (stat.S_ISDIR(mode) and not (deeper and path.is_symlink())))


def compared(sample: Sample, folder: Path, clocks: Collection[str] = ()) -> list[Again]:
    """Compare what was withheld with what was made instead of it; `clocks` are names of what a clock measured."""
    found = []
    for record in sample.records:
        try:
            differs = different(record, read(Store(folder / RUNS).path(record.key)), clocks)
        except FileNotFoundError:
            differs = ("not made again: the command asks for other work, or it failed",)
        found.append(Again(record.about, differs))
    return found


def different(one: Record, other: Record, clocks: Collection[str] = ()) -> tuple[str, ...]:
    """Names of what is not the same bits in two results."""
    first, second = (dict(_numbers(record, clocks)) for record in (one, other))
    return tuple(name for name in sorted({*first, *second}) if first.get(name) != second.get(name))


def _numbers(record: Record, clocks: Collection[str]) -> Iterator[tuple[str, bytes]]:
    yield from _leaves("", record.content, clocks)
    for name, array in record.arrays.items():
        kind = f"{array.dtype.str} {array.shape} ".encode()
        yield f"array {name}", kind + np.ascontiguousarray(array).tobytes()


def _leaves(name: str, value: Any, clocks: Collection[str]) -> Iterator[tuple[str, bytes]]:
    if isinstance(value, dict):
        for key, part in value.items():
            if key not in clocks:
                yield from _leaves(f"{name}.{key}".lstrip("."), part, clocks)
    elif isinstance(value, list):
        for number, part in enumerate(value):
            yield from _leaves(f"{name}[{number}]", part, clocks)
    else:
        yield name, json.dumps(value).encode()  # floats to the last bit
