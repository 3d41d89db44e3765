"""The validity card in words: what the numbers of a run, or of a law over many, rest on."""

from __future__ import annotations

import math
from collections.abc import Mapping

from gyroctl.reports.wording import number


def in_words(card: Mapping[str, float], whose: str = "this run") -> str:
    """Say in a sentence what the numbers of a run rest on; empty where the card is not known."""
    if not math.isfinite(card.get("beyond_validity", math.nan)):
        return ""
    needed, reversals = card["traction_p999"], card["reversals"]
    grip = f"grips at a friction coefficient of {needed:.2f} (99.9 % of the time)"
    if not needed <= 1.0:
        grip = "holds where next to nothing presses it on its track"
    if reversals > 0:
        grip += (
            f", although the axis would change to the other side of the track and roll backwards {_times(reversals)}"
        )
    wet = "never out of the water nor fully under"
    if (out := card["dry_share"] + card["submerged_share"]) > 0.0:
        wet = f"out of the water or fully under for {100.0 * out:.1f} % of the time"
    return (
        f"The numbers of {whose} rest on a rolling contact that {grip}; a coupling that stands "
        f"{number(card['coupling_torque_max'])} Nm, {number(card['slip_max'])} rad/s of slip "
        f"and {number(card['coupling_loss_max'])} W; and a float that moves through {card['kx_max']:.2f} rad of the "
        f"wave and is {wet}. {100.0 * card['beyond_validity']:.1f} % of the time something of this, or an angle above "
        f"0.3 rad, is beyond what the model can say."
    )


def _times(count: float) -> str:
    return "once" if count == 1 else f"{count:.3g} times" if count < 100 else f"{count:.0f} times"
