"""What the numbers of a device take for granted: depth, lever, size; and what of a device to doubt at once."""

from __future__ import annotations

import math
from typing import Any

from gyroctl.devices.identity import is_shipped, table_1
from gyroctl.plant import Plant
from gyroctl.studies.device.bodies import Finding, bodies

ALIKE = 0.02
"""Relative difference between the device's lever and that of its hydrodynamics that counts as none."""

SIZE = 1.5
"""Factor by which the lever may differ from that of the length that the file names."""


def doubts(plant: Plant) -> list[str]:
    """Findings that no device can be, in words; of the quick part of the check, and none of the paper's device."""
    findings = [] if is_shipped(plant) else [*bodies(plant), *assumed(plant)]
    return [f"{finding.name}: {finding.found}" for finding in findings if not finding.passed]


def assumed(plant: Plant) -> list[Finding]:
    """Compare depth, lever and size with those of the hydrodynamics."""
    p, geometry = plant.parameters, plant.geometry
    depth = f"{plant.depth:.4g} m" if math.isfinite(plant.depth) else "infinite"
    found = [Finding("depth of the water", f"{depth}, that of the hydrodynamics")]
    lever = p.a + p.b
    if geometry is not None:
        hull: Any = geometry.hull
        own = hull.reach / math.cos(math.radians(hull.inclination))
        alike = abs(own / lever - 1.0) <= ALIKE
        words = f"a + b = {lever:.4g} m; the hydrodynamics are those of a float {own:.4g} m from its hinge"
        mend = f"Make a + b {own:.4g} m, give hydrodynamics of this float (gyroctl hydro), or take those of the float "
        mend += f"and the water that are {lever / own:.4g} times as large: hydrodynamics_length times that"
        found.append(Finding("lever", f"{words}, {hull.inclination:g} deg below the horizontal", alike, mend))
    else:
        found.append(Finding("lever", f"a + b = {lever:.4g} m; the hydrodynamics hold no geometry to compare it with"))
    first = table_1(p.length_scale)
    ratio = lever / (first.a + first.b)
    words = f"length_scale = {p.length_scale:g}, of which Table 1 has a lever of {first.a + first.b:.4g} m"
    mend = f"Give length_scale = {p.length_scale * ratio:.3g}: steps, wave grids and laws go by it"
    found.append(Finding("size", words, 1.0 / SIZE <= ratio <= SIZE, mend))
    return found
