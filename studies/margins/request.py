"""What a margin report is asked for, checked before anything is computed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from gyroctl.devices.identity import device_record
from gyroctl.errors import InputError
from gyroctl.harness.protocol import Law
from gyroctl.harness.registry import build, describe
from gyroctl.linearisation import PeriodicOrbit, lock_orbit
from gyroctl.plant import Plant
from gyroctl.plant.kernel import slip_rate
from gyroctl.simulation.ensemble import UNSTABLE
from gyroctl.waves import Regular
from gyroctl.waves.checks import HEIGHT_MAX, at_most, within
from gyroctl.waves.physical import check_wave

STEP = 0.01
"""Longest step of the orbits and of the loop. [s]"""


@dataclass(frozen=True)
class Request:
    """A device, a wave, constant controls and perhaps a law.

    Parameters
    ----------
    plant : Plant
        The device.
    wave : Regular
        The regular wave; that of equal energy to a sea has height Hs/sqrt 2.
    cc, cg : float
        Constant controls, and where a law starts. [Nms]
    sense : {1, -1}
        Sense of rotation of the ring.
    law_name : str
        Empty for the constant controls alone.
    law : Law, optional
        The law.
    """

    plant: Plant
    wave: Regular
    cc: float
    cg: float
    sense: int = 1
    law_name: str = ""
    law: Law | None = None

    @property
    def controls(self) -> str:
        """The pair, in words."""
        return f"cc = {self.cc:g}, cg = {self.cg:g} Nms"

    @property
    def sea(self) -> str:
        """The wave, in words."""
        return f"wave of {self.wave.height:g} m at {self.wave.wp:g} rad/s"

    def record(self) -> dict[str, Any]:
        """Numbers for JSON."""
        return {
            "device": self.plant.name,
            "device_record": device_record(self.plant),
            "wave": {"height_m": self.wave.height, "wp_rad_s": self.wave.wp, "equal_energy_hs_m": self.wave.hs},
            "controls": {"cc_nms": self.cc, "cg_nms": self.cg},
            "sense": self.sense,
            "law": {"name": self.law_name, **describe(self.law)} if self.law is not None else None,
        }


def request(
    plant: Plant,
    height: float,
    wp: float,
    cc: float,
    cg: float,
    sense: int = 1,
    law_name: str = "",
    parameters: Mapping[str, Any] | None = None,
    own_device: bool = False,
) -> Request:
    """Check and gather what a report is asked for; for an `own_device` the law takes its numbers.

    Parameters
    ----------
    plant : Plant
        The device.
    height : float
        Height of the regular wave. [m]
    wp : float
        Its frequency. [rad/s]
    cc, cg : float
        Constant controls, from which a law starts. [Nms]
    sense : {1, -1}
        Sense of rotation of the ring.
    law_name : str
        Registered name or ``file.py:Name``; none without it.
    parameters : mapping, optional
        Of the law, in their units.
    own_device : bool
        Whether the law is built for this device.

    Returns
    -------
    Request
        Checked.

    Raises
    ------
    InputError
        Fields ``height``, ``wp``, ``cc``, ``cg``, ``sense`` or those of the law.
    """
    for name, value, unit, example in (("height", height, "m", 0.2), ("wp", wp, "rad/s", 3.14)):
        if not (math.isfinite(value) and value > 0.0):
            raise InputError(name, value, "must be a positive number", f"Give it in {unit}, for example {example}")
    at_most("height", height, HEIGHT_MAX, "m")
    low, high = plant.excitation.omega[[0, -1]]
    if not low <= wp <= high:
        mend = f"Give a frequency from {low:g} to {high:g} rad/s"
        raise InputError("wp", wp, "the excitation is not known at this frequency", mend)
    for name, value, example in (("cc", cc, 0.052), ("cg", cg, 3.5e-4)):
        if not (math.isfinite(value) and value >= 0.0):
            raise InputError(name, value, "must be a finite number, zero or more", f"Give it in Nms, e.g. {example:g}")
    if cc == 0.0 and plant.parameters.connection == "magnetic":
        raise InputError("cc", cc, "without coupling nothing turns the flywheel", "Give it in Nms, for example 0.052")
    if cg == 0.0:
        raise InputError("cg", cg, "without load there is no power and no headroom", "Give it in Nms, e.g. 3.5e-4")
    if sense not in (1, -1):
        raise InputError("sense", sense, "must be 1 or -1", "Choose the sense of rotation of the ring")
    wave = Regular(height, wp)
    check_wave(plant, wave)
    check_stiffness(plant, cc)
    within("cg", cg, 0.0, 10.0, "Give it in Nms, for example 3.5e-4")
    built = _law(law_name, parameters or {}, wp, cc, cg, plant if own_device else None) if law_name else None
    return Request(plant, wave, cc, cg, sense, law_name, built)


def check_stiffness(plant: Plant, cc: float) -> None:
    """Refuse a coupling whose slip is too fast for the step of the orbits."""
    rate = float(slip_rate(plant.coefficients, cc))
    if STEP * rate > UNSTABLE:
        problem = f"the slip decays at {rate:.3g}/s, too fast for steps of {STEP:g} s"
        raise InputError("cc", cc, problem, f"Give at most {cc * UNSTABLE / (STEP * rate):.3g} Nms")


def find_orbit(asked: Request) -> PeriodicOrbit:
    """Return the locked orbit of the constant controls.

    Parameters
    ----------
    asked : Request
        Device, wave and controls.

    Returns
    -------
    PeriodicOrbit
        Stable or not.

    Raises
    ------
    InputError
        Field ``height``, with the nearest height that has an orbit, where there is none.
    """
    orbit = lock_orbit(asked.plant, asked.wave, asked.cc, asked.cg, asked.sense)
    if orbit.status == "no orbit":
        problem = f"no locked orbit exists at this height with {asked.controls}, wp = {asked.wave.wp:g} rad/s"
        raise InputError("height", asked.wave.height, problem, orbit.advice.rstrip("."))
    return orbit


def _law(name: str, parameters: Mapping[str, Any], wp: float, cc: float, cg: float, device: Plant | None = None) -> Law:
    """Build the law; a constant law takes the pair, and a law that is told the peak frequency that of the wave."""
    built = build(name, parameters, device=device)
    own = describe(built)
    wanted = {"wp": wp, **({"cc": cc, "cg": cg} if built.information == "none" else {})}
    changes = {key: value for key, value in wanted.items() if key in own and key not in parameters}
    return build(name, {**parameters, **changes}, device=device)
