"""The two ensembles: from rest, and through a forced loss."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.controllers.supervisor import Rules, wrap
from gyroctl.devices import zhang2017
from gyroctl.harness.actuation import Actuators
from gyroctl.harness.protocol import LawError
from gyroctl.harness.run import Settings, lead_in
from gyroctl.harness.together import Loop, Outcome, pieces, run_together
from gyroctl.plant import Plant
from gyroctl.plant.equations import LEDGER, OMEGA_RATE, PHI1, PHI3, PSI, PSI_RATE
from gyroctl.simulation.lock import THRESHOLD, WINDOW
from gyroctl.simulation.metrics import evaluate
from gyroctl.simulation.progress import Progress
from gyroctl.studies.startup.fault import stuck
from gyroctl.waves import Sea, WaveRealisation, realise

CG_MIN = -0.02
"""The machine as a motor has the range that it has as a generator. [Nms]"""

EVERY = 10
"""Samples of the actuators to one of the kept time series."""


class Case(NamedTuple):
    """One law in one ensemble."""

    law: str  # name of the wrapped law
    columns: dict[str, NDArray[np.float64]]  # (runs,) numbers by run; the name ends in the unit where there is one
    # time_s (n,), net_energy_j (runs, n), and of the first run ring_speed, flywheel_speed, phi1 (n,)
    # [s], [J], [rad/s], [rad]
    series: dict[str, NDArray[np.float64]]


class Ensemble(NamedTuple):
    """What is run, from rest or through a forced loss."""

    laws: Mapping[str, Any]  # wrapped in the supervisor here
    seeds: Sequence[int]  # realisations
    sea: Sea  # the sea of all of them
    rules: Rules | None = None  # of the supervisor
    dt: float = 0.01  # longest step [s]
    quiet: bool = False  # no progress


def rest_runs(asked: Ensemble, duration: float) -> list[Case]:
    """Start at rest in the irregular sea; runs of `duration` [s].

    Parameters
    ----------
    asked : Ensemble
        Laws, seeds and sea.
    duration : float
        Length of the runs. [s]

    Returns
    -------
    list of Case
        One for each law.

    Raises
    ------
    InputError
        For a law, a seed or a duration that cannot be used.
    """
    wrapped = {name: wrap(law, asked.rules) for name, law in asked.laws.items()}
    return _cases(asked, wrapped, duration, "rest")


def lost_runs(asked: Ensemble, duration: float) -> list[Case]:
    """Start locked; in the middle of the run the generator is stuck at its limit until the ring stalls.

    Parameters
    ----------
    asked : Ensemble
        Laws, seeds and sea.
    duration : float
        Length of the runs. [s]

    Returns
    -------
    list of Case
        One for each law.

    Raises
    ------
    InputError
        For a law, a seed or a duration that cannot be used.
    """
    wrapped = {name: stuck(wrap(law, asked.rules)) for name, law in asked.laws.items()}
    return _cases(asked, wrapped, duration, "locked")


def _cases(asked: Ensemble, laws: Mapping[str, Any], duration: float, start: str) -> list[Case]:
    plant, cases = zhang2017(), []
    settings = Settings(dt=asked.dt, start=start, actuators=Actuators(cg_min=CG_MIN))
    with Progress(
        "from rest" if start == "rest" else "forced loss", len(laws) * len(asked.seeds), asked.quiet
    ) as progress:
        for name, law in laws.items():
            rows, series = [], []
            for part in pieces(len(asked.seeds)):
                waves = [lead_in(realise(plant, asked.sea, seed, duration), settings) for seed in asked.seeds[part]]
                for each, run in zip(waves, run_together(plant, [Loop(law, w, settings) for w in waves]), strict=True):
                    row, kept = _numbers(plant, run, each, settings)
                    rows.append(row)
                    series.append(kept)
                    progress.advance()
            columns = {key: np.array([row[key] for row in rows]) for key in rows[0]}
            kept = {"time_s": series[0]["time_s"], "net_energy_j": np.stack([s["net_energy_j"] for s in series])}
            kept |= {key: series[0][key] for key in ("ring_speed", "flywheel_speed", "phi1")}
            cases.append(Case(name, columns, kept))
    return cases


def _numbers(
    plant: Plant, run: Outcome, waves: WaveRealisation, settings: Settings
) -> tuple[dict[str, float], dict[str, NDArray[np.float64]]]:
    if isinstance(run, LawError):
        raise run
    record, timing = run
    period, states, wp = record.period, record.states, waves.sea.wp
    moment, rest = waves.moments[1], settings.start == "rest"
    found = evaluate(plant, record, moment, waves.dt, wp, settings.score_from, np.nan, from_rest=rest)
    span = round(WINDOW / period)
    slow = states[span:, PSI] - states[:-span, PSI] < THRESHOLD * wp * WINDOW  # windows that begin at each sample
    last = float(np.flatnonzero(slow)[-1] + 1) * period if np.any(slow) else 0.0  # begin of the first lasting lock
    lasting = last + WINDOW if last + WINDOW < waves.duration else np.nan
    begin = timing.counters.get("fault_ends", 0.0)
    net = states[:, len(plant.labels) + LEDGER.index("generator")]
    after = round(lasting / period) if np.isfinite(lasting) else states.shape[0] - 1
    phi1, phi3 = np.abs(states[:, PHI1]), np.abs(states[:, PHI3])
    row = {
        "seed": float(waves.seed),
        "lost": float(np.any(slow)),
        "fault_ends_s": begin,
        "locked_after_s": lasting - begin if np.any(slow) else 0.0,
        "payback_s": found["payback_time"],
        "motor_j": found["motor_energy"],
        "net_power_w": found["generated_w"],
        "mean_power_w": found["mean_power"],
        **{name: found[name] for name in ("stored_w", "turns_kept", "cycle_slips", "outside_share")},
        "availability": found["availability"],
        "phi1_p98_rad": float(np.quantile(phi1[after:], 0.98)),
        "phi1_max_rad": float(phi1.max()),
        "phi3_max_rad": float(phi3.max()),
        "ledger_residual": found["ledger_residual"],
    }
    names = ("starts", "pulls", "catches", "unloads", "time_start", "time_pull", "time_produce", "time_unload")
    row |= {name: float(timing.counters[name]) for name in names}
    keep = slice(None, None, EVERY)
    return row, {
        "time_s": np.asarray(np.arange(states.shape[0])[keep] * period, np.float64),
        "net_energy_j": net[keep],
        "ring_speed": states[keep, PSI_RATE],
        "flywheel_speed": states[keep, OMEGA_RATE],
        "phi1": states[keep, PHI1],
    }
