"""What a margin report is asked for, checked before anything is computed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from gyroctl.devices.identity import device_record
from gyroctl.errors import InputError
from gyroctl.froude import growth
from gyroctl.harness.for_device import InModelScale
from gyroctl.harness.protocol import Law
from gyroctl.harness.registry import build, describe
from gyroctl.linearisation import PeriodicOrbit, lock_orbit
from gyroctl.plant import Plant
from gyroctl.plant.kernel import slip_rate
from gyroctl.simulation.ensemble import UNSTABLE
from gyroctl.waves import Regular
from gyroctl.waves.checks import HEIGHT_MAX, at_most, within
from gyroctl.waves.physical import check_wave

USUAL = {"height": (0.2, "m"), "wp": (3.14, "rad/s"), "cc": (0.052, "Nms"), "cg": (3.5e-4, "Nms")}
"""What may be asked for, with its unit: examples at the size of Table 1."""

CG_MAX = 10.0
"""Largest load of a device of the size of Table 1 or smaller; more is a slip of the unit. [Nms]"""


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
        towards = f", heading {self.wave.heading:g} deg" if self.wave.heading else ""
        return f"wave of {self.wave.height:.4g} m at {self.wave.wp:.4g} rad/s{towards}"

    def record(self) -> dict[str, Any]:
        """Numbers for JSON."""
        return {
            "device": self.plant.name,
            "device_record": device_record(self.plant),
            "wave": {
                "height_m": self.wave.height,
                "wp_rad_s": self.wave.wp,
                "heading_deg": self.wave.heading,
                "equal_energy_hs_m": self.wave.hs,
            },
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
    heading: float = 0.0,
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
    heading : float
        Direction the wave travels to. [deg]

    Returns
    -------
    Request
        Checked.

    Raises
    ------
    InputError
        Fields ``height``, ``wp``, ``cc``, ``cg``, ``sense`` or those of the law.
    """
    length = plant.parameters.length_scale
    give = {
        name: f"Give it in {unit}, for example {own * growth(unit, length):.3g}" for name, (own, unit) in USUAL.items()
    }
    for name, value in (("height", height), ("wp", wp)):
        if not (math.isfinite(value) and value > 0.0):
            raise InputError(name, value, "must be a positive number", give[name])
    at_most("height", height, HEIGHT_MAX, "m")
    low, high = plant.excitation.omega[[0, -1]]
    if not low <= wp <= high:
        mend = f"Give a frequency from {low:g} to {high:g} rad/s"
        raise InputError("wp", wp, "the excitation is not known at this frequency", mend)
    for name, value in (("cc", cc), ("cg", cg)):
        if not (math.isfinite(value) and value >= 0.0):
            raise InputError(name, value, "must be a finite number, zero or more", give[name])
    if cc == 0.0 and plant.parameters.connection == "magnetic":
        raise InputError("cc", cc, "without coupling nothing turns the flywheel", give["cc"])
    if cg == 0.0:
        raise InputError("cg", cg, "without load there is no power and no headroom", give["cg"])
    if sense not in (1, -1):
        raise InputError("sense", sense, "must be 1 or -1", "Choose the sense of rotation of the ring")
    wave = Regular(height, wp, heading)
    check_wave(plant, wave)
    check_stiffness(plant, cc)
    within("cg", cg, 0.0, CG_MAX * growth("Nms", max(length, 1.0)), give["cg"])
    built = _law(law_name, parameters or {}, wp, cc, cg, plant if own_device else None) if law_name else None
    return Request(plant, wave, cc, cg, sense, law_name, built)


def check_stiffness(plant: Plant, cc: float) -> None:
    """Refuse a coupling whose slip is too fast for the step of the orbits."""
    rate, step = float(slip_rate(plant.coefficients, cc)), plant.step
    if step * rate > UNSTABLE:
        problem = f"the slip decays at {rate:.3g}/s, too fast for steps of {step:.3g} s"
        raise InputError("cc", cc, problem, f"Give at most {cc * UNSTABLE / (step * rate):.3g} Nms")


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
    """Build the law; a constant law takes the pair, and a law that is told the peak frequency that of the wave.

    A law in the units of its model is told them in those.
    """
    built = build(name, parameters, device=device)
    time, torque = (built.time, built.torque) if isinstance(built, InModelScale) else (1.0, 1.0)
    own = describe(built.law if isinstance(built, InModelScale) else built)
    wanted = {"wp": wp * time, **({"cc": cc / torque, "cg": cg / torque} if built.information == "none" else {})}
    changes = {key: value for key, value in wanted.items() if key in own and key not in parameters}
    return build(name, {**parameters, **changes}, device=device)
