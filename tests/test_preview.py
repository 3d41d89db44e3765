"""What a law can see decides: windows that open as time goes on, the level at which a law is judged, the verdict."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.comparison.compare import Realisations, compare
from gyroctl.harness.law_check import check_law
from gyroctl.harness.run import lead_in, run_law
from gyroctl.harness.sight import LONGEST_PLAN, Sight, informed, sight
from gyroctl.reports import evaluate, judge, results_table, summarise
from gyroctl.reports.wording import sees
from gyroctl.studies.evaluation.entrants import kind
from gyroctl.waves.window import Shutter, Window

PAIR = (0.0582, 4e-4)
SETTINGS = gy.Settings(blend=10.0)


@dataclass(frozen=True)
class Looker:
    """A constant pair that notes what it is handed, and adds what it reads `ahead` of now to its command."""

    information: str = "forecast"
    ahead: float = 0.0  # where it reads [s]
    period: float = 0.1
    waves: Any = None

    def informed(self, waves: Any) -> Any:
        return replace(self, waves=waves)

    def init(self) -> tuple[()]:
        return ()

    def step(self, t: float, y: Any, state: tuple[()]) -> Any:
        if self.waves is None:
            return PAIR, state
        at = round((t + self.ahead) / self.waves.dt)
        moments = self.waves.moments
        read = moments[1, min(at, moments.shape[1] - 1)]
        return (PAIR[0] + 1e-6 * read, PAIR[1]), state


@dataclass(frozen=True)
class Declared(Looker):
    """The same, which declares how far it looks and plans."""

    preview: float = 1.0
    horizon: float = 3.0


class Silent(NamedTuple):
    """A law of numbers alone, compiled."""

    information: str = "sensors"
    period: float = 0.1

    def informed(self, waves: Any) -> Any:
        raise AssertionError("a law that goes by its sensors was handed the waves")

    def init(self) -> tuple[()]:
        return ()

    def step(self, t: float, y: Any, state: tuple[()]) -> Any:
        return (0.0582, 4e-4), state


@pytest.fixture(scope="module")
def waves(device: gy.Plant) -> Any:
    return lead_in(gy.realise(device, gy.SeaState(), 100200, 40.0), SETTINGS)


# --- the window -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("preview", [0.0, 0.05, 1.0, 3.97, 100.0])
def test_window_holds_the_waves_up_to_the_preview_and_nothing_beyond(waves: Any, preview: float) -> None:
    shutter = Shutter(waves, preview)
    window = shutter.window
    for t in (0.0, 0.1, 7.3, 7.2, 39.9, 50.0):
        shutter.open(t)
        latest = max(t, 7.3) if t == 7.2 else t  # what was seen stays
        times = waves.dt * np.arange(waves.moments.shape[1])
        open_ = times <= latest + preview + 1e-6
        np.testing.assert_array_equal(window.moments[:, open_], waves.moments[:, open_])
        assert np.isnan(window.moments[:, ~open_]).all()


def test_window_holds_nothing_from_which_the_waves_could_be_had(waves: Any) -> None:
    window = Shutter(waves, 1.0).window
    assert {name for name in vars(window)} == {"moments", "dt", "duration", "preview", "deviation", "seed"}
    assert window.seed != waves.seed
    with pytest.raises(ValueError, match="read-only"):
        window.moments[0, 0] = 1.0
    owner = window.moments.base
    assert owner is None or not np.isfinite(owner[:, 30:]).any()


def test_law_reads_within_its_preview_what_is_there(device: gy.Plant, waves: Any) -> None:
    record, _ = run_law(device, Declared(ahead=1.0, preview=1.0), waves, SETTINGS)
    times = np.arange(record.commands.shape[0]) * record.period
    at = np.minimum(np.rint((times + 1.0) / waves.dt).astype(int), waves.moments.shape[1] - 1)
    np.testing.assert_array_equal(record.commands[:, 0], PAIR[0] + 1e-6 * waves.moments[1, at])


@pytest.mark.parametrize("law", [Declared(ahead=1.1, preview=1.0), Declared(ahead=4.0, preview=0.0)])
def test_law_that_reads_beyond_its_preview_reads_nothing(device: gy.Plant, waves: Any, law: Any) -> None:
    with pytest.raises(gy.LawError, match="not finite"):
        run_law(device, law, waves, SETTINGS)


def test_law_that_copies_its_window_at_the_start_has_what_was_open_then(device: gy.Plant, waves: Any) -> None:
    law, _ = informed(Declared(preview=2.0), waves, device)
    copy = np.array(law.waves.moments)  # type: ignore[attr-defined]
    seen = round(2.0 / waves.dt) + 1
    assert np.isfinite(copy[:, :seen]).all() and np.isnan(copy[:, seen:]).all()


@pytest.mark.parametrize("lead", [0.0, 1.0])
def test_commands_do_not_depend_on_waves_beyond_the_preview(device: gy.Plant, waves: Any, lead: float) -> None:
    """Other waves from t = 20 s on: the commands before 20 s less the preview keep every bit."""
    other = gy.realise(device, gy.SeaState(), 100201, 40.0)
    moments = waves.moments.copy()
    cut = round(20.0 / waves.dt) + 1
    moments[:, cut:] = other.moments[:, cut:]
    law = gy.law("nmpc", information="forecast", lead=lead)
    first, _ = run_law(device, law, waves, SETTINGS)
    second, _ = run_law(device, law, replace(waves, moments=moments), SETTINGS)
    same = round((20.0 - lead) / first.period) - 1
    np.testing.assert_array_equal(first.commands[:same], second.commands[:same])
    assert not np.array_equal(first.commands, second.commands)


class Told(NamedTuple):
    """A planner that was told all beforehand, as a law from sensors: nothing opens or closes for it."""

    inner: Any
    period: float = 0.1
    information: str = "sensors"

    def init(self) -> Any:
        return self.inner.init()

    def step(self, t: float, y: Any, state: Any) -> Any:
        return self.inner.step(t, y, state)


@pytest.mark.parametrize("lead", [0.0, 2.0])
def test_planner_sees_through_its_window_what_it_saw_of_the_whole(device: gy.Plant, waves: Any, lead: float) -> None:
    law: Any = gy.law("nmpc", information="forecast", lead=lead)
    through, _ = run_law(device, law, waves, SETTINGS)
    whole, _ = run_law(device, Told(law.informed(waves)), waves, SETTINGS)  # type: ignore[arg-type]
    np.testing.assert_array_equal(through.commands, whole.commands)


def test_probe_of_a_window_has_its_error(device: gy.Plant, waves: Any) -> None:
    runs = [
        run_law(device, gy.law("nmpc", information="forecast", lead=2.0, noise=noise), waves, SETTINGS)[0].commands
        for noise in (0.0, 0.3, 0.3)
    ]
    np.testing.assert_array_equal(runs[1], runs[2])
    assert not np.array_equal(runs[0], runs[1])


# --- the level ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("law", [Silent(), Silent("none"), replace(Looker(), information="sensors")])
def test_law_from_sensors_never_gets_the_realisation(device: gy.Plant, waves: Any, law: Any) -> None:
    assert informed(law, waves, device) == (law, None)
    record, _ = run_law(device, law, waves, SETTINGS)
    np.testing.assert_array_equal(record.commands, np.tile(PAIR, (record.commands.shape[0], 1)))
    assert sight(law).preview == 0.0


@pytest.mark.parametrize(
    ("law", "expected"),
    [
        (Declared(preview=1.0, horizon=3.0), Sight("forecast", 1.0)),
        (Declared(preview=0.0, horizon=3.0), Sight("forecast", 0.0)),
        (Declared(preview=3.0, horizon=3.0), Sight("oracle", 3.0)),
        (Declared(preview=5.0, horizon=3.0), Sight("oracle", 5.0)),
        (Declared(preview=3.9, horizon=8.0), Sight("forecast", 3.9)),
        (Declared(preview=LONGEST_PLAN, horizon=1e6), Sight("oracle", LONGEST_PLAN)),
        (Declared(preview=math.inf, horizon=math.inf), Sight("oracle", math.inf)),
        (Looker(), Sight("oracle", math.inf)),
        (replace(Declared(), information="oracle"), Sight("oracle", math.inf)),
        (replace(Declared(preview=4.0), information="sensors"), Sight("sensors", 0.0)),
    ],
)
def test_what_a_law_can_see_decides(law: Any, expected: Sight) -> None:
    assert sight(law) == expected
    assert kind(law) == ("simple" if expected.level == "sensors" else "planning")


@pytest.mark.parametrize(
    ("parameters", "expected"),
    [
        ({}, ("sensors", 0.0)),
        ({"information": "oracle"}, ("oracle", math.inf)),
        ({"information": "forecast"}, ("forecast", 0.0)),
        ({"information": "forecast", "lead": 1.0}, ("forecast", 1.0)),
        ({"information": "forecast", "lead": 2.0}, ("forecast", 2.0)),
        ({"information": "forecast", "lead": 2.0, "horizon": 2.0}, ("oracle", 2.0)),
        ({"information": "forecast", "lead": 4.0}, ("oracle", 4.0)),
        ({"information": "forecast", "lead": 4.0, "horizon": 8.0}, ("oracle", 4.0)),
        ({"information": "forecast", "lead": 60.0}, ("oracle", 60.0)),
    ],
)
@pytest.mark.parametrize("wrapped", [False, True])
def test_planner_by_its_lead(parameters: dict[str, Any], expected: tuple[str, float], wrapped: bool) -> None:
    law = gy.law("nmpc", **parameters)
    if wrapped:
        law = gy.law("supervisor", wraps={"law": "nmpc", **parameters})
    assert sight(law) == pytest.approx(expected)


def test_planner_without_preview_says_so() -> None:
    law: Any = gy.law("nmpc", information="forecast", lead=0.26)
    assert law.preview == pytest.approx(0.3), "to whole samples, as its probe tells them"
    with pytest.raises(gy.InputError, match="time"):
        sight(Declared(preview=math.nan))


# --- the verdict ----------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_no_oracle_wins_whatever_it_calls_itself(device: gy.Plant) -> None:
    waves = Realisations(gy.SeaState(), (1, 2), duration=60.0)
    laws: dict[str, Any] = {
        "weak": gy.law("constant", cc=0.05, cg=2e-4),
        "whole": Looker(),
        "full": Declared(preview=3.0, horizon=3.0),
        "some": Declared(preview=1.0, horizon=3.0),
    }
    ds = compare(device, laws, waves, SETTINGS, workers=1, quiet=True)
    assert dict(zip(ds.law.values, ds.information.values, strict=True)) == {
        "weak": "none",
        "whole": "oracle",
        "full": "oracle",
        "some": "forecast",
    }
    np.testing.assert_array_equal(ds.preview, [0.0, math.inf, 3.0, 1.0])
    forced = ds.copy(deep=True)
    forced["locked"][:] = True
    for name, power in (("weak", 1.0), ("whole", 9.0), ("full", 8.0), ("some", 2.0)):
        forced["mean_power"].loc[{"law": name}] = power
    verdict = judge(evaluate(forced))
    text = " ".join(verdict.sentences)
    assert verdict.winner == "some"
    assert "knows the future waves (oracle)" in text
    assert "is told the waves 3 s ahead, as far as it plans (oracle)" in text
    assert "some is told the waves 1 s ahead; of the laws without a preview weak gives the most power, 1.00 W" in text
    cells = list(results_table(forced).columns[-1].cells)
    assert set(cells) == {"oracle", "oracle 3 s", "forecast 1 s", "none"}
    found = summarise(forced)["laws"]
    assert (found["full"]["preview_s"], found["whole"]["preview_s"], found["some"]["information"]) == (
        3.0,
        None,
        "forecast",
    )


def test_words_of_what_a_law_sees() -> None:
    assert [sees("sensors", 0.0), sees("none", 0.0), sees("forecast", 0.0), sees("oracle", math.inf)] == [
        "sensors",
        "none",
        "forecast 0 s",
        "oracle",
    ]
    assert sees("forecast", math.nan) == "forecast", "a file that does not tell"


FORECAST = '''
from dataclasses import dataclass, replace
from typing import Any

@dataclass(frozen=True)
class Law:
    """Reads a second ahead, and says so."""

    ahead: float = {ahead}
    preview: float = 1.0
    horizon: float = 3.0
    period: float = 0.1
    information: str = "forecast"
    waves: Any = None

    def informed(self, waves):
        return replace(self, waves=waves)

    def init(self):
        return ()

    def step(self, t, y, state):
        at = min(round((t + self.ahead) / self.waves.dt), self.waves.moments.shape[1] - 1)
        return (0.0582 + 1e-6 * float(self.waves.moments[0, at]), 4e-4), state
'''


@pytest.mark.parametrize(("ahead", "kept"), [(1.0, True), (1.2, False)])
def test_check_of_a_law_tells_whether_it_keeps_its_preview(
    device: gy.Plant, tmp_path: Path, ahead: float, kept: bool
) -> None:
    file = tmp_path / "law.py"
    file.write_text(FORECAST.format(ahead=ahead))
    checks = {check.name: check for check in check_law(f"{file}:Law", device, runs=2)}
    assert checks["information"].passed and "1 s ahead" in checks["information"].found
    if kept:
        assert all(checks[name].passed for name in ("answer", "pure step", "repeatable", "bounds"))
    else:
        assert "runs" in checks and not checks["runs"].passed


def test_windows_are_not_shared_between_runs(device: gy.Plant, waves: Any) -> None:
    law = Declared(ahead=1.0)
    first, _ = run_law(device, law, waves, SETTINGS)
    second, _ = run_law(device, law, waves, SETTINGS)
    np.testing.assert_array_equal(first.commands, second.commands)
    assert isinstance(informed(law, waves, device)[0].waves, Window)  # type: ignore[attr-defined]
