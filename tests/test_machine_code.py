"""Machine code is kept by content: anything that is compiled into it, changed, is compiled anew; the rest is found."""

from __future__ import annotations

import importlib
import importlib.util
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.cache import KEY
from gyroctl.cli.first_time import say_first_time
from gyroctl.harness import loop
from gyroctl.harness.law_entry import compile_law
from gyroctl.plant import kernel, machine_code
from gyroctl.plant.compiled import entry_point
from gyroctl.plant.ingredients import Untold, ingredients
from gyroctl.plant.machine_code import folder, kept

LAW = """
import math
from typing import NamedTuple

import numpy as np

import {other}
from {other} import eased

SLOW = 0.3
TABLE = np.array([1.0, 2.0])


class State(NamedTuple):
    speed: float


class Eased(NamedTuple):
    cc: float = 0.06
    period: float = 0.1

    def init(self):
        return State(3.14)

    def limit(self):
        return 0.02

    def told(self):
        return 1.0

    def step(self, t, y, state):
        speed = state.speed + SLOW * (y.psi_rate - state.speed)
        return (self.cc, min(eased(speed), self.limit()) * {other}.FACTOR + 0.0 * TABLE[0]), State(math.fabs(speed))
"""

OTHER = """
FACTOR = 1.0


def eased(speed):
    return further(speed)


def further(speed):
    return 1e-4 * speed
"""


@pytest.fixture
def write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Any]:
    """Write the two files with some words replaced, and load the law from them."""
    monkeypatch.syspath_prepend(str(tmp_path))
    count = iter(range(100))

    def written(*changes: tuple[str, str]) -> Any:
        law, other = LAW, OTHER
        for old, new in changes:
            assert (law + other).count(old) == 1
            law, other = law.replace(old, new), other.replace(old, new)
        home = tmp_path / str(next(count))
        home.mkdir()
        (home / "part_of_a_law.py").write_text(other)
        (home / "a_law.py").write_text(law.replace("{other}", "part_of_a_law"))
        monkeypatch.syspath_prepend(str(home))
        for name in ("part_of_a_law", "a_law"):
            spec = importlib.util.spec_from_file_location(name, home / f"{name}.py")
            assert spec is not None and spec.loader is not None
            module = importlib.util.module_from_spec(spec)
            monkeypatch.setitem(sys.modules, name, module)
            spec.loader.exec_module(module)
        return module

    return written


def content(module: Any) -> str:
    return ingredients(module.Eased, module.State, names=("step",))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("SLOW = 0.3", "SLOW = 0.4"),
        ("[1.0, 2.0]", "[1.0, 3.0]"),
        ("FACTOR = 1.0", "FACTOR = 1.5"),
        ("1e-4 * speed", "2e-4 * speed"),
        ("return further(speed)", "return 2.0 * further(speed)"),
        ("return 0.02", "return 0.03"),
        ("math.fabs(speed)", "math.sqrt(speed)"),
        ("speed: float", "velocity: float"),
    ],
)
def test_all_that_a_law_leads_to_counts(write: Callable[..., Any], old: str, new: str) -> None:
    assert content(write()) != content(write((old, new)))


@pytest.mark.parametrize(("old", "new"), [("return 1.0", "return 2.0"), ("cc: float = 0.06", "cc: float = 0.07")])
def test_what_no_step_reads_does_not_count(write: Callable[..., Any], old: str, new: str) -> None:
    """A method that is never called; a parameter, which comes with the numbers of the law."""
    assert content(write()) == content(write((old, new)))


def made(gain: Any, offset: Any, steep: bool = True) -> Callable[[float], float]:
    def line(x: float, first: float = 1.0, second: float = 2.0) -> float:
        return float(gain * x + offset + first * second if steep else gain)

    return line


def with_defaults(*values: float) -> Callable[[float], float]:
    line = made(1.0, 2.0)
    line.__defaults__ = values  # type: ignore[attr-defined]
    return line


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (made(0.5, 2.0), made(2.0, 0.5)),
        (made(True, False, True), made(True, False, False)),
        (made(np.ones(2), np.zeros(2)), made(np.zeros(2), np.ones(2))),
        (made((1.0, (2.0, 3.0)), 0.0), made((2.0, (1.0, 3.0)), 0.0)),
        (made(made(1.0, 2.0), made(2.0, 1.0)), made(made(2.0, 1.0), made(1.0, 2.0))),
        (with_defaults(1.0, 2.0), with_defaults(2.0, 1.0)),
    ],
    ids=["numbers", "flags", "tables", "tuples", "functions", "defaults"],
)
def test_what_changes_places_counts(one: Any, other: Any) -> None:
    """The same things in other places are other code."""
    assert ingredients(one) == ingredients(one) != ingredients(other)


def test_same_text_in_another_folder_is_the_same(write: Callable[..., Any]) -> None:
    assert content(write()) == content(write())


def test_what_cannot_be_told_is_no_content(write: Callable[..., Any]) -> None:
    module = write()
    module.SLOW = [0.3]  # a list can change without a word
    with pytest.raises(Untold):
        content(module)


def test_sources_within_the_package_count_with_all_that_they_lead_to(monkeypatch: pytest.MonkeyPatch) -> None:
    before, beside = ingredients(loop.compiled_loop), ingredients(kernel.hold_into)
    monkeypatch.setattr(kernel, "ACCURATE", 60.0)  # read by `steps_for`, which the loop calls and the kernel does not
    assert ingredients(loop.compiled_loop) != before
    assert ingredients(kernel.hold_into) == beside


PLAIN = """
from typing import NamedTuple

GAIN = 0.0


class State(NamedTuple):
    speed: float


class Plain(NamedTuple):
    period: float = 0.1

    def init(self):
        return State(3.0)

    def step(self, t, y, state):
        return (0.05, GAIN * state.speed), State(y.psi_rate)
"""

PROBE = """
import sys
sys.path.insert(0, sys.argv[1])
import numpy as np
from numba.core.ccallback import CFunc
import a_plain_law
from gyroctl.harness import law_entry
from gyroctl.harness.loop import compiled_calls

anew = []
plainly = CFunc._compile_uncached
CFunc._compile_uncached = lambda self: (anew.append(self), plainly(self))[1]
for gain in map(float, sys.argv[2:]):
    a_plain_law.GAIN = gain
    law_entry._compiled_entry.cache_clear()
    law = law_entry.compile_law(a_plain_law.Plain())
    u, s = np.zeros(2), law.s.copy()
    compiled_calls(law.entry, law.p, s, np.full(7, 4.0), u, 1)
    print(len(anew), float(u[1]))
"""


@pytest.mark.slow
def test_another_process_finds_the_law_and_another_number_is_seen(tmp_path: Path) -> None:
    """The first process compiles and the second does not; where a number that the law reads is another, it does."""
    (tmp_path / "a_plain_law.py").write_text(PLAIN)
    environment = {**os.environ, "GYROCTL_CACHE": str(tmp_path / "cache"), "PYTHONDONTWRITEBYTECODE": "1"}
    environment.pop("NUMBA_CACHE_DIR", None)

    def probe(*gains: float) -> list[str]:
        command = [sys.executable, "-c", PROBE, str(tmp_path), *map(str, gains)]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
        return done.stdout.splitlines()

    assert probe(1e-4) == [f"1 {1e-4 * 3.0}"]
    assert probe(1e-4, 2e-4, 1e-4) == [f"0 {1e-4 * 3.0}", f"1 {2e-4 * 3.0}", f"1 {1e-4 * 3.0}"]


CALLER = """
from gyroctl.plant.compiled import entry_point, inlined
from callee_of_one import FACTOR


@inlined
def scaled(x):
    return FACTOR * x


@entry_point
def twice(x):
    return 2.0 * scaled(x)
"""


def test_what_an_entry_point_calls_is_compiled_anew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The text of the function itself and its place stay as they are."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "kept"))
    (tmp_path / "caller_of_one.py").write_text(CALLER)
    monkeypatch.syspath_prepend(str(tmp_path))
    for factor in (3.0, 5.0, 3.0):
        module = ModuleType("callee_of_one")
        module.__dict__["FACTOR"] = factor
        monkeypatch.setitem(sys.modules, "callee_of_one", module)
        monkeypatch.delitem(sys.modules, "caller_of_one", raising=False)
        assert importlib.import_module("caller_of_one").twice(7.0) == 14.0 * factor
    assert len([*(tmp_path / "kept" / "gyroctl").glob("caller_of_one.twice-*.nbi")]) == 2


def test_signatures_compiled_at_the_same_time_keep_apart(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As two processes do that both found nothing: one index is lost, and the code under the other one is its own."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))

    def halved(x: Any) -> Any:
        return x / 2

    entry_point(halved)(3.0)
    (index,) = (tmp_path / "gyroctl").glob("*.nbi")
    first = index.read_bytes()
    index.unlink()
    entry_point(halved)(3j)
    for content in (first, index.read_bytes()):
        index.write_bytes(content)
        assert entry_point(halved)(5.0) == 2.5
        assert entry_point(halved)(5j) == 2.5j


@pytest.mark.parametrize(("kept_before", "said"), [("", True), ("loop.other", True), ("loop._closed_loop_0", False)])
def test_first_time_is_said(
    kept_before: str, said: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    place = folder()
    assert place == tmp_path / "gyroctl"
    (place / f"{kept_before}.nbi").write_text("")
    say_first_time("plant and law", 4)
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err == ("Compiling plant and law for this machine, once: about 4 s\n" if said else "")


@pytest.mark.slow
def test_files_cut_short_are_compiled_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GYROCTL_CACHE", str(tmp_path))
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)

    def compiled() -> Any:
        from gyroctl.harness import law_entry

        law_entry._compiled_entry.cache_clear()
        return compile_law(gy.law("coupling"))

    assert compiled() is not None
    files = [path for path in folder().iterdir() if path.name != KEY]
    assert {path.suffix for path in files} == {".nbi", ".nbc"}
    assert kept("entry of ") and not kept("nothing of the kind")
    for path in files:
        path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    assert compiled() is not None


def test_oldest_versions_go(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    place = folder()
    assert place is not None
    names = [f"file.one_{i:016x}-{i:016x}.py311" for i in range(machine_code.VERSIONS + 2)]
    for age, name in enumerate(reversed(names)):
        for path in (place / f"{name}.nbi", place / f"{name}.1.nbc"):
            path.write_text("")
            os.utime(path, (1000.0 + age, 1000.0 + age))
    (place / "file.other-0123456789abcdef.py311.nbi").write_text("")
    machine_code._forget(names[0])
    left = {path.name for path in place.iterdir()}
    assert len(left) == 2 * machine_code.VERSIONS + 1
    assert f"{names[0]}.nbi" in left and f"{names[0]}.1.nbc" in left
    assert f"{names[-1]}.nbi" not in left and f"{names[-1]}.1.nbc" not in left


def test_folder_that_others_share_is_left_as_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """$NUMBA_CACHE_DIR is numba's, for all projects of a machine: ours is a folder in it, and no more."""
    shared = tmp_path / "shared"
    shared.mkdir()
    shared.chmod(0o1777)  # of everybody, where none can take away what is another's
    (shared / "others.function-12.py311.nbi").write_text("theirs")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(shared))
    assert folder() == shared / "gyroctl"
    assert (shared / "others.function-12.py311.nbi").read_text() == "theirs"
    if os.name == "posix":
        assert (shared.stat().st_mode & 0o777, (shared / "gyroctl").stat().st_mode & 0o777) == (0o777, 0o700)
        open_to_all = tmp_path / "open"
        open_to_all.mkdir()
        open_to_all.chmod(0o777)
        monkeypatch.setenv("NUMBA_CACHE_DIR", str(open_to_all))
        assert folder() is None  # anybody could put a folder of code of his own there
