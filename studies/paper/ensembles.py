"""The runs behind the figures: constant pairs on common realisations, computed once and shared."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.devices import zhang2017
from gyroctl.engine.ahead import Piece, do_ahead
from gyroctl.engine.steps import Steps
from gyroctl.harness.constant_pairs import scan
from gyroctl.harness.law_fingerprint import value_fingerprint
from gyroctl.plant import Plant
from gyroctl.simulation.progress import Progress
from gyroctl.waves import SeaState

HS, WP = 0.283, 3.14
"""Sea of the paper: significant wave height [m] and peak frequency [rad/s]."""

BLEND = 100.0
"""Lead-in from the regular wave; scoring begins after it. [s]"""

VARIANTS = ("corrected", "paper")

Pair = tuple[float, float]

COUPLINGS = (0.052, 0.104, 0.156)
"""The paper's magnetic couplings cc. [Nms]"""

GAINS: dict[float, tuple[float, ...]] = {
    5.0: (1e-4, 2e-4, 3.5e-4, 5e-4, 7.5e-4, 1e-3, 1.5e-3),
    50.0: (2e-4, 3.5e-4, 5e-4, 7.5e-4, 1e-3, 1.25e-3, 1.5e-3),
    1.0: (5e-5, 1e-4, 1.5e-4, 2.5e-4, 3.5e-4, 5e-4, 7.5e-4),
}
"""Generator gains cg by the peak enhancement gamma of the sea: they contain every value the paper speaks of. [Nms]"""

STATED: tuple[tuple[float, Pair], ...] = (
    (5.0, (0.052, 3.5e-4)),
    (5.0, (0.104, 3.5e-4)),
    (50.0, (0.052, 7.5e-4)),
    (1.0, (0.104, 1.5e-4)),
)
"""gamma and (cc, cg) [Nms]: pairs that the paper says to hold, and one with a larger cc."""


@dataclass(frozen=True)
class Setup:
    """How the ensembles are made."""

    seeds: tuple[int, ...] = tuple(range(1, 65))  # one realisation each, the same for every case
    duration: float = 2000.0  # length of a run [s]
    examples: int = 32  # runs of which the whole time series is kept, for the figures that show them
    workers: int | None = None  # threads; None for all cores
    quiet: bool = False  # no progress bar
    folder: Path | None = None  # where finished runs are kept; None keeps none
    client: Any = None  # of a Dask scheduler, whose workers run the ensembles; None runs them here

    def kept(self, modules: Sequence[str], kind: type, case: str, *given: Any) -> Steps:
        """Keep what is computed with `given`, whose result is of one kind: by the same code on the same waves."""
        known = value_fingerprint(*given, self.seeds, self.duration, HS, WP, BLEND)
        return Steps(self.folder, known, modules, (kind,), case)

    def note(self, plant: str) -> str:
        """Line below a figure: what was run."""
        runs = f"{len(self.seeds)} realisations of {self.duration:g} s"
        return f"{plant}; {runs}, the same for every case; intervals are 95 %"


class Case(NamedTuple):
    """One constant pair on all realisations; arrays of shape (seeds,)."""

    cc: float  # [Nms]
    cg: float  # [Nms]
    loss_time: NDArray[np.float64]  # NaN where lock was kept [s]
    power: NDArray[np.float64]  # mean electrical power [W]
    wave_input: NDArray[np.float64]  # mean power from the waves [W]
    phi1_p98: NDArray[np.float64]  # [rad]
    phi3_p98: NDArray[np.float64]  # [rad]

    @property
    def locked(self) -> NDArray[np.bool_]:
        """Whether lock was kept to the end."""
        return np.isnan(self.loss_time)

    def time_in_lock(self, duration: float) -> NDArray[np.float64]:
        """Time to the loss, or the length of the run where there was none. [s]"""
        return np.where(self.locked, duration, self.loss_time)


def sea(gamma: float) -> SeaState:
    """Sea state of the paper with peak enhancement `gamma`."""
    return SeaState(HS, WP, gamma)


def ensemble(setup: Setup, plant: Plant, gamma: float, pairs: Sequence[Pair], title: str) -> dict[Pair, Case]:
    """Run every pair (cc, cg) on every realisation of the sea with peak enhancement `gamma`."""
    run = cases_of if setup.client is None else _cases_there
    steps = setup.kept((__name__,), Case, title, plant, gamma, list(pairs))
    cases = steps(f"gamma {gamma:g}", lambda: run(setup, plant, gamma, pairs, title))
    return dict(zip(pairs, cases, strict=True))


def cases_of(setup: Setup, plant: Plant, gamma: float, pairs: Sequence[Pair], title: str) -> list[Case]:
    """Run pairs on every realisation, here."""
    how: dict[str, Any] = {"workers": setup.workers, "title": title, "quiet": setup.quiet}
    run = scan(plant, sea(gamma), pairs, setup.seeds, setup.duration, BLEND, **how)
    found = (run.loss_time, run.mean_power, run.wave_input_w, run.phi1_p98, run.phi3_p98)
    return [Case(*pair, *(values[i] for values in found)) for i, pair in enumerate(pairs)]


def _cases_there(setup: Setup, plant: Plant, gamma: float, pairs: Sequence[Pair], title: str) -> list[Case]:
    """Run each pair on a worker of the scheduler, on every realisation."""
    one = replace(setup, workers=1, quiet=True, folder=None, client=None)
    steps = Steps(None, "", (__name__,), (Case,), title)
    names = [f"pair {number}" for number in range(len(pairs))]
    given = [(one, plant, gamma, [pair], title) for pair in pairs]
    with Progress(title, len(pairs), setup.quiet) as progress:
        sent = [Piece(steps, name, cases_of, each) for name, each in zip(names, given, strict=True)]
        do_ahead(setup.client, sent, progress.advance)
    return [steps(name, partial(cases_of, *each))[0] for name, each in zip(names, given, strict=True)]


def stated_cases(setup: Setup, plant: Plant, title: str) -> dict[tuple[float, Pair], Case]:
    """Run the pairs of `STATED` on one device."""
    found: dict[tuple[float, Pair], Case] = {}
    for gamma in dict.fromkeys(gamma for gamma, _ in STATED):
        pairs = [pair for g, pair in STATED if g == gamma]
        cases = ensemble(setup, plant, gamma, pairs, f"{title}, gamma {gamma:g}")
        found |= {(gamma, pair): case for pair, case in cases.items()}
    return found


@lru_cache(maxsize=16)
def lock_grid(setup: Setup, variant: str, gamma: float) -> dict[Pair, Case]:
    """All pairs of `COUPLINGS` and `GAINS` in one sea: the figures and the statements look at the same runs."""
    pairs = [(cc, cg) for cc in COUPLINGS for cg in GAINS[gamma]]
    return ensemble(setup, zhang2017(variant), gamma, pairs, f"{variant}, gamma {gamma:g}")
