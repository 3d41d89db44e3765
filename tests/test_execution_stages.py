"""Who runs where: machine code on threads, plain Python in processes of its own."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import time
from concurrent.futures import Future, ThreadPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

import gyroctl as gy
from gyroctl.comparison import execution
from gyroctl.comparison.compare import Realisations
from gyroctl.comparison.items import Item, failed, work_items
from gyroctl.comparison.processes import AGAIN, Processes
from gyroctl.harness.run import Settings


@pytest.fixture
def sent(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, int]]:
    """Law and seed of what would go to a process; nothing is compiled beforehand."""
    noted: list[tuple[str, int]] = []

    def note(item: Item) -> Future[Any]:
        noted.append((item.name, item.seed))
        future: Future[Any] = Future()
        future.set_result([failed(item, "not run here")])
        return future

    monkeypatch.setattr(execution, "_sending", lambda items, _: [partial(note, item) for item in items])
    monkeypatch.setattr(execution, "_parts", lambda law: ())
    return noted


def run(device: gy.Plant, **laws: Any) -> set[str]:
    """Run laws on two seeds and two workers; return those of which no run failed."""
    items = work_items(device, laws, Realisations(gy.SeaState(), (1, 2), 60.0), Settings(blend=20.0), 60.0)
    outcomes = execution.execute(items, 2, None, True)
    return {law for law in laws if not any(outcomes[law, seed].failure for seed in (1, 2))}


@pytest.mark.slow
def test_a_compiled_law_around_a_slow_one_is_slow(device: gy.Plant, sent: list[tuple[str, int]]) -> None:
    """A supervisor is a NamedTuple whatever it wraps: what it wraps decides."""
    plans, rules = (gy.law("supervisor", wraps={"law": name}) for name in ("nmpc", "coupling"))
    assert run(device, plans=plans, rules=rules) == {"rules"}
    assert sent == [("plans", 1), ("plans", 2)]


def test_parts_to_be_compiled_travel_and_what_they_give_stays(device: gy.Plant) -> None:
    """Machine code cannot be sent back from the process that compiled it."""
    for part in gy.law("nmpc").preparations():
        assert callable(pickle.loads(pickle.dumps(part)))
    made: list[object] = []
    assert execution._prepare(lambda: made.append(object()) or (lambda: made)) is None
    assert made


def test_planner_as_machine_code_runs_on_threads(device: gy.Plant, sent: list[tuple[str, int]]) -> None:
    assert run(device, plans=gy.law("nmpc")) == {"plans"}
    assert not sent


def test_planner_with_a_deadline_goes_to_processes(device: gy.Plant, sent: list[tuple[str, int]]) -> None:
    assert run(device, plans=gy.law("nmpc", deadline=10.0)) == set()
    assert sent == [("plans", 1), ("plans", 2)]


def test_no_more_has_ended_than_a_few_until_it_is_taken() -> None:
    """A slow disk fills no memory with results that wait for it, and all of them come in the end."""
    begun = list[int]()

    def work(number: int) -> list[int]:
        begun.append(number)
        return [number]

    under_way: Any = execution._UnderWay(2)
    with ThreadPoolExecutor(4) as threads:
        under_way.add(
            "threads", [execution.Work(partial(threads.submit, work, number), [number]) for number in range(10)]
        )
        ended = under_way.ended()
        for taken in range(1, 5):
            wait(list(under_way.running))
            assert len(begun) == 1 + taken
            assert next(ended)[0] in range(10)
        assert len(list(ended)) == 6 and sorted(begun) == list(range(10))


def test_processes_that_were_given_up_are_begun_anew() -> None:
    """Killed before any of them had work, none would ever take any again."""
    processes = Processes(1)
    try:
        first = processes.pool
        assert processes.schedule(abs, (-1,)).result(timeout=60.0) == 1
        first._pool_manager.handle_broken_pool(RuntimeError())
        assert processes.schedule(abs, (-2,)).result(timeout=60.0) == 2
        assert processes.pool is not first
    finally:
        processes.pool.stop()
        processes.pool.join()


def test_work_that_a_pool_had_not_handed_on_when_it_was_given_up_ends() -> None:
    """Pebble lets those wait for ever: a study would hang after all its processes were killed at their start."""
    processes = Processes(1)
    try:
        assert processes.schedule(abs, (-1,)).result(timeout=60.0) == 1
        processes.pool._pool_manager.schedule = lambda task: None  # it stays where it is
        begin: Any = partial(processes.schedule, abs, (-2,))
        under_way: Any = execution._UnderWay(4, processes.look)
        under_way.add("processes", [execution.Work(begin, [number]) for number in range(3)])
        waiting = list(under_way.running)
        assert not any(one.done() for one in waiting)
        processes.look()
        assert not any(one.done() for one in waiting), "nothing is given up while the pool is there"
        processes.pool._pool_manager.handle_broken_pool(BrokenProcessPool())
        processes.look()
        assert [type(one.exception(timeout=0.0)) for one in waiting] == [BrokenProcessPool] * 3
        assert processes.schedule(abs, (-3,)).result(timeout=60.0) == 3
    finally:
        processes.pool.stop()
        processes.pool.join()


def test_what_is_waited_for_is_looked_after(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(execution, "LOOK", 0.01)
    lost: Future[Any] = Future()
    under_way: Any = execution._UnderWay(1, lambda: lost.set_result(["found"]))
    under_way.add("processes", [execution.Work(lambda: lost, ["item"])])
    assert list(under_way.ended()) == [("item", "found")]


ORPHANS = {
    "runs": """
import os, signal, time
from gyroctl.comparison.processes import AGAIN, Processes

if __name__ == "__main__":
    processes = Processes(1)
    print(processes.schedule(os.getpid, ()).result(timeout=60.0), flush=True)
    processes.schedule(time.sleep, (600.0,))
    time.sleep(0.5)
    os.kill(os.getpid(), signal.SIGKILL)
""",
    "tuning": """
import os, signal
import gyroctl as gy
from gyroctl.harness.run import Settings
from gyroctl.tuning.bench import Bench

class Slow:
    period, information = 0.1, "none"
    def init(self): return None
    def step(self, t, y, state): return (0.05, 2e-4), None

if __name__ == "__main__":
    bench = Bench(gy.zhang2017(), Settings(), Slow(), 2)
    print(bench.pool.submit(os.getpid).result(timeout=60.0), flush=True)
    os.kill(os.getpid(), signal.SIGKILL)
""",
}
"""What begins processes, tells one of them, and is killed: with work under way, and without."""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="looks for the process in /proc")
@pytest.mark.parametrize("what", ORPHANS)
def test_processes_end_with_the_one_that_began_them(what: str, tmp_path: Path) -> None:
    """Whatever they wait for: one that waited for a lock of a killed one, or for work, was there for ever."""
    (tmp_path / "orphans.py").write_text(ORPHANS[what])
    said = tmp_path / "said"
    with said.open("w") as stream:  # no pipe, which would be waited for as long as somebody holds it
        done = subprocess.run([sys.executable, "orphans.py"], cwd=tmp_path, stdout=stream, stderr=stream, check=False)
    assert done.returncode == -9, said.read_text()
    process = int(said.read_text().split()[0])
    for _ in range(100):
        if not Path(f"/proc/{process}").exists():
            return
        time.sleep(0.1)
    os.kill(process, signal.SIGKILL)
    pytest.fail("the process is there without its parent")


def test_work_that_was_given_up_is_begun_anew_but_not_for_ever() -> None:
    item: Any = SimpleNamespace(name="law", seed=1, sha256="waves", time_limit=1.0)
    for broken in (1, AGAIN, AGAIN + 1):
        begun = list[Future[Any]]()

        def begin(broken: int = broken, begun: list[Future[Any]] = begun) -> Future[Any]:
            begun.append(Future())
            if len(begun) <= broken:
                begun[-1].set_exception(BrokenProcessPool("the processes were given up"))
            else:
                begun[-1].set_result([failed(item, "")])
            return begun[-1]

        under_way: Any = execution._UnderWay(1)
        under_way.add("processes", [execution.Work(begin, [item])])
        ((ended, outcome),) = under_way.ended()
        assert ended is item and len(begun) == min(broken, AGAIN) + 1
        assert (f"lost its process {AGAIN + 1} times" in outcome.failure) == (broken > AGAIN)


def test_run_whose_processes_were_given_up_has_failed_alone(device: gy.Plant) -> None:
    item = work_items(
        device, {"law": gy.law("constant")}, Realisations(gy.SeaState(), (1,), 60.0), Settings(blend=20.0), 60.0
    )[0]
    future: Future[Any] = Future()
    future.set_exception(BrokenProcessPool("All workers expired"))
    (outcome,) = execution._outcomes_of(future, [item])
    assert "lost its process" in outcome.failure and "run again" in outcome.failure
