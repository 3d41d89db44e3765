"""What grows with the laws, with the length of a run and with the number of runs, and what does not."""

from __future__ import annotations

import base64
import gzip
import tracemalloc
import weakref
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from test_reports_synthetic import CHARACTERS, synthetic

import gyroctl as gy
from gyroctl.comparison import execution, items, kept
from gyroctl.comparison.compare import Realisations, compare
from gyroctl.comparison.items import Outcome, work_items
from gyroctl.harness import together
from gyroctl.harness.run import Settings
from gyroctl.plant.kernel import rows
from gyroctl.reports import layout, report
from gyroctl.reports.evaluation import evaluate
from gyroctl.reports.timeseries import LEVELS, PANELS, POINTS, closer_look
from gyroctl.reports.verdict import judge, shown
from gyroctl.simulation.extremes import few_points, middle
from gyroctl.statistics import family, holm, paired_difference

# --- few points for a long record ----------------------------------------------------------------------------------


@pytest.mark.parametrize(("count", "most"), [(17, 16), (1000, 50), (20_001, 20_000), (6001, 2000), (31_415, 320)])
def test_few_points_are_the_extremes_of_each_bucket_in_their_order(count: int, most: int) -> None:
    """Against a search by hand, bucket by bucket."""
    time, values = 0.1 * np.arange(count), np.random.default_rng(count).standard_cauchy((2, count))
    values[1, count // 3 : count // 2] = np.nan
    grid = few_points(time, most)
    assert grid is not None and 0.9 * most - 2 <= grid.time.size <= most
    for own, found in zip(values, grid(values), strict=True):
        at = 0
        for a, b in zip(grid.edges[:-1], grid.edges[1:], strict=True):
            known = [k for k in range(a, b) if own[k] == own[k]]
            if b - a == 1:
                expected = [own[a]]
            elif not known:
                expected = [np.nan, np.nan]
            else:
                least, most_of = min(known, key=lambda k: own[k]), max(known, key=lambda k: own[k])
                expected = [own[k] for k in sorted((least, most_of))]
            np.testing.assert_array_equal(found[at : at + len(expected)], expected)
            assert np.all((grid.time[at : at + len(expected)] >= time[a]) & (grid.time[at] <= time[b - 1]))
            at += len(expected)
        assert at == found.size
        assert (np.nanmin(found), np.nanmax(found)) == (np.nanmin(own), np.nanmax(own))
    assert grid.edges[0] == 0 and grid.edges[-1] == count
    assert np.all(np.diff(grid.time) > 0.0) and (grid.time[0], grid.time[-1]) == (time[0], time[-1])


def test_stretch_in_the_middle_stays_sample_by_sample() -> None:
    time = 0.1 * np.arange(20_000)
    grid = few_points(time, 2000)
    assert grid is not None
    begin, end = middle(time, 120.0)
    assert end - begin == 120.0
    inside = (time > begin + 0.05) & (time < end - 0.05)
    assert set(np.round(time[inside], 6)) <= set(np.round(grid.time, 6))
    values = np.sin(3.0 * time)
    found = dict(zip(np.round(grid.time, 6), grid(values), strict=True))
    assert all(found[t] == v for t, v in zip(np.round(time[inside], 6), values[inside], strict=True))


def test_short_record_stays_as_it_is() -> None:
    assert few_points(np.arange(2000.0), 2000) is None


# --- many laws -----------------------------------------------------------------------------------------------------


def many(laws: int, monkeypatch: pytest.MonkeyPatch, runs: int = 8) -> Any:
    """A comparison of so many laws; one in nine has an oracle."""
    names = ["best_constant", *(f"law_{k}" for k in range(laws - 1))]
    for k, name in enumerate(names[1:]):
        look = {"power": 1.0 + 6.0 * (0.618 * k % 1.0), "information": "oracle" if k % 9 == 4 else "sensors"}
        monkeypatch.setitem(CHARACTERS, name, CHARACTERS["load_angle"]._replace(**look))
    return synthetic(tuple(names), runs, lock=1.0, examples=False)


@pytest.mark.slow
def test_numbers_of_many_laws_are_those_of_the_full_table(monkeypatch: pytest.MonkeyPatch) -> None:
    """Law by law and pair by pair, and no corrected p is smaller than over the pairs it was chosen from."""
    ds = many(40, monkeypatch)
    found = evaluate(ds)
    monkeypatch.setattr(layout, "FEW", 1000)
    full = evaluate(ds)
    assert len(full.power_differences) == 780 and len(found.power_differences) == 39 + 38
    for one, other in zip(found.laws, full.laws, strict=True):
        np.testing.assert_equal(vars(one), vars(other))
    for pair in found.power_differences:
        whole = full.difference(pair.first, pair.second)
        np.testing.assert_equal(pair[:4], whole[:4])
        if "best_constant" in (pair.first, pair.second):
            assert pair.tests == 39 and pair.p_value <= pair.p_holm <= min(1.0, 39 * pair.p_value)
        else:
            assert found.strongest in (pair.first, pair.second)
            assert pair.tests == 780 and pair.p_holm >= whole.p_holm
        rough = found.cv_difference(pair.first, pair.second)
        np.testing.assert_equal(rough[:4], full.cv_difference(pair.first, pair.second)[:4])


def test_pair_that_is_not_listed_is_compared_as_one_of_all(monkeypatch: pytest.MonkeyPatch) -> None:
    ds = many(40, monkeypatch)
    found, power = evaluate(ds), ds.mean_power
    pair = found.difference("law_1", "law_2")
    first, second = (power.sel(law=name).values for name in (pair.first, pair.second))
    assert first.mean() > second.mean()
    estimate, p_value = paired_difference(first, second)
    assert pair.estimate == estimate and pair.tests == 780
    assert pair.p_holm == pytest.approx(min(1.0, 780 * p_value))


def test_strongest_is_the_one_without_an_oracle(monkeypatch: pytest.MonkeyPatch) -> None:
    ds = many(40, monkeypatch)
    causal = ds.law.values[ds.information.values != "oracle"]
    means = {name: float(ds.mean_power.sel(law=name).mean()) for name in causal}
    assert evaluate(ds).strongest == max(means, key=means.__getitem__)


@pytest.mark.parametrize(("laws", "calls"), [(32, 496), (33, 63), (66, 129)])
def test_pairs_grow_with_the_laws_and_not_with_their_square(
    laws: int, calls: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = []
    plain = family.paired_difference

    def counted(*arguments: Any, **more: Any) -> Any:
        made.append(1)
        return plain(np.array([1.0]), np.array([1.0]))

    monkeypatch.setattr(family, "paired_difference", counted)
    found = evaluate(many(laws, monkeypatch))
    assert len(made) == 2 * calls and len(found.power_differences) == calls
    assert bool(found.strongest) == (laws > 32)


def test_pictures_show_the_winner_the_reference_and_the_strongest(monkeypatch: pytest.MonkeyPatch) -> None:
    ds = many(60, monkeypatch, runs=32)
    ds["phi1_p98"][:] = 0.2
    ds["phi1_p98"].loc[{"law": [name for name in ds.law.values if name not in ("law_7", "best_constant")]}] = 0.5
    found = evaluate(ds)
    verdict, laws = judge(found), shown(found)
    assert verdict.winner == "law_7" and "law_7" not in {law.name for law in found.by_power[:32]}
    assert len(laws) == 32 and {"best_constant", verdict.winner} <= {law.name for law in laws}
    others = {law.name for law in found.by_power} - {"best_constant", verdict.winner}
    strongest = [law.name for law in found.by_power if law.name in others][:30]
    assert {law.name for law in laws} == {"best_constant", verdict.winner, *strongest}
    assert judge(replace(found, laws=laws)).winner == verdict.winner
    assert any("1770 pairs of 60 laws" in caveat for caveat in verdict.caveats)
    assert len(verdict.sentences) < 32 + 10


def test_correction_of_chosen_tests_is_no_smaller_than_over_all() -> None:
    rng = np.random.default_rng(3)
    for _ in range(50):
        p = (rng.uniform(size=30) ** 6).tolist()
        chosen = rng.choice(30, 8, replace=False)
        some, every = holm([p[i] for i in chosen], 30), holm(p)
        assert all(a >= every[i] for a, i in zip(some, chosen, strict=True))
        least = np.argsort(p)[:8]
        assert holm([p[i] for i in least], 30) == pytest.approx([every[i] for i in least])
    assert holm([0.01, float("nan")], 5)[0] == pytest.approx(0.05)


# --- long runs -----------------------------------------------------------------------------------------------------


def test_lines_of_the_report_are_short_and_keep_every_peak() -> None:
    ds = synthetic(duration=3000.0)
    found = closer_look(ds, evaluate(ds))
    names, head = layout.names(ds), found["head"]
    steps = np.frombuffer(gzip.decompress(base64.b64decode(found["text"])), "<u2")
    lines = steps.reshape(len(head["ranges"]), len(head["time"]))
    assert len(head["time"]) <= POINTS and len(lines) == 1 + len(PANELS) * len(names)
    np.testing.assert_allclose(head["time"], few_points(ds.time.values, POINTS).time, atol=1e-3)  # type: ignore[union-attr]
    order = [names.index(name) for name in head["laws"]]
    signals = [ds.example_elevation.values[None]]
    signals += [ds[f"example_{signal}"].values[order] for signal, _ in PANELS]
    for line, (low, high), own in zip(lines, head["ranges"], np.concatenate(signals), strict=True):
        assert (low, high) == pytest.approx((own.min(), own.max()), rel=1e-4)
        if high > low:
            assert {0, LEVELS} <= set(line.tolist()), "the least and the greatest of all samples are there"


@pytest.mark.slow
def test_page_of_many_realisations_draws_some_and_those_that_stand_out(monkeypatch: pytest.MonkeyPatch) -> None:
    ds = synthetic(realisations=60, examples=False)
    assert report._few_runs(ds, evaluate(ds))[0] is ds
    monkeypatch.setattr(report, "RUNS", 10)
    monkeypatch.setattr(report, "RUNS_LEAST", 10)
    monkeypatch.setattr(report, "POINTS_OF_RUNS", 10)
    found = evaluate(ds)
    few_ds, few = report._few_runs(ds, found)
    assert 10 <= len(few.seeds) <= 10 + 3 * 2 * ds.sizes["law"] and few.laws is found.laws
    assert few.seeds == tuple(few_ds.realisation.values) and few.seeds[0] == ds.realisation.values[0]
    assert few.seeds[-1] == ds.realisation.values[-1]
    for variable in ("mean_power", "phi1_p98", "phi3_p98"):
        for extreme in (np.min, np.max):
            whole, some = (extreme(table[variable].values, axis=1) for table in (ds, few_ds))
            np.testing.assert_array_equal(some, whole)
    page = report.render(ds)
    assert f"Of 60 realisations {len(few.seeds)} are drawn" in page and "The first 10 of 60" in page


def test_metrics_are_of_the_whole_record_however_few_points_are_kept(
    device: gy.Plant, monkeypatch: pytest.MonkeyPatch
) -> None:
    laws, waves = {"plain": gy.law("constant")}, Realisations(gy.SeaState(), (3,), 120.0)
    settings = Settings(blend=40.0)
    for room in (items, kept):
        monkeypatch.setattr(room, "SERIES", 300)
    whole, few = (
        compare(device, laws, waves, settings, workers=1, quiet=True, tuning_seeds=(), full_series=full)
        for full in (True, False)
    )
    metrics = [name for name in whole.data_vars if not name.startswith("example_") and not name.startswith("step_ms")]
    assert few[metrics].equals(whole[metrics])
    assert whole.time.size == 1200 and few.time.size <= 300
    grid = few_points(whole.time.values, 300)
    assert grid is not None
    for name in (f"example_{signal}" for signal in (*layout.EXAMPLES, "elevation")):
        np.testing.assert_array_equal(few[name].values, grid(whole[name].values))


# --- many runs -----------------------------------------------------------------------------------------------------


def test_row_is_the_metrics_and_little_more() -> None:
    names = [f"metric_{k}" for k in range(70)]
    numbers = np.random.default_rng(1).uniform(size=70)
    row = kept.Row(dict(zip(names, numbers, strict=True)))
    assert row == dict(zip(names, numbers, strict=True)) and row.get("none", 7.0) == 7.0
    with pytest.raises(KeyError):
        row["none"]
    tracemalloc.start()
    before = tracemalloc.get_traced_memory()[0]
    rows = [kept.Row(dict(zip(names, map(float, numbers), strict=True))) for _ in range(2000)]
    each = (tracemalloc.get_traced_memory()[0] - before) / len(rows)
    tracemalloc.stop()
    assert each < 70 * 8 + 300


def test_driver_lets_go_of_what_it_has_handed_on(device: gy.Plant, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 256 results no more are alive at the end than two shares of the work: the one in hand and that before it."""
    made: list[weakref.ref[Outcome]] = []

    def quick(some: Sequence[items.Item]) -> list[Outcome]:
        outcomes = [Outcome(item.sha256, {"mean_power": float(item.seed)}) for item in some]
        made.extend(weakref.ref(outcome) for outcome in outcomes)
        return outcomes

    monkeypatch.setattr(execution, "perform", quick)
    laws = {f"law_{k}": gy.law("constant", cg=1e-4 * (k + 1)) for k in range(4)}
    waves = Realisations(gy.SeaState(), tuple(range(64)), 60.0)
    seen, alive = 0, 0
    for item, outcome in execution.run_items(work_items(device, laws, waves, Settings(blend=20.0), 60.0), 1):
        assert outcome.values["mean_power"] == item.seed
        seen, alive = seen + 1, sum(ref() is not None for ref in made)
    assert seen == len(made) == 256 and alive <= 2 * 16


def test_points_of_all_laws_together_are_bounded() -> None:
    time = 0.1 * np.arange(items.SERIES)
    item = items.Item(*(None,) * 11)  # type: ignore[arg-type]
    outcome = Outcome("", {}, {"time": time, "power": np.sin(time)})
    assert kept.kept(item, outcome, 32).series["power"].size == items.SERIES
    for laws in (33, 500, 2000):
        held = kept.kept(item, outcome, laws).series
        assert laws * held["power"].size <= kept.IN_ALL and held["power"].size == held["time"].size
        assert held["power"].max() == np.sin(time).max()


def test_no_two_long_runs_are_held_at_a_time(device: gy.Plant, monkeypatch: pytest.MonkeyPatch) -> None:
    """Long: their records in all lanes would exceed what they may take. The numbers are those of runs side by side."""
    waves, sizes = Realisations(gy.SeaState(), (1, 2, 3, 4), 60.0), []
    some = work_items(device, {"plain": gy.law("constant")}, waves, Settings(blend=20.0), 60.0)
    beside = items.perform(some)
    plain = items.run_together

    def noting(plant: gy.Plant, loops: Sequence[Any]) -> list[Any]:
        sizes.append(len(loops))
        return plain(plant, loops)

    monkeypatch.setattr(items, "run_together", noting)
    record = 16 * 600 * (rows(device.coefficients) + 7) * 8
    for most, expected in ((record, [4]), (record - 1, [1, 1, 1, 1])):
        sizes.clear()
        monkeypatch.setattr(together, "MEMORY", most)
        found = items.perform(some)
        assert sizes == expected
        for one, other in zip(found, beside, strict=True):
            names = [name for name in other.values if not name.startswith("step_ms")]
            np.testing.assert_equal([one.values[name] for name in names], [other.values[name] for name in names])
