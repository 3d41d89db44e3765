"""The statements of the paper, one entry each: what it says, and how ours is measured and judged."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from gyroctl.devices import zhang2017
from gyroctl.hydrodynamics import shipped
from gyroctl.linearisation import PeriodicOrbit, lock_orbit
from gyroctl.orbits.flow import Forcing, flow
from gyroctl.plant import Parameters
from gyroctl.plant.equations import OMEGA_RATE
from gyroctl.studies.paper.ensembles import COUPLINGS, GAINS, HS, VARIANTS, WP, Case, Setup, ensemble, lock_grid
from gyroctl.studies.paper.verdicts import Result, close, holds, is_true, larger, loses, one_draw, within
from gyroctl.studies.style import sea_name
from gyroctl.waves import Regular

Check = Callable[[Setup, str], Result]


@dataclass(frozen=True)
class Statement:
    """One statement of the paper.

    Parameters
    ----------
    key : str
        Short name.
    group : str
        Heading in the table.
    says : str
        What the paper says, in our words.
    measure : str
        What our number is.
    check : callable
        (setup, variant) -> Result.
    """

    key: str
    group: str
    says: str
    measure: str
    check: Check


@dataclass(frozen=True)
class Finding:
    """A statement and what each variant gives."""

    statement: Statement
    results: dict[str, Result]


def evaluate(setup: Setup, variants: Sequence[str] = VARIANTS) -> tuple[Finding, ...]:
    """Measure and judge every statement for every variant."""
    return tuple(Finding(s, {variant: s.check(setup, variant) for variant in variants}) for s in STATEMENTS)


def _table_1(name: str) -> Check:
    """k3, Jh1 or Jh3 of the rebuilt hydrodynamics against Table 1; the same table serves both variants."""

    def check(setup: Setup, variant: str) -> Result:
        hydro, stated = shipped(), float(getattr(Parameters(), name))
        ours = {"k3": hydro.stiffness, "Jh1": hydro.added_mass_inf[0], "Jh3": hydro.added_mass_inf[1]}[name]
        return close(float(ours), stated, 0.01, "Nm/rad" if name == "k3" else "kg m²")

    return check


def _natural_frequency(direction: int) -> Check:
    """sqrt(k/(J1 + Jh)) with the rebuilt k3 and Jh against the same with Table 1."""

    def check(setup: Setup, variant: str) -> Result:
        p, hydro = Parameters(), shipped()
        stated = math.sqrt((p.k1, p.k3)[direction] / (p.J1 + (p.Jh1, p.Jh3)[direction]))
        stiffness = (p.k1, hydro.stiffness)[direction]
        ours = math.sqrt(stiffness / (p.J1 + float(hydro.added_mass_inf[direction])))
        return close(ours, stated, 0.01, "rad/s")

    return check


@lru_cache(maxsize=8)
def _orbit(variant: str) -> PeriodicOrbit:
    return lock_orbit(zhang2017(variant), Regular(HS / math.sqrt(2.0), WP), 0.052, 3.5e-4)


def _regular_lock(setup: Setup, variant: str) -> Result:
    orbit = _orbit(variant)
    if orbit.status == "no orbit":
        return is_true(math.nan, False, "", "there is no locked orbit")
    size = float(np.abs(orbit.multipliers[0]))
    return is_true(size, orbit.status == "stable", "", f"the locked orbit exists and is {orbit.status}")


def _regular_smooth(setup: Setup, variant: str) -> Result:
    """Coefficient of variation of the power along the orbit, five per cent taken as "nearly constant"."""
    orbit = _orbit(variant)
    if orbit.status == "no orbit":
        return is_true(math.nan, False, "", "there is no locked orbit")
    he = orbit.plant.excitation(np.array([WP]))[:, 0]
    forcing = Forcing(0.5 * HS / math.sqrt(2.0) * he, WP)
    points = [flow(orbit.plant, orbit.x, orbit.cc, orbit.cg, forcing, i / 32) for i in range(1, 33)]
    power = orbit.cg * np.array([float(np.real(x[OMEGA_RATE])) for x in points]) ** 2
    variation = float(power.std() / power.mean())
    return is_true(variation, variation <= 0.05, "", f"mean {power.mean():.2f} W; up to 0.05 counts as nearly constant")


def _case(gamma: float, cc: float, cg: float) -> Callable[[Setup, str], Case]:
    return lambda setup, variant: lock_grid(setup, variant, gamma)[cc, cg]


def _holds(gamma: float, cc: float, cg: float) -> Check:
    def check(setup: Setup, variant: str) -> Result:
        case = _case(gamma, cc, cg)(setup, variant)
        return _with_motion(holds(case.locked), case)

    return check


def _loses(gamma: float, cc: float, cg: float) -> Check:
    def check(setup: Setup, variant: str) -> Result:
        case = _case(gamma, cc, cg)(setup, variant)
        return _with_motion(loses(case.locked), case)

    return check


def _with_motion(result: Result, case: Case) -> Result:
    motion = float(case.phi1_p98.mean())
    outside = ", outside the linear model" if motion > 0.35 else ""
    return result._replace(note=f"{result.note}; 98 % of |φ1| {motion:.2f} rad{outside}")


def _held_power(gamma: float, cc: float, cg: float, stated: float, rounding: float) -> Check:
    def check(setup: Setup, variant: str) -> Result:
        case = _case(gamma, cc, cg)(setup, variant)
        return one_draw(case.power[case.locked], stated, rounding, "W", "realisations that kept lock")

    return check


def _held_power_range(setup: Setup, variant: str) -> Result:
    case = _case(5.0, 0.052, 3.5e-4)(setup, variant)
    return within(case.power[case.locked], (1.6, 2.0), "W", "realisations that kept lock")


def _loss_time(setup: Setup, variant: str) -> Result:
    case = _case(5.0, 0.052, 1e-3)(setup, variant)
    return one_draw(case.loss_time, 400.0, 50.0, "s", "realisations that lost lock")


def _wave_input(setup: Setup, variant: str) -> Result:
    case = _case(5.0, 0.052, 3.5e-4)(setup, variant)
    return one_draw(case.wave_input, 16.7, 0.05, "W", "realisations")


def _earlier(gamma: float, cg: float) -> Check:
    """Time in lock at cc 0.052 less that at 0.156, runs that kept lock counted with their whole length."""

    def check(setup: Setup, variant: str) -> Result:
        weak, strong = (_case(gamma, cc, cg)(setup, variant) for cc in (0.052, 0.156))
        times = [case.time_in_lock(setup.duration) for case in (weak, strong)]
        note = f"cc 0.052: {times[0].mean():.0f} s, cc 0.156: {times[1].mean():.0f} s in lock"
        return larger(times[0], times[1], "s", note)

    return check


def _hardly_holds(setup: Setup, variant: str) -> Result:
    grid = lock_grid(setup, variant, 1.0)
    best = max((grid[COUPLINGS[0], cg] for cg in GAINS[1.0]), key=lambda case: float(case.locked.mean()))
    result = loses(best.locked)
    return result._replace(note=f"{result.note} at the most favourable cg {best.cg:g}")


@lru_cache(maxsize=4)
def _rigid(setup: Setup, variant: str) -> Case:
    plant = zhang2017(variant, connection="rigid")
    pair = (0.052, 3.5e-4)
    return ensemble(setup, plant, 5.0, [pair], f"{variant}, rigid connection")[pair]


def _coupling_helps(setup: Setup, variant: str) -> Result:
    coupled, rigid = _case(5.0, 0.052, 3.5e-4)(setup, variant), _rigid(setup, variant)
    times = [case.time_in_lock(setup.duration) for case in (coupled, rigid)]
    note = f"coupled: {times[0].mean():.0f} s, rigid: {times[1].mean():.0f} s in lock"
    return larger(times[0], times[1], "s", note)


_HYDRO, _WAVE, _G5, _G50, _G1 = (
    "Hydrodynamics",
    "Regular wave of equal energy",
    *(f"Irregular sea, {sea_name(gamma)}" for gamma in (5.0, 50.0, 1.0)),
)

_KEPT = "share that kept lock 2000 s"

STATEMENTS: tuple[Statement, ...] = (
    Statement("k3", _HYDRO, "k3 = 2945 Nm/rad (Table 1)", "rebuilt from the geometry", _table_1("k3")),
    Statement("jh1", _HYDRO, "Jh1 = 14.39 kg m² (Table 1)", "rebuilt from the geometry", _table_1("Jh1")),
    Statement("jh3", _HYDRO, "Jh3 = 32.16 kg m² (Table 1)", "rebuilt from the geometry", _table_1("Jh3")),
    Statement(
        "omega1", _HYDRO, "√(k1/(J1+Jh1)) = 1.29 rad/s from Table 1", "with the rebuilt Jh1", _natural_frequency(0)
    ),
    Statement(
        "omega3", _HYDRO, "√(k3/(J1+Jh3)) = 5.28 rad/s from Table 1", "with the rebuilt k3, Jh3", _natural_frequency(1)
    ),
    Statement(
        "regular_lock",
        _WAVE,
        "The ring turns once per wave (cc 0.052, cg 3.5e-4)",
        "largest Floquet multiplier",
        _regular_lock,
    ),
    Statement(
        "regular_power", _WAVE, "The power in lock is nearly constant", "its coefficient of variation", _regular_smooth
    ),
    Statement("g5_holds", _G5, "cc 0.052, cg 3.5e-4 keeps lock", _KEPT, _holds(5.0, 0.052, 3.5e-4)),
    Statement("g5_power", _G5, "and gives 1.6 to 2.0 W", "mean power in lock", _held_power_range),
    Statement("g5_input", _G5, "The mean wave input is about 16.7 W", "mean wave input at that pair", _wave_input),
    Statement("g5_loses", _G5, "cc 0.052, cg 1e-3 loses lock", _KEPT, _loses(5.0, 0.052, 1e-3)),
    Statement("g5_loss_time", _G5, "after about 400 s", "mean time of the losses", _loss_time),
    Statement(
        "g5_earlier",
        _G5,
        "A larger cc loses lock earlier",
        "time in lock at cg 1e-3, cc 0.052 less 0.156",
        _earlier(5.0, 1e-3),
    ),
    Statement(
        "coupling",
        _G5,
        "The magnetic coupling widens the margin of lock",
        "time in lock at cg 3.5e-4, coupled less rigid",
        _coupling_helps,
    ),
    Statement("g50_holds", _G50, "cc 0.052, cg 7.5e-4 keeps lock", _KEPT, _holds(50.0, 0.052, 7.5e-4)),
    Statement("g50_power", _G50, "and gives 3.5 W", "mean power in lock", _held_power(50.0, 0.052, 7.5e-4, 3.5, 0.05)),
    Statement(
        "g50_best",
        _G50,
        "It is the best pair: more cg loses lock",
        "share that kept lock at cg 1e-3",
        _loses(50.0, 0.052, 1e-3),
    ),
    Statement(
        "g50_earlier",
        _G50,
        "A larger cc loses lock earlier",
        "time in lock at cg 7.5e-4, cc 0.052 less 0.156",
        _earlier(50.0, 7.5e-4),
    ),
    Statement("g1_weak", _G1, "cc 0.052 hardly keeps lock at any cg", _KEPT, _hardly_holds),
    Statement("g1_holds_104", _G1, "cc 0.104 keeps lock at cg 1.5e-4", _KEPT, _holds(1.0, 0.104, 1.5e-4)),
    Statement("g1_holds_156", _G1, "cc 0.156 keeps lock at cg 1.5e-4", _KEPT, _holds(1.0, 0.156, 1.5e-4)),
    Statement(
        "g1_power_104",
        _G1,
        "and gives 0.62 W (cc 0.104)",
        "mean power in lock",
        _held_power(1.0, 0.104, 1.5e-4, 0.62, 0.005),
    ),
    Statement(
        "g1_power_156",
        _G1,
        "and gives 0.62 W (cc 0.156)",
        "mean power in lock",
        _held_power(1.0, 0.156, 1.5e-4, 0.62, 0.005),
    ),
    Statement(
        "g1_loses",
        _G1,
        "and no longer at larger cg (cc 0.104)",
        "share that kept lock at cg 5e-4",
        _loses(1.0, 0.104, 5e-4),
    ),
)
