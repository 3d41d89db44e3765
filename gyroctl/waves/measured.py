"""Spectra of buoys and wave models, read by wavespectra: NDBC, Datawell, Spotter, TRIAXYS, SWAN.

The library reads; what is checked here is that a text is of bounded size and says nothing about itself that it does not
hold, and what is chosen here is one spectrum of it: time, place, part. Frequencies come in Hz, directions as those the
waves come from, clockwise from north.
"""

from __future__ import annotations

import gzip
import json
import math
import re
import tempfile
import warnings
from collections.abc import Callable
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import NOT_GIVEN, InputError
from gyroctl.reading import existing, read_text
from gyroctl.waves.columns import FIELD, FILE_MAX
from gyroctl.waves.ndbc import directional_ndbc, plain

if TYPE_CHECKING:
    import xarray

FORMATS = ("ndbc", "datawell", "spotter", "triaxys", "swan")

COUNTED = {
    "triaxys": re.compile(r"(?m)^NUMBER OF FREQUENCIES\s*=\s*(\S+)"),
    "swan": re.compile(r"(?m)^(?:LONLAT|LOCATIONS|[AR]FREQ|[NC]DIR|QUANT)\b.*\n\s*(\S+)"),
}
"""Where a text says how many numbers follow; the library believes it."""

EPOCH = "buoy}1970-01-01T00h00Z.spt"


class Measured(NamedTuple):
    """One measured spectrum."""

    frequency: NDArray[np.float64]  # (n,) [Hz]
    directions: NDArray[np.float64] | None  # (m,) that the waves come from, clockwise from north, rising [deg]
    density: NDArray[np.float64]  # (n,) [m^2/Hz] or (n, m) [m^2/Hz/deg]
    split: float | None  # that the file itself sets between swell and wind sea [Hz]
    notes: tuple[str, ...]


def read_one(
    path: str | PathLike[str], form: str, time: str | None = None, site: int | None = None, directional: bool = False
) -> Measured:
    """Read one spectrum of a file.

    Parameters
    ----------
    path : str or Path
        The file; of NDBC that of the spectral densities, beside which lie those of the directions.
    form : str
        One of `FORMATS`.
    time : str, optional
        Time stamp, or as much of its beginning as tells it from the others; needed where there are several.
    site : int, optional
        Number of the place, from 1; needed where there are several.
    directional : bool
        Whether directions are kept.

    Raises
    ------
    InputError
        Field ``sea.file`` for the file, ``sea.format``, ``sea.time``, ``sea.site``, ``sea.directional`` for the choice.
    """
    if form not in FORMATS:
        raise InputError("sea.format", form, "unknown format", f"Choose one of csv, {', '.join(FORMATS)}")
    _library(form)
    with tempfile.TemporaryDirectory() as folder:
        copy, text = _copied(path, form, Path(folder))
        ds, notes = _opened(copy, form, str(path), directional)
        if directional and form == "ndbc":
            ds, notes = directional_ndbc(
                Path(path), ds, lambda other: _opened(_copied(other, form, Path(folder))[0], form, str(other), False)[0]
            )
    stamped = not (form == "swan" and not re.search(r"(?m)^TIME\b", text)) and not (
        form == "datawell" and copy.name == EPOCH
    )
    one, at = _chosen(ds, str(path), time if stamped or time is None else _no_stamps(time), site)
    if stamped:
        notes = (*notes, f"spectrum of {at}")
    return _measured(one, str(path), directional, notes)


def _library(form: str) -> Any:
    try:
        import wavespectra
    except ImportError:
        mend = "Install the extra seas: pip install gyroctl[seas]"
        raise InputError(
            "sea.format", form, "the library that reads such files, wavespectra, is not installed", mend
        ) from None
    return wavespectra


def _copied(path: str | PathLike[str], form: str, folder: Path) -> tuple[Path, str]:
    """The text of a file, checked, in a folder and under a name of our own: some names mean more than one file."""
    source, mend = Path(path), f"Give a file of {form}"
    if source.suffix.lower() == ".gz":
        unpacked = folder / "unpacked"
        try:
            with gzip.open(existing(FIELD, source, mend)) as stream, unpacked.open("wb") as target:
                target.write(stream.read(FILE_MAX + 1))
        except (OSError, EOFError) as error:
            raise InputError(FIELD, str(path), f"cannot be unpacked: {error}", mend) from None
        text = read_text(FIELD, unpacked, mend, FILE_MAX)
    else:
        text = read_text(FIELD, source, mend, FILE_MAX)
    text = plain(text) if form == "ndbc" else _own_stamps(text) if form == "spotter" else text
    quantities = re.search(r"(?m)^QUANT\b", text) if form == "swan" else None
    if quantities and not re.search(r"(?m)^[NC]DIR\b", text[: quantities.start()]):
        problem, other = "holds spectra over frequency alone", "Write SPEC2D, or give one as columns f [Hz], S [m2/Hz]"
        raise InputError(FIELD, str(path), problem, other)
    lines = text.count("\n") + 1
    for count in COUNTED[form].finditer(text) if form in COUNTED else ():
        if not re.fullmatch(r"\d{1,9}", count[1]) or int(count[1]) > lines:
            raise InputError(FIELD, str(path), f"says {count[0].strip()[:60]!r}, and has {lines} lines", mend)
    if form == "triaxys" and re.search(r"(?m)^(?:FREQUENCY|DIRECTION) SPACING[^=]*=\s*+(?![0-9.]*[1-9])", text):
        raise InputError(FIELD, str(path), "says a spacing of zero", mend)
    name = {"datawell": EPOCH, "spotter": "spectrum" + source.suffix.lower()}.get(form, "spectrum.txt")
    if form == "datawell" and re.fullmatch(r"[^}]*\}\d{4}-\d\d-\d\dT\d\dh\d\dZ\.spt", source.name):
        name = "buoy}" + source.name.split("}")[1]
    copy = folder / name
    copy.write_text(text, encoding="utf-8", newline="\n")
    return copy, text


def _own_stamps(text: str) -> str:
    """JSON of a Spotter whose spectra have the stamps that stand with them: the library takes those of the heights."""
    try:
        content = json.loads(text)
        stamps = [{"timestamp": str(one["timestamp"])} for one in content["data"]["frequencyData"]]
    except (ValueError, TypeError, KeyError, RecursionError):
        return text  # columns, or no file of a Spotter, which the library will say
    content["data"]["waves"] = stamps
    return json.dumps(content)


def _opened(copy: Path, form: str, path: str, directional: bool) -> tuple[xarray.Dataset, tuple[str, ...]]:
    """What the library makes of a text."""
    from wavespectra.input.datawell import read_datawell
    from wavespectra.input.ndbc_ascii import read_ndbc_ascii
    from wavespectra.input.spotter import read_spotter
    from wavespectra.input.swan import read_swan
    from wavespectra.input.triaxys import read_triaxys

    readers: dict[str, Callable[[], xarray.Dataset]] = {
        "ndbc": lambda: read_ndbc_ascii(str(copy)),
        "datawell": lambda: read_datawell(str(copy), dd=2.0 if directional else None),
        "spotter": lambda: read_spotter(str(copy), dd=2.0 if directional else None),
        "triaxys": lambda: read_triaxys(str(copy)),
        "swan": lambda: read_swan(str(copy), as_site=True),
    }
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            warnings.simplefilter("error", UserWarning)  # the library warns of lines that it could not read
            ds = readers[form]()
            for name in {"efth", "freq", "dir", "time"} & {*ds.variables}:
                ds[name].values.astype("datetime64[s]" if name == "time" else np.float64)
    except Exception as error:  # whatever a damaged text makes of a parser: it is no file of this kind
        what = " ".join(f"{type(error).__name__}: {error}".split())[:200]
        raise InputError(FIELD, path, f"is no sound file of {form}: {what}", f"Give a file of {form}") from None
    if "efth" not in ds or "freq" not in ds["efth"].dims or not ds["efth"].size:
        raise InputError(FIELD, path, "holds no spectrum", f"Give a file of {form}")
    return ds, ()


def _no_stamps(time: str) -> str:
    raise InputError("sea.time", time, "the file has no time stamps", "Leave the option out")


def _chosen(ds: xarray.Dataset, path: str, time: str | None, site: int | None) -> tuple[xarray.Dataset, str]:
    """Dataset of one time and one place, and the stamp."""
    stamps = [str(stamp)[:19] for stamp in np.atleast_1d(ds["time"].values).astype("datetime64[s]")]
    asked = (time or "").strip().removesuffix("Z").replace(" ", "T")
    among = [i for i, stamp in enumerate(stamps) if stamp.startswith(asked)]
    if len(among) != 1:
        listed = f"{stamps[0]} to {stamps[-1]}" if len(stamps) > 1 else stamps[0]
        problem = f"fits {len(among) or 'none'} of the {len(stamps)} spectra of {Path(path).name}, and has to fit one"
        if time is None:
            problem = f"{Path(path).name} holds {len(stamps)} spectra"
        raise InputError(
            "sea.time", NOT_GIVEN if time is None else time, problem, f"Give one of its time stamps, {listed}"
        )
    one = ds.isel(time=among[0]) if "time" in ds.dims else ds
    places = [str(name) for name in one["efth"].dims if name not in ("freq", "dir")]
    count = int(np.prod([one.sizes[name] for name in places])) if places else 1
    if site is None and count > 1:
        raise InputError("sea.site", NOT_GIVEN, f"the file holds {count} places", f"Give a number from 1 to {count}")
    if site is not None and not 1 <= site <= count:
        raise InputError("sea.site", site, f"the file holds {count} places", f"Give a number from 1 to {count}")
    if places:
        one = one.stack(place=places).isel(place=int(site or 1) - 1)
    return one, stamps[among[0]]


def _measured(one: xarray.Dataset, path: str, directional: bool, notes: tuple[str, ...]) -> Measured:
    spectrum = one["efth"]
    frequency = np.asarray(spectrum["freq"].values, dtype=np.float64)
    if not np.all(np.isfinite(frequency)) or np.any(np.diff(frequency) <= 0.0) or frequency.size < 2:
        raise InputError(FIELD, path, "has frequencies that do not rise", "Give another file")
    several = "dir" in spectrum.dims and spectrum.sizes["dir"] > 1
    axes = ("freq", "dir") if "dir" in spectrum.dims else ("freq",)
    density = np.asarray(spectrum.transpose(*axes).values, dtype=np.float64)
    wrong = ~np.isfinite(density) | (density < 0.0) | (density >= 900.0 if not several else False)
    if np.any(wrong):
        n = int(np.argwhere(wrong)[0][0])
        raise InputError(FIELD, path, f"has no sound density at {frequency[n]:.4g} Hz", "Give another time or file")
    directions = None
    if several:
        directions, density = _around(np.asarray(spectrum["dir"].values, dtype=np.float64), density, path)
        if not directional:
            density, directions = density.sum(axis=1) * float(np.diff(directions).mean()), None
            notes = (*notes, "the directions of the file are left out: directional = true keeps them")
    elif directional:
        raise InputError("sea.directional", True, "the file holds no directions", "Leave the option out")
    elif density.ndim == 2:
        density = density[:, 0]
    own = float(one["Sep_Freq"]) if "Sep_Freq" in one else math.nan
    return Measured(frequency, directions, density, own if 0.0 < own < 9.0 else None, notes)


def _around(
    directions: NDArray[np.float64], density: NDArray[np.float64], path: str
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Rising directions within a turn, each once, and the columns that belong to them."""
    if not np.all(np.isfinite(directions)):
        raise InputError(FIELD, path, "has a direction that is no number", "Give another file")
    turned = np.mod(np.round(directions, 4), 360.0)
    kept, first = np.unique(turned, return_index=True)
    density = density[:, first]
    gap = np.diff(np.append(kept, kept[0] + 360.0))
    start = (int(np.argmax(gap)) + 1) % kept.size  # a sector begins behind its largest gap
    kept = np.concatenate((kept[start:], kept[:start] + 360.0))
    density = np.roll(density, -start, axis=1)
    step = np.diff(kept)
    if kept.size < 3 or np.ptp(step) > 0.02 * step.mean():
        raise InputError(FIELD, path, "has uneven directions", "Give a file with evenly spaced directions")
    return kept[0] + float(step.mean()) * np.arange(kept.size), density
