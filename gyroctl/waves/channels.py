"""What a plant asks of a realisation beside elevation and moments at rest, as transfers from the elevation.

Every signal is linear in the waves: a complex amplitude per metre for each component. So all of them come from the
same components as the moments, and are blended in like them.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.dispersion import wavenumber
from gyroctl.plant.beyond import HALF
from gyroctl.plant.reduced import POWERS, undisturbed_names
from gyroctl.waves.excitation import Wave, equivalent_amplitude
from gyroctl.waves.pressure import followed, half_range, powers_along

if TYPE_CHECKING:
    from gyroctl.plant import Plant
    from gyroctl.waves.components import Components


class Response(NamedTuple):
    """Signals of a plant in a sea, before the random phases."""

    components: NDArray[np.complex128]  # (channels, k), per metre of amplitude
    regular: NDArray[np.complex128]  # (channels,), of the equivalent regular wave


def response(plant: Plant, sea: Wave, waves: Components) -> Response:
    """Signals of `plant` in `sea` with its components."""
    regular = transfers(plant, np.array([sea.wp]), sea.heading)[:, 0] * equivalent_amplitude(sea)
    return Response(waves.in_direction(partial(transfers, plant), sea.heading), regular)


def transfers(plant: Plant, omega: NDArray[np.float64], heading: float) -> NDArray[np.complex128]:
    """Transfer from the elevation at the float's place at rest to each of `plant.channels`.

    Parameters
    ----------
    plant : Plant
        What is asked for.
    omega : (k,) array
        Frequencies. [rad/s]
    heading : float
        Direction the waves travel to. [deg]

    Returns
    -------
    (channels, k) complex array
        Time factor exp(+i w t). Moments [Nm/m], velocities [1/s].
    """
    he = plant.excitation(omega, heading)
    if len(plant.channels) == 2:
        return he
    assert plant.geometry is not None
    k = wavenumber(omega, plant.depth, plant.geometry.g)
    along = np.cos(np.deg2rad(heading))
    rows: dict[str, NDArray[np.complex128]] = {"Me1": he[0], "Me3": he[1]}
    if "u" in plant.channels:
        forward, upward = velocities(omega, k, plant.depth, plant.parameters.drag_height)
        rows |= {"u": along * forward, "w": upward}
    for moment in ("Me1", "Me3"):
        if f"{moment}@0" in plant.channels:
            spacing = plant.geometry.reach / HALF
            rows |= {
                f"{moment}@{i}": rows[moment] * np.exp(-1j * k * i * spacing * along) for i in range(-HALF, HALF + 1)
            }
    rows |= _undisturbed(plant, omega, k, heading)
    missing = [name for name in plant.channels if name not in rows]
    if missing:
        raise InputError("plant.channels", missing[0], "is no signal of the waves", "Leave the choice out")
    return np.stack([rows[name] for name in plant.channels])


def _undisturbed(
    plant: Plant, omega: NDArray[np.float64], k: NDArray[np.float64], heading: float
) -> dict[str, NDArray[np.complex128]]:
    """Froude-Krylov moments of the waves that a wetted surface follows, over powers of X/l where the float moves."""
    beyond = plant.coefficients.beyond
    if beyond is None or beyond.reduced is None or plant.geometry is None or plant.geometry.undisturbed is None:
        return {}
    moments = plant.geometry.undisturbed(omega, heading) * followed(k, half_range(plant.geometry.hull))
    powers = np.ones((1, len(k)), dtype=np.complex128)
    if beyond.reduced.moving is not None:
        powers = powers_along(k * plant.geometry.reach * np.cos(np.deg2rad(heading)), POWERS)
    found = (moments[:, None] * powers).reshape(-1, len(k))
    return dict(zip(undisturbed_names(beyond.reduced.moving), found, strict=True))


def velocities(
    omega: NDArray[np.float64], k: NDArray[np.float64], depth: float, height: float
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Velocity of the water over the amplitude, along the waves and upwards.

    Linear waves: w cosh k(z + h)/sinh kh, and i w sinh k(z + h)/sinh kh.

    Parameters
    ----------
    omega, k : (n,) arrays
        Frequencies [rad/s] and wavenumbers [rad/m].
    depth, height : float
        Depth of the water and height z above the mean level, not positive. [m]
    """
    fade = np.exp(k * height)
    if not np.isfinite(depth):
        return np.asarray(omega * fade, complex), np.asarray(1j * omega * fade, complex)
    below, whole = np.exp(-2.0 * k * (depth + max(height, -depth))), -np.expm1(-2.0 * k * depth)
    rate = omega * fade / whole
    return np.asarray(rate * (1.0 + below), complex), np.asarray(1j * rate * (1.0 - below), complex)
