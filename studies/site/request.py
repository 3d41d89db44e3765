"""What is asked of a site: table, device, laws, scale, seeds, length of the runs, and where everything goes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from gyroctl.comparison.compare import check_length, check_motion_limit, check_workers
from gyroctl.devices import zhang2017
from gyroctl.errors import InputError, check_kind
from gyroctl.harness.arguments import check_plant, laws_by_name
from gyroctl.harness.code_files import asked_for
from gyroctl.harness.device_sets import foreign, own_choice, own_seeds
from gyroctl.harness.protocol import Law
from gyroctl.harness.registry import build
from gyroctl.harness.run import Settings, ticks_of
from gyroctl.harness.run_size import run_size
from gyroctl.harness.seed_ledger import refused_for
from gyroctl.harness.yardstick import BASELINE
from gyroctl.plant import Plant
from gyroctl.studies.evaluation.entrants import ALL, parse
from gyroctl.studies.evaluation.seeds import seed_plan
from gyroctl.studies.site.scatter import Scatter
from gyroctl.waves.checks import within

LAWS = "coupling,load_angle"
"""Laws where none are asked for: compiled ones, of seconds a sea state."""

SITE_PAIR = "site_constant"
"""Name of the one constant pair for the whole site, which no law may bear."""

SCALES = (1e-3, 1e4)
"""Scales that may be meant. [-]"""

BUDGET, PER_SECOND = 4.5e5, 750.0
"""Simulated time to search the best pair of a sea state: at least, and for each second that a run lasts. [s]"""

BUDGET_MAX = 1e9
"""Largest of these. [s]"""


@dataclass(frozen=True)
class SiteRequest:
    """A site, ready to be run."""

    scatter: Scatter  # sea states with their share of the year
    out: Path  # folder of results, pictures and finished runs
    laws: Mapping[str, Law]  # the laws under test
    plant: Plant  # the device
    table: str = ""  # name of the file of the scatter table
    scale: float = 1.0  # length of the site's device over that of the plant [-]
    depth: float = math.inf  # of the water at the site, at its scale [m]
    gamma: float = 1.0  # peak enhancement of every sea state [-]
    seeds: tuple[int, ...] = tuple(range(1, 17))  # realisations, the same in every sea state
    duration: float = 600.0  # of a run, at the plant's scale [s]
    budget: float = BUDGET  # simulated time to search the pair of a sea state [s]
    rarest: float = 0.0  # part of the year below which a sea state is not run [1]
    motion_limit: float = 0.35  # of the 98 % motion [rad]
    settings: Settings = field(default_factory=Settings)  # sensors, actuators, integration
    workers: int | None = None  # they change no result
    tuned_on: tuple[int, ...] = ()  # seeds that may not judge these laws
    foreign: tuple[str, ...] = ()  # laws whose tuned sets all belong to another device
    scheduler: str | None = None  # of other machines
    quiet: bool = False  # no progress
    say: Callable[[str], None] = lambda _: None  # takes what is to be told

    @property
    def power_scale(self) -> float:
        """Power at the site over that of the plant, by Froude: scale^3.5. [-]"""
        return float(self.scale**3.5)

    def record(self) -> dict[str, Any]:
        """For the JSON file."""
        return {
            "table": self.table,
            "laws": list(self.laws),
            "scale": self.scale,
            "depth_m": self.depth,
            "gamma": self.gamma,
            "seeds": list(self.seeds),
            "duration_s": self.duration,
            "pair_budget_s": self.budget,
            "rarest": self.rarest,
            "motion_limit_rad": self.motion_limit,
        }


def site_request(
    scatter: Scatter,
    out: Path | str,
    laws: str | Mapping[str, Law | str] | Sequence[str] = LAWS,
    *,
    plant: Plant | None = None,
    device: Path | None = None,
    table: str = "",
    scale: float = 1.0,
    depth: float | None = None,
    gamma: float = 1.0,
    seeds: Sequence[str] = ("1:16",),
    duration: float = 600.0,
    budget: float | None = None,
    rarest: float = 0.0,
    motion_limit: float = 0.35,
    settings: Settings | None = None,
    workers: int = 0,
    allow_tuning_seeds: bool = False,
    allow_code: Sequence[str | Path] = (),
    scheduler: str | None = None,
    quiet: bool = False,
    say: Callable[[str], None] = lambda _: None,
) -> SiteRequest:
    """Ask for a site, everything checked before the first run.

    Parameters
    ----------
    scatter : Scatter
        From `read_scatter`.
    out : path
        Folder of the results.
    laws : str, mapping or sequence
        As `gyroctl evaluate --laws` takes them, or laws by name.
    plant : Plant, optional
        The device, by default the paper's, corrected. Laws that are named are built for it; one of another length is
        refused, `scale` tells that of the site.
    device : path, optional
        Its file, beside which sets that were tuned on it are taken from.
    table : str
        Name of the file of the table, for the page.
    scale : float
        Length of the device at the site over that of the plant: a sea of Hs and Tp acts on the plant as one of
        Hs / scale and Tp / sqrt(scale), and power is scale^3.5 times as much. [-]
    depth : float, optional
        Depth of the water at the site, for the power of the waves; by default that of the plant times `scale`. [m]
    gamma : float
        Peak enhancement of every sea state, 1 for Pierson-Moskowitz (Bretschneider). [-]
    seeds : sequence of str
        Realisations, as `gyroctl evaluate --seeds` takes them; the same in every sea state.
    duration : float
        Of a run, at the plant's scale. [s]
    budget : float, optional
        Simulated time to search the best constant pair of a sea state, by default 4.5e5 or 750 times `duration`. [s]
    rarest : float
        Part of the year below which a sea state is not run but named. [1]
    motion_limit : float
        Limit of the 98 % motion. [rad]
    settings, workers, allow_tuning_seeds, allow_code, scheduler, quiet, say
        As in `gyroctl.compare` and `gyroctl evaluate`.

    Raises
    ------
    InputError
        For whatever of these cannot be used.
    """
    check_kind("scatter", scatter, Scatter, "a scatter table", "Give what gyroctl.studies.site.read_scatter returns")
    plant = zhang2017() if plant is None else plant
    check_plant(plant)
    settings = Settings() if settings is None else settings
    if plant.parameters.length_scale != 1.0:
        length = plant.parameters.length_scale
        problem = f"is {length:g} times as long as Table 1, and a site is worked out at that size"
        mend = f"Give its model, gyroctl device scale FILE --length {1.0 / length:.6g}, and the length by scale"
        raise InputError("plant", plant.name, problem, mend)
    built, kinds = _laws(laws, asked_for(allow_code), plant, device)
    for name, law in built.items():
        if name in (BASELINE, SITE_PAIR):
            raise InputError("laws", name, "this name is that of a constant pair", "Leave it out: it takes part")
        ticks_of(law, name, settings.actuators)
    tuned_on = refused_for(built.values(), kinds.values())
    if device is not None:
        tuned_on = tuple(sorted({*tuned_on, *own_seeds(device, kinds.values(), plant)}))
    plan = seed_plan(seeds, allow_tuning_seeds, tuned_on)
    if plan.own:
        raise InputError("seeds", next(iter(plan.own)), "a law has seeds of its own", "Give the same seeds to all laws")
    within("scale", scale, *SCALES, "Give the length of the site's device over that of the plant, for example 20")
    within("gamma", gamma, 1.0, 1000.0, "Give a peak enhancement, 1 for Pierson-Moskowitz, for example 3.3")
    within("rarest", rarest, 0.0, 1.0, "Give a part of the year, for example 0.001")
    if depth is not None and not (depth > 0.0):
        raise InputError("depth", depth, "must be above zero", "Give the depth of the water in metres, inf for deep")
    run_size(duration, settings.dt, settings.actuators.period, plant.parameters.time_scale)
    check_length(duration, settings.score_from)
    check_motion_limit(motion_limit)
    check_workers(workers)
    spend = max(BUDGET, PER_SECOND * duration) if budget is None else budget
    within("budget", spend, 0.0, BUDGET_MAX, "Give simulated seconds, for example 4.5e5")
    place = Path(out)
    for part in (place, *place.parents):
        if part.exists() and not part.is_dir():
            raise InputError("out", str(out), f"{part} is a file, not a folder", "Give another folder")
    return SiteRequest(
        scatter,
        place,
        built,
        plant,
        table,
        float(scale),
        plant.depth * scale if depth is None else float(depth),
        float(gamma),
        plan.common,
        float(duration),
        float(spend),
        float(rarest),
        motion_limit,
        settings,
        workers or None,
        () if allow_tuning_seeds else tuned_on,
        tuple(foreign(kinds, plant, device, _tunings(laws))),
        scheduler,
        quiet,
        say,
    )


def _tunings(laws: object) -> dict[str, str | None]:
    """Sets that a list of laws asks for, by the names that the laws get."""
    return {entrant.label: entrant.tuning for entrant in parse(laws)} if isinstance(laws, str) else {}


def _laws(
    laws: str | Mapping[str, Law | str] | Sequence[str], allowed: tuple[Path, ...], plant: Plant, device: Path | None
) -> tuple[dict[str, Law], dict[str, str]]:
    """Laws by the names that they get, built for the plant where a name says which; and which these are."""

    def built_for(name: str, given: Mapping[str, Any], tuning: str | None = None) -> Law:
        parameters = {**given, **({} if tuning is None else {"tuning": tuning})}
        if device is not None:
            parameters = own_choice(device, name, plant, parameters)
        return build(name, parameters, None, allowed, plant)

    if not isinstance(laws, str):
        built = laws_by_name(laws)
        if not built:
            raise InputError("laws", {}, "there is nothing to run", "Give at least one law")
        given = list(laws.values() if isinstance(laws, Mapping) else laws)
        pairs = zip(built.items(), given, strict=True)
        built = {key: built_for(one, {}) if isinstance(one, str) else law for (key, law), one in pairs}
        return built, {key: one for key, one in zip(built, given, strict=True) if isinstance(one, str)}
    found = {}
    entrants = parse(laws)
    for entrant in entrants:
        if entrant.label in found:
            raise InputError("laws", entrant.label, "stands there twice", "Give each law once")
        found[entrant.label] = built_for(
            entrant.name, entrant.parameters, None if entrant.tuning == ALL else entrant.tuning
        )
    return found, {entrant.label: entrant.name for entrant in entrants}
