"""A run as a labelled dataset: what it holds, in which units, and where it came from."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from gyroctl.plant import Plant
from gyroctl.plant.equations import OMEGA_RATE
from gyroctl.simulation.metrics import Record

if TYPE_CHECKING:
    import xarray

    from gyroctl.simulation.labelled import Trajectory

LONG_NAMES = {
    "phi1": ("rad", "float about the vertical axis"),
    "phi3": ("rad", "float about the horizontal axis"),
    "psi": ("rad", "ring angle"),
    "omega": ("rad", "flywheel angle relative to the ring"),
    "phi1_rate": ("rad/s", "rate of phi1"),
    "phi3_rate": ("rad/s", "rate of phi3"),
    "psi_rate": ("rad/s", "ring speed"),
    "omega_rate": ("rad/s", "flywheel speed"),
    "theta_rate": ("rad/s", "speed of the spin axis on its track"),
}


def trajectory(plant: Plant, record: Record, signals: dict[str, Any], attributes: dict[str, Any]) -> Trajectory:
    """Label a run.

    Parameters
    ----------
    plant : Plant
        The device.
    record : Record
        The run.
    signals : dict
        Wave signals at the samples: elevation [m], Me1, Me3 [Nm], each (n + 1,).
    attributes : dict
        Provenance: seed, hash, parameters; nested values are stored as JSON.

    Returns
    -------
    Trajectory
        An `xarray.Dataset` with a short repr and ``.plot(begin, end)``: dimension time [s]; a variable for each state,
        control, command, wave signal, energy of the ledger, and power.
    """
    from gyroctl.simulation.labelled import Trajectory

    samples = record.states.shape[0]
    time = np.arange(samples) * record.period
    last = [*range(samples - 1), samples - 2]  # the last sample shows what was asked for, and what acted, up to it
    controls = np.concatenate([record.controls, record.ends[-1:]])
    data: dict[str, Any] = {}
    for row, label in enumerate(plant.labels):
        unit, name = LONG_NAMES.get(label, ("1", f"radiation state {label}"))
        data[label] = ("time", record.states[:, row], {"units": unit, "long_name": name})
    for column, (label, name) in enumerate((("cc", "magnetic coupling"), ("cg", "generator gain"))):
        data[label] = ("time", controls[:, column], {"units": "Nms", "long_name": name})
        attrs = {"units": "Nms", "long_name": f"{name} asked for by the law"}
        data[f"{label}_command"] = ("time", record.commands[last, column], attrs)
    power = plant.parameters.generator_efficiency * controls[:, 1] * record.states[:, OMEGA_RATE] ** 2
    data["power"] = ("time", power, {"units": "W", "long_name": "electrical power"})
    for i, label in enumerate(plant.ledger):
        energy = record.states[:, len(plant.labels) + i]
        data[f"energy_{label}"] = ("time", energy, {"units": "J", "long_name": f"energy: {label.replace('_', ' ')}"})
    units = {
        "elevation": ("m", "water surface at the float"),
        "Me1": ("Nm", "wave moment on phi1"),
        "Me3": ("Nm", "wave moment on phi3"),
    }
    for label, values in signals.items():
        data[label] = ("time", values, {"units": units[label][0], "long_name": units[label][1]})
    plain = {
        key: value if isinstance(value, str | int | float) and not isinstance(value, bool) else json.dumps(value)
        for key, value in attributes.items()
    }
    return Trajectory(data, {"time": ("time", time, {"units": "s", "long_name": "time"})}, plain)


def record_of(plant: Plant, ds: xarray.Dataset) -> Record:
    """Return the record of a run that was labelled by `trajectory`, for its metrics.

    Parameters
    ----------
    plant : Plant
        The device of the run.
    ds : xarray.Dataset
        The labelled run.
    """
    names = [*plant.labels, *(f"energy_{label}" for label in plant.ledger)]
    states = np.stack([ds[name].values for name in names], axis=1)
    commands, controls = (
        np.stack([ds[f"{name}{asked}"].values[:-1] for name in ("cc", "cg")], axis=1) for asked in ("_command", "")
    )
    period = float(ds.time[1] - ds.time[0])
    return Record(states, commands, controls, period, int(ds.attrs.get("saturations", 0)))
