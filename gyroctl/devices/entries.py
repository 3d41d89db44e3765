"""The entries of a device, each with its unit and meaning: what a device file says, and what Froude's law needs."""

from __future__ import annotations

from typing import NamedTuple


class Entry(NamedTuple):
    """An entry of a device file."""

    unit: str  # "-" for a pure number, "" for a choice
    words: str


GROUPS: dict[str, dict[str, Entry]] = {
    "Lengths": {
        "a": Entry("m", "lever from the hinge to the float"),
        "b": Entry("m", "and on to the ring, whose centre is a + b from the hinge"),
        "c": Entry("m", "height of the cylinder of the float, between two hemispheres"),
        "d": Entry("m", "diameter of the float"),
        "r1": Entry("m", "radius of the spin axis"),
        "r2": Entry("m", "radius of the ring, so that the gear ratio N is r2/r1"),
    },
    "Masses": {
        "m1": Entry("kg", "float and lever"),
        "m2": Entry("kg", "ring"),
        "m3": Entry("kg", "spin axis"),
        "m4": Entry("kg", "flywheel"),
    },
    "Moments of inertia": {
        "J11": Entry("kg m^2", "float and lever, about the centre of the float"),
        "J22": Entry("kg m^2", "ring, about the lever"),
        "J13": Entry("kg m^2", "spin axis, about itself"),
        "J14": Entry("kg m^2", "flywheel, about its axis"),
    },
    "Stiffness and damping of the hinge": {
        "k1": Entry("Nm/rad", "spring about the vertical axis"),
        "d1": Entry("Nms/rad", "damping about the vertical axis"),
        "d3": Entry("Nms/rad", "damping about the horizontal axis"),
    },
    "From the hydrodynamics where they are left out": {
        "k3": Entry("Nm/rad", "buoyancy stiffness about the horizontal axis"),
        "Jh1": Entry("kg m^2", "added inertia at infinite frequency, vertical axis"),
        "Jh3": Entry("kg m^2", "added inertia at infinite frequency, horizontal axis"),
    },
    "Form of the equations": {
        "generator_reaction": Entry("", "keep the generator's reaction on the float as the paper prints it"),
        "lever_gyroscopic": Entry("", "keep the moment of the momentum about the lever, which the paper leaves out"),
        "connection": Entry("", '"magnetic" or "rigid": flywheel on the coupling, or geared to the ring'),
    },
    "The float in the water": {
        "position": Entry("", '"rest" or "moving": where the moments of the waves act'),
        "wetted": Entry("", '"linear", "reduced" or "surface": pressure on the wetted surface'),
        "drag": Entry("-", "drag coefficient of the float, 0 for none"),
        "drag_area": Entry("m^2", "its areas for phi1 and phi3"),
        "drag_height": Entry("m", "height above the mean water level at which it takes the velocity of the water"),
    },
    "Contact, coupling, losses": {
        "contact": Entry("", '"rolling" or "friction": how the spin axis keeps to its track'),
        "traction": Entry("-", "coefficient of that friction"),
        "coupling_cap": Entry("Nm", "greatest torque of the coupling, 0 for none"),
        "coupling_slip": Entry("rad/s", "slip of an eddy-current coupling's greatest torque, 0 for none"),
        "bearing": Entry("Nm", "friction of the flywheel's bearing"),
        "windage": Entry("Nms^2", "drag of the air on the flywheel over the square of its speed"),
        "rolling_resistance": Entry("m", "lever arm of the rolling resistance of the spin axis"),
        "generator_efficiency": Entry("-", "electrical over mechanical energy"),
    },
    "Size": {
        "length_scale": Entry(
            "-", 'length over that of Table 1: steps, wave grids and laws go by it, see the page "A device of your own"'
        )
    },
}
"""All entries that are fields of `Parameters`, in the order of a device file."""

ENTRIES: dict[str, Entry] = {name: entry for group in GROUPS.values() for name, entry in group.items()}

WITH_LENGTH = "m"
"""Unit by which the length over that of Table 1 itself grows."""


def unit_of(name: str) -> str:
    """Unit by which a parameter grows with the length of a device; "-" where it does not."""
    if name == "length_scale":
        return WITH_LENGTH
    return ENTRIES[name].unit or "-"
