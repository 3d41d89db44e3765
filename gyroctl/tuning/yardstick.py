"""The yardstick of any sea and device: searched once, with twice the default budget of a law, and kept by its content.

The pairs of the default device ship with the keys of their searches, so that nothing is searched for them. So do those
of real water, which have the budget of one law there: a search of a contact that may slip takes long.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Callable, Sequence
from dataclasses import asdict, fields, replace
from typing import Any, NamedTuple

from gyroctl.cache import cache_folder
from gyroctl.engine import Store
from gyroctl.errors import InputError
from gyroctl.froude import growth
from gyroctl.harness.registry import REAL, tuned_sets
from gyroctl.harness.run import Settings
from gyroctl.harness.start import locked_start
from gyroctl.harness.yardstick import PAIR, Yardstick, shipped_pairs
from gyroctl.plant import Plant, beyond, equations, friction, reduced, wetted
from gyroctl.plant.compiled import source_stamp
from gyroctl.plant.given import check_plant
from gyroctl.plant.parameters import CHOICES
from gyroctl.reading import is_finite
from gyroctl.tuning.best_pair import Lengths, best_pair
from gyroctl.tuning.goal import Goal
from gyroctl.tuning.task import read_task
from gyroctl.tuning.waters import circumstances_of
from gyroctl.waves import ElevationRecord, Regular, Sea, SeaState, SpreadSea
from gyroctl.writing import plain

BUDGET = 8.0e6
"""Simulated time of a search: twice what a set of a law has by default, lest the yardstick be short. [s]"""

REAL_BUDGET = 4.0e5
"""Simulated time of a search in real water: the most that a planning law has there for a set of its own. [s]"""

SEEDS = range(100000, 100064)
"""Tuning seeds of the search."""

LOCKED = 0.98
"""Least part of the realisations that a pair must hold: one loss in 64, where laws are allowed none."""

SIMPLER = "; found for the same device with a contact that rolls and its wetted surface as polynomials"
"""What is said of the pair of a device that would be too costly to search for itself."""

FOLDER = "yardsticks"


class Search(NamedTuple):
    """All that the pair depends on."""

    plant: Plant
    sea: Sea
    settings: Settings
    goal: Goal
    budget: float = BUDGET
    seeds: Sequence[int] = SEEDS

    def content(self) -> dict[str, Any]:
        """As JSON can hold it. A constant pair looks at no sensor and never changes: those, lags and delays are out."""
        parameters, coefficients = self.plant.parameters, self.plant.coefficients
        off = {"traction"}  # the contact of a device that is searched for rolls
        usual = (*CHOICES, "length_scale")
        off |= {f.name for f in fields(parameters) if f.name in usual and getattr(parameters, f.name) == f.default}
        further: dict[str, Any] = {}  # what is off is no part of the key, and the keys that ship stay what they are
        if coefficients.beyond is not None:
            terms = source_stamp([beyond.__file__, friction.__file__, reduced.__file__, wetted.__file__])
            further = {"beyond": coefficients.beyond, "terms": terms, "water": self.plant.water}
        sea = {item.name: getattr(self.sea, item.name) for item in fields(self.sea) if item.compare}
        limits = self.settings.actuators
        acting = {name: getattr(limits, name) for name in ("cc_max", "cg_max", "cc_quantum", "cg_quantum", "cc_gain")}
        content = {
            "equations": source_stamp([equations.__file__]),
            "coefficients": {name: value for name, value in coefficients._asdict().items() if name != "beyond"},
            "parameters": {name: value for name, value in asdict(parameters).items() if name not in off},
            **further,
            "excitation": self.plant.excitation.sha256,
            "sea": {"kind": type(self.sea).__name__, **sea},
            "actuators": acting,
            "steps": {"dt": self.settings.dt, "blend": self.settings.blend},
            # what is not asked for is no part of the key either
            "goal": {name: value for name, value in asdict(self.goal).items() if math.isfinite(value) and value > 0.0},
            "budget_s": self.budget,
            "seeds": [self.seeds[0], self.seeds[-1]],
        }
        found: dict[str, Any] = json.loads(json.dumps(plain(content)))
        return found

    @property
    def key(self) -> str:
        """SHA-256 of the content."""
        return hashlib.sha256(json.dumps(self.content(), sort_keys=True).encode()).hexdigest()


def find_yardstick(
    plant: Plant,
    sea: Sea,
    settings: Settings | None = None,
    motion_limit: float = 0.35,
    budget: float | None = None,
    workers: int | None = None,
    quiet: bool = False,
    search: bool = True,
    say: Callable[[str], None] = lambda _: None,
) -> Yardstick:
    """Best constant pair of a sea and a device: as it ships, as it was found before, or searched now.

    Where no pair keeps the limit of motion, as in high seas, the pair is the best without that limit: one that avoids
    motion would be a weak yardstick. A device with friction in its contact or with a wetted surface that is followed is
    searched for as one that rolls, with the surface as polynomials: a search of the device itself would take days.

    Parameters
    ----------
    plant : Plant
        The device.
    sea : Sea
        The waves.
    settings : Settings, optional
        Actuators of the comparison; its steps are not those of the search.
    motion_limit : float
        Limit of the 98 % motion. [rad]
    budget : float, optional
        Simulated time of the search; 8e6 s at the size of Table 1. [s]
    workers : int, optional
        Threads, all cores by default; they change no bit of the result.
    quiet : bool
        Show no progress.
    search : bool
        Whether to search where no pair is known yet.
    say : callable
        Told when a search begins.

    Returns
    -------
    Yardstick
        Not searched for an elevation record, which is itself what judges, where no lock begins, and where no search is
        wanted: the pair that ships for the nearest sea, with the reason.

    Raises
    ------
    InputError
        For a budget that is too small.
    """
    check_plant(plant)
    if isinstance(sea, ElevationRecord):
        return unsearched(sea, "an elevation record is one realisation, on which a pair must not be tuned", plant)
    length, pace = plant.parameters.length_scale, plant.parameters.time_scale
    usual = Settings().at(length)
    acting = replace(usual, sensors=Settings().sensors, actuators=(settings or usual).actuators)
    budget = BUDGET * pace if budget is None else budget
    seeds = SEEDS[:1] if isinstance(sea, Regular) else SEEDS  # of a regular wave every seed is the same
    searched = plant.rolling.smooth
    wanted = Search(searched, sea, acting, Goal(locked=LOCKED, motion=motion_limit), budget, seeds)
    kept = _known(wanted)
    simpler = "" if searched is plant else SIMPLER
    if kept is not None:
        return replace(kept, words=kept.words + simpler)
    if not search:
        return unsearched(sea, "no search was wanted", plant)
    try:
        locked_start(plant, sea)
        found = _kept(wanted, workers, quiet, say)
    except InputError as error:
        if error.field == "budget":
            raise
        return unsearched(sea, f"the search failed: {error.problem}", plant)
    return replace(found, words=found.words + simpler)


def find_real_yardstick(
    sea: SeaState,
    budget: float = REAL_BUDGET,
    workers: int | None = None,
    quiet: bool = False,
    say: Callable[[str], None] = lambda _: None,
) -> Yardstick:
    """Best constant pair of a sea in real water: as it ships, as it was found before, or searched now.

    It is searched for as laws are tuned there: on the realistic device with its wetted surface as polynomials and a
    coupling that lags, on the seeds and for the goal of the task of the constant pair.

    Parameters
    ----------
    sea : SeaState
        One of that task.
    budget : float
        Simulated time of the search. [s]
    workers, quiet, say
        As in `find_yardstick`.

    Raises
    ------
    InputError
        For a sea that the task does not have, or a budget that is too small.
    """
    task, on = read_task(PAIR, REAL), circumstances_of(REAL)
    name = next((name for name, one in task.seas.items() if one.sea == sea), "")
    if not name:
        mend = f"Choose one of {', '.join(task.seas)}, or search on the device with find_yardstick"
        raise InputError("sea", sea, "the task of the constant pair has no such sea", mend)
    wanted = Search(on.plant, sea, on.settings, task.goals[""][name], budget, task.seeds.span)
    lengths = Lengths(task.search.dt, task.search.window, task.search.confirm)
    return _known(wanted) or _kept(wanted, workers, quiet, say, lengths)


def unsearched(sea: Sea, why: str, plant: Plant | None = None) -> Yardstick:
    """Pair that ships for the sea that is nearest, at the size of the plant, and why none was searched."""
    still = sea.sea if isinstance(sea, SpreadSea) else sea
    pairs, gamma = shipped_pairs(), still.gamma if isinstance(still, SeaState) else 5.0
    seas = {name: entry["found"]["seas"] for name, entry in tuned_sets(PAIR).items()}
    gammas = {name: own[name]["sea"]["gamma"] for name, own in seas.items() if name in own}  # not those of real water
    nearest = min(gammas, key=lambda name: abs(math.log(gammas[name] / gamma)))
    length = 1.0 if plant is None else plant.parameters.length_scale
    cc, cg = pairs[nearest] if length == 1.0 else (value * growth("Nms", length) for value in pairs[nearest])
    return Yardstick(cc, cg, searched=False, words=why)


def _kept(
    wanted: Search, workers: int | None, quiet: bool, say: Callable[[str], None], lengths: Lengths | None = None
) -> Yardstick:
    """Search a pair and keep it."""
    say("Searching the best constant pair of this sea and device, once")
    found = search_pair(wanted, workers or os.cpu_count() or 1, quiet, lengths)
    told = {"law": PAIR, "case": str(wanted.sea)}
    _store().save(wanted.key, {"pair": plain(asdict(found)), "content": wanted.content()}, None, told)
    return found


def search_pair(wanted: Search, workers: int, quiet: bool = True, lengths: Lengths | None = None) -> Yardstick:
    """Search a pair, without the limit of motion where none keeps it; nothing is looked up and nothing kept."""
    plant, sea, settings, goal, budget, seeds = wanted

    def search(goal: Goal) -> Any:
        return best_pair(plant, sea, budget, seeds, goal, settings, workers, "best constant pair", quiet, lengths)

    best, notes = search(goal), []
    if not best.met and max(best.means["phi1_p98"], best.means["phi3_p98"]) > goal.motion:
        best = search(replace(goal, motion=math.inf))
        notes.append("no pair keeps the motion limit, this is the best without it")
    if not best.met:
        notes.append(f"none holds lock in {100 * goal.locked:g} % of the tuning realisations, this one comes nearest")
    words = "; ".join([f"searched on seeds {seeds[0]} to {seeds[-1]} with {best.spent:.3g} s", *notes])
    return Yardstick(best.cc, best.cg, True, words, wanted.key)


def _known(wanted: Search) -> Yardstick | None:
    return _shipped(wanted.key) or _read(wanted)


def _shipped(key: str) -> Yardstick | None:
    for name, entry in tuned_sets(PAIR).items():
        found = entry["found"]
        if found.get("key") == key:
            span = found["seeds"]
            words = f"searched on seeds {span['first']} to {span['last']} with {found['spent_s']:.3g} s"
            return Yardstick(*shipped_pairs()[name], searched=True, words=words, key=key)
    return None


def _store() -> Store:
    cache = cache_folder()
    return Store(cache / FOLDER if cache else None)


def _read(wanted: Search) -> Yardstick | None:
    """Pair that was found before; what is not what was written, or of other content, is searched again."""
    store = _store()
    record = store.load(wanted.key)
    store.tell()
    if record is None or record.content.get("content") != wanted.content():
        return None
    try:
        found = Yardstick(**{item.name: record.content["pair"][item.name] for item in fields(Yardstick)})
    except (KeyError, TypeError):
        return None
    pair = is_finite(found.cc) and is_finite(found.cg) and found.cc >= 0.0 and found.cg >= 0.0
    told = isinstance(found.words, str) and found.searched is True and found.key == wanted.key
    return found if pair and told else None
