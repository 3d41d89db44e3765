"""A device as a file: read, written, every entry with its unit and meaning."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from gyroctl.devices.entries import ENTRIES, GROUPS, Entry
from gyroctl.devices.identity import changed, changes_in_words
from gyroctl.devices.scaling import check_length, scaled_parameters
from gyroctl.devices.zhang import VARIANTS, zhang2017
from gyroctl.errors import InputError, check_kind
from gyroctl.hydrodynamics import Hydrodynamics, load, shipped
from gyroctl.hydrodynamics.scaling import scaled
from gyroctl.names import choice_of, name_of, text_of
from gyroctl.plant import Parameters, Plant
from gyroctl.plant.parameters import POSITIVE, SCALES
from gyroctl.tables import read_tables
from gyroctl.writing import write_text

SHIPPED = "shipped"
"""Name of the hydrodynamics of the paper's device."""

HEAD: dict[str, Entry] = {
    "name": Entry("", "for studies and reports"),
    "variant": Entry("", f"one of {', '.join(VARIANTS)}: the choices of what is left out below"),
    "hydrodynamics": Entry(
        "", '"shipped", or a database of your own (see gyroctl hydro import), relative to this file'
    ),
    "hydrodynamics_length": Entry("-", "multiplies all lengths of that database, by Froude's law"),
    "radiation": Entry("", "fit of the radiation in the database: accurate, paper or fine"),
    "excitation_phase": Entry("", '"complex", or "magnitude" as the paper has it'),
}
"""Entries that are no numbers of the equations."""

SMALLEST = 1e-12
"""Size below which no length, mass, inertia or stiffness of a device is meant: what is divided by it would overflow."""

OF_TABLE = ("k3", "Jh1", "Jh3")
"""Numbers that the hydrodynamics give where the file does not."""

KNOWN = (*HEAD, *ENTRIES)


def device(path: Path | str) -> Plant:
    """Build the device that a file describes, see ``gyroctl device new``.

    Parameters
    ----------
    path : Path or str
        TOML file. What it leaves out is that of Table 1 at the file's ``length_scale``, in its ``variant``; k3, Jh1 and
        Jh3 then come from the hydrodynamics, unless these are the shipped ones as they are.

    Returns
    -------
    Plant
        Its name is that of the file and what was changed against Table 1.

    Raises
    ------
    InputError
        For a file that cannot be read, an unknown entry, or a value that no device can have; the field is the file's
        name and the entry.
    """
    check_kind("path", path, (str, Path), "a path", "Give the path of a device file, see gyroctl device new")
    file = Path(path)
    return build_device(read_tables(file, "device"), file.parent, file.name)


def build_device(tables: Mapping[str, Any], folder: Path = Path(), file: str = "device") -> Plant:
    """Build a device from the entries of its file; paths are relative to `folder`, errors name `file`."""
    _check_known(tables, file)
    try:
        return _built(dict(tables), folder, Path(file).stem)
    except InputError as error:
        field = error.field.removeprefix("plant.").removeprefix("device.")
        raise InputError(f"{file}: {field}", error.value, error.problem, error.mend) from None


def _check_known(tables: Mapping[str, Any], file: str) -> None:
    """Refuse an unknown entry, with the nearest one that there is."""
    for key, value in tables.items():
        if key in KNOWN:
            continue
        problem = "unknown table" if isinstance(value, Mapping) else "unknown key"
        raise InputError(f"{file}: {key}", value, problem, choice_of(key, KNOWN))


def _built(given: dict[str, Any], folder: Path, stem: str) -> Plant:
    name = name_of("name", given.pop("name", stem))
    variant, length = given.pop("variant", "corrected"), given.get("length_scale", 1.0)
    if not isinstance(variant, str) or variant not in VARIANTS:
        raise InputError("variant", variant, "unknown variant", f"Choose one of {', '.join(VARIANTS)}")
    Parameters(length_scale=length)
    source, by = given.pop("hydrodynamics", SHIPPED), check_by(given.pop("hydrodynamics_length", 1.0))
    table = _table(source, folder)
    table = table if table is None and by == 1.0 else scaled(table or shipped(), by)
    choices = {key: given.pop(key) for key in ("radiation", "excitation_phase") if key in given}
    if float(length) != 1.0:  # what is left out is Table 1's, and the variant's, at this length
        usual = usual_parameters(variant, float(length))
        taken = OF_TABLE if table is not None else ()
        given = {**{key: getattr(usual, key) for key in ENTRIES if key not in taken}, **given}
    plant = zhang2017(variant, table, **choices, **given)
    for key in POSITIVE:
        value = getattr(plant.parameters, key)
        if value < SMALLEST:
            raise InputError(key, value, f"must be at least {SMALLEST:g}", f"Give {key} in SI units")
    return plant.replace(name=told(name, variant, plant, choices.get("radiation")))


def usual_parameters(variant: str, length: float) -> Parameters:
    """Table 1 with the choices of a variant, for a device that is `length` times as long."""
    first = Parameters(**{name: value for name, value in VARIANTS[variant].items() if name in ENTRIES})
    return first if length == 1.0 else scaled_parameters(first, length)


def own_changes(plant: Plant) -> list[str]:
    """What was changed against Table 1 in the variant that the plant is nearest to, in words; not its length.

    Contact and wetted surface do not count: orbits are searched with those that can be differentiated. Nor do numbers
    that differ by less than 1 %, as those of a hydrodynamic database do from the paper's.
    """
    p = plant.parameters
    usual = [usual_parameters(variant, p.length_scale) for variant in VARIANTS]
    usual = [replace(one, wetted=p.wetted, contact=p.contact) for one in usual]
    nearest = min(usual, key=lambda one: len(changed(plant, one)))
    return changes_in_words(plant, first=nearest, within=0.01)[0 if p.length_scale == 1.0 else 1 :]


def told(name: str, variant: str, plant: Plant, radiation: Any = None) -> str:
    """Name of a plant from a file: that of the device, its variant, what was changed against Table 1."""
    fit = [] if radiation in (None, VARIANTS[variant]["radiation"]) else [f"radiation = {radiation}"]
    words = changes_in_words(plant, first=usual_parameters(variant, plant.parameters.length_scale))
    return ", ".join([f"{name} (zhang2017 {variant})", *words, *fit])


def check_by(value: Any) -> float:
    """Return the factor on the lengths of the hydrodynamics, or refuse it under its name."""
    try:
        return check_length(value)
    except InputError as error:
        raise InputError("hydrodynamics_length", error.value, error.problem, error.mend) from None


def _table(source: Any, folder: Path) -> Hydrodynamics | None:
    if not isinstance(source, str):
        raise InputError("hydrodynamics", source, "must be a path", 'Give the path of a database, or "shipped"')
    text_of("hydrodynamics", source)
    if source == SHIPPED:
        return None
    try:
        return load(folder / source)
    except InputError as error:
        field = "hydrodynamics" if error.field == "path" else error.field
        raise InputError(field, source, f"{error.problem}", error.mend) from None


def database_of(path: Path | str) -> Hydrodynamics:
    """Hydrodynamics of the device that a file describes, as those of its model at the size of Table 1.

    Raises
    ------
    InputError
        As `device`.
    """
    file = Path(path)
    plant = device(file)  # refuses what the file says wrong
    given = read_tables(file, "device")
    table = _table(given.get("hydrodynamics", SHIPPED), file.parent) or shipped()
    by = check_by(given.get("hydrodynamics_length", 1.0)) / plant.parameters.length_scale
    return table if by == 1.0 else scaled(table, by)


# --- writing -----------------------------------------------------------------------------------------------------


def new_device(name: str = "mine", variant: str = "corrected", **changes: Any) -> dict[str, Any]:
    """Entries of a new device file: Table 1 in a variant, with some entries changed.

    Parameters
    ----------
    name : str
        Of the device.
    variant : str
        One of `VARIANTS`.
    **changes
        Entries of the file, as ``J14=0.18``.

    Raises
    ------
    InputError
        For an unknown variant or entry.
    """
    if variant not in VARIANTS:
        raise InputError("variant", variant, "unknown variant", f"Choose one of {', '.join(VARIANTS)}")
    _check_known(changes, "device")
    head = {"name": name, "variant": variant, "hydrodynamics": SHIPPED, "hydrodynamics_length": 1.0}
    head |= {key: VARIANTS[variant][key] for key in ("radiation", "excitation_phase")}
    usual = usual_parameters(variant, float(changes.get("length_scale", 1.0)))
    numbers = {key: getattr(usual, key) for key in ENTRIES if key not in OF_TABLE}
    return {**head, **numbers, **changes}


def device_text(entries: Mapping[str, Any], above: Iterable[str] = ()) -> str:
    """Text of a device file: its entries in their groups, each with unit and meaning; `above` in comments at the top.

    Entries that the hydrodynamics give, and that are left out, stand there as comments.
    """
    lines = [f"# {line}" for line in above] + [""]
    lines += [_line(key, entries[key], entry) for key, entry in HEAD.items() if key in entries]
    for group, own in GROUPS.items():
        lines += ["", f"# {group}"]
        for key, entry in own.items():
            if key in entries:
                lines.append(_line(key, entries[key], entry))
            elif key in OF_TABLE:
                lines.append(f"# {_line(key, getattr(Parameters(), key), entry)}; Table 1")
    return "\n".join(lines).strip() + "\n"


def write_device(path: Path | str, entries: Mapping[str, Any], above: Iterable[str] = ()) -> Path:
    """Write a device file whole or not at all; one that is there is left as it is.

    Raises
    ------
    InputError
        Field ``device``: the file exists already. Or what the entries refuse, and nothing is written.
    """
    file = Path(path)
    if file.suffix != ".toml":
        raise InputError("device", str(path), "is no name of a device file", "Give one that ends with .toml")
    if file.exists():
        raise InputError("device", str(path), "exists already", "Give another name, or remove the file first")
    build_device(entries, file.parent, file.name)
    return write_text(file, device_text(entries, above))


def _line(key: str, value: Any, entry: Entry) -> str:
    unit = f"[{entry.unit}] " if entry.unit else ""
    return f"{key} = {_toml(value)}  # {unit}{entry.words}"


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, tuple | list):
        return f"[{', '.join(_toml(one) for one in value)}]"
    return repr(float(value))


def scaled_device(path: Path | str, length: float) -> dict[str, Any]:
    """Entries of the file of a device that is `length` times as long as that of a file, by Froude's law.

    Parameters
    ----------
    path : Path or str
        Device file.
    length : float
        Factor on all lengths. [-]

    Raises
    ------
    InputError
        As `device`, and for a factor that leads out of what a device may be.
    """
    file = Path(path)
    plant, factor = device(file), check_length(length)
    given = dict(read_tables(file, "device"))
    variant = given.get("variant", "corrected")
    low, high = SCALES
    size = plant.parameters.length_scale * factor
    if not low <= size <= high:
        problem = f"makes the device {size:g} times as long as that of Table 1"
        raise InputError("length", length, problem, f"Give a factor that leads to {low:g} to {high:g}")
    head = {
        "name": f"{given.get('name', file.stem)} x{factor:g}",
        "variant": variant,
        "hydrodynamics": given.get("hydrodynamics", SHIPPED),
        "hydrodynamics_length": check_by(float(given.get("hydrodynamics_length", 1.0)) * factor),
        "radiation": given.get("radiation", VARIANTS[variant]["radiation"]),
        "excitation_phase": given.get("excitation_phase", VARIANTS[variant]["excitation_phase"]),
    }
    numbers = scaled_parameters(plant.parameters, factor)
    return {**head, **{key: getattr(numbers, key) for key in ENTRIES}}
