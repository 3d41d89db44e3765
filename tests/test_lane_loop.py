"""Closed loops in lanes: each run is the one that the law makes alone, to the last bit."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Literal, NamedTuple

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.harness import lane_loop
from gyroctl.harness.protocol import LawError
from gyroctl.harness.run import lead_in, run_law
from gyroctl.harness.together import WORTH, Loop, Outcome, in_groups, pieces, run_together
from gyroctl.plant.lane_steps import lane_room, lane_state
from gyroctl.simulation.metrics import Record

SETTINGS = gy.Settings(blend=10.0)


def realisations(device: gy.Plant, count: int, duration: float = 30.0) -> list[gy.WaveRealisation]:
    return [lead_in(gy.realise(device, gy.SeaState(), seed, duration), SETTINGS) for seed in range(1, count + 1)]


def same(one: Record, other: Record) -> None:
    for name in ("states", "commands", "controls"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    assert one.saturations == other.saturations


def together(
    device: gy.Plant, law: Any, waves: Sequence[gy.WaveRealisation], settings: Any = SETTINGS
) -> list[Outcome]:
    return run_together(device, [Loop(law, each, settings) for each in waves])


class Fickle(NamedTuple):
    """Switch the coupling off and on by what the sensors say: every lane at instants of its own."""

    period: float = 0.1

    @property
    def information(self) -> Literal["sensors"]:
        return "sensors"

    def init(self) -> tuple[float, ...]:
        return (0.0,)

    def step(self, t: float, y: Any, state: tuple[float, ...]) -> tuple[tuple[float, float], tuple[float, ...]]:
        return (0.2 if y.phi1_rate > 0.0 else 0.02, 3.5e-4), (state[0] + 1.0,)


class Failing(NamedTuple):
    """Divide by nothing once the float has turned far enough."""

    far: float = 0.25  # [rad]
    period: float = 0.1

    @property
    def information(self) -> Literal["sensors"]:
        return "sensors"

    def init(self) -> tuple[float, ...]:
        return (0.0,)

    def step(self, t: float, y: Any, state: tuple[float, ...]) -> tuple[tuple[float, float], tuple[float, ...]]:
        one = 1.0 / (0.0 if y.phi1 > self.far else 1.0)
        return (0.06, 3.5e-4 * one), state


@pytest.mark.parametrize(
    "law", [gy.law("load_angle"), gy.law("coupling"), Fickle()], ids=lambda law: type(law).__name__
)
@pytest.mark.parametrize("count", [WORTH, 18])  # idle lanes; more than one filling
def test_each_run_has_the_bits_of_the_run_alone(device: gy.Plant, law: Any, count: int) -> None:
    waves = realisations(device, count)
    for each, outcome in zip(waves, together(device, law, waves), strict=True):
        assert not isinstance(outcome, LawError)
        same(outcome[0], run_law(device, law, each, SETTINGS)[0])


def test_delay_resolution_and_dropout_act_in_lanes_as_alone(device: gy.Plant) -> None:
    law, channel = gy.law("load_angle"), gy.Channel(noise=0.01, quantum=0.02, delay=2, dropout=0.2)
    actuators = gy.Actuators(delay=1, cg_quantum=1e-5, period=0.05)
    settings = gy.Settings(blend=10.0, sensors=gy.Sensors(psi=channel, phi1_rate=channel), actuators=actuators)
    waves = realisations(device, WORTH)
    for each, outcome in zip(waves, together(device, law, waves, settings), strict=True):
        assert not isinstance(outcome, LawError)
        same(outcome[0], run_law(device, law, each, settings)[0])


def test_a_law_that_fails_ends_its_own_run_alone(device: gy.Plant) -> None:
    waves, law = realisations(device, 6, 60.0), Failing()
    outcomes = together(device, law, waves)
    failed = [isinstance(outcome, LawError) for outcome in outcomes]
    assert any(failed) and not all(failed)
    assert all(isinstance(outcome, LawError) for outcome in together(device, Failing(-1.0), waves))
    for each, outcome in zip(waves, outcomes, strict=True):
        if isinstance(outcome, LawError):
            with pytest.raises(LawError) as caught:
                run_law(device, law, each, SETTINGS)
            assert str(outcome) == str(caught.value)
        else:
            same(outcome[0], run_law(device, law, each, SETTINGS)[0])


def test_what_cannot_share_its_steps_runs_by_itself(device: gy.Plant) -> None:
    settings = gy.Settings(blend=10.0, actuators=gy.Actuators(cg_lag=0.2))
    waves = realisations(device, WORTH)
    for each, outcome in zip(waves, together(device, gy.law("load_angle"), waves, settings), strict=True):
        assert not isinstance(outcome, LawError)
        same(outcome[0], run_law(device, gy.law("load_angle"), each, settings)[0])


def mixed(device: gy.Plant, count: int) -> list[Loop]:
    loops = []
    for i in range(count):
        sea = gy.SeaState(gamma=float(1 + i))
        actuators = gy.Actuators(cc_max=0.08 + 0.01 * i, cc_gain=1.0 + 0.02 * i, delay=i % 3)
        channel = gy.Channel(noise=1e-3 * i, quantum=1e-3 * (i % 2), delay=i % 4)
        settings = gy.Settings(
            dt=0.01 if i % 2 else 0.02,
            blend=10.0,
            actuators=actuators,
            sensors=gy.Sensors(phi1=channel),
            start="rest" if i % 5 == 4 else "locked",
        )
        law = gy.law("load_angle", share=0.3 + 0.01 * i)._replace(period=0.2 if i % 3 == 2 else 0.1)
        loops.append(Loop(law, lead_in(gy.realise(device, sea, 1 + i, 30.0), settings), settings, f"law {i}"))
    return loops


def test_parameters_seas_steps_sensors_and_starts_may_differ(device: gy.Plant) -> None:
    loops = mixed(device, WORTH + 2)
    assert in_groups(device, loops) == [list(range(WORTH + 2))]
    for loop, outcome in zip(loops, run_together(device, loops), strict=True):
        assert not isinstance(outcome, LawError)
        same(outcome[0], run_law(device, loop.law, loop.waves, loop.settings)[0])


def test_groups_are_of_one_kind_and_even(device: gy.Plant) -> None:
    waves = realisations(device, 20)
    angle, coupling = (
        [Loop(gy.law(name), each, SETTINGS) for each in waves[:count]]
        for name, count in (("load_angle", 20), ("coupling", 8))
    )
    loops = [loop for pair in zip(angle[:8], coupling, strict=True) for loop in pair] + angle[8:]
    groups = in_groups(device, loops)
    assert sorted(i for group in groups for i in group) == list(range(28))
    assert sorted(map(len, groups)) == [8, 10, 10]
    assert all(len({type(loops[i].law) for i in group}) == 1 for group in groups)
    # what is left of a kind stands alone
    assert list(map(len, in_groups(device, angle[: WORTH - 1]))) == [1] * (WORTH - 1)
    moving = gy.Settings(blend=10.0, actuators=gy.Actuators(cg_lag=0.2))
    assert len(in_groups(device, [loop._replace(settings=moving) for loop in angle])) == 20
    python = [loop._replace(law=gy.law("nmpc", deadline=1.0)) for loop in angle[:8]]
    assert len(in_groups(device, python)) == 8


def test_long_runs_go_one_by_one(device: gy.Plant, monkeypatch: pytest.MonkeyPatch) -> None:
    loops = [Loop(gy.law("load_angle"), each, SETTINGS) for each in realisations(device, WORTH)]
    monkeypatch.setattr("gyroctl.harness.together.MEMORY", 1e5)
    assert len(in_groups(device, loops)) == WORTH


@pytest.mark.parametrize(
    ("count", "workers", "sizes"),
    [
        (0, 2, []),
        (1, 2, [1]),
        (WORTH - 1, 2, [1] * (WORTH - 1)),
        (8, 2, [4, 4]),
        (12, 2, [6, 6]),
        (16, 1, [16]),
        (7, 2, [7]),
        (17, 1, [8, 9]),
        (64, 2, [16] * 4),
        (84, 2, [14] * 6),
    ],
)
def test_pieces_are_even_and_none_is_too_small_for_lanes(count: int, workers: int, sizes: list[int]) -> None:
    found = pieces(count, workers)
    numbers = list(range(count))
    assert [number for part in found for number in numbers[part]] == numbers
    assert sorted(len(numbers[part]) for part in found) == sizes


def test_grids_and_periods_that_differ_do_not_share_lanes(device: gy.Plant) -> None:
    law, waves = gy.law("load_angle"), realisations(device, 2 * WORTH)
    finer = [lead_in(gy.realise(device, gy.SeaState(), seed, 30.0, 0.025), SETTINGS) for seed in range(1, WORTH + 1)]
    other = gy.Settings(blend=10.0, actuators=gy.Actuators(period=0.05))
    loops = [Loop(law, each, SETTINGS) for each in (*waves[:WORTH], *finer)]
    loops += [Loop(law, each, other) for each in waves[WORTH:]]
    groups = in_groups(device, loops)
    assert groups == [list(range(i * WORTH, (i + 1) * WORTH)) for i in range(3)]


def test_counters_are_those_of_each_run(device: gy.Plant) -> None:
    law = gy.law("supervisor", wraps={"law": "load_angle"})
    settings = gy.Settings(blend=10.0, start="rest", actuators=gy.Actuators(cg_min=-0.02))
    waves = realisations(device, WORTH, 120.0)
    for each, outcome in zip(waves, together(device, law, waves, settings), strict=True):
        assert not isinstance(outcome, LawError)
        assert outcome[1].counters == run_law(device, law, each, settings)[1].counters


def lending(tree: ast.AST) -> Iterator[tuple[str, set[str]]]:
    """What each call of a function that lends is given, by its first name, and the arguments of the function around."""
    for made in ast.walk(tree):
        if not isinstance(made, ast.FunctionDef) or any(isinstance(line, ast.FunctionDef) for line in made.body):
            continue
        names = [node for node in ast.walk(made) if isinstance(node, ast.Name)]
        given = {argument.arg for argument in made.args.args}
        given -= {node.id for node in names if isinstance(node.ctx, ast.Store)}
        for call in ast.walk(made):
            if isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id.startswith("lent"):
                (what,) = call.args
                yield ast.unparse(what).partition(".")[0], given


def test_nothing_is_lent_that_the_loop_made_itself() -> None:
    """What is lent is not counted: an array made in the same function would be given back before it is used."""
    found = list(lending(ast.parse(inspect.getsource(lane_loop))))
    assert len(found) > 20
    assert all(what in given for what, given in found), found


@pytest.mark.slow
@pytest.mark.parametrize("name", ["constant", "nmpc"])
def test_fillings_on_two_threads_have_the_bits_of_each_run_alone(device: gy.Plant, name: str) -> None:
    law, waves = gy.law(name), realisations(device, 2 * WORTH, 60.0)
    loops = [Loop(law, each, SETTINGS) for each in waves]
    alone = [run_law(device, law, each, SETTINGS)[0] for each in waves]
    with ThreadPoolExecutor(2) as pool:
        for _ in range(3):
            halves = pool.map(lambda part: run_together(device, loops[part]), pieces(len(loops), 2))
            for outcome, one in zip((run for half in halves for run in half), alone, strict=True):
                assert not isinstance(outcome, LawError)
                same(outcome[0], one)


def test_plants_beyond_the_room_of_a_pack_run_alone(device: gy.Plant, monkeypatch: pytest.MonkeyPatch) -> None:
    loops = [Loop(gy.law("load_angle"), each, SETTINGS) for each in realisations(device, WORTH)]
    lanes = run_together(device, loops)
    monkeypatch.setattr("gyroctl.harness.together.ROOM", 18)
    assert in_groups(device, loops) == [[run] for run in range(WORTH)]
    for outcome, one in zip(run_together(device, loops), lanes, strict=True):
        assert not isinstance(outcome, LawError) and not isinstance(one, LawError)
        same(outcome[0], one[0])
    with pytest.raises(ValueError, match="room for 64"):
        lane_state(lane_room(65), 65)
