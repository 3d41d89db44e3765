"""A law for a device of one's own: with its numbers, and at another length in the units of its model.

Gear ratio, inertia of the flywheel and design model are those of the device. A law on a device of another length sees
the device's model at the size of Table 1, by Froude's law.

Filters, clocks and gains of a law are in the seconds and torques that it was tuned for. What a law measures is turned
into those of the model, angles as they are, rates by the square root of the length, and what it commands back into the
device's own: a device that is nothing but larger is then controlled as its model is, to rounding.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any, NamedTuple

from gyroctl.devices.identity import identity, is_shipped
from gyroctl.devices.scaling import scaled_plant
from gyroctl.devices.zhang import zhang2017
from gyroctl.errors import InputError
from gyroctl.froude import growth
from gyroctl.harness.protocol import Law
from gyroctl.plant import Parameters, Plant
from gyroctl.plant.compiled import begun, stepped
from gyroctl.plant.measurement import CHANNELS, Measurement
from gyroctl.plant.parameters import CHOICES

BLIND = ("none", "sensors")
"""Information of laws that see nothing but the device: waves are not turned into those of a model."""

PAIR = ("cc", "cg")
"""Parameters of a law that holds a pair. [Nms]"""


class InModelScale(NamedTuple):
    """A law in the units of a device's model; build it with `in_model_scale`. It compiles where the law within does."""

    law: Any  # in the units of the model
    first: Any  # its state before the first sample: () for a law that does not compile
    time: float  # unit of time of the device over that of the model [-]
    torque: float  # unit of cc and cg of the device over that of the model [-]
    period: float  # sampling period, in the device's own time [s]

    @property
    def information(self) -> Any:
        """What the law within looks at."""
        return self.law.information

    @property
    def motors(self) -> bool:
        """Whether the law within may use the generator as a motor."""
        return bool(getattr(self.law, "motors", False))

    @property
    def sensors(self) -> tuple[str, ...]:
        """Channels that the law within goes by: all of them where it does not say."""
        return tuple(getattr(self.law, "sensors", CHANNELS))

    def init(self) -> Any:
        """State of the law within before the first sample."""
        return begun(self.law, self.first)

    def step(self, t: float, y: Any, state: Any) -> tuple[tuple[float, float], Any]:
        """Let the law within see its model, and return what it commands in the units of the device."""
        time = self.time
        seen = Measurement(
            y.psi, y.psi_rate * time, y.omega_rate * time, y.phi1, y.phi3, y.phi1_rate * time, y.phi3_rate * time
        )
        (cc, cg), new = stepped(self.law, t / time, seen, state)
        return (cc * self.torque, cg * self.torque), new

    def counters(self, state: Any) -> dict[str, Any]:
        """What the law within counts."""
        counters = getattr(self.law, "counters", None)  # a law may have it or not
        return dict(counters(state)) if counters else {}


def in_model_scale(law: Law, length: float, name: str = "law", given: Collection[str] = ()) -> Law:
    """Return a law for a device that is `length` times as long as that of Table 1.

    A law that holds a pair, as ``constant``, keeps what of it is `given`, which is in the units of the device.

    Raises
    ------
    InputError
        For a law that is told the waves.
    """
    if length == 1.0:
        return law
    if law.information not in BLIND:
        problem = f"is told the waves ({law.information}), which are those of a device {length:g} times as long"
        mend = f"Study the device's model: gyroctl device scale FILE --length {1.0 / length:g}"
        raise InputError(f"laws.{name}.information", law.information, problem, mend)
    time = growth("s", length)
    if holds_a_pair(law):
        own = {key: getattr(law, key) * growth("Nms", length) for key in PAIR if key not in given}
        return law._replace(period=law.period * time, **own)  # type: ignore[attr-defined, no-any-return]
    first = law.init() if hasattr(law, "_fields") else ()
    return InModelScale(law, first, time, growth("Nms", length), float(law.period) * time)


def holds_a_pair(law: Law) -> bool:
    """Whether a law holds a pair, which is in the units of the device and not of its model."""
    return set(PAIR) <= set(getattr(law, "_fields", ())) and law.information == "none"


def numbers_of(law: Any, device: Plant) -> dict[str, Any]:
    """Parameters of a law that are numbers of its device, where it has them: gear ratio, flywheel, design model.

    They are those of the device's model at the size of Table 1, and the design model is that of the linear water, as
    that of the shipped laws is.
    """
    p, length = device.parameters, device.parameters.length_scale
    own: dict[str, Any] = {"N": p.N, "J4": p.J4 / growth("kg m^2", length)}
    found = {key: value for key, value in own.items() if _has(law, key)}
    if isinstance(getattr(law, "plant", None), Plant):
        found["plant"] = design_model(device)
    return found


def design_model(device: Plant) -> Plant:
    """The device in the linear water, at the size of Table 1: what laws are designed with."""
    usual = Parameters()
    linear = device.replace(**{name: getattr(usual, name) for name in CHOICES}, name=device.name)
    return (
        linear if device.parameters.length_scale == 1.0 else scaled_plant(linear, 1.0 / device.parameters.length_scale)
    )


def design_in(device: Plant, choice: str | Mapping[str, Any]) -> Plant:
    """Return the design model that a law asks for by a variant, or a table of choices, as that of the device.

    Raises
    ------
    InputError
        For an unknown variant or choice, or a device whose hydrodynamics cannot serve it.
    """
    table = {"variant": choice} if isinstance(choice, str) else dict(choice)
    asked = zhang2017(**table).parameters  # refuses what is unknown
    changes = {key: value for key, value in table.items() if key in Parameters.__dataclass_fields__}
    water = {name: getattr(asked, name) for name in CHOICES}
    return design_model(device).replace(**{**water, **changes})


def belongs(found: Mapping[str, Any], device: Plant) -> bool:
    """Whether a tuned set, by what it says of how it was found, was tuned on a device; old ones on the paper's."""
    told = found.get("device_sha256")
    return is_shipped(device) if told is None else bool(told == identity(device))


def _has(law: Any, name: str) -> bool:
    """Whether a parameter of a law, or of a group of its parameters, bears a name."""
    fields = getattr(law, "_fields", None) or tuple(getattr(law, "__dataclass_fields__", ()))
    groups = (getattr(law, key) for key in fields if key not in ("law", "first"))
    return name in fields or any(name in getattr(group, "_fields", ()) for group in groups)
