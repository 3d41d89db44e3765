"""The runs: both devices with the same gain, and each with its own best constant controls, sea by sea."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.comparison.compare import compare
from gyroctl.devices import zhang2017
from gyroctl.errors import InputError
from gyroctl.harness.constant_pairs import scan
from gyroctl.harness.yardstick import PAIR, Yardstick
from gyroctl.plant import Plant
from gyroctl.statistics import Estimate, Share, bootstrap_mean, holm, in_words, paired_difference, wilson
from gyroctl.tuning.yardstick import BUDGET, find_yardstick
from gyroctl.waves import SeaState, realise

CC = 0.052
"""The paper's coupling, for the comparison at the same gain. [Nms]"""

GAINS = (1e-4, 2e-4, 3.5e-4, 5e-4, 7.5e-4, 1e-3, 1.5e-3, 2e-3)
"""Generator gains of that comparison. [Nms]"""

LEVEL = 0.05
"""Of the tests, over all seas together."""

LONGER, POWER = ("longer", "shorter"), ("more", "less")


class SameGain(NamedTuple):
    """Both devices with one gain in one sea."""

    gamma: float  # peak enhancement of the sea [1]
    hs: float  # [m]
    cg: float  # [Nms]
    magnetic: Share  # of the runs that hold lock
    rigid: Share
    longer: Estimate  # time in lock with the coupling less that without, on the same waves [s]
    p_holm: float  # corrected over all gains and seas [1]
    words: str  # what the difference says


class OneDevice(NamedTuple):
    """One device with its best constant controls in one sea."""

    cc: float  # 0 for the rigid one [Nms]
    cg: float  # [Nms]
    found: str  # how the controls were found
    lock: Share  # of the runs that hold lock
    turns_kept: float  # mean [1]
    cycle_slips: float  # mean [1/1000 waves]
    power: Estimate  # generated and stored [W]
    cv: float  # of the power [1]
    phi1_p98: float  # mean of the 98 % motion [rad]


class AtBest(NamedTuple):
    """Each device with its own best constant controls in one sea."""

    gamma: float  # peak enhancement of the sea [1]
    hs: float  # [m]
    magnetic: OneDevice
    rigid: OneDevice
    gain: Estimate  # power with the coupling less that without, on the same waves [W]
    p_holm: float  # corrected over all seas [1]
    words: str  # what the difference says


@dataclass(frozen=True)
class Answer:
    """What the coupling is worth, sea by sea.

    Parameters
    ----------
    gammas : tuple of float
        Peak enhancements of the seas. [1]
    heights : tuple of float
        Significant wave heights. [m]
    seeds : tuple of int
        Realisations that judge, the same for both devices.
    duration : float
        Length of a run. [s]
    same_gain : tuple of SameGain
        Both devices with one gain: the paper's comparison.
    at_best : tuple of AtBest
        Each with its own best controls, found on other realisations.
    """

    gammas: tuple[float, ...]
    heights: tuple[float, ...]
    seeds: tuple[int, ...]
    duration: float
    same_gain: tuple[SameGain, ...]
    at_best: tuple[AtBest, ...]

    @property
    def sentences(self) -> list[str]:
        """The answer in words, one sentence for each of its two halves."""
        same, best = ([case.words for case in cases] for cases in (self.same_gain, self.at_best))
        return [
            f"With the same gain the coupled device holds lock {_counted(same, LONGER)} of {len(same)} cases.",
            f"Each at its own best constant controls, it gives {_counted(best, POWER)} of {len(best)} seas.",
        ]


def _counted(said: Sequence[str], words: tuple[str, str]) -> str:
    first, second = (sum(one == word for one in said) for word in words)
    return (
        f"{words[0]} in {first}, {words[1]} in {second} and not distinguishably either in {len(said) - first - second}"
    )


def compare_connections(
    gammas: Sequence[float] = (1.0, 5.0, 50.0),
    heights: Sequence[float] = (0.2, 0.283, 0.36),
    seeds: Sequence[int] = range(1, 65),
    duration: float = 2000.0,
    plant: Plant | None = None,
    gains: Sequence[float] = GAINS,
    budget: float = BUDGET,
    workers: int | None = None,
    quiet: bool = False,
) -> Answer:
    """Compare the device with its magnetic coupling and the rigidly geared one on identical realisations.

    Two questions. With the same generator gain, and the paper's coupling: how long does lock hold? This is the paper's
    claim of a wider margin. And with the best constant controls that a search with one budget finds for each of them
    on other realisations: how much power is there? A wider margin that wins no power would be worth little.

    Parameters
    ----------
    gammas : sequence of float
        Peak enhancements of the seas. [1]
    heights : sequence of float
        Significant wave heights. [m]
    seeds : sequence of int
        Realisations that judge; four at least, and none that searches use.
    duration : float
        Length of a run. [s]
    plant : Plant, optional
        The device with the coupling; the paper's by default. The other differs from it in its connection alone.
    gains : sequence of float
        Generator gains of the first question. [Nms]
    budget : float
        Simulated time of each search. [s]
    workers : int, optional
        Threads; all cores by default. They change no bit.
    quiet : bool
        Show no progress.

    Returns
    -------
    Answer

    Raises
    ------
    InputError
        For no sea, no gain, fewer than four seeds, a device without a magnetic coupling, and what a run refuses.

    Notes
    -----
    Source: Zhang et al., Ocean Engineering 143 (2017) 113-124, where the coupling is introduced to widen the margin of
    lock; one realisation each there.
    """
    magnetic = plant or zhang2017()
    if magnetic.parameters.connection == "rigid":
        raise InputError(
            "plant", magnetic.name, "has no magnetic coupling", 'Give the device with connection = "magnetic"'
        )
    for name, values, least in (
        ("gammas", gammas, 1),
        ("heights", heights, 1),
        ("seeds", seeds, 4),
        ("gains", gains, 1),
    ):
        if len(values) < least:
            raise InputError(name, list(values), f"holds fewer than {least}", f"Give {least} or more")
    devices = {"magnetic": magnetic, "rigid": magnetic.replace(connection="rigid")}
    seas = [SeaState(hs=float(hs), gamma=float(gamma)) for gamma in gammas for hs in heights]
    how = {"duration": duration, "workers": workers, "quiet": quiet}
    best = [_at_best(devices, sea, seeds, budget, how) for sea in seas]  # first, since a budget may be refused
    same = [case for sea in seas for case in _same_gain(devices, sea, gains, seeds, how)]
    same_p, best_p = (holm([p for _, p in cases]) for cases in (same, best))
    return Answer(
        tuple(float(gamma) for gamma in gammas),
        tuple(float(hs) for hs in heights),
        tuple(int(seed) for seed in seeds),
        duration,
        tuple(
            c._replace(p_holm=p, words=in_words(c.longer, p, LONGER, LEVEL))
            for (c, _), p in zip(same, same_p, strict=True)
        ),
        tuple(
            c._replace(p_holm=p, words=in_words(c.gain, p, POWER, LEVEL))
            for (c, _), p in zip(best, best_p, strict=True)
        ),
    )


def _same_gain(
    devices: dict[str, Plant], sea: SeaState, gains: Sequence[float], seeds: Sequence[int], how: dict[str, Any]
) -> list[tuple[SameGain, float]]:
    """Both devices with each gain, and the p-value of each difference."""
    pairs = [(CC, float(cg)) for cg in gains]
    found = {
        name: scan(plant, sea, pairs, seeds, title=_title(name, sea), ledger=False, **how)
        for name, plant in devices.items()
    }
    cases = []
    for i, (_, cg) in enumerate(pairs):
        locked = {name: run.locked[i] for name, run in found.items()}
        times = {name: np.where(locked[name], how["duration"], run.loss_time[i]) for name, run in found.items()}
        longer, p = paired_difference(times["magnetic"], times["rigid"], zero_if_lost=False)
        cases.append(
            (SameGain(sea.gamma, sea.hs, cg, _share(locked["magnetic"]), _share(locked["rigid"]), longer, p, ""), p)
        )
    return cases


def _at_best(
    devices: dict[str, Plant], sea: SeaState, seeds: Sequence[int], budget: float, how: dict[str, Any]
) -> tuple[AtBest, float]:
    """Each device with its best controls, and the p-value of the difference in power."""
    told, powers, hashes = {}, {}, set()
    for name, plant in devices.items():
        best = find_yardstick(plant, sea, budget=budget, workers=how["workers"], quiet=how["quiet"])
        waves = [realise(plant, sea, seed, how["duration"]) for seed in seeds]
        hashes.add(tuple(one.sha256 for one in waves))
        run = {"workers": how["workers"], "quiet": how["quiet"], "case": _title(name, sea)}
        ds = compare(plant, {PAIR: best.law}, waves, **run)
        told[name], powers[name] = _device(ds, best), ds.mean_power.values[0]
    if len(hashes) > 1:
        raise RuntimeError("the two devices did not see the same waves")
    gain, p = paired_difference(powers["magnetic"], powers["rigid"])
    return AtBest(sea.gamma, sea.hs, told["magnetic"], told["rigid"], gain, p, ""), p


def _device(ds: Any, best: Yardstick) -> OneDevice:
    return OneDevice(
        best.cc,
        best.cg,
        best.words,
        _share(ds.locked.values[0]),
        float(ds.turns_kept.mean()),
        float(ds.cycle_slips.mean()),
        bootstrap_mean(ds.mean_power.values[0]),
        float(ds.power_cv.mean()),
        float(ds.phi1_p98.mean()),
    )


def _share(locked: NDArray[Any]) -> Share:
    return wilson(int(np.nansum(locked)), len(locked))


def _title(name: str, sea: SeaState) -> str:
    return f"{name}, gamma {sea.gamma:g}, Hs {sea.hs:g} m"
