"""The terms beyond the linear model that a device's choices switch on."""

from __future__ import annotations

from typing import Any

from gyroctl.froude import growth
from gyroctl.plant.beyond import SLOW, STILL, Beyond, Cap, Curve, Drag, Losses, Position
from gyroctl.plant.friction import CHANGE, CHANGING, CREEP, SIDE, SOFT, Friction
from gyroctl.plant.parameters import Parameters
from gyroctl.plant.reduced import reduced


def terms(p: Parameters, geometry: Any) -> Beyond | None:
    """Terms of the device, None where it is linear.

    Parameters
    ----------
    p : Parameters
        The choices.
    geometry : Float or None
        Reach of the lever [m] and density of the water [kg/m^3].

    Raises
    ------
    InputError
        For a choice that is not there yet.
    """
    moving = p.position == "moving"
    polynomials = reduced(geometry.choice(p.wetted).reduced, moving) if p.wetted == "reduced" else None
    surface = geometry.choice(p.wetted) if p.wetted == "surface" else None
    drag = None
    if p.drag > 0.0:
        factor = 0.5 * geometry.rho * p.drag * geometry.reach
        still = STILL * growth("m^2/s^2", p.length_scale)
        drag = Drag(factor * p.drag_area[0], factor * p.drag_area[1], float(geometry.reach), still)
    losses = None
    if p.bearing > 0.0 or p.windage > 0.0 or p.rolling_resistance > 0.0:
        slow, soft = SLOW * growth("rad/s", p.length_scale), SOFT * growth("N^2 m^2", p.length_scale)
        losses = Losses(float(p.bearing), float(p.windage), p.rolling_resistance / p.r2, slow, soft)
    found = Beyond(
        position=Position() if moving else None,
        drag=drag,
        curve=Curve(float(p.coupling_slip)) if p.coupling_slip > 0.0 else None,
        cap=Cap(float(p.coupling_cap)) if p.coupling_cap > 0.0 else None,
        losses=losses,
        reduced=polynomials,
        surface=None if surface is None else 1.0,
        contact=friction(p) if p.contact == "friction" else None,
    )
    return None if all(term is None for term in found) else found


def friction(p: Parameters) -> Friction:
    """Friction of the contact, its widths in the units of the device: what is smooth at one size is so at any other."""
    moment, rate = growth("Nm", p.length_scale), growth("rad/s", p.length_scale)
    widths = SIDE * moment, CREEP * rate, SOFT * moment * moment, CHANGING * moment, CHANGE * rate
    return Friction(p.traction / p.N, p.N, 1.0 / p.lever_inertia, *widths)
