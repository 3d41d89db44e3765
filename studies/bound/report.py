"""The report on the bound: search each window, run the laws through it, draw, write."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import cloudpickle
import numpy as np

from gyroctl.devices.identity import device_record
from gyroctl.engine.ahead import Piece, do_ahead
from gyroctl.engine.cluster import connected
from gyroctl.engine.state import RUNS
from gyroctl.engine.steps import Asked, Steps, planned
from gyroctl.errors import InputError
from gyroctl.harness.law_fingerprint import law_fingerprint, value_fingerprint
from gyroctl.harness.protocol import Law
from gyroctl.harness.seed_ledger import ledger
from gyroctl.harness.travelling import by_value, modules_of
from gyroctl.plant import Plant
from gyroctl.provenance import made
from gyroctl.simulation.metrics import Record
from gyroctl.simulation.progress import Progress
from gyroctl.studies.bound.cap import momentum, momentum_cap
from gyroctl.studies.bound.cut import Cut, lag_of
from gyroctl.studies.bound.draw import picture
from gyroctl.studies.bound.model import in_own_units, model_cut
from gyroctl.studies.bound.outcome import Outcome, summary
from gyroctl.studies.bound.search import FULL, Effort, Found, best_found, beyond_linear, loosened, ticks
from gyroctl.studies.bound.window import Plan
from gyroctl.studies.style import save, styled
from gyroctl.waves import SeaState
from gyroctl.writing import Kept, plain


def bound_report(
    plant: Plant,
    sea: SeaState,
    seeds: Sequence[int],
    duration: float,
    laws: Mapping[str, Law],
    out: Path,
    free: bool = False,
    effort: Effort = FULL,
    quiet: bool = False,
    lag: float | None = None,
    motion: float | None = None,
    scheduler: Any = None,
) -> dict[str, Any]:
    """Find the bound of each window and what part of it the laws reach.

    Parameters
    ----------
    plant : Plant
        The device.
    sea : SeaState
        The sea.
    seeds : sequence of int
        One window each.
    duration : float
        Of a window. [s]
    laws : mapping of str to Law
        Laws by name; for a device of another length those of its model, see `gyroctl.devices.scaling.at_model_size`.
    out : Path
        Folder for bound.json and bound.png; made where it is missing.
    free : bool
        Also the bound with a generator power that is free in each interval.
    effort : Effort
        How hard to search.
    quiet : bool
        No progress bar.
    lag : float, optional
        Time constant of the coupling, by default as `cut` has it. [s]
    motion : float, optional
        Limit of the 98 % motion, by default as `cut` has it. [rad]
    scheduler : str or dask.distributed.Client, optional
        Address of a Dask scheduler whose workers search the windows; the same bits.

    Returns
    -------
    dict
        What bound.json holds.

    Raises
    ------
    ConnectionError
        Where the scheduler is lost; windows that were searched are kept.
    InputError
        For seeds, duration, folder or scheduler that cannot be used; nothing is written then. Where no window at all
        could be searched: bound.json then names why. A window that fails among others is named under ``failed``.
    """
    begin = time.monotonic()
    if out.exists() and not out.is_dir():
        raise InputError("out", str(out), "is not a folder", "Give the name of a folder")
    if not seeds or len(set(seeds)) < len(seeds):
        raise InputError("seeds", list(seeds), "must be different seeds, one at least", "Give for example 1,2,3")
    cuts = [model_cut(plant, sea, seed, duration, lag, motion) for seed in seeds]
    length, duration = plant.parameters.length_scale, cuts[0].duration * plant.parameters.time_scale
    stages = ticks(plant, len(laws), effort, free) + len(laws) + 2
    request = {"gamma": sea.gamma, "hs": sea.hs, "wp": sea.wp, "seeds": list(seeds), "duration_s": duration}
    request |= {"device": plant.name, "lag_s": lag_of(plant, lag), "laws": list(laws)}
    request["device_record"] = device_record(plant)
    request |= {"motion_limit_rad": motion, "beyond_linear": beyond_linear(plant)}
    request["seed_states"] = ledger().states(seeds)
    content: dict[str, Any] = {**made(), "request": request, "meaning": MEANING, "windows": []}
    kept, windows = Kept(content, out / "bound.json"), []
    refused: InputError | None = None
    steps = [_steps(one, laws, free, effort, out / RUNS) for one in cuts]
    asked = [Asked(own, _name(one), "bound", one.waves.seed) for own, one in zip(steps, cuts, strict=True)]
    with (
        connected(scheduler) if scheduler is not None else nullcontext() as client,
        planned(out / RUNS, plant.name, asked),
        Progress("bound", stages * len(cuts), quiet) as progress,
    ):
        if client is not None:
            do_ahead(client, _pieces(steps, cuts, laws, free, effort), partial(progress.advance, stages - 1))
        for own, one in zip(steps, cuts, strict=True):
            with kept.stage(f"seed {one.waves.seed}"):
                try:
                    found = own(_name(one), partial(_searched, one, laws, free, effort, progress.advance))
                    windows.append(Outcome(one, *found))
                except InputError as error:
                    refused = error
                    raise
                content["windows"] = [in_own_units(window.record(), length) for window in windows]
                content["summary"] = summary(content["windows"])
            progress.advance()
    if not windows:
        raise refused or InputError(
            "seeds", list(seeds), f"no window was searched: {kept.failed}", "Correct what failed"
        )
    with kept.stage("picture"), styled():
        save(picture(windows, sea, duration, plant), out / "bound.png")
    content["seconds"] = round(time.monotonic() - begin, 1)
    kept.write()
    return dict(plain(content))


class Window(NamedTuple):
    """What an `Outcome` holds beside its cut."""

    bounds: dict[str, Found]
    laws: dict[str, Record]
    momentum: float
    cap_w: float


MODULES = (__name__, "gyroctl.studies.bound.search")
"""What computes a window."""

KINDS = (Window, Found, Record, Plan)
"""What it is made of."""

MEANING = {
    "harvest_w": "mean power generated and change of the flywheel's energy, over the whole window",
    "smooth": "best found with perfect foresight and constant generator power: a lower estimate of the true bound; "
    "beyond the linear plant a law's own run stands for it whatever its power",
    "free": "best found with perfect foresight and a generator power that is free every 0.1 s",
    "cap_w": "what nothing inside the float can exceed in absorbed_w with an angular momentum of momentum_max_nms; "
    "none is known beyond the linear plant",
    "linear_cap_w": "that of the linear float in the same waves, with the same momentum: no limit of this plant",
    "motion_limits_rad": "limits of the 98 % motion; asked for (motion_limit_rad), else 0.35 in the linear plant, and "
    "beyond it for phi1 the 98 % of the lead-in's constant pair through the window where that is more, for phi3 0.25",
    "absorbed_w": "generated, slipped and stored inside",
    "fraction": "harvest of the law over that of the bound, same waves and same state at the start",
}


def table(content: Mapping[str, Any]) -> list[str]:
    """Lines of the table.

    Parameters
    ----------
    content : mapping
        What bound.json holds.

    Returns
    -------
    list of str
        For a terminal.
    """
    whole = content["summary"]
    asked, limits = content["request"], whole["motion_limits_rad"]
    told = ", ".join(f"{name} {_range(limits[name])} rad" for name in ("phi1", "phi3"))
    lines = [
        f"{asked['device']}; coupling lag {1e3 * asked['lag_s']:g} ms; limits of the 98 % motion: {told}",
        f"{'':24} {'harvest':>9} {'CV':>6} {'98 % phi1':>10} {'of bound':>9} {'lowest':>7}  lock, motion",
    ]
    for name, bound in whole["bounds"].items():
        lines.append(
            f"{'best found, ' + name:24} {bound['harvest_w']:7.2f} W {bound['power_cv']:6.3f} "
            f"{bound['phi1_p98']:6.2f} rad"
        )
    for name, law in whole["laws"].items():
        lines.append(
            f"{name[:24]:24} {law['harvest_w']:7.2f} W {law['power_cv']:6.3f} {law['phi1_p98']:6.2f} rad "
            f"{100 * law['fraction']['smooth']:7.1f} % {100 * law['fraction_lowest']['smooth']:5.1f} %  "
            f"{law['locked']}/{law['runs']}, {law['within_motion_limit']}/{law['runs']}"
        )
    taken = f"the best found takes {whole['bounds']['smooth']['absorbed_w']:.2f} W, slip included."
    if whole["cap_w"] is not None:
        lines.append(f"Cap on what can be taken from the float: {whole['cap_w']:.2f} W; {taken}")
    else:
        words = "No cap is known in this plant; that of the linear float in the same waves, no limit here:"
        lines.append(f"{words} {whole['linear_cap_w']:.2f} W; {taken}")
    return lines


def _range(ends: Sequence[float]) -> str:
    """Least and most, or the one number that both are."""
    low, high = (f"{end:.2f}" for end in ends)
    return low if low == high else f"{low} to {high}"


def _name(one: Cut) -> str:
    return f"seed {one.waves.seed}"


def _steps(one: Cut, laws: Mapping[str, Law], free: bool, effort: Effort, folder: Path) -> Steps:
    """Keep what is found in a window: by the same code, for the same laws and effort."""
    known = {name: law_fingerprint(law) for name, law in laws.items()}
    plant, waves = one.plant, value_fingerprint(one.waves.moments, one.waves.elevation, one.waves.dt, one.start)
    given = value_fingerprint(plant, waves, one.duration, one.settings, one.motion, list(known.items()), free, effort)
    return Steps(folder, given if waves and all(known.values()) else "", MODULES, KINDS, one.plant.name)


def _pieces(
    steps: Sequence[Steps], cuts: Sequence[Cut], laws: Mapping[str, Law], free: bool, effort: Effort
) -> list[Piece]:
    """Windows as pieces of work for other machines, where a law is known by its content: its file is here."""
    sent = {name: by_value(law) for name, law in laws.items()}
    modules = tuple(sorted({module for law in laws.values() for module in modules_of(law)}))
    return [
        Piece(own, _name(one), searched_there, (one, sent, free, effort), modules)
        for own, one in zip(steps, cuts, strict=True)
    ]


def searched_there(one: Cut, sent: Mapping[str, bytes], free: bool, effort: Effort) -> Window:
    """Search a window on a worker, with laws that are packed."""
    return _searched(one, {name: cloudpickle.loads(law) for name, law in sent.items()}, free, effort, lambda: None)


def _searched(one: Cut, laws: Mapping[str, Law], free: bool, effort: Effort, tick: Callable[[], None]) -> Window:
    runs = {}
    for name, law in laws.items():
        runs[name] = one.run(law, name)
        tick()
    smooth = best_found(one, runs, effort, tick)
    bounds = {"smooth": smooth}
    if free:
        bounds["free"] = loosened(one, smooth, runs, effort, tick)
    counted = {name: one.counted(run) for name, run in runs.items()}
    records = [*counted.values(), *(found.record for found in bounds.values())]
    most = max(float(np.linalg.norm(momentum(one.plant, record.states), axis=0).max()) for record in records)
    cap = momentum_cap(one.plant, one.waves, one.start, one.duration, most)
    tick()
    return Window(bounds, counted, most, cap)
