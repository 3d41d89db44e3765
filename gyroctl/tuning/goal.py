"""What a tuning is to reach, and the one score by which every law is tuned."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

METRICS = (
    *("mean_power", "power_cv", "locked", "phi1_p98", "phi3_p98", "cycle_slips", "short_reserve"),
    *("turns_kept", "reversed"),
)
"""What a tuning records of each run; `short_reserve` is how far the least 10 s mean of the ring speed, as a part of wp,
is below `RESERVE`, `reversed` whether the axis rolled backwards: a contact that cannot slip tells of none."""

RESERVE = 0.65
"""Least 10 s mean of the ring speed, as a part of wp, below which a run counts as nearly lost (at 0.5 it is)."""

WORST = (0.0, 10.0, 0.0, 1.0, 1.0, 1000.0, RESERVE, 0.0, 1.0)
"""Counted for a run in which the law gave no number, or instead of a metric that is not defined."""


@dataclass(frozen=True)
class Goal:
    """The most power within limits.

    Parameters
    ----------
    locked : float
        Least part of the realisations that must stay locked. [-]
    motion : float
        Largest mean of the 98 % motion, for each of phi1 and phi3. [rad]
    power_cv : float
        Largest mean coefficient of variation of the power. [-]
    turns : float
        Least mean of the turns kept. [-]
    forward : float
        Least part of the realisations in which the axis never rolls backwards. [-]
    """

    locked: float = 0.99
    motion: float = 0.34
    power_cv: float = float("inf")
    turns: float = 0.0
    forward: float = 0.0

    def met(self, means: Mapping[str, float]) -> bool:
        """Whether the limits are kept by means over realisations."""
        return not self.missed(means)

    def missed(self, means: Mapping[str, float]) -> list[str]:
        """Limits that means over realisations do not keep, each in words with what was found."""
        found = []
        for name, told in (("phi1_p98", "98 % motion of phi1"), ("phi3_p98", "98 % motion of phi3")):
            if not means[name] <= self.motion:
                found.append(f"{told} {means[name]:.4g} rad, at most {self.motion:.4g}")
        if not means["power_cv"] <= self.power_cv:
            found.append(f"power CV {means['power_cv']:.4g}, at most {self.power_cv:.4g}")
        if self.turns > 0.0 and not means["turns_kept"] >= self.turns:
            found.append(f"turns kept {means['turns_kept']:.4g}, at least {self.turns:.4g}")
        if self.forward > 0.0 and not 1.0 - means["reversed"] >= self.forward:
            found.append(f"runs without a reversal {1.0 - means['reversed']:.4g}, at least {self.forward:.4g}")
        if not means["locked"] >= self.locked:
            found.append(f"locked {means['locked']:.4g}, at least {self.locked:.4g}")
        return found

    def score(self, means: Mapping[str, float], power: float) -> float:
        """Mean power over `power` [W], less penalties: smooth, so that a search finds back from outside the limits.

        Every realisation lost counts, also within the limit: 16 for all of them. A realisation that is nearly lost
        counts 4 per unit of missing reserve, since of losses below one in a hundred a search would see none. 30 per
        rad of motion and 10 per unit of power CV beyond the limits. Where they are asked for, 30 per part of the turns
        that is missing, and 4 for all realisations with a reversal, also within the goal.
        """
        motion = sum(max(0.0, means[name] - self.motion) for name in ("phi1_p98", "phi3_p98"))
        rough = 10.0 * max(0.0, means["power_cv"] - self.power_cv)
        lost = 16.0 * (1.0 - means["locked"]) + 4.0 * means["short_reserve"]
        if self.turns > 0.0:
            lost += 30.0 * max(0.0, self.turns - means["turns_kept"])
        if self.forward > 0.0:
            lost += 4.0 * means["reversed"]
        return means["mean_power"] / power - lost - 30.0 * motion - rough
