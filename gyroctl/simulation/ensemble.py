"""Many realisations times many constant pairs, sixteen runs side by side on each core.

Every run gives the same bits alone, in any company and on any number of cores: the lanes share nothing, and the number
of steps per interval is that of the single run.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import groupby
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.plant import Plant
from gyroctl.plant.alone import run_alone
from gyroctl.plant.beyond import base_rows
from gyroctl.plant.compiled import aligned
from gyroctl.plant.kernel import RECORDED, rows, run_lanes, slip_rate, steps_for
from gyroctl.plant.pack_run import run_packs
from gyroctl.plant.packs import LANES, ROOM
from gyroctl.simulation.balance import spent
from gyroctl.simulation.lock import loss_time
from gyroctl.simulation.progress import Progress
from gyroctl.simulation.quantile import size_quantile
from gyroctl.waves import Sea, Synthesis, prepare
from gyroctl.waves.channels import Response
from gyroctl.waves.wetted import held_moments

UNSTABLE = 2.5
"""Product of step and slip rate beyond which Runge-Kutta 4 is unstable."""

PERIOD = 0.1
"""Spacing of the samples where none is asked for, for a device of the size of Table 1. [s]"""

CHUNK = 512
"""Samples of the waves that are put side by side at a time, so that what is moved stays in the cache."""


@dataclass(frozen=True)
class EnsembleRun:
    """Results of an ensemble, each of shape (pairs, seeds).

    Parameters
    ----------
    loss_time : array
        Time of the first stall, NaN where lock was kept. [s]
    mean_power : array
        Mean electrical power over the scored time, `generated_w` of the metrics. [W]
    power_cv : array
        Its coefficient of variation. [-]
    phi1_p98, phi3_p98 : array
        98 % of the motion. [rad]
    ledger_residual : array
        Energy ledger over the scored time, relative to the wave input; NaN where it was not kept. [-]
    slip_loss_w, wave_input_w : array
        Mean powers; likewise. [W]
    """

    loss_time: NDArray[np.float64]
    mean_power: NDArray[np.float64]
    power_cv: NDArray[np.float64]
    phi1_p98: NDArray[np.float64]
    phi3_p98: NDArray[np.float64]
    ledger_residual: NDArray[np.float64]
    slip_loss_w: NDArray[np.float64]
    wave_input_w: NDArray[np.float64]

    @property
    def locked(self) -> NDArray[np.bool_]:
        """Whether lock was kept, (pairs, seeds)."""
        return np.isnan(self.loss_time)


class _Job(NamedTuple):
    steps: int
    runs: tuple[tuple[int, int], ...]  # (pair, seed) of each lane


_Done = tuple[_Job, NDArray[np.float64]]


def run_ensemble(
    plant: Plant,
    sea: Sea,
    pairs: Sequence[tuple[float, float]],
    seeds: Sequence[int],
    start: NDArray[np.float64],
    duration: float = 2000.0,
    blend: float = 100.0,
    dt: float | None = None,
    period: float | None = None,
    workers: int = 2,
    sense: int = 1,
    title: str = "ensemble",
    quiet: bool = False,
    ledger: bool = True,
) -> EnsembleRun:
    """Simulate every constant pair on every realisation.

    Parameters
    ----------
    plant : Plant
        The device.
    sea : Sea
        The waves.
    pairs : sequence of (cc, cg)
        Constant controls. [Nms]
    seeds : sequence of int
        One realisation each; the same for every pair.
    start : (n,) array
        State at t = 0, commonly the locked orbit of the equivalent regular wave. [rad], [rad/s]
    duration, blend : float
        Length of the run and of the blend from the regular wave; scoring starts after the blend. [s]
    dt, period : float, optional
        Longest step, and spacing of the samples of ring angle, speed and motion; 0.01 and 0.1 s at the size of Table 1.
        [s]
    workers : int
        Threads.
    sense : {1, -1}
        Sense of rotation of the lock.
    title, quiet
        Of the progress bar.
    ledger : bool
        Whether the energy ledger is kept. Without it `ledger_residual`, `slip_loss_w` and `wave_input_w` are NaN, and
        all else is the same to the last bit, sooner.

    Returns
    -------
    EnsembleRun

    Raises
    ------
    InputError
        For controls below zero or a step too long for the slip.
    """
    dt = plant.step if dt is None else dt
    period = PERIOD * plant.parameters.time_scale if period is None else period
    check_pairs(plant, pairs, dt)
    synthesis = prepare(plant, sea, duration)
    jobs = _jobs(plant, pairs, seeds, dt, period)
    results = np.full((8, len(pairs), len(seeds)), np.nan)
    response = synthesis.prepared(plant) if len(plant.channels) > 2 else None
    every = _Every(
        plant,
        synthesis,
        response,
        [],
        start,
        round(duration / period),
        round(blend / period),
        blend,
        period,
        sense,
        ledger or None,
    )

    def work(job: _Job) -> _Done:
        controls = np.array([pairs[pair] for pair, _ in job.runs], np.float64)
        return job, every.run(job.steps, controls, [seeds[seed] for _, seed in job.runs])

    with ThreadPoolExecutor(workers) as pool, Progress(title, len(pairs) * len(seeds), quiet) as progress:
        for future in _bounded(pool, work, jobs, 2 * workers):
            job, values = future.result()
            for lane, (pair, seed) in enumerate(job.runs):
                results[:, pair, seed] = values[:, lane]
            progress.advance(len(job.runs))
    return EnsembleRun(*results)


def check_pairs(plant: Plant, pairs: Sequence[tuple[float, float]], dt: float) -> None:
    """Refuse controls below zero and steps that are unstable: h (N^2/J2 + 1/J4) cc > 2.5."""
    for cc, cg in pairs:
        for name, value in (("cc", cc), ("cg", cg)):
            if not (np.isfinite(value) and value >= 0.0):
                problem = "must be zero or positive: both controls only dissipate"
                raise InputError(name, value, problem, f"Give {name} >= 0 in Nms")
        check_step(plant, cc, dt)


def check_step(plant: Plant, cc: float, dt: float) -> None:
    """Refuse a step that is no positive number or too long for the slip at `cc`."""
    if not (np.isfinite(dt) and dt > 0.0):
        raise InputError("run.dt", dt, "must be positive", "Give the step in seconds, for example 0.01")
    rate = float(slip_rate(plant.rolling.coefficients, cc))
    if dt * rate > UNSTABLE:
        problem = f"the step is unstable for the slip: h * {rate:.0f}/s = {dt * rate:.2f} > {UNSTABLE}"
        raise InputError("run.dt", dt, problem, f"Give dt <= {UNSTABLE / rate:.4f} s, or a smaller cc (now {cc})")


def _jobs(
    plant: Plant, pairs: Sequence[tuple[float, float]], seeds: Sequence[int], dt: float, period: float
) -> list[_Job]:
    """Fill the lanes: runs of the same number of steps may stand side by side, seeds together to share their waves."""

    def steps(run: tuple[int, int]) -> int:
        return int(
            steps_for(period, dt, plant.parameters.time_scale * float(slip_rate(plant.coefficients, pairs[run[0]][0])))
        )

    runs = sorted(((p, s) for s in range(len(seeds)) for p in range(len(pairs))), key=steps)
    jobs = []
    for count, group in groupby(runs, key=steps):
        alike = list(group)
        jobs += [_Job(count, tuple(alike[i : i + LANES])) for i in range(0, len(alike), LANES)]
    return jobs


class _Room(NamedTuple):
    """Memory of one job, used again by the next one: fresh memory would cost as much as filling it."""

    record: NDArray[np.float64]  # (len(RECORDED), intervals + 1, LANES)
    waves: NDArray[np.float64]  # flat, as the kernel takes them
    moments: NDArray[np.float64]  # (LANES, 2, n), those of each seed where there are no further signals


class _Every(NamedTuple):
    """What all jobs of an ensemble have in common."""

    plant: Plant
    synthesis: Synthesis
    response: Response | None  # further signals of the plant before their phases, where it has any
    rooms: list[_Room]  # those that no job uses now
    start: NDArray[np.float64]
    intervals: int
    first: int  # interval at which scoring starts
    blend: float
    period: float
    sense: int
    ledger: bool | None  # None for the generator's row alone

    @contextmanager
    def room(self) -> Iterator[_Room]:
        """Lend a room to a job."""
        n, channels = self.synthesis.grid.n, len(self.plant.channels)
        try:
            room = self.rooms.pop()
        except IndexError:
            alone = LANES if self.response is None else 0
            record = aligned(len(RECORDED) * (self.intervals + 1) * LANES).reshape(len(RECORDED), -1, LANES)
            k = self.plant.coefficients
            waves = n * channels * LANES if k.beyond is not None or rows(k) > ROOM else 0
            room = _Room(record, aligned(waves), np.empty((alone, 2, n)))
        yield room
        self.rooms.append(room)

    def run(self, steps: int, controls: NDArray[np.float64], seeds: Sequence[int]) -> NDArray[np.float64]:
        """Run one job: a pair of `controls` (used, 2) and a seed for each lane; results (8, used)."""
        with self.room() as room:
            return self._run(room, steps, controls, seeds)

    def _run(self, room: _Room, steps: int, controls: NDArray[np.float64], seeds: Sequence[int]) -> NDArray[np.float64]:
        plant, intervals, first, pace = self.plant, self.intervals, self.first, self.plant.parameters.time_scale
        k, n, used = plant.coefficients, len(plant.labels), len(seeds)
        lane_of = np.minimum(np.arange(LANES), used - 1)  # idle lanes repeat the last run
        unique = list(dict.fromkeys(seeds))
        cc, cg = np.ascontiguousarray(controls[lane_of].T)
        first_state = np.zeros((rows(k), LANES))
        first_state[:n] = self.start[:, None]
        y = first_state.ravel()
        record, marked = room.record, y.copy()
        of_lane = [unique.index(seeds[lane]) for lane in lane_of]
        if plant.slips:  # each run takes steps of its own
            self._one_by_one(y, steps, controls, seeds, record, marked)
        elif k.beyond is None and rows(k) <= ROOM:
            dt = self.synthesis.grid.dt
            signals = self.synthesis.moments_batch(unique, self.blend, room.moments[: len(unique)])
            of = np.array(of_lane, np.int64)
            run_packs(y, k, cc, cg, self.period, steps, signals, of, dt, record, first, marked, self.ledger)
        else:
            waves = self._side_by_side(room, unique, of_lane)
            held = held_moments(plant, self.synthesis, unique, of_lane, self.blend)
            run_lanes(y, k, cc, cg, self.period, steps, waves, self.synthesis.grid.dt, record, first, marked, held)
        phi1, phi3, psi, speed = record
        end, mark = y.reshape(-1, LANES), marked.reshape(-1, LANES)
        energy = dict(zip(plant.ledger, end[n:] - mark[n:], strict=True))
        if self.ledger is None:
            energy = {name: value if name == "generator" else value * np.nan for name, value in energy.items()}
        stored = plant.stored_energy(end[:n]) - plant.stored_energy(mark[:n])
        scored = (intervals - first) * self.period
        worth = plant.parameters.generator_efficiency
        mean = worth * energy["generator"] / scored
        power = worth * cg * speed[first:] ** 2
        edge = 0.5 * (power[0] ** 2 + power[-1] ** 2)
        second = (np.sum(power**2, axis=0) - edge) / (intervals - first)
        with np.errstate(invalid="ignore", divide="ignore"):
            results = (
                pace * loss_time(psi, self.period / pace, self.synthesis.sea.wp * pace, self.sense),
                mean,
                np.sqrt(np.maximum(second - mean**2, 0.0)) / mean,
                size_quantile(phi1[first:], 0.98),
                size_quantile(phi3[first:], 0.98),
                np.abs(energy["wave_input"] - spent(energy) - stored) / np.abs(energy["wave_input"]),
                energy["slip"] / scored,
                energy["wave_input"] / scored,
            )
        return np.stack(results)[:, :used]

    def _one_by_one(
        self,
        y: NDArray[np.float64],
        steps: int,
        controls: NDArray[np.float64],
        seeds: Sequence[int],
        record: NDArray[np.float64],
        marked: NDArray[np.float64],
    ) -> None:
        """Fill the lanes in use by runs of their own."""
        k, grid = self.plant.coefficients, self.synthesis.grid
        ends, marks = y.reshape(-1, LANES), marked.reshape(-1, LANES)
        unique = list(dict.fromkeys(seeds))
        found = dict(zip(unique, self._signals(unique), strict=True))
        for lane, seed in enumerate(seeds):
            waves = np.ascontiguousarray(found[seed].T).ravel()
            held = held_moments(self.plant, self.synthesis, [seed], blend=self.blend)
            own, mark = ends[:, lane].copy(), np.empty(ends.shape[0])
            course = np.empty((len(RECORDED), self.intervals + 1))
            pair = np.ascontiguousarray(controls[lane][:, None])
            run_alone(own, k, pair, self.period, steps, waves, grid.dt, course, self.first, mark, held)
            record[:, :, lane], ends[:, lane], marks[:, lane] = course, own, mark
        record[:, :, len(seeds) :] = record[:, :, len(seeds) - 1 : len(seeds)]

    def _side_by_side(self, room: _Room, seeds: Sequence[int], of_lane: Sequence[int]) -> NDArray[np.float64]:
        """Signals of all lanes as the kernel takes them, see `kernel.interpolate`; `of_lane` counts in `seeds`."""
        plant, n = self.plant, self.synthesis.grid.n
        if self.response is None:
            of_seed = self.synthesis.moments_batch(seeds, self.blend, room.moments[: len(seeds)])
            both = room.waves.reshape(n, 2, -1)
            for at in range(0, n, CHUNK):
                both[at : at + CHUNK] = of_seed[of_lane, :, at : at + CHUNK].transpose(2, 1, 0)
            return room.waves
        rows, count = base_rows(plant.coefficients.beyond), len(of_lane)
        waves = room.waves.reshape(n, -1)
        for seed, signals in enumerate(self._signals(seeds)):
            samples = np.ascontiguousarray(signals.T)
            nodes = samples.shape[1] - rows
            for lane in np.flatnonzero(np.equal(of_lane, seed)):
                waves[:, lane : rows * count : count] = samples[:, :rows]
                waves[:, rows * count + lane * nodes :][:, :nodes] = samples[:, rows:]
        return room.waves

    def _signals(self, seeds: Sequence[int]) -> Iterable[NDArray[np.float64]]:
        """Signals of each seed in turn, (channels, n)."""
        if self.response is None:
            return self.synthesis.moments_batch(seeds, self.blend)
        return self.synthesis.each_signals(self.plant, seeds, self.blend, self.response)


def _bounded(
    pool: ThreadPoolExecutor, work: Callable[[_Job], _Done], jobs: Sequence[_Job], ahead: int
) -> Iterator[Future[_Done]]:
    """Yield finished futures with at most `ahead` jobs under way, so that memory stays small."""
    pending: set[Future[_Done]] = set()
    for job in jobs:
        pending.add(pool.submit(work, job))
        if len(pending) >= ahead:
            done, pending = wait(pending, return_when=FIRST_COMPLETED)
            yield from done
    yield from pending
