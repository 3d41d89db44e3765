"""Runs on the workers of a Dask scheduler: the bits of this machine, and nothing that is stored is run twice."""

from __future__ import annotations

import contextlib
import os
import signal
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import gyroctl as gy
from gyroctl.comparison import items
from gyroctl.comparison.compare import Realisations, compare
from gyroctl.comparison.verification import CLOCKS
from gyroctl.engine import Store, cluster
from gyroctl.harness.run import Settings

distributed = pytest.importorskip("distributed", reason="needs the extra cluster: dask.distributed")

WAVES, SETTINGS = Realisations(gy.SeaState(), (3, 1), duration=60.0), Settings(blend=40.0)

LAW = """
from typing import NamedTuple
from travelling_gains import CC

class Mine(NamedTuple):
    period: float = 0.1
    information = "none"
    def init(self): return ()
    def step(self, t, y, state): return (CC, 2e-4), state
"""


@pytest.fixture
def local() -> Iterator[Any]:
    """Scheduler and worker on the loopback, in this process."""
    with started() as found:
        yield found


def started(**how: Any) -> Any:
    given = {"processes": False, "protocol": "tcp", "host": "127.0.0.1", "dashboard_address": None, **how}
    return distributed.LocalCluster(n_workers=1, threads_per_worker=1, **given)


def bits(ds: Any) -> dict[str, Any]:
    return {str(name): ds[name].values.tobytes() for name in ds.data_vars if name not in (*CLOCKS, "failure")}


def run(device: gy.Plant, **how: Any) -> Any:
    laws = how.pop("laws", {"plain": gy.law("constant"), "coupling": gy.law("coupling")})
    return compare(device, laws, WAVES, SETTINGS, 1, quiet=True, **how)


def test_workers_give_the_bits_of_this_machine(device: gy.Plant, local: Any, tmp_path: Path) -> None:
    here = run(device)
    there = run(device, scheduler=local.scheduler_address, results=tmp_path / "address")
    assert bits(there) == bits(here) and not there.failed.any()
    with distributed.Client(local) as client:
        assert bits(run(device, scheduler=client, results=tmp_path / "client")) == bits(here)
        assert client.status == "running", "it is the user's own"
    names = [{path.name for path in Store(tmp_path / folder).files()} for folder in ("address", "client")]
    assert len(names[0]) == 4 and names[0] == names[1], "known by the same keys"


class Held:
    """A law that holds what cannot be sent."""

    period, information = 0.1, "none"

    def __init__(self) -> None:
        self.lock = threading.Lock()

    def init(self) -> None:
        return None

    def step(self, t: float, y: Any, state: None) -> tuple[tuple[float, float], None]:
        return (0.05, 2e-4), None


def test_law_that_cannot_be_sent_fails_alone_there_as_here(device: gy.Plant, local: Any) -> None:
    laws = {"plain": gy.law("constant"), "held": Held()}
    with pytest.warns(UserWarning, match="every run of held failed"):
        there = run(device, laws=laws, scheduler=local.scheduler_address)
    assert not there.failed.sel(law="plain").any() and there.failed.sel(law="held").all()
    assert "cannot be sent to a process of its own, nor to another machine" in str(
        there.failure.sel(law="held")[0].item()
    )
    with pytest.warns(UserWarning, match="every run of held failed"):
        assert bits(run(device, laws=laws)) == bits(there)


def test_what_is_stored_is_not_run_again_when_the_scheduler_was_lost(
    device: gy.Plant, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ran, save, perform = list[str](), Store.save, items.perform

    def counted(some: Any) -> Any:
        ran.extend(f"{item.name} {item.seed}" for item in some)
        return perform(some)

    monkeypatch.setattr(items, "perform", counted)
    with started() as first:

        def lost(store: Store, key: str, *given: Any) -> None:
            save(store, key, *given)
            first.close()

        with monkeypatch.context() as here:
            here.setattr(Store, "save", lost)
            here.setattr(cluster, "AHEAD", 0)
            laws = {f"law {i}": gy.law("constant", cg=1e-4 * (i + 1)) for i in range(4)}
            with pytest.raises(OSError, match="was lost"):
                run(device, laws=laws, scheduler=first.scheduler_address, results=tmp_path)
    kept = len(list(Store(tmp_path).files()))
    assert 0 < kept < 8
    ran.clear()
    with started() as second:
        ds = run(device, laws=laws, scheduler=second.scheduler_address, results=tmp_path)
    assert len(ran) == 8 - kept
    assert bits(ds) == bits(run(device, laws=laws))


def test_worker_whose_bits_may_be_others_is_left_out(
    device: gy.Plant, local: Any, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    code_of, here = cluster.code_of, threading.main_thread()

    def other(*modules: str) -> str:
        return code_of(*modules) if threading.current_thread() is here else "another"

    monkeypatch.setattr(cluster, "code_of", other)
    monkeypatch.setattr(cluster, "made_with", lambda: {"numpy": "99.0"})
    with pytest.raises(gy.InputError, match="no worker gives the same bits") as error:
        run(device, scheduler=local.scheduler_address)
    assert error.value.field == "scheduler" and "numpy 99.0 (here" in str(error.value)
    assert capsys.readouterr().err.count("is left out") == 1


def test_worker_without_memory_fails_one_run_and_says_so(
    device: gy.Plant, local: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The piece is taken apart, and only the run that asks for too much fails."""
    perform = items.perform

    def short(some: Any) -> Any:
        if any(item.seed == 1 and item.name == "law 2" for item in some):
            raise MemoryError
        return perform(some)

    monkeypatch.setattr(items, "perform", short)
    monkeypatch.setattr("gyroctl.comparison.cluster.pieces", lambda count, threads: [slice(0, count)])
    laws = {f"law {i}": gy.law("constant", cg=1e-4 * (i + 1)) for i in range(3)}
    ds = run(device, laws=laws, scheduler=local.scheduler_address)
    assert ds.failed.values.sum() == 1
    assert "too little memory on its worker" in str(ds.failure.sel(law="law 2", realisation=1).values)


@pytest.mark.parametrize("address", ["127.0.0.1:8786", "tcp://host", "file:///etc/passwd", "tcp://a b:1", 3])
def test_what_is_no_address_is_refused(device: gy.Plant, address: Any) -> None:
    with pytest.raises(gy.InputError, match="no address") as error:
        run(device, scheduler=address)
    assert error.value.field == "scheduler"


def test_scheduler_that_does_not_answer_is_refused(device: gy.Plant, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "PATIENCE", 0.2)
    with pytest.raises(gy.InputError, match="does not answer"):
        run(device, scheduler="tcp://127.0.0.1:1")


@pytest.mark.slow
def test_law_from_elsewhere_travels_with_its_modules_and_fails_alone(device: gy.Plant, tmp_path: Path) -> None:
    """The worker is another process, in another folder, and ends at once where a law ends its process."""
    (tmp_path / "travelling_gains.py").write_text("CC = 0.05\n")
    (tmp_path / "mine.py").write_text(LAW)
    ends = LAW.replace("return (CC", "import os; os._exit(3) if t > 1.0 else None; return (CC").replace("Mine", "Ends")
    (tmp_path / "ends.py").write_text(ends)
    with pytest.MonkeyPatch.context() as here:
        here.syspath_prepend(str(tmp_path))
        laws = {"mine": gy.law(f"{tmp_path}/mine.py:Mine"), "ends": gy.law(f"{tmp_path}/ends.py:Ends")}
        expected = run(device, laws={"mine": laws["mine"]})
    with started(processes=True) as local:
        ds = run(device, laws=laws, scheduler=local.scheduler_address)
    assert bits(ds.sel(law=["mine"])) == bits(expected)
    assert ds.failed.sel(law="ends").all() and "must not end the program" in str(ds.failure.sel(law="ends").values[0])


def test_scheduler_forgets_an_answer_before_it_is_stored(local: Any) -> None:
    """Else it would be computed again, though it is stored, where its worker dies meanwhile."""
    with distributed.Client(local) as client:
        code = cluster.code_of(cluster.__name__)
        task = cluster.Task(-3, None, (cluster.__name__,), code)
        handed_out = cluster.hand_out(client, abs, [task], lambda one: [one])
        assert next(handed_out) == (task, 3)
        for _ in range(200):  # it is told on its way, not at once
            if not local.scheduler.tasks:
                break
            time.sleep(0.01)
        assert not local.scheduler.tasks
        assert not list(handed_out)


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="needs a signal to one process")
def test_worker_that_is_killed_is_made_up_for(
    device: gy.Plant, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    laws = {f"law {i}": gy.law("constant", cg=1e-4 * (i + 1)) for i in range(6)}
    with started(processes=True) as local, distributed.Client(local) as client:
        save, alive = Store.save, [local.workers[0].pid]

        def killing(store: Store, key: str, *given: Any) -> None:
            """Kill once, although results are stored by several threads."""
            save(store, key, *given)
            with contextlib.suppress(IndexError):
                os.kill(alive.pop(), signal.SIGKILL)

        monkeypatch.setattr(Store, "save", killing)
        there = run(device, laws=laws, scheduler=client, results=tmp_path)
    assert not alive and bits(there) == bits(run(device, laws=laws))
