"""The plant: parameters, radiation and excitation in one immutable value with the dynamics as its methods."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyroctl.errors import InputError
from gyroctl.faces.device import plant_face
from gyroctl.faces.show import shown
from gyroctl.names import choice_of
from gyroctl.plant import equations
from gyroctl.plant.beyond import BEYOND, HALF, Beyond
from gyroctl.plant.differences import differences
from gyroctl.plant.equations import LEDGER, Coefficients
from gyroctl.plant.friction import contact_of
from gyroctl.plant.near import near_signals
from gyroctl.plant.parameters import Parameters
from gyroctl.plant.radiation import Radiation
from gyroctl.plant.reduced import undisturbed_names
from gyroctl.plant.symbolic import casadi_derivative
from gyroctl.plant.terms import terms

STEP = 0.01
"""Longest Runge-Kutta step of verdicts, for a device of the size of Table 1. [s]"""


class Excitation(Protocol):
    """Wave excitation moments per metre of amplitude."""

    @property
    def sha256(self) -> str:
        """Hash of the table."""

    @property
    def omega(self) -> NDArray[np.float64]:
        """Tabulated frequencies. [rad/s]"""

    def __call__(self, omega: ArrayLike, heading: float = 0.0) -> NDArray[np.complex128]:
        """Return He_1, He_3 (2, n) [Nm/m] at `omega` (n,) [rad/s] for `heading` [deg], time factor exp(+iwt)."""


class Float(Protocol):
    """Where the float is in the water, and in which water."""

    @property
    def reach(self) -> float:
        """Horizontal distance from the hinge to the centre of the float. [m]"""

    @property
    def rho(self) -> float:
        """Density of the water. [kg/m^3]"""

    @property
    def g(self) -> float:
        """Gravity. [m/s^2]"""

    @property
    def sha256(self) -> str:
        """Hash of all of it."""

    @property
    def hull(self) -> Any:
        """Surface of the float."""

    @property
    def reduced(self) -> Any:
        """Polynomials of the wetted surface, or None."""

    @property
    def undisturbed(self) -> Excitation | None:
        """Froude-Krylov moments, or None."""

    def choice(self, wetted: str) -> Float:
        """Return itself, or refuse a wetted surface that it cannot serve."""


@shown(plant_face)
@dataclass(frozen=True)
class Plant:
    """GyroPTO with its radiation and excitation.

    Parameters
    ----------
    parameters : Parameters
        Device and choices.
    radiation : pair of Radiation
        For phi1 and phi3.
    excitation : Excitation
        He_1 and He_3 over frequency and heading.
    name : str
        For reports. A plant made by `replace` is called by what was changed: "zhang2017 corrected, d1 = 3".
    depth : float
        Water depth, for the power that the waves carry; infinite where unknown. [m]
    origin : Plant, optional
        The plant that was changed into this one, for its name.
    geometry : Float, optional
        Needed where the float moves through the waves, has drag, or a wetted surface of its own. Lengths in [m].

    Raises
    ------
    InputError
        If the radiation is no pair of `Radiation`, or a choice needs the geometry and there is none.
    """

    parameters: Parameters
    radiation: tuple[Radiation, Radiation]
    excitation: Excitation
    name: str = "custom"
    depth: float = math.inf
    origin: Plant | None = dataclasses.field(default=None, repr=False, compare=False)
    geometry: Float | None = dataclasses.field(default=None, repr=False)

    def __post_init__(self) -> None:
        """Refuse what is no pair of radiation functions."""
        pair = self.radiation
        if not (isinstance(pair, tuple) and len(pair) == 2 and all(isinstance(r, Radiation) for r in pair)):
            mend = "Leave it out, choose accurate, paper or fine, or give two Radiation"
            raise InputError("plant.radiation", pair, "must be a pair of Radiation, for phi1 and phi3", mend)
        if self.parameters.in_the_waves and self.geometry is None:
            choices = {name: getattr(self.parameters, name) for name in ("position", "drag", "wetted")}
            name = next(n for n, v in choices.items() if v not in ("rest", 0.0, "linear"))
            mend = "Build the database with gyroctl hydro build, which stores it, or leave the choice out"
            raise InputError(f"plant.{name}", choices[name], "these hydrodynamics have no geometry of the float", mend)
        if self.geometry is not None:
            self.geometry.choice(self.parameters.wetted)
        if self.parameters.wetted != "linear" and getattr(self.excitation, "phase", "complex") != "complex":
            mend = 'Choose excitation_phase = "complex", or wetted = "linear"'
            problem = "needs the phases of the moments, which were dropped"
            raise InputError("plant.wetted", self.parameters.wetted, problem, mend)

    def __getstate__(self) -> dict[str, Any]:
        """Fields alone: the same plant has the same bytes, whatever has been asked of it before."""
        return {f.name: getattr(self, f.name) for f in dataclasses.fields(self)}

    def replace(self, **changes: Any) -> Plant:
        """Return a plant with some choices changed.

        Parameters
        ----------
        **changes
            Fields of `Plant` or of `Parameters`, e.g. ``d1=1.0`` or ``lever_gyroscopic=False``.

        Raises
        ------
        InputError
            For an unknown field, or a value that the field refuses.
        """
        own = {f.name for f in dataclasses.fields(self)}
        inner = {f.name for f in dataclasses.fields(self.parameters)}
        for name in changes:
            if name not in own | inner:
                mend = choice_of(name, sorted(own | inner))
                raise InputError(f"plant.{name}", changes[name], "unknown parameter", mend)
        parameters = changes.get("parameters", self.parameters)
        parameters = dataclasses.replace(parameters, **{n: v for n, v in changes.items() if n in inner})
        outer = {n: v for n, v in changes.items() if n in own}
        changed = dataclasses.replace(self, **{**outer, "parameters": parameters})
        if "name" in outer:  # a plant with a name of its own is what later changes count from
            return dataclasses.replace(changed, origin=None)
        origin = self.origin or self
        words = differences(changed, origin)
        if not words:
            return dataclasses.replace(changed, name=origin.name, origin=None)
        return dataclasses.replace(changed, name=", ".join([origin.name, *words]), origin=origin)

    @cached_property
    def coefficients(self) -> Coefficients:
        """Constants of the equations of motion."""
        return coefficients(self.parameters, self.radiation, self.geometry)

    @cached_property
    def channels(self) -> tuple[str, ...]:
        """Signals that the plant asks of a realisation, in their order.

        Me1, Me3: moments at rest [Nm]. With drag u, w: velocity of the water along x3 and upwards [m/s]. With a moving
        position Me1@-10 .. Me1@10, then those of Me3: moments at X = l i/10 along x3 [Nm]. With a reduced wetted
        surface F1, F3 between them: linear Froude-Krylov moments [Nm], with a moving position F1^0 .. F1^10 and those
        of F3, their coefficients over powers of X/l.
        """
        beyond = self.coefficients.beyond or Beyond()
        nodes = range(-HALF, HALF + 1) if beyond.position is not None else ()
        return (
            *("Me1", "Me3"),
            *(("u", "w") if beyond.drag is not None else ()),
            *(undisturbed_names(beyond.reduced.moving) if beyond.reduced is not None else ()),
            *(f"{moment}@{i}" for moment in ("Me1", "Me3") for i in nodes),
        )

    @cached_property
    def ledger(self) -> tuple[str, ...]:
        """Names of the powers in the energy ledger, in their order."""
        return LEDGER if self.coefficients.beyond is None else (*LEDGER, *BEYOND)

    @cached_property
    def water(self) -> tuple[str, ...]:
        """What tells this plant from one of the same coefficients and excitation: float and depth, where they act.

        Part of the key of whatever is kept; empty for a linear plant.
        """
        if self.coefficients.beyond is None or self.geometry is None:
            return ()
        return self.geometry.sha256, repr(self.depth)

    @cached_property
    def smooth(self) -> Plant:
        """The device as far as it can be differentiated: a contact that rolls, polynomials for a wetted surface.

        Where the float has no such polynomials its wetted surface is the linear one.
        """
        if self.parameters.wetted != "surface" or self.geometry is None:
            return self.rolling
        return self.rolling.replace(wetted="linear" if self.geometry.reduced is None else "reduced")

    @cached_property
    def labels(self) -> tuple[str, ...]:
        """Names of the states in their order."""
        chain = [f"z{j}_{i + 1}" for j, r in zip((1, 3), self.radiation, strict=True) for i in range(len(r.q))]
        mechanical = ("phi1", "phi3", "psi", "omega", "phi1_rate", "phi3_rate", "psi_rate", "omega_rate")
        return (*mechanical, *chain, *(("theta_rate",) if self.slips else ()))

    @property
    def step(self) -> float:
        """Longest Runge-Kutta step where none is asked for: 0.01 s at the size of Table 1. [s]"""
        return STEP * self.parameters.time_scale

    @property
    def slips(self) -> bool:
        """Whether the spin axis may slip on its track: its speed is then a state of its own."""
        return self.parameters.contact == "friction"

    @cached_property
    def rolling(self) -> Plant:
        """The same device with a contact that rolls: what laws are designed with and orbits are found on."""
        return self.replace(contact="rolling", name=self.name) if self.slips else self

    def derivative(self, x: ArrayLike, u: Any, moments: Any) -> NDArray[Any]:
        """Rate of change of the state, (22)-(25), (28).

        Parameters
        ----------
        x : array_like, (n,) or (n, batch)
            State in the order of `labels`; real or complex. [rad, rad/s]
        u : (cc, cg)
            Magnetic coupling and generator gain, scalars or (batch,). [Nms]
        moments : (Me1, Me3) or (len(channels),)
            Wave excitation moments, scalars or (batch,) [Nm]; beyond the linear model all signals in the order of
            `channels`, or the two alone for still water and a float at rest.

        Returns
        -------
        array of the shape of `x`
        """
        return self._evaluate(x, u, moments)[: len(self.labels)]

    def powers(self, x: ArrayLike, u: Any, moments: Any) -> dict[str, NDArray[Any]]:
        """Powers by the names of `ledger`: wave_input, radiated, hinge, slip, generator, and those beyond. [W]

        The state `x`, the controls `u` and the `moments` are those of `derivative`.
        """
        values = self._evaluate(x, u, moments)[len(self.labels) :]
        return dict(zip(self.ledger, values, strict=True))

    def power(self, x: ArrayLike, u: Any) -> Any:
        """Electrical power of state `x` under controls `u`, see `derivative`: efficiency times cg omega'^2. [W]

        The paper's text prints cg omega', its figures show the square.
        """
        return self.parameters.generator_efficiency * u[1] * np.asarray(x)[equations.OMEGA_RATE] ** 2

    def stored_energy(self, x: ArrayLike) -> Any:
        """Kinetic energy and the energy of the two springs of state `x` (n,) or (n, batch). [J]

        The energy in the radiation states is in the ledger's `radiated`.
        """
        return stored_energy(self.coefficients, np.asarray(x))

    def casadi(self) -> Any:
        """Return the casadi function (x, u, moments) -> derivative, built from the same text.

        Beyond the linear model `moments` are the signals that `near` returns.
        """
        return casadi_derivative(self.coefficients)

    def near(self, x: ArrayLike, moments: Any) -> NDArray[Any]:
        """Signals as the equations see them next to the float: polynomials in place of the moments at all nodes.

        Parameters
        ----------
        x, moments
            As in `derivative`.
        """
        return near_signals(self.coefficients.beyond, np.asarray(x), moments)

    def jacobians(self, x: ArrayLike, u: Any, moments: Any) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Exact Jacobians of `derivative` by complex step.

        Parameters
        ----------
        x, u, moments
            The point, as in `derivative`; one state, no batch.

        Returns
        -------
        A : (n, n) array
            With respect to the state.
        B : (n, 2 + len(moments)) array
            With respect to cc, cg and the moments as given.
        """
        point = np.array([*np.asarray(x, float), *u, *moments], complex)
        n, step = len(self.labels), 1e-30
        batch = np.repeat(point[:, None], point.size, axis=1)
        batch[np.diag_indices(point.size)] += 1j * step
        slope = self.derivative(batch[:n], batch[n : n + 2], batch[n + 2 :]).imag / step
        return slope[:, :n], slope[:, n:]

    def _evaluate(self, x: ArrayLike, u: Any, moments: Any) -> NDArray[Any]:
        state = np.asarray(x)
        if state.ndim not in (1, 2) or state.shape[0] != len(self.labels):
            mend = "Give an array of shape (n,) or (n, batch) in the order of plant.labels"
            raise InputError("x", state.shape, f"the state has {len(self.labels)} rows", mend)
        kind = np.result_type(state, *map(np.asarray, u), *map(np.asarray, moments), float)
        dx = np.empty((state.shape[0] + len(self.ledger), *state.shape[1:]), kind)
        signals = None if len(moments) == 2 else self.near(state, moments)
        k = self.coefficients
        equations.derivative(state, dx, 1, 0, k, u[0], u[1], moments[0], moments[1], k.beyond, signals)
        return dx


def coefficients(
    parameters: Parameters, radiation: tuple[Radiation, Radiation], geometry: Float | None = None
) -> Coefficients:
    """Derive the constants of the equations from the device."""
    p = parameters
    N, K, J2, J3, J4 = p.N, p.K, p.J2, p.J3, p.J4
    column = np.array([2.0 * N * J3, J4])  # inertia between (psi, omega) and the direction (cos psi, -sin psi)
    if p.contact == "friction":  # in place of psi the spin axis alone
        G, column = np.diag([0.5 / J3, 1.0 / J4]), np.array([2.0 * J3, J4])
    elif p.connection == "magnetic":
        G = np.diag([1.0 / J2, 1.0 / J4])
    else:  # omega' = N psi': the inverse inertia on the constraint
        along = np.array([1.0, N])
        G = np.outer(along, along) / (J2 + N**2 * J4)
    reaction = G @ column
    return Coefficients(
        N=N,
        K=K,
        J3=J3,
        J4=J4,
        i1=1.0 / (p.J1 + p.Jh1),
        i3=1.0 / (p.J1 + p.Jh3),
        Gpp=float(G[0, 0]),
        Gpo=float(G[0, 1]),
        Goo=float(G[1, 1]),
        ap=float(reaction[0]),
        ao=float(reaction[1]),
        kappa=float(K - column @ reaction),
        k1=float(p.k1),
        k3=float(p.k3),
        d1=float(p.d1),
        d3=float(p.d3),
        C2=p.lever_inertia if p.lever_gyroscopic else 0.0,
        reaction=1.0 if p.generator_reaction else 0.0,
        p1=radiation[0].p,
        q1=radiation[0].q,
        p3=radiation[1].p,
        q3=radiation[1].q,
        beyond=terms(p, geometry),
    )


def stored_energy(k: Coefficients, x: NDArray[Any]) -> Any:
    """Kinetic and spring energy [J] of the state `x` (n,) or (n, batch), from the same constants as the equations."""
    phi1, phi3, psi = x[equations.PHI1], x[equations.PHI3], x[equations.PSI]
    v1, v3 = x[equations.PHI1_RATE], x[equations.PHI3_RATE]
    w, W = x[equations.PSI_RATE], x[equations.OMEGA_RATE]
    u1 = np.cos(psi) * v1 - np.sin(psi) * v3
    if contact_of(k.beyond) is not None:
        axis, alone = x[-1], 1.0 / k.beyond.contact.ring
        kinetic = v1**2 / k.i1 + v3**2 / k.i3 + k.K * u1**2 + alone * w**2 + 2.0 * k.J3 * axis**2 + k.J4 * W**2
        return 0.5 * (kinetic + k.k1 * phi1**2 + k.k3 * phi3**2) + (2.0 * k.J3 * axis + k.J4 * W) * u1
    J2 = ring_inertia(k)
    kinetic = v1**2 / k.i1 + v3**2 / k.i3 + k.K * u1**2 + J2 * w**2 + k.J4 * W**2
    return 0.5 * (kinetic + k.k1 * phi1**2 + k.k3 * phi3**2) + (2.0 * k.N * k.J3 * w + k.J4 * W) * u1


def ring_inertia(k: Coefficients) -> float:
    """J2 of (16), from the inverse inertia. [kg m^2]"""
    if k.Gpo == 0.0:
        return 1.0 / k.Gpp
    return 1.0 / k.Gpp - k.N**2 * k.J4
