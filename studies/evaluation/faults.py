"""Faults and other devices in real water: lost and biased sensors, late samples, another water, seas of two kinds.

Everything stands on the realistic device with a coupling that lags by 20 ms. The laws stay as they are and plan with
that device; of a case they know nothing, but for a delay that a case says they are told. Every case is a row, no code.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from gyroctl.devices import zhang2017
from gyroctl.harness.run import Settings
from gyroctl.harness.sensing import Reads, Sensors
from gyroctl.plant.measurement import CHANNELS
from gyroctl.studies.evaluation.perturbed_devices import NOMINAL, Truth
from gyroctl.waves import Sea, TurningSea, TwoPeaks

LAG = 0.02
"""Time constant of the coupling where nothing else is said. [s]"""

LOST_FROM, LOST_FOR = 200.0, 20.0
"""When a sensor is lost, and for how long. [s]"""

READS: tuple[Reads, ...] = ("nothing", "last", "zero")
"""What a law reads of a lost sensor."""

BIAS: Mapping[str, float] = {
    "psi": 0.02,
    "psi_rate": 0.02,
    "omega_rate": 0.5,
    "phi1": 0.01,
    "phi3": 0.01,
    "phi1_rate": 0.01,
    "phi3_rate": 0.01,
}
"""Biases: half a degree of an inclinometer, half a degree per second of a gyro, a misplaced encoder. [rad, rad/s]"""

DEVICES: Mapping[str, Mapping[str, float]] = {
    "drag 0.3": {"drag": 0.3},
    "drag 0.8": {"drag": 0.8},
    "drag 1": {"drag": 1.0},
    "drag 1.2": {"drag": 1.2},
    "friction 0.3": {"traction": 0.3},
    "friction 0.4": {"traction": 0.4},
    "friction 0.45": {"traction": 0.45},
    "friction 0.8": {"traction": 0.8},
    "bearing 0": {"bearing": 0.0},
    "bearing 0.02 Nm": {"bearing": 0.02},
    "bearing 0.03 Nm": {"bearing": 0.03},
}
"""Devices in other water or with other losses."""

OFF = 0.2
"""By which part a constant of the device differs. [1]"""

LAGS = (0.01, 0.05, 0.1)
"""Other time constants of the coupling. [s]"""


def seas(gamma: float, duration: float) -> dict[str, Sea]:
    """Seas of two kinds; the heading turns over the whole run of `duration` [s]."""
    return {
        "swell below": TwoPeaks(gamma=gamma, wp_second=1.8, share=0.25),
        "wind sea above": TwoPeaks(gamma=gamma, wp_second=5.0, gamma_second=1.0, share=0.25),
        "heading turns by 20 deg": TurningSea(gamma=gamma, heading_end=20.0, over=duration),
    }


def faults(given: Settings, gamma: float, duration: float) -> tuple[Truth, ...]:
    """Every case, the nominal one first.

    Parameters
    ----------
    given : Settings
        Steps, sensors and actuators; the lag of the coupling is `LAG`.
    gamma : float
        Peak enhancement of the sea.
    duration : float
        Length of the runs. [s]
    """
    usual = acting(given, cc_lag=LAG)
    whole, late = usual.sensors, usual.actuators.delay + 1
    base = zhang2017("realistic").parameters
    devices: dict[str, dict[str, Any]] = {name: dict(changes) for name, changes in DEVICES.items()}
    for name in ("k1", "J14"):
        for sign in (-1, 1):
            words = f"{name} {'+' if sign > 0 else '-'}{100 * OFF:.0f} %"
            devices[words] = {name: (1.0 + sign * OFF) * getattr(base, name)}
    cases = [Truth(NOMINAL, zhang2017("realistic"), usual)]
    cases += [Truth(name, zhang2017("realistic", **changes), usual) for name, changes in devices.items()]

    def on(name: str, settings: Settings, told: Mapping[str, Any] | None = None) -> Truth:
        return Truth(name, zhang2017("realistic"), settings, None, told or {})

    cases += [on(f"lag {1e3 * lag:.0f} ms", acting(given, cc_lag=lag)) for lag in LAGS]
    for sign in (-1, 1):
        cases.append(on(f"biases {'+' if sign > 0 else '-'}", sensing(usual, biased(whole, sign))))
    once = {"lost_from": LOST_FROM, "lost_for": usual.actuators.period, "lost_reads": "last"}
    cases.append(on("one sample late once", sensing(usual, changed(whole, CHANNELS, **once))))
    cases.append(on("commands a sample late", acting(usual, delay=late)))
    cases.append(on("commands a sample late, told", acting(usual, delay=late), {"delay": late}))
    cases.append(on("sensors a sample late, told", sensing(usual, changed(whole, CHANNELS, delay=1)), {"delay": late}))
    for name in CHANNELS:
        for reads in READS:
            gone = {"lost_from": LOST_FROM, "lost_for": LOST_FOR, "lost_reads": reads}
            cases.append(on(f"{name} lost, reads {reads}", sensing(usual, changed(whole, (name,), **gone))))
    for name, sea in seas(gamma, duration).items():
        cases.append(Truth(name, zhang2017("realistic"), usual, sea))
    return tuple(cases)


def biased(sensors: Sensors, sign: float) -> Sensors:
    """Sensors with `BIAS` on every channel, beside what they have."""
    changes = {}
    for name, bias in BIAS.items():
        channel = getattr(sensors, name)
        changes[name] = replace(channel, bias=channel.bias + sign * bias)
    return replace(sensors, **changes)


def changed(sensors: Sensors, names: tuple[str, ...], **changes: Any) -> Sensors:
    """Sensors of which some are changed alike."""
    return replace(sensors, **{name: replace(getattr(sensors, name), **changes) for name in names})


def acting(settings: Settings, **changes: Any) -> Settings:
    """Return settings with other actuators."""
    return replace(settings, actuators=replace(settings.actuators, **changes))


def sensing(settings: Settings, sensors: Sensors) -> Settings:
    """Return settings with other sensors."""
    return replace(settings, sensors=sensors)
