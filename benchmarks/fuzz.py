"""Readers of files from outside, given what no writer wrote: python benchmarks/fuzz.py READER --inputs 100000 --seed 1.

Each input is a sound file with one to three things wrong (`fuzz_mutations`). It must give a sound result or an
`InputError`; anything else is a finding: another exception, a result that asserts refuse (`fuzz_readers`), more than
5 s, more than 1 GB, the end of the process. Batches run in a child of limited memory; findings stay in a folder.

A batch reads HDF5 within its own process, for speed. An input that brings that to its end is read once more as users
read it, through a process of its own, and what comes of that counts.
"""

from __future__ import annotations

import argparse
import collections
import io
import json
import os
import random
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import traceback
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

SECONDS, BYTES = 5.0, 1 << 30
"""What an input may take, of a processor: a busy machine is no fault of a reader."""

GRACE = 120.0
"""After which a child that tells nothing and needs no processor is ended. [s]"""

LOOK = 1.0
"""How often to look at a child that tells nothing. [s]"""


@dataclass
class Spent:
    """What inputs took of a processor, all and the longest [s], and the most memory of a child above its start. [B]"""

    all: float = 0.0
    longest: float = 0.0
    memory: float = 0.0


class TooLong(BaseException):
    """An input took more than `SECONDS`."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("readers", nargs="+", help="names in fuzz_readers.READERS, or all")
    parser.add_argument("--inputs", type=int, default=100_000, help="for each reader")
    parser.add_argument("--hdf5", type=int, help="inputs for those that read HDF5, where it differs")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="number of the first input, to see one again")
    parser.add_argument("--out", type=Path, default=Path("fuzz-findings"), help="folder of findings")
    parser.add_argument("--json", type=Path, help="file of figures; those of other readers that it holds stay")
    parser.add_argument("--batch", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--apart", action="store_true", help="read HDF5 as users do, a process for each file")
    asked = parser.parse_args()
    if asked.batch:
        return batch(asked)
    names = [name for reader in asked.readers for name in (known() if reader == "all" else [reader])]
    findings = 0
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            inputs = asked.hdf5 if asked.hdf5 and name.endswith("-hdf5") else asked.inputs
            findings += fuzzed(name, inputs, asked, Path(folder))
    return 1 if findings else 0


def known() -> list[str]:
    from fuzz_readers import READERS

    return list(READERS)


def fuzzed(name: str, inputs: int, asked: argparse.Namespace, folder: Path) -> int:
    """Put all inputs of a reader through child processes; print and return how many findings there are."""
    counts: collections.Counter[str] = collections.Counter()
    spent, begin, at, last = Spent(), time.monotonic(), asked.first, asked.first + inputs
    again = 0
    while at < last:
        done, ended = _child(name, range(at, last), asked, folder, asked.apart, counts, spent)
        at += done
        if at < last and name.endswith("-hdf5") and not asked.apart:
            done, ended = _child(name, range(at, at + 1), asked, folder, True, counts, spent)
            at, again = at + done, again + 1
            if done:
                continue
        if at < last:  # the child ended within an input
            counts["the process ended" if ended != -signal.SIGKILL else "stuck"] += 1
            kept = asked.out / name / str(at)
            kept.mkdir(parents=True, exist_ok=True)
            (kept / "why.txt").write_text(f"the child ended with {ended}\n")
            at += 1
            if not done and counts["the process ended"] > 20:
                print(f"{name}: no child gets anywhere")
                return 1
    findings = sum(count for kind, count in counts.items() if kind not in ("read", "refused"))
    read, refused = counts.pop("read", 0), counts.pop("refused", 0)
    wall = time.monotonic() - begin
    told = f"{inputs} inputs in {wall:.0f} s ({spent.all:.0f} s of a processor), longest {spent.longest:.2f} s"
    told += f", at most {spent.memory / 1e6:.0f} MB" + (f", {again} read apart" if again else "")
    print(f"{name}: {told}: {read} read, {refused} refused, {findings} findings {dict(counts) or ''}", flush=True)
    if asked.json:
        figures = {"inputs": inputs, "seed": asked.seed, "read": read, "refused": refused, "findings": dict(counts)}
        figures |= {"seconds": round(wall), "processor_s": round(spent.all, 1), "longest_s": round(spent.longest, 3)}
        figures |= {"read_apart": again} if name.endswith("-hdf5") else {}
        note(asked.json, name, {**figures, "peak_mb": round(spent.memory / 1e6, 1)})
    return findings


def note(path: Path, name: str, figures: dict[str, Any]) -> None:
    """Write the figures of a reader beside those of the others."""
    known: dict[str, Any] = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    path.write_text(json.dumps(dict(sorted({**known, name: figures}.items())), indent=1) + "\n", encoding="utf-8")


def _child(
    name: str,
    numbers: range,
    asked: argparse.Namespace,
    folder: Path,
    apart: bool,
    counts: collections.Counter[str],
    spent: Spent,
) -> tuple[int, int]:
    """Put inputs through one child process; return how many it told of, and how it ended."""
    command = [sys.executable, __file__, name, "--seed", str(asked.seed), "--first", str(numbers.start)]
    command += ["--inputs", str(len(numbers)), "--out", str(asked.out), "--batch", str(folder)]
    command += ["--apart"] if apart else []
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as child:
        return _followed(child, counts, spent), child.wait()


def _followed(child: subprocess.Popen[bytes], counts: collections.Counter[str], spent: Spent) -> int:
    """Count what a child tells, line by line, and end it where it tells nothing more."""
    assert child.stdout is not None
    done, rest, begun, told_at, used_at = 0, b"", False, time.monotonic(), 0.0
    while True:
        ready, _, _ = select.select([child.stdout], [], [], LOOK)
        if not ready:
            state, used = _state(child.pid)
            stuck = begun and used - used_at > 2.0 * SECONDS  # in C, where no signal reaches it
            idle = time.monotonic() - told_at > GRACE and state not in "RD"  # a busy machine is no fault of a reader
            if not stuck and not idle:
                continue
            child.kill()
        data = os.read(child.stdout.fileno(), 65536)
        if not data:
            child.wait()
            return done
        *lines, rest = (rest + data).split(b"\n")
        begun, told_at, used_at = True, time.monotonic(), _state(child.pid)[1]
        for line in lines:
            if line != b"begun":
                told: dict[str, Any] = json.loads(line)
                counts[told["kind"]] += 1
                done, spent.all = done + 1, spent.all + told["seconds"]
                spent.longest, spent.memory = max(spent.longest, told["seconds"]), max(spent.memory, told["memory"])


def _state(process: int) -> tuple[str, float]:
    """State of a process, and what it has used of a processor. [s]"""
    words = Path(f"/proc/{process}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    return words[0], (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


def batch(asked: argparse.Namespace) -> int:
    """Work through inputs in this process, and tell each."""
    import resource

    from fuzz_mutations import mutated
    from fuzz_readers import READERS

    from gyroctl import netcdf

    os.environ[netcdf.TRUSTED] = "0" if asked.apart else "1"  # this is a child of limited memory and time itself
    warnings.simplefilter("ignore")
    (name,) = asked.readers
    reader, home = READERS[name], asked.batch / name
    listing = asked.batch / f"{name}.json"
    if not listing.is_file():
        listing.write_text(json.dumps([str(path) for path in reader.examples(home)]))
    examples = [Path(path) for path in json.loads(listing.read_text())]
    for path in examples:
        reader.read(path)  # what is sound is read, and all is imported and compiled
    told = sys.stdout
    sys.stdout = io.StringIO()
    used = int(Path("/proc/self/statm").read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    resource.setrlimit(resource.RLIMIT_AS, (used + BYTES, used + BYTES))
    signal.signal(signal.SIGPROF, _too_long)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    print("begun", file=told, flush=True)
    with tempfile.TemporaryDirectory() as scratch:
        for number in range(asked.first, asked.first + asked.inputs):
            rng = random.Random(f"{name} {asked.seed} {number}")
            example = rng.choice(examples)
            place = Path(scratch) / str(number)  # a name of its own: readers may remember
            whole = example if example.is_dir() else example.parent
            shutil.copytree(whole, place)
            files = sorted(path for path in place.rglob("*") if path.is_file())
            main_file = place / example.relative_to(whole)
            file = main_file if main_file.is_file() and rng.random() < 0.8 else rng.choice(files)
            file.write_bytes(mutated(file.read_bytes(), rng))
            begin = _processor()
            kind, why = _outcome(reader.read, main_file)
            seconds = _processor() - begin
            if kind in ("read", "refused") and seconds > SECONDS:
                kind, why = "too long", f"{seconds} s, those of processes that it started among them\n"
            if kind not in ("read", "refused"):
                kept = asked.out / name / str(number)
                shutil.rmtree(kept, ignore_errors=True)
                shutil.copytree(place, kept)
                (kept / "why.txt").write_text(why, encoding="utf-8", errors="backslashreplace")
            shutil.rmtree(place)
            memory = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) * 1024
            print(json.dumps({"kind": kind, "seconds": seconds, "memory": memory}), file=told, flush=True)
    return 0


def _processor() -> float:
    """What this process and those that it started have used of a processor. [s]"""
    import resource

    kinds = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    return sum(used.ru_utime + used.ru_stime for used in map(resource.getrusage, kinds))


def _outcome(read: Any, path: Path) -> tuple[str, str]:
    from gyroctl.errors import InputError

    signal.setitimer(signal.ITIMER_PROF, SECONDS)
    try:
        try:
            read(path)
            return "read", ""
        except InputError as error:
            _check_refusal(error)
            return "refused", ""
    except TooLong:
        return "too long", traceback.format_exc()[-4000:]
    except AssertionError:
        return "nonsense", traceback.format_exc()[-4000:]
    except Exception as error:
        return type(error).__name__, traceback.format_exc()[-4000:]
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)


def _check_refusal(error: Any) -> None:
    """A refusal can be printed, is no novel, and says once what to do: it is not the whole of another within one."""
    assert str(error).isprintable() and len(str(error)) < 5000, repr(error)[:3000]
    assert str(error).count(error.mend) == 1 or not error.mend.isprintable(), str(error)


def _too_long(*_: object) -> None:
    raise TooLong


if __name__ == "__main__":
    sys.exit(main())
