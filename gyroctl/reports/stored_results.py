"""A comparison as it stands in a file: read with care, and what no comparison can hold refused by its name."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gyroctl.errors import InputError
from gyroctl.names import text_of
from gyroctl.netcdf import Contents, read_netcdf
from gyroctl.reading import CONTROL, is_finite, parse_json
from gyroctl.writing import SEALED, seal_of

if TYPE_CHECKING:
    import xarray as xr

MEND = "Give the results.nc that gyroctl compare wrote"

DAMAGED = "the file is not what was written: damaged, cut short or edited"
AGAIN = "Run gyroctl compare again with the same --out: finished runs are kept, and the file is written anew"
UNREADABLE = f"{MEND}. If this is it, it is cut short or damaged: r{AGAIN[1:]}"

LARGEST = 1e15
"""Size beyond which no result is meant; infinite and no number have their meanings."""

LAWS_MAX, TEXT_MAX = 10_000, 10_000_000
"""Most laws of a comparison, and the longest text of an attribute."""

BY_LAW, BY_RUN = ("information", "label", "preview"), ("failed", "failure")
"""Coordinates and variables that are no results."""

TEXTS = ("law", "sha256", "information", "label", "failure")
"""Variables that hold names and words."""

NAMES = ("law", "label")
"""Those of them in which nothing may hide."""

JSON: Mapping[str, type | tuple[type, ...]] = {
    "tuning_seeds": list,
    "seed_states": dict,
    "yardstick": dict,
    "parameters": dict,
    "versions": dict,
}
"""Attributes in JSON and what stands there; an experiment may be any text."""


def read_results(path: Path) -> xr.Dataset:
    """Read the file of a comparison, in memory.

    Raises
    ------
    InputError
        Field ``results``: as `gyroctl.netcdf.read_netcdf`, for a file that is not what was written, or for variables
        that do not fit together.
    """
    try:
        intact = seal_of(path)
    except OSError as error:
        raise InputError("results", str(path), f"cannot be read: {error.strerror}", MEND) from None
    if intact is False:
        raise InputError("results", str(path), DAMAGED, AGAIN)
    contents = read_netcdf("results", path, UNREADABLE)
    try:
        ds = _dataset(contents)
    except (KeyError, TypeError, ValueError) as error:
        problem = f"this NetCDF file cannot be read ({error})"
        raise InputError("results", str(path), problem, MEND) from error
    if ds.attrs.pop(SEALED, None) is not None and intact is None:
        raise InputError("results", str(path), DAMAGED, AGAIN)
    return ds


def _dataset(contents: Contents) -> xr.Dataset:
    """Label the variables of a file; of what an attribute may ask for, only flags are decoded."""
    import xarray as xr

    data: dict[str, Any] = {}
    named = set(str(contents.attributes.get("coordinates", "")).split())
    for name, (dimensions, values, told) in contents.variables.items():
        attributes = {key: value for key, value in told.items() if key not in ("_FillValue", "_Encoding", "dtype")}
        named |= set(str(attributes.pop("coordinates", "")).split()) | ({name} & set(dimensions))
        flags = told.get("dtype") == "bool" and values.dtype.kind in "iu"
        data[name] = (dimensions, values.astype(np.bool_) if flags else values, attributes)
    coordinates = {name: data.pop(name) for name in list(data) if name in named}
    attributes = {key: value for key, value in contents.attributes.items() if key != "coordinates"}
    return xr.Dataset(data, coordinates, attributes)


def check_values(ds: xr.Dataset, name: str, results: tuple[str, ...]) -> None:
    """Refuse values that no comparison can hold; its layout is known to be one.

    Parameters
    ----------
    ds : xarray.Dataset
        The comparison.
    name : str
        Of its file, for messages.
    results : tuple of str
        Variables over (law, realisation).

    Raises
    ------
    InputError
        Field ``results``, or that of the variable or attribute within it.
    """

    def refuse(part: str, value: object, problem: str) -> None:
        raise InputError(f"results: {part}", value, problem, f"{MEND}; {name} is damaged or was made otherwise")

    for part in ("law", "realisation", *(one for one in (*BY_LAW, "sha256") if one in ds.variables)):
        wanted = ("realisation",) if part in ("realisation", "sha256") else ("law",)
        if ds[part].dims != wanted:
            refuse(part, ds[part].dims, f"must have the dimension {wanted[0]}")
    for part in TEXTS:
        if part in ds.variables:
            texts = ds[part].values.ravel().tolist()
            if not all(isinstance(text, str) for text in texts):
                refuse(part, str(ds[part].dtype), "must be text")
            strange = [text for text in texts if CONTROL.search(text)]
            if part in NAMES:
                for text in texts:
                    text_of(f"results.{part}", text)
            elif strange:
                refuse(part, strange[0], "holds a control character")
    laws, seeds = ds["law"].values.tolist(), ds["realisation"].values
    if len(laws) > LAWS_MAX or len(set(laws)) < len(laws) or not all(laws):
        refuse("law", len(laws), f"must be different names, at most {LAWS_MAX}")
    if seeds.dtype.kind not in "iu" or seeds.min() < 0 or len(set(seeds.tolist())) < seeds.size:
        refuse("realisation", str(seeds.dtype), "must be different seeds, whole numbers from 0")
    series = [str(part) for part in ds.variables if str(part).startswith("example_") or part in ("time", "preview")]
    for part in (*(one for one in results if one in ds.variables), *series):
        values = ds[part].values
        if values.dtype.kind not in "fiub":
            refuse(part, str(values.dtype), "must be numbers")
        sizes = np.abs(values[np.isfinite(values)].astype(np.float64))
        if sizes.size and sizes.max() > LARGEST:
            refuse(part, float(sizes.max()), f"is beyond {LARGEST:g}")
    locked = ds["locked"].values.astype(np.float64)
    if not np.all((locked == 0.0) | (locked == 1.0) | np.isnan(locked)):
        refuse("locked", "another number", "must be 0 or 1")
    if np.any(ds["loss_time"].values < 0.0):
        refuse("loss_time", float(np.nanmin(ds["loss_time"].values)), "must not be negative")
    _check_series(ds, refuse)
    _check_failures(ds, refuse)
    _check_attributes(ds, refuse)


def _check_series(ds: xr.Dataset, refuse: Any) -> None:
    for part in map(str, ds.variables):
        if part.startswith("example_"):
            wanted = {"time"} if part == "example_elevation" else {"law", "time"}
            if set(ds[part].dims) != wanted:
                refuse(part, ds[part].dims, f"must have the dimensions {', '.join(sorted(wanted))}")
    if "time" in ds.variables:
        time = ds["time"].values
        if ds["time"].dims != ("time",) or not np.all(np.isfinite(time)) or np.any(np.diff(time) <= 0.0):
            refuse("time", ds["time"].dims, "must rise")


def _check_failures(ds: xr.Dataset, refuse: Any) -> None:
    there = [part for part in BY_RUN if part in ds.variables]
    if there and len(there) < len(BY_RUN):
        refuse(there[0], "alone", "must stand beside " + " and ".join(BY_RUN))
    for part in there:
        if set(ds[part].dims) != {"law", "realisation"}:
            refuse(part, ds[part].dims, "must have the dimensions law and realisation")
    if there and ds["failed"].dtype.kind not in "iub":
        refuse("failed", str(ds["failed"].dtype), "must be true or false")


def _check_attributes(ds: xr.Dataset, refuse: Any) -> None:
    for part in ("experiment", "gyroctl_version", "created", "tuning_seeds"):
        value = ds.attrs[part]
        if not isinstance(value, str) or len(value) > TEXT_MAX:
            refuse(part, value, "must be text")
    for part, value in ds.attrs.items():
        if part not in ("experiment", *JSON) and isinstance(value, str) and CONTROL.search(value):
            refuse(str(part), value, "holds a control character")
    limit = np.asarray(ds.attrs.get("motion_limit", 1.0)).tolist()
    if not (is_finite(limit) and 0.0 < limit < LARGEST):
        refuse("motion_limit", ds.attrs["motion_limit"], "must be a positive angle")
    for part, kind in JSON.items():
        if part in ds.attrs:
            _check_json(part, ds.attrs[part], kind, refuse)


def _check_json(part: str, text: object, kind: type | tuple[type, ...], refuse: Any) -> None:
    """Refuse an attribute in JSON that holds something else; one that is no JSON counts as not there."""
    try:
        value = parse_json(part, part, str(text), MEND, finite=False)
    except InputError:
        return
    if value is not None and not isinstance(value, kind):
        refuse(part, text, f"must hold a {getattr(kind, '__name__', 'table')}")
    lists = [value] if part == "tuning_seeds" else list(value.values()) if part == "seed_states" and value else []
    if not all(isinstance(seeds, list) and all(type(seed) is int and seed >= 0 for seed in seeds) for seeds in lists):
        refuse(part, text, "must list seeds, whole numbers from 0")
    if part == "yardstick" and value:
        pair = is_finite(value.get("cc")) and is_finite(value.get("cg")) and isinstance(value.get("searched"), bool)
        if not pair or not isinstance(value.get("words"), str) or math.fabs(value["cc"]) > LARGEST:
            refuse(part, text, "must tell a pair and how it was found")
