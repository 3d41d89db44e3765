"""The file of a hydrodynamic table: the shipped one, loading and saving."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from gyroctl.errors import InputError
from gyroctl.hydrodynamics import netcdf_classic
from gyroctl.hydrodynamics.capytaine_layout import from_capytaine, to_dataset
from gyroctl.hydrodynamics.table import LAYOUT, Hydrodynamics

SHIPPED = Path(__file__).parent.parent / "data" / "hydrodynamics.nc"


@cache
def shipped() -> Hydrodynamics:
    """Return the database that comes with the package: the float of Zhang et al. (2017), rebuilt by `bem.build`."""
    return load(SHIPPED)


def load(path: Path | str) -> Hydrodynamics:
    """Read a database from a NetCDF file in the layout that Capytaine writes.

    Parameters
    ----------
    path : Path or str
        NetCDF classic (read without any further library) or NetCDF 4 (needs xarray with h5netcdf and h5py).

    Returns
    -------
    Hydrodynamics
        Conjugated from Capytaine's exp(-i w t) to exp(+i w t). What the file lacks is derived: the added mass at
        infinite frequency from Kramers-Kronig.

    Raises
    ------
    InputError
        When the file is missing, unreadable or of another layout.
    """
    file = Path(path)
    if not file.is_file():
        raise InputError("path", str(path), "there is no such file", "Check the path of the hydrodynamic database")
    with file.open("rb") as stream:
        magic = stream.read(4)
    if magic[:3] == b"CDF" and magic[3:] in (b"\x01", b"\x02"):
        contents = netcdf_classic.read(file)
    elif magic == b"\x89HDF":
        contents = _read_netcdf4(file)
    else:
        raise InputError("path", str(path), "is not a NetCDF file", LAYOUT)
    return from_capytaine(contents.variables, contents.attributes, str(path))


def _read_netcdf4(path: Path) -> netcdf_classic.Contents:
    """Read a NetCDF 4 file through xarray."""
    import xarray as xr

    try:
        with xr.open_dataset(path, engine="h5netcdf") as dataset:
            data = dataset.load()
    except ImportError as error:
        raise InputError(
            "path", str(path), "is a NetCDF 4 file and h5py is not installed", "Run: pip install h5py"
        ) from error
    except (OSError, ValueError) as error:
        raise InputError("path", str(path), f"cannot be read as NetCDF 4 ({error})", LAYOUT) from error
    variables = {
        str(name): netcdf_classic.Variable(tuple(map(str, values.dims)), np.asarray(values.values))
        for name, values in data.variables.items()
    }
    return netcdf_classic.Contents(variables, {str(k): v for k, v in data.attrs.items()})


def save(hydro: Hydrodynamics, path: Path | str) -> Path:
    """Write the database as NetCDF classic in Capytaine's layout; `load` reads it back bit by bit.

    Parameters
    ----------
    hydro : Hydrodynamics
        The table.
    path : Path or str
        File to write. It appears whole or not at all.

    Returns
    -------
    Path
    """
    target = Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    partial = target.with_name(target.name + ".partial")
    try:
        to_dataset(hydro).to_netcdf(partial, engine="scipy", format="NETCDF3_64BIT")
        partial.replace(target)
    finally:
        partial.unlink(missing_ok=True)
    return target
