"""The comparison in plain sentences, written from its numbers: who wins, by how much, and what to beware of."""

from __future__ import annotations

import math
from typing import NamedTuple

from gyroctl.reports.evaluation import Evaluation, LawResult
from gyroctl.reports.wording import interval, listed, number, plain, seed_ranges
from gyroctl.statistics import FEWEST, NOT_DISTINGUISHABLE, Estimate


class Verdict(NamedTuple):
    """The winner's name (None when no law qualifies), the sentences of the verdict and the caveats."""

    winner: str | None
    sentences: tuple[str, ...]
    caveats: tuple[str, ...]


def judge(evaluation: Evaluation) -> Verdict:
    """Name the law with most power among those that may be used, keep lock and stay within the motion limit.

    A law qualifies when it does without an oracle, held lock in at least one run and in at least as many runs as the
    reference (without a reference: as many as any causal law), and keeps its mean 98 % motion within the limit. Laws
    that give more power but do not qualify are named with the reason.

    Parameters
    ----------
    evaluation : Evaluation
        Statistics of the comparison.

    Returns
    -------
    Verdict
        Sentences ready to print.
    """
    reasons = {law.name: _reasons(law, evaluation) for law in evaluation.laws}
    fit = [law for law in evaluation.by_power if not reasons[law.name]]
    winner = fit[0] if fit else None
    sentences = [_opening(evaluation, winner)]
    if winner is not None:
        sentences += [_lock(winner, evaluation), *_runner_up(winner, fit[1:], evaluation)]
    sentences += _excluded(winner, reasons, evaluation)
    sentences += _smoothest(winner, fit)
    sentences += [*_without_preview(winner, fit), *_unsearched(evaluation)]
    return Verdict(winner.name if winner else None, tuple(sentences), tuple(_caveats(evaluation)))


def _reasons(law: LawResult, evaluation: Evaluation) -> list[str]:
    causal = [other.locked for other in evaluation.laws if other.information != "oracle"]
    needed = evaluation.law(evaluation.reference).locked if evaluation.reference else max(causal, default=0)
    reasons = []
    if law.information == "oracle":
        told = f"is told the waves {plain(law.preview)} s ahead, as far as it plans"
        ahead = told if math.isfinite(law.preview) else "knows the future waves"
        reasons.append(f"{ahead} (oracle)")
    if law.locked == 0:
        reasons.append(f"lost lock in every run ({law.runs})")
    elif law.locked < needed:
        against = f"{evaluation.reference}: {needed}" if evaluation.reference else f"best: {needed}"
        reasons.append(f"held lock in {law.locked} of {law.runs} runs only ({against})")
    for name, value in (("phi1", law.phi1_p98), ("phi3", law.phi3_p98)):
        if value > evaluation.motion_limit:
            reasons.append(
                f"moves too far (98 % of |{name}| {number(value)} rad, limit {plain(evaluation.motion_limit)} rad)"
            )
    return reasons


def _opening(evaluation: Evaluation, winner: LawResult | None) -> str:
    count = len(evaluation.seeds)
    same = "realisations, identical for all laws," if count > 1 else "realisation"
    base = f"On {count} {same} of {plain(evaluation.duration)} s"
    if winner is None:
        return f"{base}, no law without an oracle keeps lock as it should and stays within the motion limit: no winner."
    if len(evaluation.laws) == 1:
        return f"{base}, {winner.name} gives {_power(winner.power)}."
    keeps = f"keep lock at least as often as {evaluation.reference}" if evaluation.reference else "keep lock most often"
    text = f"{base}, {winner.name} gives the most power among the laws that {keeps} and stay within the motion limit"
    text = f"{text}: {_power(winner.power)}"
    if evaluation.reference is None:
        return f"{text}."
    if winner.name == evaluation.reference:
        return f"{text}. No law beats the best constant pair within these limits."
    return f"{text}, {number(winner.ratio.value)} times {evaluation.reference}{_bracket(winner.ratio)}."


def _lock(winner: LawResult, evaluation: Evaluation) -> str:
    bounds = f"95 % interval of the probability {interval(winner.lock, 2)}"
    text = f"It held lock in {winner.locked} of {winner.runs} runs ({bounds})"
    if evaluation.reference and winner.name != evaluation.reference:
        reference = evaluation.law(evaluation.reference)
        text += f", {reference.name} in {reference.locked} of {reference.runs}"
    return f"{text}; its power varies with a CV of {number(winner.power_cv.value, 2)}."


def _runner_up(winner: LawResult, others: list[LawResult], evaluation: Evaluation) -> list[str]:
    if not others:
        return []
    difference = evaluation.difference(winner.name, others[0].name)
    lead = f"{number(difference.estimate.value)} W{_bracket(difference.estimate, 'W')} over the next, {others[0].name}"
    if difference.words == NOT_DISTINGUISHABLE:
        pairs = len(evaluation.power_differences)
        over = f" over {pairs} pairs" if pairs > 1 else ""
        return [f"Its lead of {lead}, is {NOT_DISTINGUISHABLE} (Holm-corrected{over}, p {_p(difference.p_holm)})."]
    if difference.words == "more":
        return [f"Its lead of {lead}, is distinguishable (Holm-corrected p {_p(difference.p_holm)})."]
    return [f"Its lead is {lead}; {difference.words}."]


def _excluded(winner: LawResult | None, reasons: dict[str, list[str]], evaluation: Evaluation) -> list[str]:
    floor = winner.power.value if winner else float("-inf")
    stronger = [law for law in evaluation.by_power if reasons[law.name] and law.power.value > floor]
    lead = "gives more power" if winner else "gives"
    return [
        f"{law.name} {lead}{',' if winner else ''} {number(law.power.value)} W, but {listed(reasons[law.name])}."
        for law in stronger
    ]


def _smoothest(winner: LawResult | None, fit: list[LawResult]) -> list[str]:
    finite = [law for law in fit if law.power_cv.value == law.power_cv.value]
    if winner is None or len(finite) < 2:
        return []
    smoothest = min(finite, key=lambda law: law.power_cv.value)
    if smoothest.name == winner.name:
        return ["It is also the smoothest of these laws."]
    cv, power = number(smoothest.power_cv.value, 2), number(smoothest.power.value)
    return [f"The smoothest of these laws is {smoothest.name}, CV {cv} at {power} W."]


def _without_preview(winner: LawResult | None, fit: list[LawResult]) -> list[str]:
    """What a winner that is told waves to come is worth beside laws that go by their sensors."""
    if winner is None or winner.information not in ("forecast", "oracle"):
        return []
    ahead = f"{winner.name} is told the waves {plain(winner.preview)} s ahead"
    own = next((law for law in fit if law.information in ("none", "sensors")), None)
    if own is None:
        return [f"{ahead}; no law without a preview keeps these limits."]
    return [f"{ahead}; of the laws without a preview {own.name} gives the most power, {number(own.power.value)} W."]


def _unsearched(evaluation: Evaluation) -> list[str]:
    """Warn of a yardstick that is not the best one."""
    name, how = evaluation.reference, evaluation.yardstick
    if name is None or (how and how.get("searched")):
        return []
    why = f": {how['words']}" if how else ", as far as the file says"
    return [f"{name} was not searched for this sea and device{why}. A pair found for them may give more power."]


def _caveats(evaluation: Evaluation) -> list[str]:
    caveats = []
    if len(evaluation.seeds) < FEWEST:
        caveats.append(
            f"Too few realisations for intervals (at least {FEWEST}): read this as a demonstration, not as a result."
        )
    if evaluation.seed_overlap:
        caveats.append(
            f"Seeds {seed_ranges(evaluation.seed_overlap)} were used for tuning as well as for evaluation: "
            "the results of tuned laws are too good."
        )
    caveats += _known_seeds(evaluation)
    # In lulls the phase of the waves itself jumps, so even a locked ring counts slips: judge against the reference.
    usual = evaluation.law(evaluation.reference).cycle_slips if evaluation.reference else 0.0
    against = f" ({evaluation.reference} {number(usual, 2)})" if evaluation.reference else ""
    laws = evaluation.laws
    over = [f"{law.name} {law.over_limit} of {law.runs}" for law in laws if law.over_limit]
    outside = [f"{law.name} {law.outside_model} of {law.runs}" for law in laws if law.outside_model]
    sliding = [f"{law.name} {number(law.cycle_slips, 2)}" for law in laws if law.cycle_slips > max(10.0, 2.0 * usual)]
    fallen = [f"{law.name} {law.fallbacks}" for law in laws if law.fallbacks]
    unbalanced = [f"{law.name} {number(law.ledger_residual, 2)}" for law in laws if law.ledger_residual > 1e-4]
    for concerned, lead, tail in (
        (over, f"Runs over the motion limit of {plain(evaluation.motion_limit)} rad", ""),
        (outside, "Runs that leave the small-angle model (|phi| above 0.3 rad at some time)", ""),
        (sliding, "Many cycle slips per 1000 waves", f"{against}. Power won by sliding is not locked power"),
        (fallen, "Steps that fell back to a simpler law", ""),
        (unbalanced, "The energy ledger does not close (relative residual)", ""),
    ):
        if concerned:
            caveats.append(f"{lead}: {listed(concerned)}{tail}.")
    return caveats


def _known_seeds(evaluation: Evaluation) -> list[str]:
    """What the ledger of seeds says of those that judge here."""
    spent, reserve = (tuple(evaluation.seed_states.get(state, ())) for state in ("spent", "reserve"))
    caveats = []
    if spent:
        caveats.append(
            f"Seeds {seed_ranges(spent)} are spent: laws were changed after results on them were known. "
            "They show what a law does, and do not judge it afresh."
        )
    if reserve:
        caveats.append(f"Seeds {seed_ranges(reserve)} were in reserve: mark them spent in the ledger by a commit.")
    return caveats


def _power(power: Estimate) -> str:
    return f"{number(power.value)} W{_bracket(power, 'W')}"


def _bracket(estimate: Estimate, unit: str = "") -> str:
    bounds = interval(estimate)
    return f" (95 % interval {bounds}{f' {unit}' if unit else ''})" if bounds else ""


def _p(value: float) -> str:
    return "< 0.001" if value < 1e-3 else f"= {number(value, 2)}"
