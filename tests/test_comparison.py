"""The fair comparison: identical waves, stored results, refusals, and the same bits whatever the workers."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.comparison import execution
from gyroctl.comparison.compare import Realisations, check_fair, compare
from gyroctl.comparison.items import Item, Outcome
from gyroctl.engine import Store
from gyroctl.harness.run import Settings, run_law
from gyroctl.simulation import evaluate

SEA = gy.SeaState()
WAVES = Realisations(SEA, (3, 1, 8), duration=120.0)
SETTINGS = Settings(blend=40.0)
TIMES = ("step_ms_median", "step_ms_p99")


def laws() -> dict[str, gy.Law]:
    return {"plain": gy.law("constant"), "angle": gy.law("load_angle"), "strong": gy.law("constant", cg=1e-3)}


@pytest.fixture(scope="module")
def ds(device: gy.Plant) -> Any:
    return compare(device, laws(), WAVES, SETTINGS, workers=1, tuning_seeds=[101, 100], quiet=True)


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, int]]:
    """Note which items are performed."""
    seen: list[tuple[str, int]] = []
    plain = execution.perform

    def noting(items: Sequence[Item]) -> list[Outcome]:
        seen.extend((item.name, item.seed) for item in items)
        return plain(items)

    monkeypatch.setattr(execution, "perform", noting)
    return seen


# --- what comes out ----------------------------------------------------------------------------------------------


def test_dataset_has_the_layout_of_results(ds: Any) -> None:
    from gyroctl.reports import check_layout

    check_layout(ds, "results.nc")
    assert ds.sizes["law"] == 3 and ds.sizes["realisation"] == 3 and ds.sizes["time"] == 1200
    assert list(ds.law.values) == ["plain", "angle", "strong"]
    assert list(ds.realisation.values) == [3, 1, 8]
    assert list(ds.information.values) == ["none", "sensors", "none"]
    assert ds.locked.dtype == bool and ds.outside_model.dtype == bool
    for name, variable in ds.data_vars.items():
        assert "units" in variable.attrs and "long_name" in variable.attrs, name
    assert json.loads(ds.attrs["tuning_seeds"]) == [100, 101]
    assert json.loads(ds.attrs["parameters"])["strong"]["cg"] == 1e-3
    assert json.loads(ds.attrs["experiment"])["run"]["seeds"] == [3, 1, 8]


def test_hashes_are_those_of_the_waves_that_acted(device: gy.Plant, ds: Any) -> None:
    for seed, digest in zip(WAVES.seeds, ds.sha256.values, strict=True):
        assert digest == gy.realise(device, SEA, seed, 120.0).blended(40.0).sha256


def test_every_number_is_that_of_the_run_alone(device: gy.Plant, ds: Any) -> None:
    """By hand: realise, blend, run, evaluate."""
    waves = gy.realise(device, SEA, 8, 120.0).blended(40.0)
    record, _ = run_law(device, laws()["angle"], waves, SETTINGS)
    values = evaluate(device, record, waves.moments[1], waves.dt, SEA.wp, 40.0, 1.0)
    for name, value in values.items():
        if name != "capture_width_ratio":
            np.testing.assert_array_equal(float(ds[name].sel(law="angle", realisation=8)), value, err_msg=name)
    assert float(ds.saturations.sel(law="angle", realisation=8)) == record.saturations


def test_capture_width_is_power_over_that_of_the_waves(ds: Any) -> None:
    """Energy of the spectrum times the group speed in 0.7 m of water, by brentq and a trapezoid, over d + c."""
    from scipy.optimize import brentq

    w = np.linspace(1.0, 16.0, 1500)
    k = np.array([brentq(lambda k, w=w_: 9.81 * k * np.tanh(0.7 * k) - w**2, 1e-3, 100.0) for w_ in w])
    power = 1000.0 * 9.81 * np.trapezoid(SEA.spectrum(w) * np.gradient(w, k), w)
    found = ds.mean_power / ds.capture_width_ratio
    np.testing.assert_allclose(found, power * (0.55 + 0.08), rtol=5e-3)


def test_example_is_the_first_realisation(device: gy.Plant, ds: Any) -> None:
    waves = gy.realise(device, SEA, 3, 120.0).blended(40.0)
    record, _ = run_law(device, laws()["strong"], waves, SETTINGS)
    chosen = ds.sel(law="strong")
    np.testing.assert_array_equal(chosen.example_ring_speed, record.states[:-1, 6])
    np.testing.assert_array_equal(chosen.example_power, record.controls[:, 1] * record.states[:-1, 7] ** 2)
    np.testing.assert_array_equal(chosen.example_cg, 1e-3)
    np.testing.assert_allclose(ds.example_elevation, waves.elevation[:-1:2], atol=1e-12)


def test_realisations_by_hand_give_the_same_comparison(device: gy.Plant, ds: Any) -> None:
    waves = [gy.realise(device, SEA, seed, 120.0) for seed in WAVES.seeds]
    other = compare(device, laws(), waves, SETTINGS, workers=1, tuning_seeds=[101, 100], quiet=True)
    assert other.drop_vars(TIMES).equals(ds.drop_vars(TIMES))


def test_two_workers_change_no_bit(device: gy.Plant, ds: Any) -> None:
    other = compare(device, laws(), WAVES, SETTINGS, workers=2, tuning_seeds=[101, 100], quiet=True)
    assert other.drop_vars(TIMES).identical(ds.drop_vars(TIMES).assign_attrs(created=other.attrs["created"]))


def test_order_of_laws_and_seeds_changes_no_bit(device: gy.Plant, ds: Any) -> None:
    turned = dict(reversed(laws().items()))
    other = compare(device, turned, replace(WAVES, seeds=(8, 3, 1)), SETTINGS, workers=1, quiet=True)
    variables = [name for name in ds.data_vars if not name.startswith("example") and name not in TIMES]
    assert other[variables].sel(law=ds.law, realisation=ds.realisation).equals(ds[variables])


# --- stored results ----------------------------------------------------------------------------------------------


def test_finished_runs_are_not_computed_again(
    device: gy.Plant, ds: Any, tmp_path: Path, calls: list[tuple[str, int]], monkeypatch: pytest.MonkeyPatch
) -> None:
    first = compare(device, laws(), WAVES, SETTINGS, workers=1, results=tmp_path, tuning_seeds=[101, 100], quiet=True)
    assert len(calls) == 9 and len(list(tmp_path.glob("*.run"))) == 9
    assert first.drop_vars(TIMES).equals(ds.drop_vars(TIMES))

    def never(items: Sequence[Item]) -> list[Outcome]:
        raise AssertionError("computed again")

    monkeypatch.setattr(execution, "perform", never)
    again = compare(device, laws(), WAVES, SETTINGS, workers=1, results=tmp_path, tuning_seeds=[101, 100], quiet=True)
    assert again.equals(first)


def test_more_laws_and_seeds_add_only_what_is_new(
    device: gy.Plant, tmp_path: Path, calls: list[tuple[str, int]]
) -> None:
    some = {"plain": gy.law("constant")}
    compare(device, some, replace(WAVES, seeds=(3, 1)), SETTINGS, workers=1, results=tmp_path, quiet=True)
    calls.clear()
    compare(device, laws(), WAVES, SETTINGS, workers=1, results=tmp_path, quiet=True)
    assert ("plain", 3) not in calls and ("plain", 1) not in calls
    assert len(calls) == 7


@pytest.mark.parametrize("damage", [b"", b"PK\x03\x04 torn", b"not an archive at all"])
def test_corrupted_result_is_computed_again(
    device: gy.Plant, tmp_path: Path, calls: list[tuple[str, int]], damage: bytes
) -> None:
    one = {"plain": gy.law("constant")}
    first = compare(device, one, WAVES, SETTINGS, workers=1, results=tmp_path, quiet=True)
    files = sorted(tmp_path.glob("*.run"))
    files[1].write_bytes(damage)
    calls.clear()
    again = compare(device, one, WAVES, SETTINGS, workers=1, results=tmp_path, quiet=True)
    assert len(calls) == 1
    assert again.drop_vars(TIMES).equals(first.drop_vars(TIMES))
    calls.clear()
    compare(device, one, WAVES, SETTINGS, workers=1, results=tmp_path, quiet=True)
    assert not calls, "the repaired file was not kept"


def test_truncated_result_is_computed_again(device: gy.Plant, tmp_path: Path, calls: list[tuple[str, int]]) -> None:
    one = {"plain": gy.law("constant")}
    compare(device, one, WAVES, SETTINGS, workers=1, results=tmp_path, quiet=True)
    for file in tmp_path.glob("*.run"):
        content = file.read_bytes()
        file.write_bytes(content[: len(content) // 2])
    calls.clear()
    compare(device, one, WAVES, SETTINGS, workers=1, results=tmp_path, quiet=True)
    assert len(calls) == 3


CHANGES: dict[str, Callable[[gy.Plant], dict[str, Any]]] = {
    "law": lambda plant: {"laws": {"plain": gy.law("constant", cg=4e-4)}},
    "plant": lambda plant: {"plant": plant.replace(d1=1.9)},
    "excitation": lambda plant: {"plant": gy.zhang2017(excitation_phase="magnitude")},
    "sea": lambda plant: {"waves": replace(WAVES, sea=gy.SeaState(hs=0.284))},
    "duration": lambda plant: {"waves": replace(WAVES, duration=130.0)},
    "step": lambda plant: {"settings": replace(SETTINGS, dt=0.005)},
    "blend": lambda plant: {"settings": replace(SETTINGS, blend=30.0)},
    "sensors": lambda plant: {"settings": replace(SETTINGS, sensors=gy.Sensors.ideal())},
    "actuators": lambda plant: {"settings": replace(SETTINGS, actuators=gy.Actuators(delay=1))},
}


@pytest.fixture(scope="module")
def stored(device: gy.Plant, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("runs")
    compare(device, {"plain": gy.law("constant")}, WAVES, SETTINGS, workers=1, results=folder, quiet=True)
    return folder


@pytest.mark.parametrize("change", sorted(CHANGES))
def test_whatever_changes_a_result_is_computed_anew(
    device: gy.Plant, stored: Path, calls: list[tuple[str, int]], change: str
) -> None:
    arguments: dict[str, Any] = {
        "plant": device,
        "laws": {"plain": gy.law("constant")},
        "waves": WAVES,
        "settings": SETTINGS,
    }
    compare(**{**arguments, **CHANGES[change](device)}, workers=1, results=stored, quiet=True)
    assert len(calls) == 3


@dataclass(frozen=True)
class Scaled:
    """A law of plain Python with a part that cannot be described in numbers."""

    scale: Any
    period: float = 0.1
    information: Any = "none"

    def init(self) -> None:
        return None

    def step(self, t: float, y: Any, state: None) -> tuple[tuple[float, float], None]:
        return (0.052, 1e-4 * float(self.scale[0])), state


@pytest.mark.slow
def test_law_with_an_array_is_told_apart_by_its_content(device: gy.Plant, tmp_path: Path) -> None:
    one = replace(WAVES, seeds=(1,))
    powers = [
        float(compare(device, {"x": Scaled(np.array([s]))}, one, SETTINGS, 1, tmp_path, quiet=True).generated_w[0, 0])
        for s in (2.0, 3.0, 2.0)
    ]
    assert powers[1] > 1.2 * powers[0] and powers[2] == powers[0]
    assert len(list(tmp_path.glob("*.run"))) == 2


def user_law(gain: str) -> str:
    return (
        "from typing import NamedTuple\n"
        f"def gain(): return {gain}\n"
        "class Mine(NamedTuple):\n"
        "    cc: float = 0.052\n"
        "    period: float = 0.1\n"
        "    information = 'none'\n"
        "    def init(self): return ()\n"
        "    def step(self, t, y, state): return (self.cc, gain()), state\n"
    )


@pytest.mark.slow
def test_edited_file_of_a_user_is_never_answered_from_the_store(device: gy.Plant, tmp_path: Path) -> None:
    """The class stays as it is, a helper in its file changes."""
    file, one = tmp_path / "mine.py", replace(WAVES, seeds=(1,))
    powers = []
    for gain in ("2e-4", "4e-4"):
        file.write_text(user_law(gain))
        law = gy.law(f"{file}:Mine")
        found = compare(device, {"m": law}, one, SETTINGS, 1, tmp_path / "runs", quiet=True)
        powers.append(float(found.generated_w[0, 0]))
    assert powers[1] > 1.5 * powers[0]


def test_interrupted_comparison_resumes(
    device: gy.Plant, ds: Any, tmp_path: Path, calls: list[tuple[str, int]], monkeypatch: pytest.MonkeyPatch
) -> None:
    noting = execution.perform

    def interrupted(items: Sequence[Item]) -> list[Outcome]:
        if len(calls) == 5:
            raise KeyboardInterrupt
        return noting(items)

    monkeypatch.setattr(execution, "perform", interrupted)
    with pytest.raises(KeyboardInterrupt):
        compare(device, laws(), WAVES, SETTINGS, workers=1, results=tmp_path, quiet=True)
    kept = len(list(tmp_path.glob("*.run")))
    assert 1 <= kept <= 5 and not list(tmp_path.glob("*.part*"))
    calls.clear()
    monkeypatch.setattr(execution, "perform", noting)
    whole = compare(device, laws(), WAVES, SETTINGS, workers=1, results=tmp_path, tuning_seeds=[101, 100], quiet=True)
    assert len(calls) == 9 - kept
    assert whole.drop_vars(TIMES).equals(ds.drop_vars(TIMES))


# --- fairness ----------------------------------------------------------------------------------------------------


def outcomes(*hashes: str) -> list[Outcome]:
    return [Outcome(digest, {}) for digest in hashes]


def test_runs_on_different_waves_are_refused() -> None:
    check_fair({"a": outcomes("1", "2"), "b": outcomes("1", "2")})
    with pytest.raises(gy.InputError, match=r"laws\.b = 'x': realisation 2 differs from that of a \(2\)"):
        check_fair({"a": outcomes("1", "2"), "b": outcomes("1", "x")})
    with pytest.raises(gy.InputError, match="differs"):
        check_fair({"a": outcomes("1", "2"), "b": outcomes("2", "1")})


def test_foreign_waves_in_the_store_are_refused(device: gy.Plant, tmp_path: Path) -> None:
    """A result stored under the right key with other waves in it, however it got there."""
    compare(device, laws(), WAVES, SETTINGS, workers=1, results=tmp_path, quiet=True)
    store = Store(tmp_path)
    record = store.load(next(store.files()).stem)
    assert record is not None
    other = {**record.content, "sha256": record.content["sha256"][::-1]}
    store.save(record.key, other, record.arrays, record.about)
    with pytest.raises(gy.InputError, match="identical waves only"):
        compare(device, laws(), WAVES, SETTINGS, workers=1, results=tmp_path, quiet=True)


@pytest.mark.parametrize(
    ("field", "words", "change"),
    [
        ("laws", "nothing to compare", {"laws": {}}),
        ("run.seeds", "no realisations", {"waves": replace(WAVES, seeds=())}),
        ("run.seeds", "repeats", {"waves": replace(WAVES, seeds=(1, 2, 1))}),
        ("run.seeds", "used for tuning", {"tuning_seeds": (8, 9)}),
        ("run.seeds", "same waves", {"waves": Realisations(gy.Regular(0.2, 3.14), (1, 2), 120.0)}),
        ("waves", "no realisations", {"waves": []}),
        ("run.duration", "blend", {"settings": Settings(blend=121.0)}),
        ("run.duration", "blend", {"settings": Settings(blend=120.0)}),
        ("run.dt", "unstable", {"settings": Settings(blend=40.0, dt=0.08)}),
        ("sea.hs", "locked orbit", {"waves": replace(WAVES, sea=gy.SeaState(hs=0.005))}),
    ],
)
def test_unfair_or_impossible_comparison_is_refused(
    device: gy.Plant, tmp_path: Path, field: str, words: str, change: dict[str, Any]
) -> None:
    arguments: dict[str, Any] = {"plant": device, "laws": laws(), "waves": WAVES, "settings": SETTINGS}
    with pytest.raises(gy.InputError, match=words) as caught:
        compare(**{**arguments, **change}, workers=1, results=tmp_path / "runs", quiet=True)
    assert caught.value.field == field and caught.value.mend
    if words != "same waves":
        assert not (tmp_path / "runs").exists(), "half-written"


def test_waves_of_different_seas_are_refused(device: gy.Plant) -> None:
    waves = [gy.realise(device, sea, 1, 120.0) for sea in (SEA, gy.SeaState(gamma=1.0))]
    with pytest.raises(gy.InputError, match="different seas"):
        compare(device, laws(), waves, SETTINGS, workers=1, quiet=True)


def test_bad_law_fails_alone_and_keeps_nothing_of_its_own(device: gy.Plant, tmp_path: Path) -> None:
    bad: dict[str, gy.Law] = {"bad": Scaled(np.array([np.nan]))}
    ds = compare(device, bad, WAVES, SETTINGS, workers=1, results=tmp_path / "runs", quiet=True)
    assert ds.failed.values.all() and all("'bad'" in reason for reason in ds.failure.values.ravel())
    assert not list(tmp_path.rglob("*.run"))


@pytest.fixture(scope="module")
def regular(device: gy.Plant) -> Iterator[Any]:
    waves = Realisations(gy.Regular(0.2, 3.14), (1,), 120.0)
    yield compare(device, {"plain": gy.law("constant")}, waves, SETTINGS, workers=1, quiet=True)


def test_regular_sea_gives_the_power_of_its_orbit(device: gy.Plant, regular: Any) -> None:
    """The start on the orbit and the blend from the regular wave to itself change nothing: no transient at all."""
    law = gy.law("constant")
    orbit = gy.lock_orbit(device, gy.Regular(0.2, 3.14), law.cc, law.cg)  # type: ignore[attr-defined]
    assert float(regular.generated_w[0, 0]) == pytest.approx(orbit.power, rel=1e-4)
    assert bool(regular.locked[0, 0]) and float(regular.cycle_slips[0, 0]) == 0.0
    assert float(regular.power_cv[0, 0]) < 0.05


@pytest.mark.slow
def test_python_laws_on_processes_give_the_bits_of_one_worker(device: gy.Plant) -> None:
    law: dict[str, gy.Law] = {"python": Scaled(np.array([3.0]))}
    two = replace(WAVES, seeds=(1, 2))
    one, other = (compare(device, law, two, SETTINGS, workers=workers, quiet=True) for workers in (1, 2))
    assert one.drop_vars(TIMES).equals(other.drop_vars(TIMES))
