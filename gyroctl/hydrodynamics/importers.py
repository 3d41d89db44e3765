"""Results of other solvers as a database: WAMIT (.1, .3, .hst), NEMOH (Tecplot files) and Capytaine (NetCDF).

Capytaine writes these text formats and reads them only through the separate package bemio; the two small formats are
read here. Results are about the hinge, or about a point that the files or options name and from which they are moved
(`moving`), with waves referred to a point below the centre of the float, x along the paper's x3 and z up. Rigid modes
are numbered as usual (1 surge .. 4 roll, 5 pitch, 6 yaw): phi1 turns about the downward vertical, so it is minus yaw,
and phi3 is roll. What is read of each format, and what is refused: docs/import.md.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.database import load, save
from gyroctl.hydrodynamics.nemoh import read_nemoh
from gyroctl.hydrodynamics.panels import Hull
from gyroctl.hydrodynamics.radiation import fit_all
from gyroctl.hydrodynamics.site import Site
from gyroctl.hydrodynamics.table import Hydrodynamics
from gyroctl.hydrodynamics.undisturbed import completed
from gyroctl.hydrodynamics.wamit import read_wamit

__all__ = ["READERS", "Site", "import_results", "read_capytaine", "read_nemoh", "read_wamit"]


def read_capytaine(path: Path | str, site: Site | None = None) -> Hydrodynamics:
    """Read a NetCDF file of Capytaine, its degrees of freedom phi1 and phi3 or rigid modes; see `database.load`."""
    site = site or Site()
    if site.length is not None:
        problem = "is WAMIT's: Capytaine's results have units of their own"
        raise InputError("hydro.length", site.length, problem, "Leave it out")
    if site.phases is not None:
        problem = "does not matter: Capytaine's excitation is complex"
        raise InputError("hydro.phases", site.phases, problem, "Leave it out")
    return load(path, site)


#: Reader of each format; a new format is one more entry.
READERS: dict[str, Callable[[Path | str, Site | None], Hydrodynamics]] = {
    "capytaine": read_capytaine,
    "wamit": read_wamit,
    "nemoh": read_nemoh,
}


def check_out(out: Path | str) -> Path:
    """Return the path of a file to write, or refuse it before what goes into it is computed."""
    path = Path(out)
    if path.is_dir():
        raise InputError("out", str(out), "is a folder", "Give the name of a file, for example float.nc")
    if not path.resolve().parent.is_dir():
        raise InputError("out", str(out), "its folder does not exist", f"Make the folder {path.parent} first")
    return path


def import_results(
    path: Path | str, format: str, out: Path | str, site: Site | None = None, hull: Hull | None = None
) -> Path:
    """Read results of another solver, fit the radiation and write a database.

    Parameters
    ----------
    path : Path or str
        The results.
    format : str
        "capytaine", "wamit" or "nemoh".
    out : Path or str
        NetCDF file to write.
    site : Site, optional
        What the format leaves out.
    hull : Hull, optional
        Surface of the float and its hinge, see `panels.read_hull`: what acts at the float's true position needs them.
        Froude-Krylov and diffraction are taken from the results where they hold them apart, else from this surface.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        When the format is unknown, a file is missing or of another layout, or `out` is no place for a file.
    """
    if format not in READERS:
        raise InputError("hydro.format", format, f"is not one of {', '.join(READERS)}", "Choose one of these")
    check_out(out)
    hydro = completed(READERS[format](path, site), hull)
    return save(replace(hydro, fits=fit_all(hydro)), out)
