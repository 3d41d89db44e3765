"""A change makes the results that depend on it new, and no other: keys of stored runs before and after it."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.comparison.items import Realisations, work_items
from gyroctl.fingerprint import rests_on
from gyroctl.fingerprint.local import sources
from gyroctl.harness.law_fingerprint import law_fingerprint
from gyroctl.harness.run import Settings

ROOT = Path(gy.__file__).resolve().parents[1]
WAVES = Realisations(gy.SeaState(), (3,), duration=120.0)
SETTINGS = Settings(blend=40.0)

MINE = """
import sys
from pathlib import Path
from typing import NamedTuple

sys.path.insert(0, str(Path(__file__).parent))
from gains import gain

class Mine(NamedTuple):
    cc: float = 0.052
    period: float = 0.1
    information = "none"
    def init(self): return ()
    def step(self, t, y, state): return (self.cc, gain()), state
"""
GAINS = """
import deeper
TABLE = [float(n) for n in open(__file__.replace("gains.py", "numbers.csv")).read().split(",")]
def gain(): return deeper.part() * TABLE[0]
"""
DEEPER = "def part(): return 0.5\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A user's law with a module, that one's module, and a table."""
    import sys

    for name, text in {"mine.py": MINE, "gains.py": GAINS, "deeper.py": DEEPER, "numbers.csv": "4e-4,1"}.items():
        (tmp_path / name).write_text(text)
    (tmp_path / "other.py").write_text("x = 1\n")
    (tmp_path / "notes.txt").write_text("nothing\n")
    monkeypatch.setattr(sys, "path", [*sys.path])
    for name in ("gains", "deeper"):
        sys.modules.pop(name, None)
    return tmp_path


def keys(folder: Path, **change: Any) -> dict[str, str]:
    """Key of each law's run."""
    laws = {
        "coupling": gy.law("coupling"),
        "scheduled": gy.law("scheduled_lqr"),
        "nmpc": gy.law("nmpc"),
        "mine": gy.law(f"{folder}/mine.py:Mine"),
        **change.get("laws", {}),
    }
    plant, waves = change.get("plant", gy.zhang2017()), change.get("waves", WAVES)
    items = work_items(plant, laws, waves, change.get("settings", SETTINGS), 60.0)
    assert all(item.key for item in items)
    return {item.name: item.key for item in items}


ALL = {"coupling", "scheduled", "nmpc", "mine"}

PACKAGE = {
    "gyroctl/waves/spectrum.py": ALL,
    "gyroctl/harness/run.py": ALL,
    "gyroctl/plant/equations.py": ALL,
    "gyroctl/simulation/metrics.py": ALL,
    "gyroctl/version.py": ALL,
    "gyroctl/data/hydrodynamics.nc": ALL,
    "gyroctl/fingerprint/package.py": ALL,
    "controllers/nmpc/solvers/riccati.py": {"nmpc"},
    "controllers/gain_scheduled/scheduled.py": {"scheduled"},
    "controllers/rule_based/coupling.py": {"coupling"},
    "controllers/supervisor/rules.py": set(),
    "gyroctl/reports/report.py": set(),
    "gyroctl/cli/app.py": set(),
    "gyroctl/linearisation/riccati.py": set(),
    "gyroctl/palette.py": set(),
    "studies/style.py": set(),
    "gyroctl/data/seeds.toml": set(),
}


@pytest.mark.parametrize("file", sorted(PACKAGE))
def test_a_line_in_the_package(file: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def read(path: Path) -> bytes:
        return plain(path) + (b"\n# another line" if path.resolve() == (ROOT / file).resolve() else b"")

    plain, before = Path.read_bytes, keys(folder)
    monkeypatch.setattr(Path, "read_bytes", read)
    rests_on._listed.cache_clear()
    after = keys(folder)
    rests_on._listed.cache_clear()
    assert {law for law in before if before[law] != after[law]} == PACKAGE[file]


LOCAL = {
    "mine.py": {"mine"},
    "gains.py": {"mine"},
    "deeper.py": {"mine"},
    "numbers.csv": {"mine"},
    "other.py": set(),
    "notes.txt": set(),
}


@pytest.mark.parametrize("file", sorted(LOCAL))
def test_a_line_beside_a_law(file: str, folder: Path) -> None:
    before = keys(folder)
    text = (folder / file).read_text()
    (folder / file).write_text(text + (",5" if file.endswith("csv") else "# another line\n"))
    after = keys(folder)
    assert {law for law in before if before[law] != after[law]} == LOCAL[file]


def of_the_law(laws: dict[str, Any]) -> dict[str, Any]:
    return {"laws": laws}


def one_cell(law: Any) -> Any:
    """The same law with one number of its gain table changed."""
    from gyroctl import nested

    numbers = nested.leaves(law.cells)
    at = next(i for i, number in enumerate(numbers) if isinstance(number, float) and number)
    numbers[at] = np.nextafter(numbers[at], 1.0)
    return law._replace(cells=nested.like(law.cells, [float(n) for n in numbers]))


INPUT: dict[str, tuple[Callable[[], dict[str, Any]], set[str]]] = {
    "a parameter of a law": (lambda: of_the_law({"coupling": gy.law("coupling", through1=2.3)}), {"coupling"}),
    "a gain table": (lambda: of_the_law({"scheduled": one_cell(gy.law("scheduled_lqr"))}), {"scheduled"}),
    "the plant": (lambda: {"plant": gy.zhang2017(d1=1.99)}, ALL),
    "a sensor": (lambda: {"settings": replace(SETTINGS, sensors=gy.Sensors.ideal())}, ALL),
    "an actuator": (lambda: {"settings": replace(SETTINGS, actuators=gy.Actuators(delay=1))}, ALL),
    "the step": (lambda: {"settings": replace(SETTINGS, dt=0.005)}, ALL),
    "the length": (lambda: {"waves": replace(WAVES, duration=120.1)}, ALL),
    "the sea": (lambda: {"waves": replace(WAVES, sea=gy.SeaState(gamma=5.1))}, ALL),
    "the grid": (lambda: {"waves": replace(WAVES, dt=0.04)}, ALL),
}


@pytest.mark.parametrize("change", sorted(INPUT))
def test_a_change_of_what_is_asked(change: str, folder: Path) -> None:
    make, touched = INPUT[change]
    before, after = keys(folder), keys(folder, **make())
    assert {law for law in before if before[law] != after[law]} == touched


ASKED = """
[run]
duration = 120.0
blend = 40.0
dt = 0.01
seeds = [3]

[plant]
k3 = 2945.0
hydrodynamics = "float.nc"

[sensors.psi]
noise = 0.001

[actuators]
cc_lag = 0.02

[laws.mine]
law = "mine.py:Mine"

[laws.steady]
law = "coupling"

[laws.tuned]
law = "mine.py:Mine"
tuning = "all"
"""

SETS = '{"sets": {"all": {"parameters": {"cc": 0.06}}}}'

STUDIED = {"mine", "steady", "tuned"}
WRITTEN: dict[str, tuple[str, str, str, set[str]]] = {
    "a comment": ("mine.toml", "[run]", "# seen by nobody\n[run]", set()),
    "another order of its tables": (
        "mine.toml",
        "duration = 120.0\nblend = 40.0",
        "blend = 40.0\nduration = 120",
        set(),
    ),
    "its name": ("mine.toml", "", "", set()),
    "the limit of the verdict": ("mine.toml", "seeds = [3]", "seeds = [3]\nmotion_limit = 0.3", set()),
    "the time that a run may take": ("mine.toml", "seeds = [3]", "seeds = [3]\ntime_limit = 99.0", set()),
    "the step": ("mine.toml", "dt = 0.01", "dt = 0.005", STUDIED),
    "the noise of a sensor": ("mine.toml", "noise = 0.001", "noise = 0.0011", STUDIED),
    "the lag of an actuator": ("mine.toml", "cc_lag = 0.02", "cc_lag = 0.021", STUDIED),
    "a number of the plant": ("mine.toml", "k3 = 2945.0", "k3 = 2945.5", STUDIED),
    "the database of the float": ("float.nc", "", "", STUDIED),
    "a parameter of a law": ("mine.toml", 'law = "coupling"', 'law = "coupling"\nthrough1 = 2.3', {"steady"}),
    "a tuned set": ("tuned/Mine.json", "0.06", "0.061", {"tuned"}),
    "another set of the same file": (
        "tuned/Mine.json",
        '{"all"',
        '{"other": {"parameters": {"cc": 0.1}}, "all"',
        set(),
    ),
    "the module of a law": ("gains.py", "import deeper", "import deeper  # once more", {"mine", "tuned"}),
}


@pytest.mark.parametrize("change", sorted(WRITTEN))
def test_a_change_of_a_file_that_a_study_is_written_in(change: str, folder: Path) -> None:
    """From the experiment file to the keys: just what depends on a change is new."""
    import dataclasses

    from gyroctl.comparison.experiment import read_experiment
    from gyroctl.hydrodynamics import save, shipped

    def asked(file: str = "mine.toml") -> dict[str, str]:
        setup = read_experiment(folder / file)
        waves = Realisations(setup.sea, setup.run.seeds, setup.run.duration)
        laws = {name: law for name, law in setup.laws.items() if name in STUDIED}
        items = work_items(setup.plant, laws, waves, setup.settings, setup.run.time_limit or 60.0)
        return {item.name: item.key for item in items}

    (folder / "mine.toml").write_text(ASKED)
    (folder / "tuned").mkdir()
    (folder / "tuned" / "Mine.json").write_text(SETS)
    save(shipped(), folder / "float.nc")
    before = asked()
    assert len(set(before.values())) == 3 and all(before.values())
    name, old, new, touched = WRITTEN[change]
    if change == "its name":
        (folder / "mine.toml").rename(folder / "other.toml")
    elif change == "the database of the float":
        hydro = shipped()
        save(dataclasses.replace(hydro, excitation=hydro.excitation * (1.0 + 1e-12)), folder / "float.nc")
    else:
        text = (folder / name).read_text()
        assert text.count(old) == 1 or old == "[run]"
        (folder / name).write_text(text.replace(old, new, 1))
    after = asked("other.toml" if change == "its name" else "mine.toml")
    assert {law for law in before if before[law] != after[law]} == touched


@pytest.mark.parametrize("name", ["numpy", "scipy", "numba"])
def test_another_version_of_a_library(name: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = keys(folder)
    monkeypatch.setattr(f"{name}.__version__", "99.0")
    after = keys(folder)
    assert all(before[law] != after[law] for law in before)


@pytest.mark.parametrize("what", ["python_version_tuple", "libc_ver"])
def test_another_python_or_system(what: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = keys(folder)
    monkeypatch.setattr(f"platform.{what}", lambda *_: ("3", "99", "0"))
    assert all(before[law] != key for law, key in keys(folder).items())


def test_another_processor(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = keys(folder)
    monkeypatch.setattr(rests_on, "processor", lambda: "another one")
    assert all(before[law] != key for law, key in keys(folder).items())


def test_another_folder_changes_nothing(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    import sys

    before = keys(folder)
    other = tmp_path_factory.mktemp("elsewhere") / "deeper_down"
    shutil.copytree(folder, other)
    sys.path.remove(str(folder))
    for name in ("gains", "deeper"):
        sys.modules.pop(name, None)
    assert keys(other) == before


def test_law_that_is_named_by_its_file_counts(tmp_path: Path) -> None:
    """Among parameters, and in the text of a law: by what it holds, and not by the folder that it lies in."""
    for place in ("here", "there"):
        (tmp_path / place).mkdir()
        (tmp_path / place / "named.py").write_text(DEEPER)
        text = MINE.replace("from gains import gain", "").replace("gain()", "0.0")
        (tmp_path / place / "mine.py").write_text(
            text.replace("cc: float = 0.052", 'cc: float = 0.052\n    within: str = ""')
        )
        (tmp_path / place / "other.py").write_text(text + "\nWITHIN = 'named.py:Mine'\n")

    def told(place: str) -> tuple[str, str]:
        named = gy.law(f"{tmp_path / place}/mine.py:Mine", within=f"{tmp_path / place}/named.py:Mine")
        return law_fingerprint(named), law_fingerprint(gy.law(f"{tmp_path / place}/other.py:Mine"))

    before = told("here")
    assert before == told("there") and all(before)
    (tmp_path / "here" / "named.py").write_text(DEEPER + "# changed\n")
    assert not set(before) & set(told("here"))


def test_edited_module_is_loaded_again_and_a_table_is_seen_when_it_is_read(folder: Path) -> None:
    """In one process: what runs is what the key says, also for a table whose name is put together from parts."""
    (folder / "gains.py").write_text(GAINS.replace('"numbers.csv"', '"num" + "bers.csv"'))
    first = gy.law(f"{folder}/mine.py:Mine")
    assert type(gy.law(f"{folder}/mine.py:Mine")) is type(first), "compiled once"
    before = keys(folder)["mine"]
    assert first.step(0.0, None, ())[0][1] == 2e-4
    (folder / "deeper.py").write_text("def part(): return 0.25\n")
    (folder / "numbers.csv").write_text("8e-4,1")
    second = gy.law(f"{folder}/mine.py:Mine")
    assert second.step(0.0, None, ())[0][1] == 2e-4 and type(second) is not type(first)
    after = keys(folder)["mine"]
    (folder / "numbers.csv").write_text("4e-4,1")
    assert len({before, after, keys(folder)["mine"]}) == 3
    assert gy.law(f"{folder}/mine.py:Mine").step(0.0, None, ())[0][1] == 1e-4


@pytest.mark.slow
def test_every_import_is_followed() -> None:
    """What the imports of the sources reach, by another reader of them, is within the rooms that are hashed."""
    from import_graph import file_graph, room

    graph, seen = file_graph(ROOT), set[str]()
    todo = ["gyroctl.comparison.items", "gyroctl.controllers.nmpc.law"]
    while todo:
        module = todo.pop()
        if module not in seen:
            seen.add(module)
            todo += graph[module]
    rooms = set(rests_on.rooms_of("gyroctl.comparison.items", "gyroctl.controllers.nmpc.law"))
    met = {room(module) for module in seen} - {"", "controllers"}
    assert met - {*rests_on.LOOKS} <= rooms
    assert not rooms & {*rests_on.LOOKS}, "what only shows results makes none of them stale"
    assert "controllers/nmpc" in rooms and "controllers/rule_based" not in rooms and "reports" not in rooms


def test_modules_are_found_however_they_are_imported(tmp_path: Path) -> None:
    texts = {
        "a.py": "def f():\n    from b import (one,\n  two as three)\n    import c, d as e\n    return 'table.csv'\n",
        "b.py": "import importlib\nx = importlib.import_module('g')\n",
        "c.py": "",
        "d/__init__.py": "from .inside import x\n",
        "d/inside.py": "from ..d import other\n",
        "d/other.py": "",
        "g.py": "import numpy, os\n",
        "unused.py": "",
        "table.csv": "1",
    }
    for name, text in texts.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    found = sources([tmp_path / "a.py"])
    names = {path.relative_to(tmp_path.resolve()).as_posix() for path in found.files}
    assert names == set(texts) - {"unused.py"}
    assert [version.split()[0] for version in found.versions] == ["numpy"]
    (tmp_path / "d" / "a.py").write_text("import a\n")  # a circle ends
    assert sources([tmp_path / "d" / "a.py"]).files


def test_keys_cost_little(device: gy.Plant, folder: Path) -> None:
    """Five milliseconds an item, at most; the median of several, since other work runs beside the tests."""
    import time

    laws = {"coupling": gy.law("coupling"), "mine": gy.law(f"{folder}/mine.py:Mine")}
    waves = replace(WAVES, seeds=tuple(range(1, 51)))
    work_items(device, laws, waves, SETTINGS, 60.0)
    times = []
    for _ in range(5):
        begin = time.perf_counter()
        count = len(work_items(device, laws, waves, SETTINGS, 60.0))
        times.append((time.perf_counter() - begin) / count)
    assert sorted(times)[2] < 5e-3
