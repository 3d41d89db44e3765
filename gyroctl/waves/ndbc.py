"""Directions of NDBC buoys: mean direction and first moment of the directions stand in files beside the densities.

The distribution over the directions is the cos^2s with the mean direction alpha1 and the first moment r1 of the file:
s = r1 / (1 - r1). The truncated Fourier series that is often drawn instead is negative in places, and a sea that is a
sum of waves cannot be.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gyroctl.errors import InputError

if TYPE_CHECKING:
    import xarray

MISSING = 900.0
"""From here on a number is none: NDBC writes 999."""


def beside(path: Path) -> tuple[Path, Path]:
    """Files of mean direction and first moment of a file of densities.

    Raises
    ------
    InputError
        Field ``sea.file``: the name follows neither custom, so that theirs are unknown.
    """
    name = path.name
    for suffix in (".data_spec", ".spec"):  # of the last 45 days
        if name.endswith(suffix):
            stem = name.removesuffix(suffix)
            return path.with_name(f"{stem}.swdir"), path.with_name(f"{stem}.swr1")
    found = re.fullmatch(r"(\w{5})w(\d{4}.*)", name)  # of a year
    if found:
        return path.with_name(f"{found[1]}d{found[2]}"), path.with_name(f"{found[1]}j{found[2]}")
    mend = "Name it STATION.data_spec beside .swdir and .swr1, or STATIONwYEAR.txt beside STATIONd.. and STATIONj.."
    raise InputError("sea.file", str(path), "its name does not tell the files of its directions", mend)


def plain(text: str) -> str:
    """Text as the library reads it: years of two digits, as archives to 1998 have them, in four; no second heading.

    What is missing and written MM becomes 999, which is refused where it is needed.
    """
    lines = text.split("\n")
    out = lines[:1]
    for line in lines[1:]:
        if line.lstrip().startswith("#"):  # units
            continue
        year = re.match(r"\s*(\d\d)(?=\s+\d{1,2}\s)", line)
        row = line if year is None else f"19{line.lstrip()}"
        out.append(re.sub(r"(?<!\S)MM(?!\S)", "999.00", row))
    return "\n".join(out)


def directional_ndbc(
    path: Path, ds: xarray.Dataset, read: Callable[[Path], xarray.Dataset]
) -> tuple[xarray.Dataset, tuple[str, ...]]:
    """Densities over frequency and direction, from the densities `ds` and the files beside.

    Raises
    ------
    InputError
        Field ``sea.file``: a file that is missing, or does not belong to the densities.
    """
    import xarray as xr
    from wavespectra.construct.direction import cartwright

    names = beside(path)
    mean, first = (read(name)["efth"].isel(dir=0, drop=True) for name in names)
    flat, notes = ds["efth"].isel(dir=0, drop=True), []
    both = [one.reindex(time=flat.time) if one.sizes["freq"] == flat.sizes["freq"] else None for one in (mean, first)]
    for name, one in zip(names, both, strict=True):
        if one is None or not np.allclose(one.freq, flat.freq, rtol=1e-3):
            raise InputError(
                "sea.file", str(name), "has other frequencies than the densities", "Give files of one buoy"
            )
    mean, first = (one.assign_coords(freq=flat.freq) for one in both if one is not None)
    if float(first.where(first < MISSING).max()) > 1.5:
        first = first.where(first >= MISSING, 0.01 * first)
        notes.append("first moments divided by 100, as archived files of NDBC have them")
    known = (mean >= 0.0) & (mean <= 360.0) & (first > 0.0) & (first < 1.0)
    lost = float(flat.where(~known).sum() / flat.sum())
    turn = np.deg2rad(mean.where(known))
    # Bins without a direction, which have little energy, take the mean one of the spectrum.
    weight = flat.where(known)
    overall = np.rad2deg(np.arctan2((weight * np.sin(turn)).sum("freq"), (weight * np.cos(turn)).sum("freq")))
    if lost > 0.0:
        notes.append(f"bins without a direction, {lost:.1%} of the energy of the file, take the mean one")
    spread = np.rad2deg(np.sqrt(2.0 * (1.0 - first.where(known, 0.5).clip(0.01, 0.999))))
    directions = xr.DataArray(np.arange(0.0, 360.0, 2.0), dims="dir", name="dir")
    directions = directions.assign_coords(dir=directions.values)
    shape = cartwright(directions, np.mod(mean.where(known, overall), 360.0), spread)
    return (flat * shape).to_dataset(name="efth").merge(ds.drop_vars("efth").drop_dims("dir", errors="ignore")), tuple(
        notes
    )
