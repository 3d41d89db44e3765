"""The statements of the paper, one entry each: what it says, and how ours is measured and judged."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import NamedTuple

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
"""Of the runs and the variant."""


class Statement(NamedTuple):
    """One statement of the paper."""

    key: str  # short name
    group: str  # heading in the table
    says: str  # what the paper says, in our words
    measure: str  # what our number is
    check: Check


class Finding(NamedTuple):
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


def _omega_1(setup: Setup, variant: str) -> Result:
    """sqrt(k1/(J1 + Jh1)) with the rebuilt Jh1 against the same with Table 1."""
    p, hydro = Parameters(), shipped()
    ours = math.sqrt(p.k1 / (p.J1 + float(hydro.added_mass_inf[0])))
    return close(ours, math.sqrt(p.k1 / (p.J1 + p.Jh1)), 0.01, "rad/s")


def _omega_3(setup: Setup, variant: str) -> Result:
    """sqrt(k3/(J1 + Jh3)) with the rebuilt k3 and Jh3 against the same with Table 1."""
    p, hydro = Parameters(), shipped()
    ours = math.sqrt(hydro.stiffness / (p.J1 + float(hydro.added_mass_inf[1])))
    return close(ours, math.sqrt(p.k3 / (p.J1 + p.Jh3)), 0.01, "rad/s")


@lru_cache(maxsize=8)
def _orbit(variant: str) -> PeriodicOrbit:
    return lock_orbit(zhang2017(variant), Regular(HS / math.sqrt(2.0), WP), 0.052, 3.5e-4)


def _locks(setup: Setup, variant: str) -> Result:
    orbit = _orbit(variant)
    if orbit.status == "no orbit":
        return is_true(math.nan, False, "", "there is no locked orbit")
    size = float(np.abs(orbit.multipliers[0]))
    return is_true(size, orbit.status == "stable", "", f"the locked orbit exists and is {orbit.status}")


def _smooth(setup: Setup, variant: str) -> Result:
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


def _at(gamma: float, cc: float, cg: float, judge: Callable[[Case], Result]) -> Check:
    """Judge the runs of one pair in one sea."""

    def check(setup: Setup, variant: str) -> Result:
        return judge(lock_grid(setup, variant, gamma)[cc, cg])

    return check


def _holds(case: Case) -> Result:
    return _with_motion(holds(case.locked), case)


def _loses(case: Case) -> Result:
    return _with_motion(loses(case.locked), case)


def _with_motion(result: Result, case: Case) -> Result:
    motion = float(case.phi1_p98.mean())
    outside = ", outside the linear model" if motion > 0.35 else ""
    return result._replace(note=f"{result.note}; 98 % of |φ1| {motion:.2f} rad{outside}")


def _power(stated: float, rounding: float) -> Callable[[Case], Result]:
    def judge(case: Case) -> Result:
        return one_draw(case.power[case.locked], stated, rounding, "W", "realisations that kept lock")

    return judge


def _power_range(case: Case) -> Result:
    return within(case.power[case.locked], (1.6, 2.0), "W", "realisations that kept lock")


def _loss_time(case: Case) -> Result:
    return one_draw(case.loss_time, 400.0, 50.0, "s", "realisations that lost lock")


def _wave_input(case: Case) -> Result:
    return one_draw(case.wave_input, 16.7, 0.05, "W", "realisations")


def _stays_longer(setup: Setup, cases: dict[str, Case]) -> Result:
    """Time in lock of the first case less that of the second, runs that kept lock counted with their whole length."""
    times = {name: case.time_in_lock(setup.duration) for name, case in cases.items()}
    note = ", ".join(f"{name}: {time.mean():.0f} s" for name, time in times.items())
    first, second = times.values()
    return larger(first, second, "s", f"{note} in lock")


def _earlier(gamma: float, cg: float) -> Check:
    def check(setup: Setup, variant: str) -> Result:
        grid = lock_grid(setup, variant, gamma)
        return _stays_longer(setup, {f"cc {cc}": grid[cc, cg] for cc in (0.052, 0.156)})

    return check


def _coupling_helps(setup: Setup, variant: str) -> Result:
    plant, pair = zhang2017(variant, connection="rigid"), (0.052, 3.5e-4)
    rigid = ensemble(setup, plant, 5.0, [pair], f"{variant}, rigid connection")[pair]
    return _stays_longer(setup, {"coupled": lock_grid(setup, variant, 5.0)[pair], "rigid": rigid})


def _hardly_holds(setup: Setup, variant: str) -> Result:
    grid = lock_grid(setup, variant, 1.0)
    best = max((grid[COUPLINGS[0], cg] for cg in GAINS[1.0]), key=lambda case: float(case.locked.mean()))
    result = loses(best.locked)
    return result._replace(note=f"{result.note} at the most favourable cg {best.cg:g}")


_KEPT, _POWER = "share that kept lock 2000 s", "mean power in lock"
_EARLIER = "A larger cc loses lock earlier"

_GROUPS: dict[str, tuple[tuple[str, str, str, Check], ...]] = {
    "Hydrodynamics": (
        ("k3", "k3 = 2945 Nm/rad (Table 1)", "rebuilt from the geometry", _table_1("k3")),
        ("jh1", "Jh1 = 14.39 kg m² (Table 1)", "rebuilt from the geometry", _table_1("Jh1")),
        ("jh3", "Jh3 = 32.16 kg m² (Table 1)", "rebuilt from the geometry", _table_1("Jh3")),
        ("omega1", "√(k1/(J1+Jh1)) = 1.29 rad/s from Table 1", "with the rebuilt Jh1", _omega_1),
        ("omega3", "√(k3/(J1+Jh3)) = 5.28 rad/s from Table 1", "with the rebuilt k3, Jh3", _omega_3),
    ),
    "Regular wave of equal energy": (
        ("regular_lock", "The ring turns once per wave (cc 0.052, cg 3.5e-4)", "largest Floquet multiplier", _locks),
        ("regular_power", "The power in lock is nearly constant", "its coefficient of variation", _smooth),
    ),
    f"Irregular sea, {sea_name(5.0)}": (
        ("g5_holds", "cc 0.052, cg 3.5e-4 keeps lock", _KEPT, _at(5.0, 0.052, 3.5e-4, _holds)),
        ("g5_power", "and gives 1.6 to 2.0 W", _POWER, _at(5.0, 0.052, 3.5e-4, _power_range)),
        (
            "g5_input",
            "The mean wave input is about 16.7 W",
            "mean wave input at that pair",
            _at(5.0, 0.052, 3.5e-4, _wave_input),
        ),
        ("g5_loses", "cc 0.052, cg 1e-3 loses lock", _KEPT, _at(5.0, 0.052, 1e-3, _loses)),
        ("g5_loss_time", "after about 400 s", "mean time of the losses", _at(5.0, 0.052, 1e-3, _loss_time)),
        ("g5_earlier", _EARLIER, "time in lock at cg 1e-3, cc 0.052 less 0.156", _earlier(5.0, 1e-3)),
        (
            "coupling",
            "The magnetic coupling widens the margin of lock",
            "time in lock at cg 3.5e-4, coupled less rigid",
            _coupling_helps,
        ),
    ),
    f"Irregular sea, {sea_name(50.0)}": (
        ("g50_holds", "cc 0.052, cg 7.5e-4 keeps lock", _KEPT, _at(50.0, 0.052, 7.5e-4, _holds)),
        ("g50_power", "and gives 3.5 W", _POWER, _at(50.0, 0.052, 7.5e-4, _power(3.5, 0.05))),
        (
            "g50_best",
            "It is the best pair: more cg loses lock",
            "share that kept lock at cg 1e-3",
            _at(50.0, 0.052, 1e-3, _loses),
        ),
        ("g50_earlier", _EARLIER, "time in lock at cg 7.5e-4, cc 0.052 less 0.156", _earlier(50.0, 7.5e-4)),
    ),
    f"Irregular sea, {sea_name(1.0)}": (
        ("g1_weak", "cc 0.052 hardly keeps lock at any cg", _KEPT, _hardly_holds),
        ("g1_holds_104", "cc 0.104 keeps lock at cg 1.5e-4", _KEPT, _at(1.0, 0.104, 1.5e-4, _holds)),
        ("g1_holds_156", "cc 0.156 keeps lock at cg 1.5e-4", _KEPT, _at(1.0, 0.156, 1.5e-4, _holds)),
        ("g1_power_104", "and gives 0.62 W (cc 0.104)", _POWER, _at(1.0, 0.104, 1.5e-4, _power(0.62, 0.005))),
        ("g1_power_156", "and gives 0.62 W (cc 0.156)", _POWER, _at(1.0, 0.156, 1.5e-4, _power(0.62, 0.005))),
        (
            "g1_loses",
            "and no longer at larger cg (cc 0.104)",
            "share that kept lock at cg 5e-4",
            _at(1.0, 0.104, 5e-4, _loses),
        ),
    ),
}
"""Heading in the table: key, what the paper says, what our number is, and how it is judged."""

STATEMENTS = tuple(
    Statement(key, group, says, measure, check) for group, rows in _GROUPS.items() for key, says, measure, check in rows
)
