"""Faults planted one at a time, to see whether the tests see them.

    python benchmarks/mutants.py                              # all of them, half an hour or so on one core
    python benchmarks/mutants.py --only statistics --only verdict   # rooms, or names of mutants
    python benchmarks/mutants.py --check                      # whether the set still fits the sources

The faults stand in ``benchmarks/mutants/ROOM.toml``: file, exact old text, new text, and the tests that are to fail,
whole files or functions, which are found by their names wherever they stand.
Each is put into a copy of the tree, never into the checkout, and its tests run there until one fails. A text that is
not found exactly once is stale: the source has moved on and the fault is to be written anew.

The copy's compiled code is kept apart: faults in files that are compiled into others begin with an empty cache, all
others with one that the sound tree has filled. So no fault meets the machine code of another.
"""

from __future__ import annotations

import argparse
import ast
import json
import multiprocessing
import os
import shutil
import sys
import tempfile
import time
import tomllib
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
FOLDER = Path(__file__).with_suffix("")

COPIED = ("gyroctl", "controllers", "studies", "tests", "docs", "benchmarks", "pyproject.toml", "README.md")
COMPILED = ("gyroctl/plant/", "gyroctl/harness/sensing", "gyroctl/harness/actuation", "gyroctl/harness/loop")
COMPILED += ("gyroctl/harness/lane_loop",)
"""Files that are compiled into functions which other files keep on disk."""

PRELOADED = ["pytest", "hypothesis", "numba", "scipy.stats", "scipy.integrate", "scipy.optimize", "scipy.linalg"]
PRELOADED += ["control", "casadi", "xarray", "sympy", "typer.testing", "rich.table", "rich.progress", "plotly"]
"""Libraries that every process of tests would load again: loaded once where processes can be forked."""

LIMIT = 240.0
"""Seconds after which tests that still run count as failed: a fault that never ends is seen."""


@dataclass(frozen=True)
class Mutant:
    """A fault: `old` becomes `new` in `file`."""

    room: str
    name: str
    file: str
    old: str
    new: str
    tests: tuple[str, ...]
    survives: str = ""  # why no test can or should see it, where that is so


@dataclass(frozen=True)
class Found:
    """What became of a fault: killed by a test, killed by the clock, survived, or stale."""

    room: str
    name: str
    status: str
    by: str
    seconds: float
    survives: str


def read_mutants(folder: Path = FOLDER) -> list[Mutant]:
    """All faults, room by room."""
    found = []
    for path in sorted(folder.glob("*.toml")):
        table = tomllib.loads(path.read_text(encoding="utf-8"))
        for entry in table["mutant"]:
            tests = tuple(entry.get("tests", table.get("tests", ())))
            fields = {name: entry[name] for name in ("name", "file", "old", "new")}
            found.append(Mutant(path.stem, **fields, tests=tests, survives=entry.get("survives", "")))
    return found


def stale(mutants: Sequence[Mutant], root: Path = ROOT) -> list[str]:
    """What no longer fits: a text that is not there exactly once, a test that is gone, a name used twice."""
    problems = []
    names = [f"{mutant.room}/{mutant.name}" for mutant in mutants]
    problems += [f"{name}: two mutants of that name" for name in sorted({n for n in names if names.count(n) > 1})]
    for mutant, name in zip(mutants, names, strict=True):
        path = root / mutant.file
        count = path.read_text(encoding="utf-8").count(mutant.old) if path.is_file() else 0
        if count != 1:
            problems.append(f"{name}: its text is {count} times in {mutant.file}")
        if (
            count == 1
            and path.suffix == ".py"
            and not _readable(path.read_text(encoding="utf-8").replace(mutant.old, mutant.new))
        ):
            problems.append(f"{name}: is no Python any more")
        if mutant.old == mutant.new or not mutant.tests:
            problems.append(f"{name}: changes nothing, or names no test")
        problems += [f"{name}: there is not one {test}" for test in mutant.tests if not located(test, root)]
    return problems


def _readable(text: str) -> bool:
    try:
        ast.parse(text)
    except SyntaxError:
        return False
    return True


def located(test: str, root: Path = ROOT) -> str:
    """What pytest is to be told: a file of tests, or a function with the file that has it; empty where not one has."""
    if test.endswith(".py"):
        return test if (root / test).is_file() else ""
    pattern = f"def {test}("
    files = [path for path in sorted((root / "tests").glob("test_*.py")) if pattern in path.read_text(encoding="utf-8")]
    return f"{files[0].relative_to(root).as_posix()}::{test}" if len(files) == 1 else ""


def run_tests(root: Path, cache: Path, tests: Sequence[str], output: Path) -> None:
    """Run pytest in this process, a fresh one, on the copy below `root`; the exit code is that of pytest."""
    os.chdir(root)
    os.environ |= {"PYTHONPATH": str(root), "NUMBA_CACHE_DIR": str(cache), "PYTHONDONTWRITEBYTECODE": "1"}
    sys.dont_write_bytecode = True
    sys.path.insert(0, str(root))
    with output.open("w") as file:
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
    import numba
    import pytest

    numba.config.CACHE_DIR = str(cache)  # numba may have been loaded before
    sys.exit(int(pytest.main(["-x", "-q", "-p", "no:cacheprovider", "--no-header", "--hypothesis-seed=0", *tests])))


class Tree:
    """A copy of the checkout with caches of its own."""

    def __init__(self, folder: Path) -> None:
        self.root, self.warm = folder / "tree", folder / "warm"
        self.cache = folder / "cache"
        self.warm.mkdir()
        self.root.mkdir()
        kind = "forkserver" if "forkserver" in multiprocessing.get_all_start_methods() else "spawn"
        self.processes: Any = multiprocessing.get_context(kind)
        if kind == "forkserver":
            self.processes.set_forkserver_preload(PRELOADED)
        for name in COPIED:
            source, target = ROOT / name, self.root / name
            if source.is_dir():
                ignored = shutil.ignore_patterns("__pycache__", ".hypothesis")
                shutil.copytree(source, target, symlinks=True, ignore=ignored)
            else:
                shutil.copy2(source, target)

    def run(self, tests: Sequence[str], cache: Path, limit: float) -> tuple[str, str]:
        """Run tests until one fails: "passed", "failed" or "too long", and the last line of what they print."""
        output = self.root.parent / "output.txt"
        named = [located(test) for test in tests]
        process = self.processes.Process(target=run_tests, args=(self.root, cache, named, output))
        process.start()
        process.join(limit)
        if process.exitcode is None:
            process.kill()
            process.join()
            return "too long", f"{limit:g} s"
        lines = output.read_text(encoding="utf-8", errors="replace").strip().splitlines()
        telling = [line for line in lines if line.startswith(("FAILED", "ERROR"))]
        return ("passed" if process.exitcode == 0 else "failed"), (telling or lines or ["no output"])[-1][:160]

    def sound(self, tests: Sequence[str]) -> str:
        """Run the tests on the sound tree, which fills the cache; what fails, or nothing."""
        status, said = self.run(tests, self.warm, 3600.0)
        return "" if status == "passed" else said

    def tried(self, mutant: Mutant, limit: float) -> Found:
        """Plant a fault, run its tests, take it out again."""
        path = self.root / mutant.file
        text, times = path.read_text(encoding="utf-8"), path.stat()
        shutil.rmtree(self.cache, ignore_errors=True)
        if mutant.file.startswith(COMPILED):
            self.cache.mkdir()
        else:
            shutil.copytree(self.warm, self.cache)
        begin = time.perf_counter()
        path.write_text(text.replace(mutant.old, mutant.new), encoding="utf-8")
        try:
            status, said = self.run(mutant.tests, self.cache, limit)
        finally:
            path.write_text(text, encoding="utf-8")
            shutil.rmtree(self.root / ".hypothesis", ignore_errors=True)  # what it found is no test of the next fault
            os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))  # machine code of the sound tree stays valid
        word = {"passed": "survived", "failed": "killed", "too long": "killed"}[status]
        return Found(mutant.room, mutant.name, word, said, time.perf_counter() - begin, mutant.survives)


def chosen(mutants: Sequence[Mutant], only: Sequence[str]) -> list[Mutant]:
    """Mutants of the rooms, or with the names, that are asked for."""
    return [m for m in mutants if not only or {m.room, m.name, f"{m.room}/{m.name}"} & set(only)]


def score(found: Sequence[Found]) -> str:
    """One line: how many of the faults were seen, and which were not."""
    killed = sum(each.status == "killed" for each in found)
    left = [f"{each.room}/{each.name}" for each in found if each.status != "killed"]
    share = 100.0 * killed / max(len(found), 1)
    return f"{killed} of {len(found)} killed, {share:.1f} %" + (f"; not killed: {', '.join(left)}" if left else "")


def merged(path: Path, found: Sequence[Found]) -> list[Found]:
    """What was found in earlier chunks, renewed by what is found now."""
    known = {(each.room, each.name): each for each in found}
    if path.is_file():
        before = json.loads(path.read_text(encoding="utf-8"))["mutants"]
        known = {(each["room"], each["name"]): Found(**each) for each in before} | known
    present = {(mutant.room, mutant.name) for mutant in read_mutants()}
    return [known[key] for key in sorted(known) if key in present]


def write(path: Path, found: Sequence[Found]) -> None:
    """Keep the findings as JSON, so that the set can be run in chunks."""
    path.parent.mkdir(parents=True, exist_ok=True)
    content = {"score": score(found), "mutants": [asdict(each) for each in found]}
    path.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", action="append", default=[], help="a room, or the name of a mutant; repeatable")
    parser.add_argument("--check", action="store_true", help="only say what is stale")
    parser.add_argument("--limit", type=float, default=LIMIT, help="seconds for the tests of a mutant")
    parser.add_argument("--out", type=Path, default=ROOT / "results" / "mutants.json", help="earlier chunks are kept")
    options = parser.parse_args()
    wanted = chosen(read_mutants(), options.only)
    problems = stale(wanted)
    print("\n".join(problems) if problems else f"{len(wanted)} mutants fit the sources")
    if options.check or problems:
        return int(bool(problems))
    with tempfile.TemporaryDirectory(prefix="mutants") as folder:
        tree = Tree(Path(folder))
        tests = sorted({test for mutant in wanted for test in mutant.tests})
        print(f"the sound tree: {len(tests)} tests or files of them", flush=True)
        broken = tree.sound(tests)
        if broken:
            print(f"they fail on the sound tree: {broken}")
            return 2
        found = []
        for mutant in wanted:
            found.append(tree.tried(mutant, options.limit))
            each = found[-1]
            print(f"{each.status:8}  {each.seconds:5.1f} s  {each.room}/{each.name}  {each.by}", flush=True)
            write(options.out, merged(options.out, found))
    print(score(found))
    print(f"{options.out}: {score(merged(options.out, found))}")
    return int(any(each.status != "killed" and not each.survives for each in found))


if __name__ == "__main__":
    sys.exit(main())
