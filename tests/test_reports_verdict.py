"""The verdict of a comparison, and its caveats."""

from __future__ import annotations

import re

import numpy as np
from test_reports_synthetic import CHARACTERS, synthetic

from gyroctl.reports import evaluate, judge


def test_verdict_prefers_power_among_laws_that_qualify():
    ds = synthetic(tuple(CHARACTERS), realisations=16, lock=1.0)
    verdict = judge(evaluate(ds))
    assert verdict.winner == "load_angle"
    text = " ".join(verdict.sentences)
    assert "preview gives more power" in text
    assert "oracle" in text
    assert re.search(r"nmpc gives more power.*moves too far", text)
    assert any("motion limit" in caveat for caveat in verdict.caveats)


def test_verdict_passes_over_the_law_that_loses_lock_more_often():
    ds = synthetic(realisations=32, lock=1.0)
    ds["locked"].loc[{"law": "load_angle", "realisation": 3}] = False
    ds["loss_time"].loc[{"law": "load_angle", "realisation": 3}] = 200.0
    verdict = judge(evaluate(ds))
    assert verdict.winner == "coupling"
    assert "load_angle gives more power" in " ".join(verdict.sentences)
    assert "31 of 32" in " ".join(verdict.sentences)


def test_verdict_says_not_distinguishable_of_twins():
    ds = synthetic(("best_constant", "coupling", "constant"), 32, lock=1.0)
    twin = ds["mean_power"].sel(law="coupling").values * (1.0 + 0.01 * np.resize([1.0, -1.0], 32))
    ds["mean_power"].loc[{"law": "constant"}] = twin
    assert "is not distinguishable (Holm-corrected over 3 pairs, p" in " ".join(judge(evaluate(ds)).sentences)


def test_verdict_without_lock_has_no_winner():
    verdict = judge(evaluate(synthetic(lock=0.0)))
    assert verdict.winner is None
    assert "no winner" in verdict.sentences[0]


def test_verdict_when_nothing_beats_the_reference():
    assert "No law beats" in judge(evaluate(synthetic(("best_constant", "constant"), lock=1.0))).sentences[0]


def test_caveat_of_sliding_is_measured_against_the_reference():
    ds = synthetic()
    ds["cycle_slips"].loc[{"law": "best_constant"}] = 12.0
    ds["cycle_slips"].loc[{"law": "constant"}] = 20.0
    ds["cycle_slips"].loc[{"law": "coupling"}] = 40.0
    (caveat,) = [c for c in judge(evaluate(ds)).caveats if "slips" in c]
    assert "coupling 40 (best_constant 12)" in caveat
    assert "constant 20" not in caveat


def test_caveats_name_overlapping_seeds_and_few_runs():
    caveats = " ".join(judge(evaluate(synthetic(realisations=3, tuning_seeds=(2, 3, 50)))).caveats)
    assert "Seeds 2, 3 were used for tuning" in caveats
    assert "Too few realisations" in caveats


def test_caveat_of_an_interval_is_a_sentence_that_can_be_read():
    ds = synthetic()
    ds["mean_power"].loc[{"law": "coupling"}] = -50.0 + ds["mean_power"].sel(law="coupling")
    (caveat,) = [line for line in judge(evaluate(ds)).caveats if "do not hold" in line]
    assert (
        "power: the interval is of runs like those that were made" in caveat and "of runs like those seen" not in caveat
    )
