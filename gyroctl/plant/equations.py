"""Equations of motion (22)-(25) with radiation (27)-(28): the one text.

The same lines serve NumPy arrays, complex numbers (complex-step derivatives), casadi symbols and, compiled, the
kernels. Everything else in the package that knows the dynamics calls this text.

A state is a column of `rows`. Many runs may stand side by side: entry `row` of run `l` out of `L` is at
``row * L + l`` of a flat buffer. With ``L = 1, l = 0`` that is plainly ``x[row]``.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from gyroctl.plant.beyond import coupling_torque, further, ledger_rows
from gyroctl.plant.compiled import inlined
from gyroctl.plant.friction import axis_momentum, axis_rows, axis_speed, contact_of, on_axis, put_axis, ring_rate
from gyroctl.plant.trigonometry import cos_sin

PHI1, PHI3, PSI, OMEGA, PHI1_RATE, PHI3_RATE, PSI_RATE, OMEGA_RATE, RADIATION = range(9)

LEDGER = ("wave_input", "radiated", "hinge", "slip", "generator")
"""Powers that `derivative` writes behind the state, in this order; those of `beyond.BEYOND` follow. [W]"""

INPUTS = ("wave_input", "second_order")
"""Powers of the ledger that the waves bring in; all others take."""


class Coefficients(NamedTuple):
    """Constants of the equations of motion, in the paper's symbols.

    `G..` is the inverse of the inertia of (psi, omega) alone; where the flywheel is rigidly geared to the ring it is
    the inverse on the constraint, so that one text serves both devices.
    """

    N: float  # gear ratio r2/r1 [-]
    K: float  # J3 + J4/2 [kg m^2]
    J3: float  # [kg m^2]
    J4: float  # [kg m^2]
    i1: float  # 1/(J1 + Jh1) [1/(kg m^2)]
    i3: float  # 1/(J1 + Jh3) [1/(kg m^2)]
    Gpp: float  # [1/(kg m^2)]
    Gpo: float  # [1/(kg m^2)]
    Goo: float  # [1/(kg m^2)]
    ap: float  # reaction of phi'' on psi'' [-]
    ao: float  # reaction of phi'' on omega'' [-]
    kappa: float  # rank-one part of the reduced inertia of (phi1, phi3) [kg m^2]
    k1: float  # [Nm/rad]
    k3: float  # [Nm/rad]
    d1: float  # [Nms/rad]
    d3: float  # [Nms/rad]
    C2: float  # inertia about the lever, 0 where the lever term is left out [kg m^2]
    reaction: float  # 1 where the generator reaction of (22)-(23) is kept as printed, else 0 [-]
    p1: tuple[float, ...]  # radiation numerator of phi1, highest power first
    q1: tuple[float, ...]  # radiation denominator of phi1 without its leading 1
    p3: tuple[float, ...]
    q3: tuple[float, ...]
    beyond: Any = None  # what acts beyond the linear model, see `gyroctl.plant.beyond.Beyond`


@inlined
def derivative(
    x: Any,
    dx: Any,
    L: int,
    l: int,
    k: Coefficients,
    cc: Any,
    cg: Any,
    me1: Any,
    me3: Any,
    more: Any = None,
    signals: Any = None,
    at: int = 0,
) -> None:
    """Write the rate of change of state `x` and the powers of the energy ledger into `dx`.

    Parameters
    ----------
    x : indexable, at least 8 + n1 + n3 rows
        State: phi1, phi3, psi, omega [rad], their rates [rad/s], radiation states; with friction in the contact the
        speed theta' of the spin axis [rad/s].
    dx : indexable, 5 rows more than the state, or 11 beyond the linear model
        Rates of the state, then the powers named by `LEDGER` and `BEYOND` [W].
    L, l : int
        Number of runs side by side and the run meant.
    k : Coefficients
        Constants of the device.
    cc, cg : scalar
        Magnetic coupling and generator gain. [Nms]
    me1, me3 : scalar
        Wave excitation moments at rest. [Nm]
    more : Beyond, optional
        The terms beyond the linear model, `k.beyond`; an argument of its own, so that they are compiled away.
    signals : indexable, optional
        All signals of the waves beyond the linear model, see `gyroctl.plant.beyond`; without them the water is still.
    at : int
        Where they begin.
    """
    phi1, phi3, psi, v1, v3, w, W = motion(x, L, l)
    c, s = cos_sin(psi)
    u1 = c * v1 - s * v3
    u3 = s * v1 + c * v3
    last = RADIATION + len(k.q1) + len(k.q3)
    axis = k.N * w
    if more is not None:
        axis = axis_speed(more.contact, axis, x, last * L + l)
    slip = W - axis
    mr1 = radiation(x, dx, L, l, RADIATION, k.p1, k.q1, v1)
    mr3 = radiation(x, dx, L, l, RADIATION + len(k.q1), k.p3, k.q3, v3)

    # generalised forces, everything but the accelerations
    K, J3, J4, N = k.K, k.J3, k.J4, k.N
    generator = cg * W
    coupling = cc * slip
    if more is not None:
        coupling = coupling_torque(more, cc, slip)
    hinge1, hinge3 = k.d1 * v1, k.d3 * v3
    reaction = k.reaction * generator
    lever = k.C2 * w
    Kw = K * w
    along = 2.0 * N * J3 * w  # momentum of the spin axis about itself
    if more is not None:
        along = axis_momentum(more.contact, along, J3, axis)
    spin = (along + J4 * W) * w
    # sin 2psi phi1' + cos 2psi phi3' = s u1 + c u3, and cos 2psi phi1' - sin 2psi phi3' = c u1 - s u3
    f1 = Kw * (s * u1 + c * u3) + s * spin + lever * v3 + c * reaction  # (22)
    f1 = f1 - k.k1 * phi1 - hinge1 - mr1 + me1
    f3 = Kw * (c * u1 - s * u3) + c * spin - lever * v1 - s * reaction  # (23)
    f3 = f3 - k.k3 * phi3 - hinge3 - mr3 + me3
    fp = N * coupling - (K * u1 + J4 * W) * u3  # (24)
    fo = J4 * u3 * w - coupling - generator  # (25)
    ledger, on_ring = last, 0.0
    if more is not None:
        fp, ledger = on_axis(more.contact, fp, coupling, J3, u3, w), last + axis_rows(more.contact)
        moved = phi1, phi3, psi, v1, v3, w, W, axis
        g, spent, on_ring = further(more, k, moved, u1, me1, me3, signals, at, L, l)
        f1, f3, fp, fo = f1 + g[0], f3 + g[1], fp + g[2], fo + g[3]
        write(dx, L, l, ledger + len(LEDGER), spent)

    # the inertia couples (phi1, phi3) to (psi, omega) along e = (c, -s) only: eliminate, then a rank-one update
    held = k.ap * fp + k.ao * fo
    g1, g3 = (f1 - c * held) * k.i1, (f3 + s * held) * k.i3
    e1, e3 = c * k.i1, s * k.i3
    share = k.kappa * (c * g1 - s * g3) / (1.0 + k.kappa * (c * e1 + s * e3))
    a1, a3 = g1 - e1 * share, g3 + e3 * share
    ae = c * a1 - s * a3
    aw = k.Gpp * fp + k.Gpo * fo - k.ap * ae
    aW = k.Gpo * fp + k.Goo * fo - k.ao * ae

    if more is not None:  # where the spin axis may slip, it was the axis that answered in the place of the ring
        put_axis(more.contact, dx, last * L + l, aw)
        aw = ring_rate(more.contact, aw, k, on_ring, u1, u3, W, axis)
    write(dx, L, l, PHI1, (v1, v3, w, W, a1, a3, aw, aW))
    radiated, hinge = mr1 * v1 + mr3 * v3, hinge1 * v1 + hinge3 * v3
    write(dx, L, l, ledger, (me1 * v1 + me3 * v3, radiated, hinge, coupling * slip, generator * W))


@inlined
def states_of(k: Coefficients) -> int:
    """Rows of the state."""
    return RADIATION + len(k.q1) + len(k.q3) + axis_rows(contact_of(k.beyond))


@inlined
def powers(k: Coefficients) -> int:
    """Rows of the energy ledger."""
    return len(LEDGER) + ledger_rows(k.beyond)


@inlined
def motion(x: Any, L: int, l: int) -> Any:
    """Return phi1, phi3, psi and the rates of phi1, phi3, psi, omega of a run; see `derivative`."""
    angles = x[PHI1 * L + l], x[PHI3 * L + l], x[PSI * L + l]
    rates = x[PHI1_RATE * L + l], x[PHI3_RATE * L + l], x[PSI_RATE * L + l], x[OMEGA_RATE * L + l]
    return angles + rates


@inlined
def write(dx: Any, L: int, l: int, first: int, values: Any) -> None:
    """Write `values` into the rows of a run from row `first` on; see `derivative`."""
    for i in range(len(values)):
        dx[(first + i) * L + l] = values[i]


@inlined
def radiation(x: Any, dx: Any, L: int, l: int, first: int, p: Any, q: Any, rate: Any) -> Any:
    """Return the moment Mr = P/Q phi' and write the rates of its states, from row `first` on, into `dx`. (27)-(28)

    In controllable canonical form every state is the rate of the one before.
    """
    moment, top = 0.0 * rate, rate
    n = len(q)
    for i in range(len(p)):
        moment = moment + p[len(p) - 1 - i] * x[(first + i) * L + l]
    for i in range(n):
        top = top - q[n - 1 - i] * x[(first + i) * L + l]
    for i in range(n - 1):
        dx[(first + i) * L + l] = x[(first + i + 1) * L + l]
    dx[(first + n - 1) * L + l] = top
    return moment
