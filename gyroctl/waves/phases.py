"""Random phases from a seed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gyroctl.waves.checks import seed_number

WAVE_DOMAIN = 0x77617665
"""Spawn key ("wave" in ASCII) that keeps these numbers apart from any other use of the same seed, e.g. sensor noise."""


def random_phases(seed: int, count: int) -> NDArray[np.float64]:
    """Draw phases that are independent and uniform on [0, 2 pi).

    The bit generator is PCG64 seeded by ``SeedSequence(seed, spawn_key=(WAVE_DOMAIN,))``; the upper 53 bits of each
    output make one phase. NumPy promises these streams for ever, unlike those of ``Generator.random``, so a seed
    gives the same bits on every machine and with every release. More phases of one seed begin with the fewer.

    Parameters
    ----------
    seed : int
        Seed, 0 or above.
    count : int
        Number of phases.

    Returns
    -------
    ndarray, shape (count,)
        Phases. [rad]

    Raises
    ------
    InputError
        Field ``run.seeds``.
    """
    source = np.random.PCG64(np.random.SeedSequence(seed_number(seed), spawn_key=(WAVE_DOMAIN,)))
    bits = np.asarray(source.random_raw(count), dtype=np.uint64) >> np.uint64(11)
    return bits.astype(np.float64) * (2.0 * np.pi / 2.0**53)
