"""Tuned sets of a device of one's own: a folder beside its file, ``mine.tuned`` beside ``mine.toml``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from gyroctl.harness.code_files import is_file, parted
from gyroctl.harness.for_device import belongs
from gyroctl.harness.registry import tuned_sets
from gyroctl.harness.tuned_sets import read_sets, seeds_of
from gyroctl.names import file_in
from gyroctl.plant import Plant

PAIRS = ("constant", "best_constant")
"""Laws that hold a pair: it is given, or searched for the device."""

ALL = "all"
"""Name of the set that serves all seas."""


def sets_folder(device_file: Path) -> Path:
    """Folder of the tuned sets of a device."""
    return device_file.with_suffix(".tuned")


def own_sets(device_file: Path, name: str, device: Plant) -> dict[str, Any]:
    """Tuned sets of a law that were found on a device, by name; those of another device in its folder do not count."""
    stem = parted(name)[1] if is_file(name) else name
    sets = read_sets(file_in(sets_folder(device_file), stem, ending=".json"))
    return {key: entry for key, entry in sets.items() if belongs(entry.get("found", {}), device)}


def own_parameters(device_file: Path, name: str, device: Plant, sea: str = ALL) -> dict[str, Any]:
    """Parameters of a law as tuned on a device, for all seas or else for `sea`; none where it was not tuned there."""
    sets = own_sets(device_file, name, device)
    found = sets.get(ALL) or sets.get(sea) or {}
    return dict(found.get("parameters", {}))


def own_seeds(device_file: Path, names: Iterable[str], device: Plant) -> set[int]:
    """Seeds on which laws were tuned on a device: they may not judge it."""
    return {seed for name in names for seed in seeds_of(own_sets(device_file, name, device))}


def foreign(kinds: Mapping[str, str], device: Plant, device_file: Path | None = None) -> list[str]:
    """Laws, by their names here, whose tuned sets all belong to another device than this one.

    Parameters
    ----------
    kinds : mapping of str to str
        Registered name or "file.py:Name" of each law.
    device : Plant
        The device.
    device_file : Path, optional
        Its file, beside which sets of its own may be.
    """
    strange = []
    for name, kind in kinds.items():
        if kind in PAIRS:
            continue
        if device_file is not None and own_sets(device_file, kind, device):
            continue
        sets = tuned_sets(kind) if not is_file(kind) else {}
        if sets and not any(belongs(entry.get("found", {}), device) for entry in sets.values()):
            strange.append(name)
    return strange
