"""A rebuilt table with the bits of the one before it.

Threads add in another order from run to run, so that a rebuild agrees to rounding, not to the bit. Waves are hashed
with the bits of the excitation: what was stored with the former table stays comparable only where they stay.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.table import Hydrodynamics

ROUNDING = 1e-9
"""Largest difference that counts as rounding, over the largest value of the table."""

TABLES = ("omega", "headings", "added_mass", "damping", "added_mass_inf", "excitation")


def with_bits_of(former: Hydrodynamics, rebuilt: Hydrodynamics) -> Hydrodynamics:
    """Return the rebuilt table with the tables and fits of the former one.

    Parameters
    ----------
    former, rebuilt : Hydrodynamics
        Two results of the same calculation.

    Returns
    -------
    Hydrodynamics

    Raises
    ------
    InputError
        Field ``hydro.keep``: where they differ by more than rounding.
    """
    for name in TABLES:
        old, new = getattr(former, name), getattr(rebuilt, name)
        if old.shape != new.shape or float(np.max(np.abs(old - new))) > ROUNDING * float(np.max(np.abs(old))):
            problem = f"has another {name} than the rebuilt table"
            raise InputError("hydro.keep", name, problem, "Build without it: the results have changed")
    return replace(rebuilt, **{name: getattr(former, name) for name in (*TABLES, "fits", "coupling")})
