"""Every setting: a value out of bounds is refused by field, value and mend; what is accepted is a run one can make."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

import gyroctl as gy
from gyroctl.cli.app import app
from gyroctl.comparison.compare import check_motion_limit, check_workers
from gyroctl.comparison.experiment import RunTable, build_experiment
from gyroctl.harness.run_size import SAMPLES_MAX, STEPS_MAX, RunSize, run_size
from gyroctl.studies.evaluation.request import request as evaluation_request
from gyroctl.studies.evaluation.seeds import seed_plan
from gyroctl.studies.margins import margin_report
from gyroctl.studies.margins import request as margin_request
from gyroctl.tuning.task import read_task
from gyroctl.tuning.tune import tune
from gyroctl.tuning.waters import Circumstances
from gyroctl.waves import DriftingSea

WILD = (math.nan, math.inf, -math.inf, 1e30, -1e30)

PLANT = gy.zhang2017()


def asked(**changes: Any) -> Any:
    given = {"height": 0.2, "wp": 3.14, "cc": 0.052, "cg": 3.5e-4, **changes}
    return margin_request(PLANT, **given)


REFUSED: list[tuple[str, Callable[[Any], Any], tuple[Any, ...]]] = [
    ("run.dt", lambda v: gy.Settings(dt=v), (*WILD, 0.0, -0.01, 1e-12, 60.0, "a", True)),
    ("run.blend", lambda v: gy.Settings(blend=v), (*WILD, -1.0, 1e9, "a")),
    ("sensors", lambda v: gy.Settings(sensors=v), (None, 0.1, gy.Channel())),
    ("actuators", lambda v: gy.Settings(actuators=v), (None, 0.1)),
    *[
        (f"actuators.{name}", lambda v, name=name: gy.Actuators(**{name: v}), (*WILD, -1.0, 1e-300, "a"))
        for name in (f.name for f in fields(gy.Actuators))
        if name not in ("cg_min", "delay")
    ],
    ("actuators.period", lambda v: gy.Actuators(period=v), (0.0, 1e-9, 1e9)),
    ("actuators.delay", lambda v: gy.Actuators(delay=v), (*WILD, -1, 0.5, 10**12)),
    ("actuators.cg_min", lambda v: gy.Actuators(cg_min=v), (*WILD, 0.02, -1e6, -1e-300)),
    *[
        (f"sensors.psi.{name}", lambda v, name=name: gy.Sensors(psi=gy.Channel(**{name: v})), (*WILD, -1e-300, "a"))
        for name in (f.name for f in fields(gy.Channel))
    ],
    ("sensors.psi.delay", lambda v: gy.Sensors(psi=gy.Channel(delay=v)), (10**12, 0.5, -1)),
    ("sensors.psi.dropout", lambda v: gy.Sensors(psi=gy.Channel(dropout=v)), (1.0, 1.5, -0.1)),
    ("sensors.psi", lambda v: gy.Sensors(psi=v), (0.1, None)),
    ("run.duration", lambda v: RunTable(duration=v), (*WILD, 0.0, -1.0, 1e9)),
    ("run.dt", lambda v: RunTable(dt=v), (*WILD, 0.0, 1e-12)),
    ("run.blend", lambda v: RunTable(blend=v), (*WILD, -1.0)),
    ("run.motion_limit", lambda v: RunTable(motion_limit=v), (*WILD, 0.0, -0.3, 20.0)),
    ("run.motion_limit", check_motion_limit, (*WILD, 0.0, 20.0)),
    ("run.seeds", lambda v: RunTable(seeds=v), ((-1,), (1.5,), (2**63,), tuple(range(100_001)))),
    ("workers", check_workers, (-1, 10**9, 1.5, math.nan)),
    ("sea.hs", lambda v: gy.SeaState(hs=v), (*WILD, 0.0, -0.3, 283.0)),
    ("sea.wp", lambda v: gy.SeaState(wp=v), (*WILD, 0.0, 1e3)),
    ("sea.gamma", lambda v: gy.SeaState(gamma=v), (*WILD, 0.5, 1e4)),
    ("sea.heading", lambda v: gy.SeaState(heading=v), (*WILD, 200.0)),
    ("sea.height", lambda v: gy.Regular(v, 3.14), (*WILD, 0.0, 200.0)),
    ("sea.wp", lambda v: gy.Regular(0.2, v), (*WILD, 0.0, 1e3)),
    ("sea.heights", lambda v: gy.Bichromatic((v, 0.1), (3.0, 3.3)), (*WILD, 0.0, 200.0)),
    ("sea.frequencies", lambda v: gy.Bichromatic((0.1, 0.1), (v, 3.3)), (*WILD, 0.0, 1e3)),
    ("sea.over", lambda v: DriftingSea(over=v), (*WILD, 0.0, 1.0)),
    ("sea.wp_end", lambda v: DriftingSea(wp_end=v, over=9e5), (*WILD, 0.0, 101.0)),
    ("run.seeds", lambda v: gy.realise(PLANT, gy.SeaState(), v, 100.0), (-1, 1.5, 2**63, "1", True)),
    ("run.duration", lambda v: gy.realise(PLANT, gy.SeaState(), 1, v), (*WILD, 0.0, 1e9)),
    ("run.dt", lambda v: gy.realise(PLANT, gy.SeaState(), 1, 100.0, v), (*WILD, 0.0, 1e-12, 1.0)),
    ("height", lambda v: asked(height=v), (*WILD, 0.0, 30.0)),
    ("wp", lambda v: asked(wp=v), (*WILD, 0.0, 1e3)),
    ("cc", lambda v: asked(cc=v), (*WILD, 0.0, 5.0)),
    ("cg", lambda v: asked(cg=v), (*WILD, 0.0, 1e3)),
    ("sense", lambda v: asked(sense=v), (0, 2, math.nan)),
    ("samples", lambda v: margin_report(asked(), Path("out"), v, quiet=True), (0, -1, 10**9, 1.5, math.nan)),
    ("budget", lambda v: tune(read_task("constant"), "all", Circumstances(PLANT), v, quiet=True), (*WILD, 0.0, 1e3)),
    ("duration", lambda v: evaluation_request(Path("out"), "coupling", duration=v), (*WILD, 0.0, 50.0, 1e9)),
    ("budget", lambda v: evaluation_request(Path("out"), "coupling", budget=v), (*WILD, 0.0)),
    ("workers", lambda v: evaluation_request(Path("out"), "coupling", workers=v), (-1, 10**9)),
    ("seeds", lambda v: seed_plan([v]), ("1:999999999999", "0:-1", "a", "")),
]


@pytest.mark.parametrize(("field", "build", "values"), REFUSED, ids=[f"{i}-{row[0]}" for i, row in enumerate(REFUSED)])
def test_value_out_of_bounds_is_refused_by_field_value_and_mend(
    field: str, build: Callable[[Any], Any], values: tuple[Any, ...]
) -> None:
    for value in values:
        with pytest.raises(gy.InputError) as caught:
            build(value)
        assert caught.value.field == field, (value, caught.value)
        assert caught.value.problem and len(caught.value.mend) > 5, value


COMMANDS = [
    ("simulate --law constant --hs 283", "sea.hs"),
    ("simulate --law constant --dt 1e-12", "run.dt"),
    ("simulate --law constant --duration 1e9", "run.duration"),
    ("simulate --law constant --duration nan", "duration"),
    ("simulate --law constant --blend=-5", "run.blend"),
    ("simulate --law constant --seed=-1", "run.seeds"),
    ("simulate --law constant --motor nan", "motor"),
    ("simulate --law constant --motor=-0.02", "motor"),
    ("simulate --law constant --wp 1e-9", "sea.wp"),
    ("margins --height 30", "height"),
    ("margins --samples 0", "samples"),
    ("margins --cc 5", "cc"),
    ("lockmap --height 30", "height"),
    ("lockmap --cg nan", "cg"),
    ("bound --seeds 1-999999999999", "seeds"),
    ("bound --duration 1e9", "duration"),
    ("bound --hs 30", "sea.hs"),
    ("evaluate --duration inf", "duration"),
    ("evaluate --budget nan", "budget"),
    ("evaluate --seeds 1:99999999999", "seeds"),
    ("evaluate --workers 99999", "--workers"),
    ("compare --workers 99999", "--workers"),
    ("tune constant --workers 99999", "--workers"),
    ("laws check constant --runs 999999", "--runs"),
    ("laws check constant --runs 1", "--runs"),
]


@pytest.mark.parametrize(("line", "field"), COMMANDS, ids=[line for line, _ in COMMANDS])
def test_option_out_of_bounds_is_refused_and_nothing_written(
    line: str, field: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    out = [] if line.startswith("laws") else ["--out", "out.nc"]
    done = CliRunner().invoke(app, [*line.split(), *out])
    if isinstance(done.exception, gy.InputError):
        assert done.exception.field == field
    else:
        assert done.exit_code == 2 and field in done.output
    assert list(tmp_path.iterdir()) == []


# --- whatever is accepted can be run -----------------------------------------------------------------------------

numbers = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True),
    st.floats(1e-3, 3000.0),
    st.sampled_from([0, 1, 2, 10**12, -1, 1e-12, 1e-300, 0.01, 0.1, 0.05, 100.0, 600.0, 2000.0]),
)


def table(kind: type, but: tuple[str, ...] = ()) -> st.SearchStrategy[dict[str, Any]]:
    names = [f.name for f in fields(kind) if f.name not in but]
    return st.dictionaries(st.sampled_from(names), numbers, max_size=2)


experiments = st.fixed_dictionaries(
    {},
    optional={
        "run": table(RunTable, ("seeds", "start")),
        "sea": table(gy.SeaState),
        "actuators": table(gy.Actuators),
        "sensors": st.dictionaries(
            st.sampled_from([f.name for f in fields(gy.Sensors)]), table(gy.Channel), max_size=1
        ),
    },
)


@settings(max_examples=300, deadline=None)
@given(experiments, st.lists(st.integers(-2, 2**70), min_size=1, max_size=3))
def test_no_setting_gives_anything_but_refusal_or_a_run_one_can_make(tables: dict[str, Any], seeds: list[int]) -> None:
    run = {**tables.get("run", {}), "seeds": seeds}
    try:
        setup = build_experiment({**tables, "run": run, "laws": {"constant": {}}})
        plan = run_size(setup.run.duration, setup.run.dt, setup.actuators.period, setup.plant.parameters.time_scale)
        sensing = setup.sensors.arrays(10, setup.run.seeds[0])
        acting = setup.actuators.arrays()
    except gy.InputError as refusal:
        assert refusal.field and refusal.mend
        return
    assert 0 < plan.steps <= STEPS_MAX and 0 <= plan.samples <= SAMPLES_MAX
    assert np.all(np.isfinite(sensing.error)) and np.all(np.isfinite(sensing.quantum))
    assert (
        np.all(np.isfinite(acting.limit))
        and np.all(np.isfinite(acting.quantum))
        and np.all(np.isfinite([acting.rate, acting.lag]))
    )
    assert np.all(acting.rate >= 0.0) and np.all(acting.lag >= 0.0)
    assert np.isfinite(setup.sea.spectrum([setup.sea.wp])).all()  # type: ignore[union-attr]


def test_size_of_a_run() -> None:
    assert run_size(2000.0, 0.01, 0.1) == RunSize(20000, 200000)
    with pytest.raises(gy.InputError, match=r"run.duration = 100000.0: makes 1e\+08 samples"):
        run_size(1e5, 0.01, 1e-3)
    with pytest.raises(gy.InputError, match=r"run.dt = 1e-05: makes 1e\+10 steps"):
        run_size(1e5, 1e-5, 0.1)


def test_step_as_long_as_a_part_of_the_wave_is_refused(device: gy.Plant) -> None:
    """It asks for so little accuracy that the run says nothing; a larger device has slower waves."""
    waves, law = gy.realise(device, gy.SeaState(), 100000, 40.0), gy.law("constant", cc=0.05, cg=2e-4)
    with pytest.raises(gy.InputError, match=r"run.dt = 0.5: is too coarse a step .* at most 0.1 s"):
        gy.simulate(device, law, waves, gy.Settings(dt=0.5, blend=20.0))
    with pytest.raises(gy.InputError, match=r"run.dt = 0.2: is too coarse a step"):
        build_experiment({"run": {"dt": 0.2}, "laws": {"constant": {}}})
    assert run_size(600.0, 0.1, 0.1).samples == 6000
    assert run_size(600.0, 0.6, 0.7, time_scale=50.0**0.5).samples == 857
    with pytest.raises(gy.InputError, match=r"at most 0.707 s"):
        run_size(600.0, 0.8, 0.7, time_scale=50.0**0.5)


# --- waves that cannot be ----------------------------------------------------------------------------------------


def miche(wp: float, depth: float) -> float:
    """Height of the steepest wave by bisection of the dispersion relation, apart from the code under test. [m]"""
    low, high = 1e-6, 1e3
    for _ in range(200):
        k = math.sqrt(low * high)
        low, high = (k, high) if 9.81 * k * math.tanh(k * depth) < wp**2 else (low, k)
    return 0.142 * 2.0 * math.pi / k * math.tanh(k * depth)


@pytest.mark.parametrize("wp", [2.6, 3.14, 3.6])
def test_sea_is_refused_where_its_equivalent_wave_breaks(wp: float) -> None:
    limit = miche(wp, PLANT.depth)
    gy.realise(PLANT, gy.SeaState(hs=0.99 * math.sqrt(2.0) * limit, wp=wp), 1, 50.0)
    gy.realise(PLANT, gy.Regular(0.99 * limit, wp), 1, 50.0)
    gy.lock_orbit(PLANT, gy.Regular(0.99 * limit, wp), 0.052, 3.5e-4, nearest=False)
    cases: list[tuple[str, Callable[[], Any]]] = [
        ("sea.hs", lambda: gy.realise(PLANT, gy.SeaState(hs=1.01 * math.sqrt(2.0) * limit, wp=wp), 1, 50.0)),
        ("sea.height", lambda: gy.realise(PLANT, gy.Regular(1.01 * limit, wp), 1, 50.0)),
        ("height", lambda: gy.lock_orbit(PLANT, gy.Regular(1.01 * limit, wp), 0.052, 3.5e-4)),
    ]
    for field, call in cases:
        with pytest.raises(gy.InputError, match="breaks on waves") as caught:
            call()
        assert caught.value.field == field


def test_wave_that_the_float_cannot_follow_is_refused() -> None:
    """In deep water at 1 rad/s a wave of 2.5 m is not steep, but higher than the lever is long twice over."""
    deep = PLANT.replace(depth=math.inf)
    with pytest.raises(gy.InputError, match="cannot follow") as caught:
        gy.realise(deep, gy.Regular(2.5, 1.0), 1, 50.0)
    assert "breaks" not in caught.value.problem
    gy.lock_orbit(deep, gy.Regular(0.5, 2.0), 0.052, 3.5e-4, nearest=False)


def test_record_in_millimetres_is_refused_with_the_unit_as_mend() -> None:
    waves = gy.realise(PLANT, gy.SeaState(), 1, 300.0)
    gy.realise(PLANT, gy.ElevationRecord(waves.time, waves.elevation), 1, 100.0)
    with pytest.raises(gy.InputError, match="millimetres") as caught:
        gy.realise(PLANT, gy.ElevationRecord(waves.time, 1e3 * waves.elevation), 1, 100.0)
    assert caught.value.field == "sea.eta"


def test_every_sea_of_the_offdesign_table_may_be() -> None:
    from gyroctl.studies.evaluation.offdesign import off_seas
    from gyroctl.waves import prepare

    for off in off_seas(600.0):
        prepare(PLANT, off.sea, 100.0)
