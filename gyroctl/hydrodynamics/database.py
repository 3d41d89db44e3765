"""The file of a hydrodynamic table: the shipped one, loading and saving."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.capytaine_layout import Variable, Variables, from_capytaine, to_dataset
from gyroctl.hydrodynamics.table import LAYOUT, Hydrodynamics
from gyroctl.writing import written_whole

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
        NetCDF classic or NetCDF 4.

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
        variables, attributes = read_classic(file)
    elif magic == b"\x89HDF":
        variables, attributes = _read_netcdf4(file)
    else:
        raise InputError("path", str(path), "is not a NetCDF file", LAYOUT)
    return from_capytaine(variables, attributes, str(path))


def read_classic(path: Path) -> tuple[Variables, dict[str, Any]]:
    """Return all variables and the global attributes of a NetCDF classic file; character arrays become arrays of str.

    SciPy is what xarray would read it with, and comes without the second that importing xarray takes.

    Raises
    ------
    InputError
        When the file is damaged or has an unlimited dimension, which no table has.
    """
    from scipy.io import netcdf_file

    try:
        with netcdf_file(path, mmap=False) as file:
            if None in file.dimensions.values():
                raise ValueError("it has an unlimited dimension")
            variables = {name: _variable(v.dimensions, v.data) for name, v in file.variables.items()}
            attributes = {
                name: value.decode() if isinstance(value, bytes) else np.asarray(value).tolist()
                for name, value in file._attributes.items()
            }
    except (ArithmeticError, LookupError, MemoryError, OSError, TypeError, ValueError) as error:
        problem = f"is not a readable NetCDF classic file ({error})"
        raise InputError("path", str(path), problem, "Write it again with xarray or Capytaine") from error
    return variables, attributes


def _variable(dimensions: tuple[str, ...], values: NDArray[Any]) -> Variable:
    if values.dtype.char != "c" or values.ndim == 0:
        return Variable(dimensions, values.astype(values.dtype.newbyteorder("=")))
    text = np.ascontiguousarray(values).view(f"S{values.shape[-1]}")[..., 0]
    return Variable(dimensions[:-1], np.char.decode(text, "utf-8"))


def _read_netcdf4(path: Path) -> tuple[Variables, dict[str, Any]]:
    """Read a NetCDF 4 file through xarray."""
    import xarray as xr

    try:
        with xr.open_dataset(path, engine="h5netcdf") as dataset:
            data = dataset.load()
    except ImportError as error:
        problem = "is a NetCDF 4 file and h5py is not installed"
        raise InputError("path", str(path), problem, "Run: pip install h5py") from error
    except (OSError, ValueError) as error:
        raise InputError("path", str(path), f"cannot be read as NetCDF 4 ({error})", LAYOUT) from error
    found = {str(k): Variable(tuple(map(str, v.dims)), np.asarray(v.values)) for k, v in data.variables.items()}
    return found, {str(k): v for k, v in data.attrs.items()}


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
    with written_whole(target) as part:
        to_dataset(hydro).to_netcdf(part, engine="scipy", format="NETCDF3_64BIT")
    return target
