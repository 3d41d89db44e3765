"""How well a planner foresees the moments in its own closed loop, whatever it goes by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import InputError
from gyroctl.harness.protocol import Law
from gyroctl.harness.run import lead_in, run_law
from gyroctl.studies.evaluation.cases import Case
from gyroctl.waves import realise

LEADS = (1.0, 2.0)
"""How far ahead the forecast is judged. [s]"""

SETTLING = 50.0
"""What is foreseen so long after the lead-in does not count: the sea is being learnt. [s]"""


class Foreseeing(Protocol):
    """A planner whose state tells the moments that it foresees."""

    def memory(self, state: Any) -> Any:
        """Return the memory in a state; its `ahead` (2, n) are the moments at the end of each interval. [Nm]"""


@dataclass(frozen=True)
class Noting:
    """A planner that goes its way while what it foresees is noted."""

    law: Any
    leads: tuple[int, ...]  # [samples]
    noted: list[NDArray[np.float64]] = field(default_factory=list, repr=False)

    @property
    def period(self) -> float:
        """Sampling period of the planner. [s]"""
        return float(self.law.period)

    @property
    def information(self) -> Any:
        """What the planner looks at."""
        return self.law.information

    def informed(self, waves: Any) -> Noting:
        """Let the planner see the waves."""
        return replace(self, law=self.law.informed(waves))

    def init(self) -> Any:
        """Begin as the planner."""
        return self.law.init()

    def step(self, t: float, y: Any, state: Any) -> Any:
        """Step as the planner, and note."""
        command, state = self.law.step(t, y, state)
        ahead = self.law.memory(state).ahead
        self.noted.append(np.array([ahead[:, lead - 1] for lead in self.leads]))
        return command, state


def forecast_error(case: Case, law: Law, seeds: Sequence[int], duration: float) -> NDArray[np.float64]:
    """Mean square error of the moments that a planner foresees over their variance, in its own closed loop.

    Parameters
    ----------
    case : Case
        Device, sea, settings.
    law : Law
        A planner, see `Foreseeing`.
    seeds : sequence of int
        Realisations.
    duration : float
        Of each. [s]

    Returns
    -------
    (2, leads) array
        Of Me1 and Me3 at `LEADS`, the mean over the realisations. [-]

    Raises
    ------
    InputError
        Field ``duration``: too short for anything to count.
    """
    leads = tuple(round(lead / law.period) for lead in LEADS)
    first = round((case.settings.score_from + SETTLING) / law.period)
    found = []
    for seed in seeds:
        waves = lead_in(realise(case.truth, case.sea, seed, duration), case.settings)
        noting = Noting(law, leads)
        run_law(case.truth, noting, waves, case.settings)
        truth = waves.moments[:, :: round(law.period / waves.dt)]
        noted = np.array(noting.noted)  # (samples, leads, 2)
        made = np.arange(first, min(noted.shape[0], truth.shape[1] - max(leads)))
        if made.size == 0:
            raise InputError("duration", duration, "leaves no forecast to judge", "Give a longer one, for example 400")
        variance = np.mean(truth[:, first:] ** 2, axis=1)
        error = [np.mean((noted[made, i].T - truth[:, made + lead]) ** 2, axis=1) for i, lead in enumerate(leads)]
        found.append(np.stack(error, axis=1) / variance[:, None])
    return np.asarray(np.mean(found, axis=0), np.float64)
