"""The file of a hydrodynamic table: the shipped one, loading and saving."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np

from gyroctl.errors import InputError, check_kind
from gyroctl.hydrodynamics.capytaine_layout import from_capytaine, to_dataset
from gyroctl.hydrodynamics.site import Site
from gyroctl.hydrodynamics.table import LAYOUT, Hydrodynamics
from gyroctl.netcdf import read_netcdf
from gyroctl.writing import written_whole

SHIPPED = Path(__file__).parent.parent / "data" / "hydrodynamics.nc"


@cache
def shipped() -> Hydrodynamics:
    """Return the database that comes with the package: the float of Zhang et al. (2017), rebuilt by `bem.build`.

    Returns
    -------
    Hydrodynamics
        The table, read once in a process.

    Raises
    ------
    InputError
        Where the file of the package is damaged.
    """
    return load(SHIPPED)


def load(path: Path | str, site: Site | None = None) -> Hydrodynamics:
    """Read a database from a NetCDF file in the layout that Capytaine writes.

    Parameters
    ----------
    path : Path or str
        NetCDF classic or NetCDF 4, along omega, freq, period, wavenumber or wavelength.
    site : Site, optional
        What the file leaves out: density, gravity and depth, k3, the modes of phi1 and phi3, units, the hinge.

    Returns
    -------
    Hydrodynamics
        Conjugated from Capytaine's exp(-i w t) to exp(+i w t). Frequencies at which the file holds nan are left out,
        rows at infinite and at zero frequency are kept as such. What the file lacks is derived: the added mass at
        infinite frequency from Kramers-Kronig.

    Raises
    ------
    InputError
        When the file is missing, unreadable or of another layout.
    """
    check_kind("path", path, (str, Path), "a path", "Give the path of a hydrodynamic database")
    contents = read_netcdf("path", path, LAYOUT)
    with np.errstate(all="ignore"):  # what overflows is refused as what it gives
        return of_file(str(path), lambda: from_capytaine(*contents, str(path), site))


def of_file(name: str, read: Callable[[], Hydrodynamics]) -> Hydrodynamics:
    """Return what `read` makes of a file, or name the file where its numbers are refused."""
    try:
        return read()
    except InputError as error:
        known = name in error.field or str(error.value) == name
        raise error if known else InputError(f"{name}: {error.field}", error.value, error.problem, error.mend) from None


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
