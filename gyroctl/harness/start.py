"""The start: on the locked orbit of the regular wave that is equivalent to the sea, or at rest in the irregular sea.

From rest only about one initial ring angle in eight locks by itself, even in regular waves: a law that is to start the
device has to turn it. The start is common to all laws: it is part of the realisation, not of the law.

The orbits of the default sea ship: to find one, the kernel is compiled for complex numbers too, which takes longer than
a run. They are known by all that they follow from; a change of any of it, or of the equations, has them searched again.
"""

from __future__ import annotations

import hashlib
import json
import math
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.devices.file import own_changes
from gyroctl.errors import InputError
from gyroctl.froude import growth
from gyroctl.nested import leaves
from gyroctl.orbits.search import search_orbit
from gyroctl.plant import Plant, equations
from gyroctl.plant.compiled import source_stamp
from gyroctl.plant.equations import PSI, PSI_RATE
from gyroctl.waves import Regular, Sea
from gyroctl.writing import write_json

STARTS = ("locked", "rest")
"""Where runs may begin."""

STREAM = 0x57A7  # separates the ring's angle at rest from the other random numbers of the same seed

REFERENCE = ((0.052, 3.5e-4), (0.104, 1.5e-4), (0.052, 1e-4), (0.104, 3e-5))
"""Controls on the starting orbit, in the order in which they are tried; at the size of Table 1. [Nms]"""


def locked_start(plant: Plant, sea: Sea) -> tuple[NDArray[np.float64], tuple[float, float]]:
    """State (n,) on the locked orbit of the equivalent regular wave (height Hs/sqrt 2) and the controls there.

    Where the spin axis may slip, the orbit is that of rolling. A wetted surface cannot be differentiated: its runs
    start where the reduced one locks.

    Raises
    ------
    InputError
        Where no such orbit exists for any of the reference controls.
    """
    if plant.slips:
        rolling, controls = locked_start(plant.rolling, sea)
        return np.append(rolling, plant.parameters.N * rolling[PSI_RATE]), controls
    plant = plant.smooth
    wave = equivalent(sea)
    about = plant.water, plant.parameters.length_scale, plant.excitation.sha256
    key = (plant.coefficients, *about, wave.height, wave.wp, wave.heading)
    if key not in _found:
        _found[key] = shipped().get(key_of(plant, wave)) or search(plant, wave)
    return _found[key]


def equivalent(sea: Sea) -> Regular:
    """Regular wave of the same energy, frequency and heading."""
    return Regular(height=sea.hs / math.sqrt(2.0), wp=sea.wp, heading=sea.heading)


def rest_start(plant: Plant, seed: int) -> NDArray[np.float64]:
    """State (n,) at rest; the ring stands where it came to rest, at an angle drawn from the seed of the waves."""
    state = np.zeros(len(plant.labels))
    rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, STREAM])))
    state[PSI] = rng.uniform(0.0, 2.0 * math.pi)
    return state


Start = tuple[NDArray[np.float64], tuple[float, float]]
"""State (n,) and controls [Nms]."""

_found: dict[tuple[object, ...], Start] = {}
"""Starts by plant and wave: every run of a comparison asks for the same one."""

SHIPPED = Path(__file__).parents[1] / "data" / "starts.json"


def key_of(plant: Plant, wave: Regular) -> str:
    """SHA-256 of all that a start follows from; of a plant beyond the linear model none ships, and it has no key."""
    if plant.coefficients.beyond is not None:
        return ""
    numbers = [None if leaf is None else float(leaf).hex() for leaf in leaves(plant.coefficients)]
    about = [
        *plant.water,
        plant.excitation.sha256,
        *(float(part).hex() for part in (wave.height, wave.wp, wave.heading)),
    ]
    content = json.dumps([source_stamp([equations.__file__]), numbers, about])
    return hashlib.sha256(content.encode()).hexdigest()


@lru_cache(maxsize=1)
def shipped() -> dict[str, Start]:
    """Starts that ship, by their keys."""
    stored = json.loads(SHIPPED.read_text(encoding="utf-8"))
    return {one["key"]: (np.array(one["state"]), (one["cc_nms"], one["cg_nms"])) for one in stored}


def ship(cases: dict[str, tuple[Plant, Sea]], file: Path = SHIPPED) -> None:
    """Search the starts of some plants in some seas, by their names, and write what ships."""
    written: list[dict[str, Any]] = []
    for name, (plant, sea) in cases.items():
        wave = equivalent(sea)
        state, (cc, cg) = search(plant, wave)
        head = {"of": name, "height_m": wave.height, "wp_rad_s": wave.wp, "key": key_of(plant, wave)}
        written.append({**head, "cc_nms": cc, "cg_nms": cg, "state": state.tolist()})
    write_json(file, written)


def search(plant: Plant, wave: Regular) -> Start:
    """Find the orbit to start on; errors as of `locked_start`."""
    unstable = None
    unit = growth("Nms", plant.parameters.length_scale)
    for cc, cg in ((unit * cc, unit * cg) for cc, cg in REFERENCE):
        orbit = search_orbit(plant, wave, cc, cg)
        if orbit.status == "stable":
            return orbit.x, (cc, cg)
        # an orbit on which an oscillation grows slowly is still where a lock would begin; a saddle is not
        if orbit.status == "unstable" and abs(orbit.multipliers[0]) < 1.1 and unstable is None:
            unstable = orbit.x, (cc, cg)
    if unstable is not None:
        return unstable
    raise _no_start(plant, wave)


def _no_start(plant: Plant, wave: Regular) -> InputError:
    """Error that says what keeps the lock from beginning: the device where it was changed, else its sea."""
    hs, changes = wave.height * math.sqrt(2.0), own_changes(plant)
    sea = f"Hs {hs:.3g} m, {wave.wp:.3g} rad/s"
    mend = f"Raise Hs, or bring wp nearer to {3.14 / plant.parameters.time_scale:.3g} rad/s"
    beyond = plant.coefficients.beyond is not None
    if beyond:
        weaker = "Weaken drag, bearing, windage or rolling_resistance, raise coupling_cap or Hs"
        mend = f'{weaker}, or choose start = "rest"'
    if changes:
        problem = (
            f"no lock begins in this sea ({sea}): with these entries in place of those of Table 1, which stand in "
        )
        problem += "brackets, the device has no locked orbit in the equivalent regular wave"
        return InputError("plant", ", ".join(changes), problem, f"Correct these entries. If they are meant: {mend}")
    if beyond:
        problem = "has no locked orbit in the equivalent regular wave: its drag or losses are too strong or its "
        problem += f"coupling too weak for it, or the sea ({sea}) too small"
        return InputError("plant", plant.name, problem, mend)
    problem = "the equivalent regular wave is too small, or too far off the device's frequency, for a locked orbit"
    return InputError("sea.hs", hs, problem, mend)
