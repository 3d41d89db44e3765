"""Swell and wind sea of a directional spectrum by its shape: each hill by watershed, steep ones are wind sea.

wavespectra finds the hills over frequency and direction (Tracy et al. 2007; watersheds of the smoothed spectrum, as
Portilla et al. 2009) and calls a hill wind sea where Hs over the wavelength at its energy period is 0.025 or more; the
sea of Pierson and Moskowitz has 0.035. Neither wind nor depth is asked for.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError


def part_of_hills(
    frequency: NDArray[np.float64], directions: NDArray[np.float64], density: NDArray[np.float64], partition: str
) -> NDArray[np.float64]:
    """Density of one part, zero where the other one is; the two add up to the whole.

    Parameters
    ----------
    frequency : ndarray (n,)
        Rising. [Hz]
    directions : ndarray (m,)
        Evenly spaced. [deg]
    density : ndarray (n, m)
        Over both. [m^2/Hz/deg]
    partition : str
        "swell" or "wind sea".

    Raises
    ------
    InputError
        Field ``sea.partition``: the spectrum has no such part.
    """
    import xarray as xr
    from wavespectra.partition.partition import Partition

    moving = frequency > 0.0  # what does not oscillate has no steepness
    axes = {"freq": frequency[moving], "dir": np.mod(directions, 360.0)}
    spectrum = xr.DataArray(density[moving], dims=("freq", "dir"), coords=axes).sortby("dir")
    parts = Partition(spectrum).steepness(swells=1, smooth=True).sel(dir=axes["dir"]).transpose("part", "freq", "dir")
    steep = np.zeros(density.shape, dtype=bool)
    steep[moving] = parts.values[0] > 0.0
    kept = np.where(steep == (partition == "wind sea"), density, 0.0)
    if not np.any(kept > 0.0):
        mend = f"Choose {'swell' if partition == 'wind sea' else 'wind sea'}, or leave it out"
        raise InputError("sea.partition", partition, "is not in this spectrum, by the steepness of its hills", mend)
    return np.asarray(kept, dtype=np.float64)
