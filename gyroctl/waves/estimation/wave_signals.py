"""What a design model beyond the linear one needs of the waves, from what an estimator knows of them.

Drag asks for the water's velocity, a moving position for the moments elsewhere, a wetted surface for the Froude-Krylov
moments. A law sees none of them. All are linear in the same elevation as the two moments at rest, so the best guess
from these and their rates is one matrix: the least-squares solution over the spectrum of the sea,

    minimise over R the integral of |T - R (He1, i w He1, He3, i w He3)|^2 S dw,

with T the transfers of `gyroctl.waves.channels`. In a narrow band it is exact. The moments at rest stay the state: what
the float feels at its place is the model's, and what is forecast are the moments at rest.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.hydrodynamics.dispersion import wavenumber
from gyroctl.plant.beyond import base_rows, cubic_rows, signal_rows
from gyroctl.plant.compiled import inlined
from gyroctl.plant.equations import PHI1
from gyroctl.plant.near import ANGLES, standing
from gyroctl.plant.plant import Plant
from gyroctl.plant.trigonometry import cos_sin
from gyroctl.waves.channels import transfers
from gyroctl.waves.spectrum import SeaState

Array = NDArray[np.float64]

KNOWN = 4
"""Me1, Me1', Me3, Me3': what is known of the waves at an instant."""

OF_MOMENT1 = ("Me1", "F1", "u")
"""Beginnings of the names of the signals that are guessed from Me1; all others are guessed from Me3."""


OFTEN = 2
"""Node of the position, 0.2 m from rest, at which the guess of the moments is judged."""


def band(sea: SeaState) -> Array:
    """Frequencies over which the guess is made. [rad/s]"""
    return np.asarray(sea.wp * np.linspace(0.4, 4.4, 600))


def regression(plant: Plant, sea: SeaState) -> Array:
    """Signals of `plant.channels` from what is known, (channels, 4).

    Parameters
    ----------
    plant : Plant
        The design model.
    sea : SeaState
        Weighs the frequencies and gives the heading.

    Returns
    -------
    (channels, 4) array
        For Me1 [Nm], Me1' [Nm/s], Me3, Me3'.
    """
    omega = band(sea)
    wanted, given = transfers(plant, omega, sea.heading), known_of(plant, omega, sea.heading)
    weight = np.sqrt(sea.spectrum(omega))
    found = np.zeros((len(wanted), KNOWN))
    for row, name in enumerate(plant.channels):
        first = 2 * (not name.startswith(OF_MOMENT1))
        known = weight * given[first : first + 2] / np.array([[1.0], [sea.wp]])
        left = np.hstack([known.real, known.imag])  # real coefficients: both parts at once
        right = weight * wanted[row]
        found[row, first : first + 2] = np.linalg.lstsq(left.T, np.hstack([right.real, right.imag]), rcond=None)[0]
    found[:, 1::2] /= sea.wp
    return found


def known_of(plant: Plant, omega: Array, heading: float) -> NDArray[np.complex128]:
    """Me1, Me1', Me3, Me3' per metre of a wave of each frequency, (4, n)."""
    one, three = plant.excitation(omega, heading)
    return np.stack([one, 1j * omega * one, three, 1j * omega * three])


def signal_table(plant: Plant, sea: SeaState) -> Array:
    """Signals as the equations see them, by the float's place, (places, signal_rows, 4); see `regression`.

    Where the position is at rest there is one place.
    """
    beyond = plant.coefficients.beyond
    matrix = regression(plant, sea)
    x = np.zeros(len(plant.labels))
    table = []
    for angle in ANGLES if position_of(beyond) is not None else (0.0,):
        x[PHI1] = angle
        table.append(np.stack([plant.near(x, column) for column in matrix.T], axis=1))
    return np.ascontiguousarray(table)


def unexplained(plant: Plant, sea: SeaState) -> float:
    """Moment on the float that the guess of the signals misses: standard deviation, both moments together. [Nm]

    The rest of `regression` over the spectrum of the sea: of the moments where the float often is, of the Froude-Krylov
    moments, and of the water's velocity times the slope of the drag. Zero for a design model without them.
    """
    beyond = plant.coefficients.beyond
    if beyond is None or len(plant.channels) == 2:
        return 0.0
    omega = band(sea)
    wanted, known = transfers(plant, omega, sea.heading), known_of(plant, omega, sea.heading)
    weight = sea.spectrum(omega) * (omega[1] - omega[0])
    rest = np.sum(np.abs(wanted - regression(plant, sea) @ known) ** 2 * weight, axis=1)  # variances
    of = dict(zip(plant.channels, rest, strict=True))
    total = 0.0
    if beyond.position is not None:
        total += of[f"Me1@{OFTEN}"] + of[f"Me3@{OFTEN}"]
    if beyond.reduced is not None:
        total += sum(of.get(name, of.get(f"{name}^0", 0.0)) for name in ("F1", "F3"))
    if beyond.drag is not None:
        of_water = np.sum(np.abs(wanted[list(plant.channels).index("w")]) ** 2 * weight)
        total += of_water * (beyond.drag.factor1**2 * of["u"] + beyond.drag.factor3**2 * of["w"])
    return float(np.sqrt(total))


@inlined
def put_signals(more: Any, table: Any, phi1: float, m1: float, r1: float, m3: float, r3: float, out: Any) -> None:
    """Write the signals next to a float at `phi1` [rad] for known moments [Nm] and rates [Nm/s] into `out`."""
    if more is not None:
        at, sense, place, base = 0, 1.0, 0.0, base_rows(more)
        if more.position is not None:
            at, sense, place = standing(phi1)
        for i in range(signal_rows(more)):
            row = table[at, i]
            out[i] = row[0] * m1 + row[1] * r1 + (row[2] * m3 + row[3] * r3)
        if more.position is not None:
            for i in range(base + 1, base + cubic_rows(more), 2):  # odd powers of the angle from the place
                out[i] *= sense
            out[base + cubic_rows(more)] = place


def phase_along(plant: Plant, sea: SeaState) -> float:
    """Phase that waves of the peak frequency lose along the reach of the lever. [rad]"""
    if position_of(plant.coefficients.beyond) is None or plant.geometry is None:
        return 0.0
    along = plant.geometry.reach * np.cos(np.deg2rad(sea.heading))
    return float(wavenumber(np.array([sea.wp]), plant.depth, plant.geometry.g)[0] * along)


def seen_from(plant: Plant) -> Plant:
    """The smooth device as its float feels it: the moments at its own place are those that are estimated."""
    smooth = plant.rolling.smooth
    moves = position_of(smooth.coefficients.beyond) is not None
    return smooth.replace(position="rest") if moves else smooth


@inlined
def position_of(more: Any) -> Any:
    """Term of a moving position, None where there is none."""
    if more is None:
        return None
    return more.position


@inlined
def at_rest(position: Any, turning: float, wp: float, phi1: float, moved: Any) -> None:
    """Take corrections of Me1, Me1', Me3, Me3' [Nm, Nm/s] from where the float is to where it rests, in place.

    What the sensors tell is of the waves at the float. There and at rest the moments swing alike, a phase apart; so a
    gain that was designed for a float at rest serves, turned by that phase. Left unturned it would drive the rates the
    wrong way on one side, and the estimator would run away at large angles.
    """
    if position is not None:
        _, along = cos_sin(phi1)
        c, s = cos_sin(turning * along)
        for j in range(0, 4, 2):
            here, rate = moved[j], moved[j + 1]
            moved[j], moved[j + 1] = c * here + s * rate / wp, c * rate - s * wp * here
