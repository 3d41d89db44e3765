"""A comparison whose processes are killed at random, beside the same one that nobody disturbs.

    python benchmarks/kills.py                        # both: on a cluster of this machine, and alone; some minutes
    python benchmarks/kills.py --scheduler            # 4 workers of Dask; kills of workers, driver and scheduler
    python benchmarks/kills.py --alone                # threads and processes; kills of the driver and its processes
    python benchmarks/kills.py --alone --items 60 --workers 3 --drivers 2 --seed 7

The processes are real ones. Who is killed, by which signal, after how many stored results and how long after that, is
drawn from ``--seed``. After each death of the driver the same command is given again, until it ends well; what else
dies is started again, as a queue of a cluster would. Then nothing may be lost, stored twice, computed though it was
stored, or have other bits than in the serial study (`kills_witness.py`); no process, half-written file or traceback
may be left. Writes ``kills.json`` beside itself, or ``--out``, and ends with 1 where something is wrong.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Any, NamedTuple

from clock import here
from kills_witness import WRONG, Witness, found, journal

ROOT = Path(__file__).resolve().parents[1]
LAWS = 4
TOKEN = f"kills-{os.getpid()}-{time.time_ns()}"
"""In the environment of every process that this one starts, and of theirs."""

APART = 0.6
"""Mean time between two kills where several are due: a crowd of them would meet processes that are not up yet. [s]"""

EXPERIMENT = """
[run]
duration = {duration:.1f}
blend = 20.0
seeds = [{seeds}]

[laws.coupling]

[laws.load_angle]

[laws.own]
law = "own.py:Own"
"""

OWN = '''
"""A law from a file, in plain Python: each of its runs takes a while in a process of its own."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Own:
    period: float = 0.1
    information: str = "sensors"

    def init(self):
        return ()

    def step(self, t, y, state):
        return (0.05, 2e-4 + 1e-5 * min(max(y.psi_rate, 0.0), 10.0)), state
'''


YOUNG = 2.0
"""Before which Python itself answers signals, with a traceback: no program of it can do otherwise. [s]"""


UP = 1.0
"""The same for a process that Python has begun, whose modules come later. [s]"""


class Kill(NamedTuple):
    """Who is killed, and when."""

    after: int  # stored results
    wait: float  # [s]
    who: str  # worker, driver, scheduler
    signal: signal.Signals


def planned(rng: random.Random, items: int, counts: dict[str, int]) -> list[Kill]:
    """Draw the kills: every kind of signal as often as another one, of a scheduler the hard one."""
    kinds = [signal.SIGKILL, signal.SIGTERM, signal.SIGINT]
    kills = []
    for who, count in counts.items():
        signals = [signal.SIGKILL if who == "scheduler" else kinds[i % len(kinds)] for i in range(count)]
        kills += [Kill(rng.randrange(round(0.7 * items)), rng.uniform(0.0, 1.5), who, how) for how in signals]
    return sorted(kills)


class Study:
    """The processes of a study, and their deaths."""

    def __init__(self, place: Path, scheduler: bool, pool: int) -> None:
        self.place, self.folder, self.scheduler, self.pool = place, place / "out", scheduler, pool
        self.driver: subprocess.Popen[bytes] | None = None
        self.cluster: dict[str, subprocess.Popen[bytes]] = {}
        self.port = free_port() if scheduler else 0
        self.codes: Counter[int] = Counter()
        self.killed: Counter[str] = Counter()
        self.dead, self.started = set[int](), 0.0
        self.said, self.tracebacks, self.starts = set[str](), 0, 0
        (self.folder / "runs").mkdir(parents=True)
        self.environment = {**os.environ, "KILLS_TOKEN": TOKEN, "KILLS_JOURNAL": str(place / "journal")}
        path = [str(Path(__file__).with_name("kills_journal")), str(ROOT)]
        self.environment["PYTHONPATH"] = os.pathsep.join(path)
        self.environment |= {f"DASK_DISTRIBUTED__COMM__TIMEOUTS__{name}": "120s" for name in ("CONNECT", "TCP")}

    def start(self, *words: str, log: str) -> subprocess.Popen[bytes]:
        with (self.place / log).open("ab") as stream:
            command = [sys.executable, "-m", *words]
            return subprocess.Popen(
                command, cwd=self.place, env=self.environment, stdin=subprocess.DEVNULL, stdout=stream, stderr=stream
            )

    def keep_up(self) -> bool:
        """Start what is not there, and tell whether the study has ended well."""
        if self.scheduler:
            where = f"tcp://127.0.0.1:{self.port}"
            wanted = {"scheduler": ("scheduler", "--host", "127.0.0.1", "--port", str(self.port), "--no-dashboard")}
            own = ("--nthreads", "1", "--no-nanny", "--no-dashboard")
            wanted |= {f"worker {i}": ("worker", where, *own) for i in range(self.pool)}
            for name, words in wanted.items():
                if name not in self.cluster or self.cluster[name].poll() is not None:
                    self.cluster[name] = self.start("dask", *words, log="cluster.log")
        if self.driver is not None and self.driver.poll() is not None:
            self.codes[self.driver.returncode] += 1
            log = (self.place / f"driver {self.starts}.log").read_text(encoding="utf-8", errors="replace")
            self.tracebacks += "Traceback" in log
            self.said |= {line for line in log.splitlines() if line.startswith(("Error:", "Stopped."))}
            if self.driver.returncode == 0:
                return True
            self.driver = None
        if self.driver is None:
            self.starts += 1
            where_to = (
                ("--scheduler", f"tcp://127.0.0.1:{self.port}")
                if self.scheduler
                else ("--workers", str(min(self.pool, 2)))
            )
            words = ("gyroctl", "compare", "study.toml", "--out", "out", "--no-search", *where_to)
            self.driver, self.started = self.start(*words, log=f"driver {self.starts}.log"), time.monotonic()
        return False

    def kill(self, one: Kill) -> bool:
        """Kill a process if one of that kind is there."""
        targets: list[int] = []
        if one.who == "driver" and self.driver is not None and self.driver.poll() is None:
            young = time.monotonic() - self.started < YOUNG
            targets = [] if young else [self.driver.pid]
        elif one.who != "driver" and self.scheduler:
            targets = [p.pid for name, p in self.cluster.items() if name.startswith(one.who) and p.poll() is None]
        elif one.who == "worker" and self.driver is not None:
            targets = workers_of(self.driver.pid)
        targets = [target for target in targets if target not in self.dead]
        if one.signal is signal.SIGINT:
            targets = [target for target in targets if age(target) > UP]
        if not targets:
            return False
        target = random.Random(f"{one.after} {one.wait}").choice(sorted(targets))
        self.dead.add(target)
        os.kill(target, one.signal)
        self.killed[f"{one.who} {one.signal.name}"] += 1
        return True

    def end(self) -> int:
        """End the cluster; return how many processes of the study are left after that."""
        for process in self.cluster.values():
            process.kill()
            process.wait()
        deadline = time.monotonic() + 60.0  # one that was just begun has its imports before it sees that it is alone
        while (left := with_token()) and time.monotonic() < deadline:
            time.sleep(0.2)
        for process_id in left:
            os.kill(process_id, signal.SIGKILL)
        return len(left)


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def workers_of(driver: int) -> list[int]:
    """Processes in which a driver runs laws."""
    found = []
    for path in Path("/proc").glob("[0-9]*"):
        try:
            parent = int((path / "stat").read_text().rpartition(")")[2].split()[1])
            if parent == driver and b"spawn_main" in (path / "cmdline").read_bytes():
                found.append(int(path.name))
        except (OSError, ValueError, IndexError):
            continue
    return found


def age(process: int) -> float:
    """Time since a process was started, 0 where it is no more. [s]"""
    try:
        ticks = int(Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[19])
    except (OSError, IndexError):
        return 0.0
    return float(Path("/proc/uptime").read_text().split()[0]) - ticks / os.sysconf("SC_CLK_TCK")


def with_token() -> list[int]:
    """Processes that this one has started, and theirs, zombies apart."""
    found = []
    for path in Path("/proc").glob("[0-9]*"):
        try:
            if TOKEN.encode() in (path / "environ").read_bytes():
                found.append(int(path.name))
        except OSError:
            continue
    return found


def disturbed(place: Path, asked: argparse.Namespace, scheduler: bool) -> dict[str, Any]:
    """Run a study and kill its processes."""
    counts = {
        "worker": asked.workers,
        "driver": asked.drivers,
        **({"scheduler": asked.schedulers} if scheduler else {}),
    }
    rng = random.Random(f"{asked.seed} {scheduler}")
    kills, free = planned(rng, asked.items, counts), 0.0
    study = Study(place, scheduler, asked.pool)
    witness = Witness(study.folder / "runs")
    begin, due = time.monotonic(), list[tuple[float, Kill]]()
    try:
        while not study.keep_up():
            now = time.monotonic()
            if now - begin > asked.patience:
                raise TimeoutError(f"the study has not ended: {study.codes}, {study.said}, {witness.count} stored")
            while kills and witness.count >= kills[0].after:
                due.append((now + kills[0].wait, kills.pop(0)))
            for one in [one for one in due if max(one[0], free) <= now]:
                if study.kill(one[1]):
                    due.remove(one)
                    free = now + rng.expovariate(1.0 / APART)
                    break
            time.sleep(0.02)
        time.sleep(0.5)
    finally:
        left = study.end()
    table = found(witness, journal(place / "journal"), study.folder, place.parent / "serial" / "out")
    return {
        **table,
        "processes_left": left,
        "tracebacks": study.tracebacks,
        "kills_not_made": len(kills) + len(due),
        "killed": dict(sorted(study.killed.items())),
        "commands": study.starts,
        "exit_codes": {str(code): count for code, count in sorted(study.codes.items())},
        "said": sorted(line.replace(str(place), ".").replace(str(study.port), "PORT") for line in study.said),
        "wall_s": round(time.monotonic() - begin, 1),
    }


def written(place: Path, asked: argparse.Namespace) -> Path:
    """Make the folder of a study with its experiment."""
    place.mkdir()
    seeds = ", ".join(str(seed) for seed in range(1, asked.items // LAWS + 1))
    (place / "study.toml").write_text(EXPERIMENT.format(duration=asked.duration, seeds=seeds))
    (place / "own.py").write_text(OWN)
    return place


def serial(place: Path) -> None:
    """Run the study by one worker that nobody disturbs."""
    words = ["compare", "study.toml", "--out", "out", "--no-search", "--workers", "1"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    subprocess.run(
        [sys.executable, "-m", "gyroctl", *words], cwd=place, env=environment, check=True, stdout=subprocess.DEVNULL
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scheduler", action="store_true", help="on workers of Dask alone")
    parser.add_argument("--alone", action="store_true", help="without Dask alone")
    parser.add_argument("--items", type=int, default=500)
    parser.add_argument("--duration", type=float, default=300.0, help="of a run [s]")
    parser.add_argument("--patience", type=float, default=3600.0, help="for a study to end [s]")
    parser.add_argument("--pool", type=int, default=4, help="workers of Dask; alone two processes run laws")
    parser.add_argument("--workers", type=int, default=20, help="kills of workers")
    parser.add_argument("--drivers", type=int, default=3)
    parser.add_argument("--schedulers", type=int, default=1)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--keep", type=Path, help="folder for all that is written, kept; the serial study is found there"
    )
    parser.add_argument("--out", type=Path, default=Path(__file__).with_suffix(".json"))
    asked = parser.parse_args()
    asked.items -= asked.items % LAWS
    modes = [name for name in ("scheduler", "alone") if getattr(asked, name)] or ["scheduler", "alone"]
    known = json.loads(asked.out.read_text(encoding="utf-8")) if asked.out.is_file() else {}
    content = {**{mode: known[mode] for mode in ("scheduler", "alone") if mode in known}, **here()}
    with tempfile.TemporaryDirectory(prefix="kills-") as home:
        place = asked.keep or Path(home) / "kept"
        place.mkdir(parents=True, exist_ok=True)
        if not (place / "serial").is_dir():
            serial(written(place / "serial", asked))
        for mode in modes:
            table = disturbed(written(place / mode, asked), asked, mode == "scheduler")
            wrong = [name for name in (*WRONG, "processes_left", "tracebacks", "kills_not_made") if table[name]]
            content[mode] = {"wrong": sum(table[name] for name in wrong), **table, "seed": asked.seed}
            print(json.dumps({mode: content[mode]}, indent=1), flush=True)
    asked.out.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    sys.exit(1 if any(content[mode]["wrong"] for mode in modes) else 0)


if __name__ == "__main__":
    main()
