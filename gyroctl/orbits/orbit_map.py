"""The map whose fixed points are the locked orbits, as a function of any parameters, with exact derivatives."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, Protocol, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyroctl.errors import InputError
from gyroctl.orbits.choices import NEVER_OFF, TERMS, of_moment, switched_on, unit_term, with_choice
from gyroctl.orbits.flow import PADDING, Forcing, Stretch, Vector, changes, directions, run, step_count
from gyroctl.orbits.orbit import LockProblem, Orbit, describe
from gyroctl.orbits.sensitivity import CONTROLS, DEVICE, PARAMETERS, Setting, parameter_column, with_gear
from gyroctl.orbits.symmetry import free_rows, signs
from gyroctl.orbits.wave import Wave
from gyroctl.plant import Plant
from gyroctl.plant.equations import LEDGER, OMEGA_RATE, PSI, PSI_RATE
from gyroctl.waves.channels import transfers

LEAST = {"cc": 0.0, "cg": 0.0, "d1": 0.0, "phase": -np.inf, "N": 1.0}
LEAST |= {name: 0.0 for name in TERMS if name not in NEVER_OFF}
"""Least value of a parameter; the others must be positive."""

POSITIVE = 1e-9


@dataclass(frozen=True)
class ShiftedExcitation:
    """Excitation whose first moment leads the second by a given angle at every frequency.

    Parameters
    ----------
    base : excitation
        Gives the moduli and the phase of the second moment.
    phase : float
        arg He1 - arg He3. [rad]
    """

    base: Any
    phase: float

    @property
    def sha256(self) -> str:
        """Hash of the table below and the phase."""
        return f"{self.base.sha256}, phase {self.phase!r}"

    @property
    def omega(self) -> NDArray[np.float64]:
        """Tabulated frequencies. [rad/s]"""
        return np.asarray(self.base.omega)

    def __call__(self, omega: ArrayLike, heading: float = 0.0) -> NDArray[np.complex128]:
        """Return He_1, He_3 (2, n) [Nm/m]."""
        return with_phase(np.array(self.base(omega, heading), complex), self.phase)


def with_phase(he: NDArray[np.complex128], phase: float) -> NDArray[np.complex128]:
    """Return moments (2, ...) of which the first leads the second by `phase` [rad]."""
    out = he.copy()
    out[0] = np.abs(he[0]) * np.exp(1j * (np.angle(he[1]) + phase))
    return out


class Evaluation(NamedTuple):
    """The map at one point: what `OrbitMap.evaluate` returns."""

    image: Vector  # (m,)
    by_state: NDArray[np.float64]  # (m, m)
    by_parameter: NDArray[np.float64]  # (m, number of parameters)
    power: float  # mean electrical power on the way [W]


class ParametricMap(Protocol):
    """A map whose fixed points are followed: all that the continuation needs to know of the device."""

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the parameters."""

    @property
    def symmetric(self) -> bool:
        """Whether the map is the square root of the one that is meant."""

    def over(self, parameters: tuple[str, ...]) -> Self:
        """Return the same map over other parameters."""

    def value(self, name: str) -> float:
        """Present value of a parameter."""

    def least(self, name: str) -> float:
        """Least possible value of a parameter."""

    def span(self, values: Vector) -> float:
        """Time that one application takes. [s]"""

    def evaluate(self, x: Vector, values: Vector, derivative: bool = True) -> Evaluation:
        """Image of `x` and derivatives at parameter values."""

    def orbit(self, x: Vector, values: Vector) -> Orbit:
        """The orbit through a fixed point."""


@dataclass(frozen=True)
class OrbitMap:
    """Half a period of the flow followed by the symmetry (or a whole period), over named parameters.

    Parameters
    ----------
    plant, wave, cc, cg, sense, dt
        As for `lock_orbit`, the step as well; they hold for what is not among the parameters.
    parameters : tuple of str
        Names out of `PARAMETERS`: cc, cg [Nms], height [m], wp [rad/s], phase between the moments [rad], d1 [Nms/rad],
        k1 [Nm/rad], N [-]; drag [-], bearing [Nm], windage [Nms^2], rolling_resistance [m], coupling_slip [rad/s],
        coupling_cap [Nm].
    symmetric : bool
        Half a period; False for a whole one, where orbits without the symmetry are followed as well.
    """

    plant: Plant
    wave: Wave
    cc: float
    cg: float
    sense: int = 1
    dt: float | None = None
    parameters: tuple[str, ...] = ()
    symmetric: bool = True

    def __post_init__(self) -> None:
        """Refuse unknown parameters; take the whole period where the device has no symmetry."""
        if self.symmetric and not self.plant.parameters.symmetric:
            object.__setattr__(self, "symmetric", False)
        for name in self.parameters:
            if name not in PARAMETERS:
                raise InputError("parameter", name, "cannot be continued in", f"Choose one of {', '.join(PARAMETERS)}")
        if "phase" in self.parameters and self.plant.parameters.wetted != "linear":
            problem = "the moments of a wetted surface have the phases of the geometry"
            raise InputError("parameter", "phase", problem, 'Choose another one, or wetted = "linear"')
        switched_on(self.plant, self.parameters)

    @property
    def longest(self) -> float:
        """Longest step. [s]"""
        return self.plant.step if self.dt is None else self.dt

    def value(self, name: str) -> float:
        """Present value of a parameter."""
        if name == "phase":
            return float(np.angle(self._present_he[0] * np.conj(self._present_he[1])))
        if name in TERMS:
            return float(getattr(self.plant.parameters, name))
        holder: Any = self if name in CONTROLS else self.plant.coefficients if name in DEVICE else self.wave
        return float(getattr(holder, name))

    def over(self, parameters: tuple[str, ...]) -> OrbitMap:
        """Return the same map over other parameters."""
        return dataclasses.replace(self, parameters=parameters)

    def least(self, name: str) -> float:
        """Least possible value of a parameter."""
        return LEAST.get(name, POSITIVE)

    def span(self, values: Vector) -> float:
        """Time that one application takes: half a period or a whole one. [s]"""
        return (0.5 if self.symmetric else 1.0) * self.setting(values).forcing.period

    def orbit(self, x: Vector, values: Vector) -> Orbit:
        """The orbit through the fixed point `x` (m,), with everything that is told of it."""
        at = self.moved(self._named(values))
        setting = at.setting(values)
        residual = float(np.max(np.abs(self.evaluate(x, values, derivative=False).image - x)))
        problem = LockProblem(at.plant, at.cc, at.cg, at.sense, at.longest, at.wave)
        return describe(problem, Forcing.of(at.plant, at.wave), self.full(x, setting), residual)

    def moved(self, values: dict[str, float]) -> OrbitMap:
        """Return the map with parameters set to new values, as a device and a wave of its own."""
        plant, wave = self.plant, self.wave
        own: dict[str, Any] = {n: float(v) for n, v in values.items() if n in CONTROLS}
        for name, number in values.items():
            if name == "N":
                plant = plant.replace(r2=plant.parameters.r1 * float(number))
            elif name in DEVICE:
                plant = plant.replace(**{name: float(number)})
            elif name == "phase":
                plant = plant.replace(excitation=ShiftedExcitation(plant.excitation, float(number)))
            elif name not in CONTROLS:
                wave = dataclasses.replace(wave, **{name: float(number)})
        return dataclasses.replace(self, plant=plant, wave=wave, **own)

    def setting(self, values: Vector) -> Setting:
        """Constants, controls and wave at parameter values (p,)."""
        at = self._named(values)
        device: dict[str, Any] = {n: at[n] for n in ("d1", "k1") if n in at}
        k = self._on.coefficients._replace(**device)
        for name in TERMS:
            if name in at:
                k = with_choice(k, self._units[name], name, at[name])
        if "N" in at:
            rigid = self.plant.parameters.connection == "rigid"
            k = with_gear(k, at["N"] - k.N, self.plant.parameters.J13, rigid)
        wp, height, he = self._wave(at)
        return Setting(k, at.get("cc", self.cc), at.get("cg", self.cg), Forcing(0.5 * height * he, wp))

    def evaluate(self, x: Vector, values: Vector, derivative: bool = True) -> Evaluation:
        """Image of the unknowns `x` (m,) and its exact derivatives at parameter values (p,)."""
        k, cc, cg, forcing = setting = self.setting(values)
        free, state = free_rows(self.plant), self.full(x, setting)
        n, halves = state.size, 1 if self.symmetric else 2
        hold = 0.5 * halves * forcing.period
        steps = halves * step_count(k, cc, hold / halves, self.longest, self.plant.parameters.time_scale)
        stretch = Stretch(PADDING * forcing.dt, hold, steps, forcing.grid(0.5 * halves), forcing.dt)
        sign = signs(n) if self.symmetric else np.ones(n)
        turn = np.zeros(n)
        turn[PSI] = self.sense * np.pi * halves
        plain = run(k, state, cc, cg, stretch)
        image, power = (sign * plain[:n] - turn)[free], float(plain[n + LEDGER.index("generator")]) / hold
        if not derivative:
            return Evaluation(image, np.empty((0, 0)), np.empty((0, 0)), power)
        seeds = directions(n, k.N if self.plant.parameters.connection == "rigid" else None)
        _, columns = changes(k, state, seeds[:, free], cc, cg, stretch)
        slopes = [
            parameter_column(self._on, setting, name, state, stretch, self._change(name, values, halves))
            for name in self.parameters
        ]
        by_parameter = np.stack(slopes, axis=1) if slopes else np.empty((n, 0))
        return Evaluation(image, sign[free, None] * columns[free], sign[free, None] * by_parameter[free], power)

    def full(self, x: Vector, setting: Setting) -> Vector:
        """State (n,) of the unknowns (m,)."""
        state = np.zeros(len(self.plant.labels))
        state[free_rows(self.plant)] = x
        if self.plant.parameters.connection == "rigid":
            state[OMEGA_RATE] = setting.coefficients.N * state[PSI_RATE]
        return state

    def _named(self, values: Vector) -> dict[str, float]:
        return dict(zip(self.parameters, map(float, values), strict=True))

    @cached_property
    def _on(self) -> Plant:
        """The plant with the terms of all parameters there."""
        return switched_on(self.plant, self.parameters)

    @cached_property
    def _units(self) -> dict[str, Any]:
        """Terms of the parameters that are choices, where each is 1."""
        return {name: unit_term(self.plant, name) for name in self.parameters if name in TERMS}

    def _wave(self, at: dict[str, float]) -> tuple[float, float, NDArray[np.complex128]]:
        """Frequency [rad/s], height [m] and transfers (channels,) at parameter values."""
        wp = at.get("wp", self.wave.wp)
        he = self._present_he if wp == self.wave.wp else self._transfers(np.array([wp]))[:, 0]
        return wp, at.get("height", self.wave.height), self._turned(he, at)

    @cached_property
    def _present_he(self) -> NDArray[np.complex128]:
        """Transfers at the wave's own frequency: the table is slower than the flow."""
        return self._transfers(np.array([self.wave.wp]))[:, 0]

    def _transfers(self, omega: Vector) -> NDArray[np.complex128]:
        """Transfers (channels, n) from the elevation to the signals, at frequencies (n,) [rad/s]."""
        return np.asarray(transfers(self._on, omega, self.wave.heading))

    def lacks_signals(self, omega: tuple[float, ...]) -> bool:
        """Whether a signal is cut off at one of the frequencies [rad/s]: the map is not smooth on the way there."""
        return bool(np.any(self._transfers(np.array(omega)) == 0.0))

    def _turned(self, he: NDArray[np.complex128], at: dict[str, float]) -> NDArray[np.complex128]:
        """Transfers (channels, ...) with the phase of the first moment, at rest and at all positions."""
        if "phase" not in at:
            return he
        out, rows = he.copy(), of_moment(self._on.channels, "Me1")
        out[rows] *= with_phase(he[:2], at["phase"])[0] / he[0]
        return out

    def _change(self, name: str, values: Vector, halves: int) -> Vector:
        """Derivative of the grid of signals with respect to a parameter of the wave, at the same phase."""
        at = self._named(values)
        wp, height, he = self._wave(at)
        slope = np.zeros(he.size, complex)
        if name == "height":
            slope = 0.5 * he
        elif name == "phase":
            rows = of_moment(self._on.channels, "Me1")
            slope[rows] = 0.5j * height * he[rows]
        elif name == "wp":  # on the table, a cubic spline, exact but for rounding; on the lengths of the waves to 1e-11
            h = 1e-3 * wp
            near = self._turned(self._transfers(wp + h * np.array([-2.0, -1.0, 1.0, 2.0])), at).T
            slope = 0.5 * height * (8.0 * (near[2] - near[1]) - (near[3] - near[0])) / (12.0 * h)
        return Forcing(slope, wp).grid(0.5 * halves)
