"""The comparison in plain sentences, written from its numbers: who wins, by how much, and what to beware of."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import NamedTuple

from gyroctl.reports.evaluation import Evaluation, LawResult
from gyroctl.reports.layout import FEW
from gyroctl.reports.wording import interval, listed, number, percent, plain, seed_ranges
from gyroctl.statistics import FEWEST, NOT_DISTINGUISHABLE, Estimate
from gyroctl.statistics.means import AS_SEEN

SEEN_ONLY = "the interval is of runs like those that were made, with no loss of lock that none of them showed"
"""What a reader is told of an interval whose note is `AS_SEEN`."""

COUNTS: Mapping[str, Callable[[LawResult], int]] = {
    "locked": lambda law: law.locked,
    "in step": lambda law: law.in_step or 0,
    "within the limit": lambda law: law.runs - law.over_limit,
}
"""Runs of which a law needs as many as the reference."""

SMALL = 0.02
"""Part of the power below which what is stored goes without saying. [1]"""

STRAY = 0.01
"""Part of the runs that may be over the motion limit even if the reference never is. [1]"""


class Verdict(NamedTuple):
    """The winner's name (None when no law qualifies), the sentences of the verdict and the caveats.

    Parameters
    ----------
    winner : str or None
        Name of the law that wins.
    sentences : tuple of str
        The verdict, in prose.
    caveats : tuple of str
        What it does not say.
    """

    winner: str | None
    sentences: tuple[str, ...]
    caveats: tuple[str, ...]


def judge(evaluation: Evaluation) -> Verdict:
    """Name the law with most power among those that may be used, keep lock and step and stay within the motion limit.

    A law qualifies when it does without an oracle, held lock in at least one run and in at least as many runs as the
    reference, keeps its mean 98 % motion within the limit and is over it in no more runs than the reference or one in a
    hundred, and is in step in some run, in more than
    half as many as the reference and not in so few that chance at 5 % does not explain it. Without a reference the
    best of the causal laws stands in its place. Power is what is judged, generated and stored; but a flywheel that was
    slowed before the scoring began takes more from the waves while it comes up again, so a law whose lead over the
    reference is for the greater part stored does not qualify, nor one whose lead is not distinguishable from none. Laws
    that give more power but do not qualify are named with the reason, and so is every law that failed in any run: it is
    out, whatever its other runs give.

    Parameters
    ----------
    evaluation : Evaluation
        Statistics of the comparison.

    Returns
    -------
    Verdict
        Sentences ready to print.
    """
    needs = {
        what: _needed(evaluation, [(law, count(law)) for law in evaluation.laws]) for what, count in COUNTS.items()
    }
    reasons = {law.name: _reasons(law, evaluation, needs) for law in evaluation.laws}
    fit = [law for law in evaluation.by_power if not reasons[law.name]]
    winner = fit[0] if fit else None
    sentences = [_opening(evaluation, winner)]
    if winner is not None:
        sentences += [_lock(winner, evaluation), *_parts(winner), *_runner_up(winner, fit[1:], evaluation)]
    sentences += _excluded(winner, reasons, evaluation)
    sentences += _smoothest(winner, fit)
    sentences += [*_without_preview(winner, fit), *_unsearched(evaluation)]
    return Verdict(winner.name if winner else None, tuple(sentences), tuple(_caveats(evaluation)))


def shown(evaluation: Evaluation) -> tuple[LawResult, ...]:
    """Laws that pictures and terminals show, most power first: of many the winner, the reference and the strongest."""
    laws = evaluation.by_power
    if len(laws) <= FEW:
        return laws
    always = {judge(evaluation).winner, evaluation.reference} - {None}
    others = [law.name for law in laws if law.name not in always]
    chosen = always | set(others[: FEW - len(always)])
    return tuple(law for law in laws if law.name in chosen)


def _reasons(law: LawResult, evaluation: Evaluation, needs: Mapping[str, tuple[int, str]]) -> list[str]:
    reasons = []
    if law.failures:
        reasons.append(_failure(law))
    if law.information == "oracle":
        told = f"is told the waves {plain(law.preview)} s ahead, as far as it plans"
        ahead = told if math.isfinite(law.preview) else "knows the future waves"
        reasons.append(f"{ahead} (oracle)")
    needed, who = needs["locked"]
    if law.failed == law.runs:
        return reasons
    if law.locked == 0:
        reasons.append(f"lost lock in every run ({law.runs})")
    elif law.locked < needed:
        reasons.append(f"held lock in {law.locked} of {law.runs} runs only ({who}: {needed})")
    needed, who = needs["in step"]
    if law.in_step is not None and too_few(law.in_step, needed, law.runs):
        reasons.append(f"is in step with the waves in {law.in_step} of {law.runs} runs only ({who}: {needed})")
    reasons += _motion(law, evaluation, needs["within the limit"])
    if evaluation.reference and law.name != evaluation.reference:
        reference = evaluation.law(evaluation.reference)
        lead, generated = law.power.value - reference.power.value, law.generated_w - reference.generated_w
        if lead > 0.0 and generated < 0.5 * lead:
            part = f"{number(generated, 2)} of {number(lead, 2)} W"
            reasons.append(f"owes its lead over {reference.name} to what it stored, not to what it generated ({part})")
        elif lead > 0.0 and evaluation.difference(law.name, reference.name).words == NOT_DISTINGUISHABLE:
            reasons.append(f"leads {reference.name} by no more than chance explains ({number(lead, 2)} W)")
    return reasons


def _failure(law: LawResult) -> str:
    return f"failed in {law.failed} of {law.runs} runs ({next(iter(law.failures.values()))})"


def _motion(law: LawResult, evaluation: Evaluation, need: tuple[int, str]) -> list[str]:
    limit = plain(evaluation.motion_limit)
    far = [
        f"moves too far (98 % of |{name}| {number(value)} rad, limit {limit} rad)"
        for name, value in (("phi1", law.phi1_p98), ("phi3", law.phi3_p98))
        if value > evaluation.motion_limit
    ]
    within, who = need
    if not far and law.over_limit > max(law.runs - within, STRAY * law.runs):
        far.append(
            f"moves too far in {law.over_limit} of {law.runs} runs (limit {limit} rad; {who}: {law.runs - within})"
        )
    return far


@lru_cache(maxsize=4096)
def too_few(count: int, needed: int, runs: int) -> bool:
    """Whether a law is in step in too few of its runs, beside a reference that is in step in `needed` of as many."""
    from scipy.stats import binom

    by_chance = float(binom.cdf(count, runs, (needed + 1.0) / (runs + 2.0)))  # Laplace's estimate of its probability
    return 2 * count <= needed or by_chance < 0.05


def _needed(evaluation: Evaluation, counts: list[tuple[LawResult, int]]) -> tuple[int, str]:
    """Count of the reference; without one the best of the causal laws. And what to call it."""
    if evaluation.reference:
        return next(count for law, count in counts if law.name == evaluation.reference), evaluation.reference
    return max((count for law, count in counts if law.information != "oracle"), default=0), "best"


def _opening(evaluation: Evaluation, winner: LawResult | None) -> str:
    count = len(evaluation.seeds)
    same = "realisations, identical for all laws," if count > 1 else "realisation"
    base = f"On {count} {same} of {plain(evaluation.duration)} s"
    if winner is None:
        return (
            f"{base}, no law without an oracle keeps lock and step as it should and stays within the motion limit: "
            "no winner."
        )
    if len(evaluation.laws) == 1:
        return f"{base}, {winner.name} gives {_power(winner.power)}."
    keeps = f"keep lock at least as often as {evaluation.reference}" if evaluation.reference else "keep lock most often"
    keeps += ", keep step with the waves" if winner.in_step is not None else ""
    text = f"{base}, {winner.name} gives the most power among the laws that {keeps} and stay within the motion limit"
    text = f"{text}: {_power(winner.power)}"
    if evaluation.reference is None:
        return f"{text}."
    if winner.name == evaluation.reference:
        return f"{text}. No law beats the best constant pair within these limits."
    return f"{text}, {number(winner.ratio.value)} times {evaluation.reference}{_bracket(winner.ratio)}."


def _lock(winner: LawResult, evaluation: Evaluation) -> str:
    beside = f"; {winner.lock.note}" if winner.lock.note else ""
    text = f"It held lock in {winner.locked} of {winner.runs} runs ({_probability(winner.lock)}{beside})"
    reference = evaluation.law(evaluation.reference) if evaluation.reference else winner
    if reference is not winner:
        text += f", {reference.name} in {reference.locked} of {reference.runs}"
    if winner.in_step is None:
        text += "; whether it was in step with the waves is not recorded"
    else:
        text += f"; it was in step with the waves in {winner.in_step} of {winner.runs} ({_probability(winner.step)})"
        if reference is not winner:
            text += f", {reference.name} in {reference.in_step} of {reference.runs}"
        text += f", keeping {number(winner.turns_kept)} of the turns"
    return f"{text}; its power varies with a CV of {number(winner.power_cv.value, 2)}."


def _parts(winner: LawResult) -> list[str]:
    """Both parts of the power, where the stored one is not small."""
    if not abs(winner.stored_w) > SMALL * abs(winner.power.value) or winner.power.value == winner.generated_w:
        return []
    generated, stored = number(winner.generated_w), number(winner.stored_w, 2)
    return [f"Of its power {generated} W was generated and {stored} W went into flywheel and float."]


def _runner_up(winner: LawResult, others: list[LawResult], evaluation: Evaluation) -> list[str]:
    if not others:
        return []
    difference = evaluation.difference(winner.name, others[0].name)
    lead = f"{number(difference.estimate.value)} W{_bracket(difference.estimate, 'W')} over the next, {others[0].name}"
    if difference.words == NOT_DISTINGUISHABLE:
        pairs = difference.tests
        over = f" over {pairs} pairs" if pairs > 1 else ""
        return [f"Its lead of {lead}, is {NOT_DISTINGUISHABLE} (Holm-corrected{over}, p {_p(difference.p_holm)})."]
    if difference.words == "more":
        return [f"Its lead of {lead}, is distinguishable (Holm-corrected p {_p(difference.p_holm)})."]
    return [f"Its lead is {lead}; {difference.words}."]


def _excluded(winner: LawResult | None, reasons: dict[str, list[str]], evaluation: Evaluation) -> list[str]:
    floor = winner.power.value if winner else float("-inf")
    stronger = [law for law in evaluation.by_power if reasons[law.name] and law.power.value > floor]
    lead = "gives more power" if winner else "gives"
    named = {law.name for law in stronger}
    failed = [law for law in evaluation.laws if law.failures and law.name not in named]
    said = [f"{law.name} is out: it {_failure(law)}." for law in failed[:FEW]]
    said += [f"{len(failed) - FEW} more laws are out: they failed in some run."] if len(failed) > FEW else []
    said += [
        f"{law.name} {lead}{',' if winner else ''} {number(law.power.value)} W, but {listed(reasons[law.name])}."
        for law in stronger[:FEW]
    ]
    more = len(stronger) - FEW
    return [*said, f"{more} more {'give more power' if winner else 'laws'}, but do not qualify."] if more > 0 else said


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
    if winner is None or winner.information not in ("gauge", "forecast", "oracle"):
        return []
    gauged, seconds = winner.information == "gauge", plain(winner.preview)
    told = "reads a wave gauge" if gauged else f"is told the waves {seconds} s ahead"
    ahead = f"{winner.name} {told}"
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
    outside = [_outside(law) for law in laws if law.outside_model]
    turned = [_turned(law) for law in laws if law.card.get("reversals", 0.0) > 0.0]
    behind = [f"{law.name} {_behind(law)}" for law in laws if law.in_step is not None and 2 * law.in_step < law.locked]
    sliding = [f"{law.name} {number(law.cycle_slips, 2)}" for law in laws if law.cycle_slips > max(10.0, 2.0 * usual)]
    fallen = [f"{law.name} {law.fallbacks}" for law in laws if law.fallbacks]
    noted = [f"{law.name} ({what})" for law in laws if law.failed < law.runs and (what := _left_out(law))]
    unbalanced = [f"{law.name} {number(law.ledger_residual, 2)}" for law in laws if law.ledger_residual > 1e-4]
    for concerned, lead, tail in (
        (over, f"Runs over the motion limit of {plain(evaluation.motion_limit)} rad", ""),
        (outside, "Outside the small-angle model (|phi| above 0.3 rad) for part of the time", ""),
        (
            turned,
            "The spin axis changes sides on its track and rolls backwards",
            "" if evaluation.slips else "; a plant whose contact rolls leaves the rest of it out",
        ),
        (behind, "Locked but not in step with the waves", ": no stall, but the ring loses turns"),
        (sliding, "Many cycle slips per 1000 waves", f"{against}. Power won by sliding is not locked power"),
        (noted, "What these means and intervals do not hold", ""),
        (fallen, "Steps that fell back to a simpler law", ""),
        (unbalanced, "The energy ledger does not close (relative residual)", ""),
    ):
        if concerned:
            many = [f"{len(concerned) - FEW + 1} more"] if len(concerned) > FEW else []
            caveats.append(f"{lead}: {listed([*concerned[: FEW - len(many)], *many])}{tail}.")
    if evaluation.strongest:
        caveats.append(_part_of_the_pairs(evaluation))
    if any(law.in_step is None for law in laws):
        caveats.append(
            "Turns kept and step with the waves are not recorded in this file: lock alone hides pole slipping."
        )
    return caveats


def _part_of_the_pairs(evaluation: Evaluation) -> str:
    """Which pairs of many laws were compared, and what of them is drawn and told."""
    count, who = len(evaluation.laws), evaluation.reference
    pairs = f"{count * (count - 1) // 2} pairs of {count} laws"
    named = f"with {who} (Holm's correction over {count - 1})" if who else ""
    best = f"with {evaluation.strongest}, which is chosen by its power (corrected as some of all pairs)"
    others = named if who == evaluation.strongest else f"{named} and {best}" if named else best
    told = f"Pictures and words are of {FEW} laws, the strongest; every law has its row and stands in summary.json"
    return f"Of the {pairs} those {others} are compared. {told}."


def _left_out(law: LawResult) -> str:
    """Runs without a number, and what else the intervals of power, ratio, lock and time to loss do not hold."""
    estimates = {"power": law.power, "ratio": law.ratio, "lock": law.lock, "time to loss": law.mttl}
    concerned = ("not finite", "not finished", "scatter", "rate", "like those", "told from zero")
    said = {what: e.note for what, e in estimates.items() if any(word in e.note for word in concerned)}
    return "; ".join(f"{what}: {note.replace(AS_SEEN, SEEN_ONLY)}" for what, note in said.items())


def _outside(law: LawResult) -> str:
    if law.outside_share != law.outside_share:  # a file that does not record it
        return f"{law.name} in {law.outside_model} of {law.runs} runs"
    return f"{law.name} {percent(100.0 * law.outside_share)} (up to {number(max(law.phi1_max, law.phi3_max), 2)} rad)"


def _turned(law: LawResult) -> str:
    times = number(law.card["reversals"], 2)
    return f"{law.name} {times} times a run"


def _behind(law: LawResult) -> str:
    return f"in {law.locked - (law.in_step or 0)} of {law.runs} runs (keeps {number(law.turns_kept)} of the turns)"


def _probability(estimate: Estimate) -> str:
    return f"95 % interval of the probability {interval(estimate, 2)}"


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
