"""The layout of a comparison file (results.nc): what a report needs, and one place that reads and checks it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.reading import existing, is_finite, parse_json
from gyroctl.reports.stored_results import LARGEST, MEND, check_values, read_results

if TYPE_CHECKING:
    import xarray as xr

REFERENCE = "best_constant"
"""Name of the law that the others are measured against."""

MOTION_LIMIT = 0.35
"""Default limit of the 98 % motion, for either rotation. [rad]"""

FEW = 32
"""Laws up to which every pair is compared and every law is drawn and told.

Of more laws only the pairs with the reference and with the strongest are compared, and pictures and words are of so
many laws: the work grows with the laws and not with their pairs.
"""

POWER = ("mean_power", "power_cv", "p98_over_mean")
LOCK = ("locked", "loss_time", "cycle_slips")
MOTION = ("phi1_p98", "phi3_p98")
FLOWS = ("wave_input_w", "radiated_w", "hinge_w", "slip_loss_w", "stored_w")
REQUIRED = (*POWER, *LOCK, *MOTION, *FLOWS, "ledger_residual")
"""Variables over (law, realisation) without which there is no report."""

EXTRAS = ("power_cv_1s", "capture_width_ratio", "saturations", "outside_model")
JUDGED = ("generated_w", "turns_kept", "in_step", "outside_share", "phi1_max", "phi3_max")
CARD = (
    "traction_p99",
    "traction_p999",
    "traction_over_03",
    "traction_over_06",
    "reversals",
    "coupling_torque_max",
    "slip_max",
    "coupling_loss_max",
    "immersion_max",
    "immersion_min",
    "dry_share",
    "submerged_share",
    "kx_max",
    "beyond_validity",
)
"""What the numbers rest on, see `gyroctl.simulation.validity`."""

STEPS = ("step_ms_median", "step_ms_p99", "deadline_misses", "fallbacks")
SUPERVISED = ("availability", "motor_energy", "net_energy", "lock_begins", "payback_time", "starts", "unloads")
OPTIONAL = (*EXTRAS, *JUDGED, *CARD, *STEPS, *SUPERVISED)
"""Variables over (law, realisation) shown where present, and as unknown in files that are older than they are."""

EXAMPLES = ("power", "ring_speed", "phi1", "phi3", "cc", "cg", "load_share")
"""Time series over (law, time) of one realisation, each stored as ``example_<name>``."""

FURTHER_EXAMPLES = ("load_angle",)
"""More of them, in files that are young enough."""

COORDINATES = ("law", "realisation", "sha256", "information")
ATTRIBUTES = ("experiment", "gyroctl_version", "created", "tuning_seeds")


def open_results(source: xr.Dataset | str | Path) -> xr.Dataset:
    """Read a comparison and check that it has the layout a report needs.

    Parameters
    ----------
    source : xarray.Dataset, str or Path
        The dataset itself, its NetCDF file, or the directory that ``gyroctl compare`` wrote it to.

    Returns
    -------
    xarray.Dataset
        In memory; the file is closed again.

    Raises
    ------
    InputError
        No such file, not a NetCDF file, one that is not what was written, or a NetCDF file of another layout (the
        message lists what is missing).
    """
    if not isinstance(source, str | Path):
        return check_layout(source, "dataset in memory")
    path = Path(source)
    path = path / "results.nc" if path.is_dir() else path
    existing("results", path, "Give the directory that gyroctl compare wrote, or its results.nc")
    return check_layout(read_results(path), str(path))


def check_layout(ds: xr.Dataset, name: str) -> xr.Dataset:
    """Return `ds` unchanged if it is a comparison, else raise an InputError that lists all that is missing.

    Parameters
    ----------
    ds : xarray.Dataset
        What is to be a comparison.
    name : str
        Where it comes from, for the message.

    Returns
    -------
    xarray.Dataset
        The same.

    Raises
    ------
    InputError
        Where variables, dimensions or attributes are missing: it names all of them.
    """
    missing = [f"dimension {dim}" for dim in ("law", "realisation") if dim not in ds.dims]
    missing += [f"coordinate {coord}" for coord in COORDINATES if coord not in ds.variables]
    missing += [f"variable {variable}" for variable in REQUIRED if variable not in ds.variables]
    missing += [
        f"dimensions (law, realisation) of {variable}"
        for variable in (*REQUIRED, *OPTIONAL)
        if variable in ds.variables and set(ds[variable].dims) != {"law", "realisation"}
    ]
    missing += [f"attribute {attribute}" for attribute in ATTRIBUTES if attribute not in ds.attrs]
    if not duration(ds) > 0.0:
        missing.append("attribute duration (or run.duration in the experiment, or the coordinate time)")
    if missing:
        raise InputError("results", name, f"this is no comparison of laws; missing: {', '.join(missing)}", MEND)
    if ds.sizes["law"] == 0 or ds.sizes["realisation"] == 0:
        raise InputError("results", name, "the comparison holds no run", MEND)
    check_values(ds, name, (*REQUIRED, *OPTIONAL))
    return ds


def read_json(ds: xr.Dataset, attribute: str, default: Any) -> Any:
    """Read a JSON attribute; `default` where it is absent or not JSON, so that an odd file stays readable."""
    try:
        return parse_json(attribute, attribute, str(ds.attrs[attribute]), MEND, finite=False)
    except (KeyError, InputError):
        return default


def experiment(ds: xr.Dataset) -> dict[str, Any]:
    """Read the experiment as a dictionary; empty where the attribute holds none."""
    value = read_json(ds, "experiment", {})
    return value if isinstance(value, dict) else {}


def duration(ds: xr.Dataset) -> float:
    """Duration [s] of every run: attribute ``duration``, else the experiment's, else the end of the examples."""
    run = experiment(ds).get("run")
    told = run.get("duration") if isinstance(run, dict) else None
    told = np.asarray(ds.attrs.get("duration", told)).tolist()  # a number of NumPy is one of Python's
    if told is None and "time" in ds.variables and ds["time"].size and ds["time"].dtype.kind in "fiu":
        told = float(ds["time"].values.ravel()[-1])
    return float(told) if is_finite(told) and abs(float(told)) <= LARGEST else float("nan")  # type: ignore[arg-type]


def names(ds: xr.Dataset) -> list[str]:
    """Names of the laws in the order of the file."""
    return [str(name) for name in ds["law"].values]


def failures(ds: xr.Dataset) -> list[dict[int, str]]:
    """Why runs of each law failed, by seed; empty for files that are older than this."""
    if "failed" not in ds.variables:
        return [{} for _ in names(ds)]
    failed, why = (ds[name].transpose("law", "realisation").values for name in ("failed", "failure"))
    seeds = [int(seed) for seed in ds["realisation"].values]
    return [
        {seed: str(reason) for seed, broken, reason in zip(seeds, *row, strict=True) if broken}
        for row in zip(failed, why, strict=True)
    ]


def values(ds: xr.Dataset, variable: str) -> NDArray[np.float64]:
    """Read a variable over (law, realisation), NaN where the file has no such variable."""
    if variable not in ds.variables:
        return np.full((ds.sizes["law"], ds.sizes["realisation"]), np.nan)
    return np.asarray(ds[variable].transpose("law", "realisation").values, dtype=np.float64)


def packing(ds: xr.Dataset) -> dict[str, dict[str, Any]]:
    """How a comparison is written: its time series compressed, without the loss of a bit."""
    series = [name for name in ds.data_vars if str(name).startswith("example_") and ds[name].size]
    return {str(name): {"zlib": True, "complevel": 4, "shuffle": True} for name in series}


def has_examples(ds: xr.Dataset) -> bool:
    """Whether the file holds the time series of the example realisation."""
    wanted = (*(f"example_{name}" for name in EXAMPLES), "example_elevation", "time")
    return all(name in ds.variables for name in wanted)
