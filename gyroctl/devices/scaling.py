"""A device at another size, by Froude's law: what ran at one length runs at the other, in its own units of time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any

from gyroctl.devices.entries import unit_of
from gyroctl.errors import InputError
from gyroctl.froude import growth
from gyroctl.hydrodynamics.excitation import ExcitationTable
from gyroctl.hydrodynamics.floating import Floating
from gyroctl.hydrodynamics.scaling import scaled_fit, scaled_fraction, scaled_hull
from gyroctl.plant import Parameters, Plant, Radiation
from gyroctl.plant.parameters import LARGEST
from gyroctl.reading import is_finite

LENGTHS = (1e-2, 1e2)
"""Least and largest factor on the length of a device."""


def scaled_parameters(parameters: Parameters, length: float) -> Parameters:
    """Parameters of the device with all lengths multiplied: each by the power of its unit.

    Parameters
    ----------
    parameters : Parameters
        The device.
    length : float
        Factor on all lengths. [-]

    Returns
    -------
    parameters : Parameters
        Where a number stands for what does not move, 1e15, it stays that.

    Raises
    ------
    InputError
        Field ``length``: no factor from 0.01 to 100, or one that leads out of what a device may be.
    """
    factor = check_length(length)
    return replace(parameters, **grown({f.name: getattr(parameters, f.name) for f in fields(parameters)}, factor))


def grown(values: Mapping[str, Any], length: float) -> dict[str, Any]:
    """Parameters by name with all lengths multiplied by `length`, each by the power of its unit."""
    found: dict[str, Any] = {}
    for name, value in values.items():
        unit = unit_of(name)
        by = 1.0 if isinstance(value, str | bool) else growth(unit, length)
        if by == 1.0:
            found[name] = value
        else:
            found[name] = tuple(v * by for v in value) if isinstance(value, tuple) else min(value * by, LARGEST)
    return found


def scaled_radiation(radiation: Radiation, length: float) -> Radiation:
    """Radiation function of the device with all lengths multiplied by `length`."""
    import numpy as np

    p, q = scaled_fraction(np.array(radiation.p), np.array(radiation.q), check_length(length))
    return Radiation(tuple(p), tuple(q))


def scaled_plant(plant: Plant, length: float) -> Plant:
    """Return the device with all lengths multiplied by `length`, the depth of its water included.

    Raises
    ------
    InputError
        Field ``length``, see `scaled_parameters`; ``plant.excitation`` for one that is no table.
    """
    factor = check_length(length)
    if not isinstance(plant.excitation, ExcitationTable):
        problem, mend = "is no table that could be scaled", "Build the device with a hydrodynamic database"
        raise InputError("plant.excitation", type(plant.excitation).__name__, problem, mend)
    one, three = (scaled_radiation(r, factor) for r in plant.radiation)
    geometry = plant.geometry
    if isinstance(geometry, Floating):
        undisturbed = None if geometry.undisturbed is None else _scaled_table(geometry.undisturbed, factor)
        hull, fit = scaled_hull(geometry.hull, factor), scaled_fit(geometry.reduced, factor)
        geometry = replace(geometry, hull=hull, undisturbed=undisturbed, reduced=fit)
    name = f"{plant.name}, {factor:g} times as long"
    excitation = _scaled_table(plant.excitation, factor)
    parameters = scaled_parameters(plant.parameters, factor)
    return Plant(parameters, (one, three), excitation, name, plant.depth * factor, geometry=geometry)


def at_model_size(plant: Plant) -> Plant:
    """Return the model of a device at the size of Table 1.

    Raises
    ------
    InputError
        As `scaled_plant`.
    """
    length = plant.parameters.length_scale
    if length == 1.0:
        return plant
    model = scaled_plant(plant, 1.0 / length)
    return model.replace(length_scale=1.0, name=f"{plant.name}, its model")


def _scaled_table(table: ExcitationTable, length: float) -> ExcitationTable:
    values, omega = table.values * growth("Nm/m", length), table.omega * growth("rad/s", length)
    return replace(table, omega=omega, values=values)


def check_length(length: Any) -> float:
    """Return a factor on the length of a device, or refuse what is none."""
    low, high = LENGTHS
    if not is_finite(length) or not low <= length <= high:
        problem = f"must be a factor from {low:g} to {high:g}"
        raise InputError("length", length, problem, "Give how many times as long the device is to be, for example 20")
    return float(length)
