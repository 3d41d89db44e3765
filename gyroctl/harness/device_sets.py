"""Tuned sets of a device of one's own: a folder beside its file, ``mine.tuned`` beside ``mine.toml``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from gyroctl.devices import device as read_device
from gyroctl.errors import InputError
from gyroctl.harness.code_files import is_file, parted
from gyroctl.harness.for_device import belongs
from gyroctl.harness.registry import DEFAULT_SEA, REAL, tuned_sets
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


def sets_file(device_file: Path, name: str) -> Path:
    """File of the tuned sets of a law, a registered name or "file.py:Name", for a device."""
    return file_in(sets_folder(device_file), parted(name)[1] if is_file(name) else name, ending=".json")


def own_sets(device_file: Path, name: str, device: Plant) -> dict[str, Any]:
    """Tuned sets of a law that were found on a device, by name; those of another device in its folder do not count."""
    sets = read_sets(sets_file(device_file, name))
    return {key: entry for key, entry in sets.items() if belongs(entry.get("found", {}), device)}


def set_of(sets: Mapping[str, Any], tuning: str | None = None) -> str | None:
    """Name of the set that serves, by the rules of those that ship: that for all seas, or the one that is asked for."""
    wanted = (REAL, f"{REAL}-{DEFAULT_SEA}") if tuning == REAL else (tuning or ALL,)
    return next((name for name in wanted if name in sets), None)


def own_choice(device_file: Path, name: str, device: Plant, given: Mapping[str, Any]) -> dict[str, Any]:
    """Parameters that are given on top of those of the set that was tuned on the device.

    Parameters
    ----------
    device_file : Path
        Beside which the sets are.
    name : str
        Registered name or "file.py:Name" of the law.
    device : Plant
        The device.
    given : mapping of str
        Parameters, among them perhaps ``tuning``, the name of a set.

    Returns
    -------
    dict of str
        As `given`, its ``tuning`` too, where the device has no such set: it is then one that ships.

    Raises
    ------
    InputError
        Field ``laws.NAME.tuning``, for a set that is neither the device's nor ships.
    """
    sets, tuning = own_sets(device_file, name, device), given.get("tuning")
    chosen = set_of(sets, tuning) if tuning is None or isinstance(tuning, str) else None
    if chosen is not None:
        return {**sets[chosen]["parameters"], **{key: value for key, value in given.items() if key != "tuning"}}
    shipped = tuned_sets(name) if isinstance(tuning, str) and not is_file(name) else {}
    if sets and shipped and tuning != REAL and tuning not in shipped:
        known = f"{', '.join(sets)} of {sets_folder(device_file).name}, or of those that ship {', '.join(shipped)}"
        raise InputError(f"laws.{name}.tuning", tuning, "there is no such set of tuned parameters", f"Choose {known}")
    return dict(given)


def on_file(path: str | Path, name: str, given: Mapping[str, Any]) -> tuple[Plant, dict[str, Any]]:
    """Device of a file, and the parameters of a law for it by `own_choice`."""
    plant = read_device(path)
    return plant, own_choice(Path(path), name, plant, given)


def own_seeds(device_file: Path, names: Iterable[str], device: Plant) -> set[int]:
    """Seeds on which laws were tuned on a device: they may not judge it."""
    return {seed for name in names for seed in seeds_of(own_sets(device_file, name, device))}


def foreign(
    kinds: Mapping[str, str],
    device: Plant,
    device_file: Path | None = None,
    tunings: Mapping[str, str | None] | None = None,
) -> list[str]:
    """Laws, by their names here, that run with a set of another device than this one.

    Parameters
    ----------
    kinds : mapping of str to str
        Registered name or "file.py:Name" of each law.
    device : Plant
        The device.
    device_file : Path, optional
        Its file, beside which sets of its own may be.
    tunings : mapping of str to str or None, optional
        The set that each law is to take, where one is named.
    """
    strange = []
    for name, kind in kinds.items():
        if kind in PAIRS:
            continue
        asked = (tunings or {}).get(name)
        if device_file is not None and set_of(own_sets(device_file, kind, device), asked):
            continue
        sets = tuned_sets(kind) if not is_file(kind) else {}
        if sets and not any(belongs(entry.get("found", {}), device) for entry in sets.values()):
            strange.append(name)
    return strange


def foreign_note(strange: Sequence[str], kinds: Mapping[str, str], device: Plant, device_file: Path | None) -> str:
    """Sentence on laws that run with a set of another device: which sets of this one could be asked for."""
    told = []
    for name in strange:
        own = own_sets(device_file, kinds[name], device) if device_file is not None else {}
        told.append(f"{name} (for it: tuning = {' or '.join(own)})" if own else name)
    file = device_file.name if device_file is not None else "FILE"
    search = f"gyroctl tune {' '.join(dict.fromkeys(kinds[name] for name in strange))} --device {file}"
    return f"Note: tuned for another device: {', '.join(told)}. For this one: {search}"
