"""What the numbers of a run rest on: grip of the rolling contact, coupling, small angles, water line, k X.

The model takes all this for granted; the card says what the device would have to stand for the run to come true.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.dispersion import wavenumber
from gyroctl.hydrodynamics.geometry import Geometry, statics
from gyroctl.plant import Plant
from gyroctl.plant.equations import LEDGER, PHI1, PHI3, PSI, PSI_RATE
from gyroctl.simulation.metrics import MODEL_LIMIT, Record, production
from gyroctl.simulation.second_look import look
from gyroctl.waves import WaveRealisation

Floats = NDArray[np.float64]

UNITS = {
    "traction_p99": "1",
    "traction_p999": "1",
    "traction_over_03": "1",
    "traction_over_06": "1",
    "reversals": "1",
    "coupling_torque_max": "Nm",
    "slip_max": "rad/s",
    "coupling_loss_max": "W",
    "immersion_max": "m",
    "immersion_min": "m",
    "dry_share": "1",
    "submerged_share": "1",
    "kx_max": "1",
    "beyond_validity": "1",
}
"""Numbers of the card and their units."""

STEEL = 0.3
"""Coefficient of friction that a dry contact of steel has for sure. [-]"""

GRIP = 0.6
"""Coefficient of friction that a good pairing has. [-]"""


class Floating(NamedTuple):
    """The float at rest, as far as the card needs it."""

    arm: float  # horizontal distance of its centre from the hinge [m]
    draft: float  # of its lowest point, below the water level [m]
    height: float  # of the whole float [m]


def floating(plant: Plant) -> Floating:
    """How the float of the plant lies at rest: as in the geometry of its hydrodynamics, or inclined as in the paper."""
    p, geometry = plant.parameters, plant.geometry
    if geometry is not None:
        height = geometry.hull.vertices[:, 2]
        return Floating(geometry.reach, -float(height.min()), float(np.ptp(height)))
    moment = p.m1 * p.a + (p.m2 + p.m3 + p.m4) * (p.a + p.b)
    return _floating(Geometry(p.d, p.c, p.a + p.b, moment=moment, depth=plant.depth))


@lru_cache(maxsize=64)
def _floating(geometry: Geometry) -> Floating:
    """Float at rest; the draft is NaN where none carries it."""
    half = 0.5 * geometry.diameter + 0.5 * geometry.cylinder * float(abs(geometry.axis[2]))
    try:
        centre = statics(geometry).height
    except InputError:
        centre = float("nan")
    return Floating(geometry.reach, half - centre, 2.0 * half)


def validity(
    plant: Plant, record: Record, waves: WaveRealisation, score_from: float, from_rest: bool = False
) -> dict[str, float]:
    """Card of a run.

    Parameters
    ----------
    plant : Plant
        The device.
    record : Record
        The run.
    waves : WaveRealisation
        As it acted on the plant.
    score_from : float
        Start of the scoring. [s]
    from_rest : bool
        The run began at rest, where nothing presses the axis on its track: it counts only once lock has begun.

    Returns
    -------
    dict
        By the names of `UNITS`: quantiles over the time of the friction coefficient that rolling needs, and the shares
        of the time in which it is above 0.3 and 0.6; how often the spin axis would change to the other side of its
        track and roll backwards; largest torque, slip and loss of the coupling; how deep the lowest point of the float
        is below the water, at most and at least (negative: out of it); shares of the time out of the water and
        fully under; largest displacement in the wave, k X, with k at the peak; share of the time in which something
        of this, or an angle beyond 0.3 rad, is beyond what the model can say. NaN where a run is not finite.
    """
    n, first = len(plant.labels), round(score_from / record.period)
    if from_rest:
        net = record.states[:, n + LEDGER.index("generator")]
        locked = production(record.states[:, PSI], net, record.period, waves.sea.wp)
        first = int(np.argmax(locked)) if locked.any() else first
    states = record.states[first:, :n]
    time = (first + np.arange(states.shape[0])) * record.period
    if not np.all(np.isfinite(states)):
        return dict.fromkeys(UNITS, float("nan"))
    float_, k = floating(plant), float(wavenumber(np.array([waves.sea.wp]), plant.depth)[0])
    depth = float_.draft + np.interp(time, waves.time, waves.elevation) - float_.arm * states[:, PHI3]
    beyond = np.maximum(np.abs(states[:, PHI1]), np.abs(states[:, PHI3])) > MODEL_LIMIT
    dry, under = depth <= 0.0, depth >= float_.height
    signals = np.array([np.interp(time, waves.time, signal) for signal in waves.signals(plant)])
    held = waves.held(plant)
    if held is not None:
        signals = np.concatenate([signals, held.model.along(held.fields, time, states.T)])
    seen = look(plant, record, first, signals)
    backwards = seen.M3.ravel() >= 0.0  # start and end of each interval in turn
    if plant.slips:
        backwards = states[:, -1] * states[:, PSI_RATE] < 0.0
    slid = seen.over(GRIP)
    slides = np.append(slid > 0.0, False)
    return {
        "traction_p99": seen.quantile(0.99),
        "traction_p999": seen.quantile(0.999),
        "traction_over_03": float(seen.over(STEEL).mean()),
        "traction_over_06": float(slid.mean()),
        "reversals": float(np.count_nonzero(backwards[1:] & ~backwards[:-1])),
        "coupling_torque_max": seen.torque,
        "slip_max": seen.slip,
        "coupling_loss_max": seen.loss,
        "immersion_max": float(depth.max()),
        "immersion_min": float(depth.min()),
        "dry_share": float(np.mean(dry)),
        "submerged_share": float(np.mean(under)),
        "kx_max": k * float_.arm * float(np.abs(states[:, PHI1]).max()),
        "beyond_validity": float(np.mean(beyond | dry | under | slides)),
    }
