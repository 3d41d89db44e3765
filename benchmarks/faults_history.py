"""A history of a study under faults, made from one integer, and what must hold of it whatever happens.

The engine that stores and finds runs is the real one, and so is what hands them out to other machines; the disk
(`faults_disk`), the scheduler, and the runs themselves are played. Must hold:

- what was told stored is there, after every kill and every power cut;
- what is there whole is not computed again, and nothing is stored twice;
- nothing is believed that is not what was computed;
- a study that comes through has the bits of one that nothing disturbed;
- no half-written file is left at the end.
"""

from __future__ import annotations

import io
import random
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import redirect_stderr
from typing import Any

import numpy as np
from faults_disk import ROOT, Killed, Medium, Pool, Process, SimulatedDisk, World
from faults_scheduler import Scheduler, played_dask

from gyroctl.comparison.cluster import run_far
from gyroctl.comparison.execution import execute
from gyroctl.comparison.items import Item, Outcome, failed
from gyroctl.comparison.kept import kept
from gyroctl.controllers.rule_based.constant import Constant
from gyroctl.engine import Store
from gyroctl.errors import InputError
from gyroctl.tuning.log import TuningLog, _step

FOLDER = ROOT / "out" / "runs"

LOG = ROOT / "out" / "law.jsonl"
STEPS = {f"step {number}": [0.1 * number, float("inf"), -0.0] for number in range(6)}
"""Of a search."""

AT_AN_OPERATION = ("kill", "kill", "kill after", "cut", "cut", "cut after", "full", "room", "error", "error")
AT_AN_OPERATION += ("short, kill", "short, cut", "short")
"""What may happen at an operation of a process on its disk."""


class Broken(AssertionError):
    """What must hold does not."""


def played(seed: int) -> dict[str, int]:
    """Play a history; return what happened in it, by kind.

    Raises
    ------
    Broken
        Where something does not hold.
    """
    with redirect_stderr(io.StringIO()), played_dask():
        return (Tuning if seed % 8 == 7 else History)(seed).play()


class History:
    """A study, its disk, and what is known of it by who looks from above."""

    def __init__(self, seed: int) -> None:
        self.rng = random.Random(seed)
        self.medium, self.world = Medium(self.rng), World(self.rng)
        self.threads = self.rng.random() < 0.04
        self.items = self._items()
        self.truth = {_name(item): _computed(item) for item in self.items}
        self.stored: set[str] = set()  # keys that were told stored
        self.twice: set[str] = set()  # and those that one driver has stored once more
        self.seen: dict[str, int] = {}
        self.cut_at_last = False

    def _items(self) -> list[Item]:
        laws, seeds = self.rng.randint(1, 2), self.rng.randint(1, 3)
        items = []
        for law in range(laws):
            for seed in range(seeds):
                key = f"{law}{seed}".ljust(64, "a") if self.rng.random() < 0.95 else ""
                about: Any = None  # no plant and no waves: nothing is run
                common = (about, f"law {law}", Constant(), about, seed, about)
                items.append(Item(*common, 1.0, seed == 0, f"waves {seed}", 60.0, key))
        return items

    def note(self, what: str) -> None:
        """Count what happened."""
        self.seen[what] = self.seen.get(what, 0) + 1

    def play(self) -> dict[str, int]:
        """Disturb the study some times, and let it come through at last."""
        for _ in range(self.rng.randint(1, 4)):
            drivers = [
                self._driver(self._faults()) for _ in range(2 if self.threads and self.rng.random() < 0.5 else 1)
            ]
            self._run(*drivers)
            if self.rng.random() < 0.15:
                self.medium.cut()
                self.note("power cut")
            self._check_stored()
            self.medium.now += self.rng.choice((1.0, 1.0, 1e5))
            if self.rng.random() < 0.3:
                self._damage()
        last = self._driver({}, sound=True)
        self._run(last)
        self.cut_at_last = self.rng.random() < 0.5
        if self.cut_at_last:
            self.medium.cut()
        self._check_stored()
        self._check_rest()
        return self.seen

    def _run(self, *drivers: Callable[[], None]) -> None:
        errors: list[BaseException] = []

        def guarded(driver: Callable[[], None]) -> Callable[[], None]:
            def work() -> None:
                try:
                    driver()
                except BaseException as error:
                    errors.append(error)

            return work

        if self.threads:
            self.world.run(*map(guarded, drivers))
        else:
            for driver in drivers:
                guarded(driver)()
        for process in self.medium.processes:
            process.dead = True
        self.medium.processes.clear()
        if errors:
            raise errors[0]

    def _faults(self) -> dict[int, str]:
        count = self.rng.choice((0, 1, 1, 1, 2, 3))
        return {self.rng.randint(1, 60): self.rng.choice(AT_AN_OPERATION) for _ in range(count)}

    # --- a driver ------------------------------------------------------------------------------------------------

    def _driver(self, faults: dict[int, str], sound: bool = False) -> Callable[[], None]:
        number = self.rng.choice((1, 1, 7, self.rng.randrange(100, 30000)))
        living = {process.process for process in self.medium.processes}
        while number in living:
            number += 1
        mine = set[str]()
        process = Process(number, f"{self.rng.randrange(1 << 32):08x}", faults)
        self.medium.processes.append(process)
        disk = SimulatedDisk(self.medium, process, lambda: Pool(self.world, told, self.threads), self.world.turn)

        def told(key: str) -> None:
            self.twice |= mine & {key}
            mine.update([key] if key else [])
            if key and not process.dead:
                self.stored.add(key)

        return self._drive(disk, sound)

    def _drive(self, disk: SimulatedDisk, sound: bool) -> Callable[[], None]:
        process, faults = disk.process, disk.process.faults

        def drive() -> None:
            there = self._whole()
            unread = any(fault == "error" for fault in faults.values())

            def run(items: Sequence[Item], workers: int) -> Iterator[tuple[Item, Outcome]]:
                again = {item.key for item in items} & there
                if again and not unread and not process.dead:
                    raise Broken(f"computed again: {sorted(again)}")
                far = self.rng.random() < 0.4
                return self._far(items, sound) if far else self._near(items, sound)

            try:
                found = execute(self.items, 1, FOLDER, True, "a case", run, disk)
            except Killed:
                self.note("killed")
            except (OSError, CancelledError) as error:
                if sound and not isinstance(error, ConnectionError):
                    raise Broken(f"ends without a reason: {error!r}") from error
                self.note(type(error).__name__ if isinstance(error, ConnectionError) else "disk refused")
            else:
                if process.dead:
                    self.note("killed")
                    return
                self.note("came through")
                self._check_found(found)
                ended = [item for item in self.items if not found[item.name, item.seed].failure]
                self.stored |= {item.key for item in ended if item.key}

        return drive

    def _near(self, items: Sequence[Item], sound: bool) -> Iterator[tuple[Item, Outcome]]:
        """Runs that end in any order; workers are lost, results come twice and late."""
        todo = list(items)
        while todo:
            item = todo.pop(self.rng.randrange(len(todo)))
            self.world.turn()
            kind = "" if sound else self.rng.choice(("", "", "", "", "", "", "worker lost", "twice", "scheduler lost"))
            if kind == "scheduler lost" and self.rng.random() < 0.3:
                raise ConnectionError("the scheduler was lost")
            if kind == "worker lost":
                todo.append(item)
                self.note(kind)
                continue
            if kind == "twice":
                todo.append(item)
                self.note(kind)
            yield item, self.truth[_name(item)]

    def _far(self, items: Sequence[Item], sound: bool) -> Iterator[tuple[Item, Outcome]]:
        """The real hands of a cluster, whose scheduler and workers are played."""
        return run_far(Scheduler(self.rng, self._ended, self.note, self.world.turn, sound), items)

    def _ended(self, items: Sequence[Item]) -> list[Outcome]:
        return [self.truth[_name(item)] for item in items]

    # --- what must hold ------------------------------------------------------------------------------------------

    def _whole(self) -> set[str]:
        """Keys of what is there as it was written."""
        return {
            path.stem
            for path, inode in self.medium.files.items()
            if path.suffix == ".run" and path.parent == FOLDER and path.name[0] != "." and inode.data == inode.whole
        }

    def _check_stored(self) -> None:
        if self.twice:
            raise Broken(f"stored twice: {sorted(self.twice)}")
        lost = self.stored - self._whole()
        if lost:
            raise Broken(f"told stored, and lost: {sorted(lost)}")
        for path, inode in self.medium.files.items():
            if path.name.endswith(".plan.json") and path.name[0] != "." and inode.data != inode.whole:
                raise Broken(f"a plan that is not whole: {path.name}")

    def _check_found(self, found: dict[tuple[str, int], Outcome]) -> None:
        laws = len({item.name for item in self.items})
        if set(found) != {(item.name, item.seed) for item in self.items}:
            raise Broken("not all came through")
        for item in self.items:
            outcome = found[item.name, item.seed]
            if "lost its worker" not in outcome.failure and _bits(outcome) != _bits(
                kept(item, self.truth[_name(item)], laws)
            ):
                raise Broken(f"other bits: {item.name}, seed {item.seed}")

    def _check_rest(self) -> None:
        wanted = {item.key for item in self.items if item.key and not self.truth[item.key].failure}
        if self.stored != wanted:
            raise Broken(f"not stored: {wanted - self.stored}")
        parts = [path.name for path in self.medium.files if ".part" in path.name]
        if parts:
            raise Broken(f"left behind: {parts}")
        pool = Pool(self.world, lambda _: None, False)
        store = Store(FOLDER, lambda _: None, SimulatedDisk(self.medium, Process(1, "0"), lambda: pool, lambda: None))
        for key in self.stored:
            record = store.load(key)
            if record is None:
                raise Broken(f"not believed: {key}")
            values, series = record.content["values"], dict(record.arrays)
            if _bits(Outcome(record.content["sha256"], values, series)) != _bits(self.truth[key]):
                raise Broken(f"other bits stored: {key}")
        if len([path for path in self.medium.files if path.suffix == ".run"]) != len(self.stored):
            raise Broken("something is stored that nobody asked for")

    # --- what time and people do to files ------------------------------------------------------------------------

    def _damage(self) -> None:
        files = [path for path in self.medium.files if path.suffix == ".run" and path.name[0] != "."]
        if not files:
            return
        path = self.rng.choice(files)
        inode, kind = self.medium.files[path], self.rng.choice(("flip", "cut", "zeros", "longer", "gone", "another's"))
        self.note(f"damaged: {kind}")
        data = bytearray(inode.data)
        if kind == "flip" and data:
            data[self.rng.randrange(len(data))] ^= 1 << self.rng.randrange(8)
        elif kind == "cut":
            data = data[: int(self.rng.random() * len(data))]
        elif kind == "zeros":
            data = bytearray(len(data))
        elif kind == "longer":
            data += b"\n"
        elif kind == "another's":
            data = bytearray(self.medium.files[self.rng.choice(files)].data)
        inode.data = inode.safe = bytes(data)
        if kind == "gone":
            del self.medium.files[path]
            self.medium.stable.pop(path, None)
        self.stored &= self._whole()


class Tuning(History):
    """The same of a search, whose steps are lines of one file."""

    def _drive(self, disk: SimulatedDisk, sound: bool) -> Callable[[], None]:
        def drive() -> None:
            there = self._whole()
            try:
                log = TuningLog(LOG, disk)
                for key, value in STEPS.items():
                    known = log.get(key)
                    if known is None and key in there and not disk.process.dead:
                        raise Broken(f"computed again: {key}")
                    if known not in (None, value):
                        raise Broken(f"other numbers: {key}")
                    if known is None:
                        self._added(log, key, value)
            except Killed:
                self.note("killed")
            except (OSError, InputError) as error:
                if sound:
                    raise Broken(f"ends without a reason: {error!r}") from error
                self.note("disk refused")

        return drive

    def _added(self, log: TuningLog, key: str, value: Any) -> None:
        try:
            log.add(key, value)
        except OSError:
            if self.rng.random() < 0.5:  # whoever searches may go on all the same
                raise
            self.note("went on")
        else:
            self.stored.add(key)

    def _faults(self) -> dict[int, str]:
        return {place // 3 + 1: fault for place, fault in super()._faults().items()}

    def _whole(self) -> set[str]:
        disk = SimulatedDisk(self.medium, Process(1, "0"), lambda: Pool(self.world, print, False), lambda: None)
        lines = disk.read(LOG).decode("utf-8", "replace").split("\n") if LOG in self.medium.files else []
        steps = [step for line in lines if (step := _step(line)) is not None]
        if any(STEPS[key] != value for key, value, _ in steps):
            raise Broken("other numbers are believed")
        return {key for key, *_ in steps}

    def _check_rest(self) -> None:
        missing = set(STEPS) - self._whole()
        if missing and not self.cut_at_last:  # a line whose sync failed is read until then, and was not told stored
            raise Broken(f"steps are missing: {missing}")

    def _damage(self) -> None:
        if LOG not in self.medium.files:
            return
        inode = self.medium.files[LOG]
        data = bytearray(inode.data)
        if data:
            self.note("damaged: a line")
            data[self.rng.randrange(len(data))] ^= 1 << self.rng.randrange(8)
        inode.data = inode.safe = bytes(data)
        self.stored &= self._whole()


def _name(item: Item) -> str:
    return item.key or f"{item.name} {item.seed}"


def _computed(item: Item) -> Outcome:
    """What the run of an item gives, for ever the same."""
    rng = random.Random(f"{item.name} {item.seed}")
    if rng.random() < 0.1:
        return failed(item, "it fails")
    values = {"mean_power": rng.random(), "loss_time": float("inf"), "none": float("nan"), "zero": -0.0}
    series = {"time": np.arange(4.0), "power": np.array([rng.random() for _ in range(4)])}
    return Outcome(item.sha256, values, series if item.example else {})


def _bits(outcome: Outcome) -> tuple[Any, ...]:
    values = tuple((name, repr(float(value))) for name, value in sorted(outcome.values.items()))
    series = tuple((name, row.dtype.str, row.tobytes()) for name, row in sorted(outcome.series.items()))
    return outcome.sha256, values, series, outcome.failure
