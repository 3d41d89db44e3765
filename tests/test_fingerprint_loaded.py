"""A law is what its file finds when it is loaded: values that the text does not tell make another law of it."""

from __future__ import annotations

import shutil
import sqlite3
from pathlib import Path

import pytest
from command_line import Run

import gyroctl as gy
from gyroctl.fingerprint.as_loaded import environment, fetches
from gyroctl.harness import registry
from gyroctl.harness.law_fingerprint import law_fingerprint

LAW = """
import os, sqlite3, subprocess, time
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).resolve().parent
LOADED = time.perf_counter()  # nothing asks for it
def read(): return float(subprocess.run(["cat", str(HERE / ("ga" + "in"))], capture_output=True).stdout)
def stored(): return sqlite3.connect(str(HERE / ("gain" + ".db"))).execute("select g from t").fetchone()[0]
{head}

class Mine(NamedTuple):
    cc: float = 0.05
    period: float = 0.1
    information: str = "none"
    def init(self): return ()
    def step(self, t, y, state): return (self.cc, {gain} + 0.0 * len(str(HERE))), state
"""

WAYS = {
    "environment at load": ('GAIN = float(os.environ["GYROCTL_TEST_GAIN"])', "GAIN"),
    "environment in step": ("", 'float(os.getenv("GYROCTL_TEST_GAIN"))'),
    "program at load": ("GAIN = read()", "GAIN"),
    "database at load": ("GAIN = stored()", "GAIN"),
    "within a group": ("GAINS = {'low': [read(), 1]}", "GAINS['low'][0]"),
    "default of a function": ("def gain(g=read()): return g", "gain()"),
    "closure": ("def made(g):\n    return lambda: g\ngain = made(read())", "gain()"),
    "attribute of a class": ("class Gains:\n    def low(self): return self.g\n    g = read()", "Gains().low()"),
    "module": ("import told_{own} as told", "told.GAIN"),
}


@pytest.mark.parametrize("way", WAYS)
def test_value_that_is_found_at_load_makes_another_law(
    tmp_path: Path, way: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    head, gain = (part.replace("{own}", str(list(WAYS).index(way))) for part in WAYS[way])

    def law(folder: Path, value: float) -> str:
        folder.mkdir(exist_ok=True)
        (folder / "mine.py").write_text(LAW.replace("{head}", head).replace("{gain}", gain))
        read = "import subprocess, pathlib\nFILE = pathlib.Path(__file__).parent / ('ga' + 'in')\n"
        told = read + "GAIN = float(subprocess.run(['cat', str(FILE)], capture_output=True).stdout)\n"
        (folder / f"told_{list(WAYS).index(way)}.py").write_text(told)
        (folder / "gain").write_text(str(value))
        with sqlite3.connect(folder / "gain.db") as base:
            base.execute("create table if not exists t(g)")
            base.execute("delete from t")
            base.execute("insert into t values(?)", (value,))
        base.close()
        monkeypatch.setenv("GYROCTL_TEST_GAIN", str(value))
        if "environment" not in way:  # which is looked at in the same process too
            registry._loaded.clear()
        for name in [name for name in registry.sys.modules if name.startswith("told_")]:
            monkeypatch.delitem(registry.sys.modules, name)
        return law_fingerprint(gy.law(f"{folder}/mine.py:Mine"))

    here = tmp_path / "here"
    first, other, again = law(here, 2e-4), law(here, 3e-4), law(here, 2e-4)
    assert first and first != other
    if way != "database at load":  # whose file has pages of its own
        assert first == again
        shutil.copytree(here, tmp_path / "moved")
        assert law(tmp_path / "moved", 2e-4) == first


def test_variable_that_is_empty_is_another_than_one_that_is_not_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "mine.py"
    file.write_text('import os\nHOW = os.environ.get("GYROCTL_TEST_HOW", "fast")\n')
    found = []
    for value in (None, "", "slow"):
        monkeypatch.delenv("GYROCTL_TEST_HOW", raising=False)
        if value is not None:
            monkeypatch.setenv("GYROCTL_TEST_HOW", value)
        found += environment([file])
    assert len(found) == 3 and len(set(found)) == 3


def test_what_is_fetched_unseen_is_named(tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    file.write_text("import os.path, random\nimport numpy as np\nfrom urllib.request import urlopen\nx = np.random\n")
    assert fetches([file]) == ["numpy.random", "random", "urllib"]
    file.write_text("import math\nimport numpy as np\n# a random choice\n")
    assert fetches([file]) == []


def test_compare_names_what_it_does_not_see(tmp_path: Path, run: Run) -> None:
    law = "import random\n" + LAW.replace("{head}", "").replace("{gain}", "random.random() * 1e-4")
    (tmp_path / "mine.py").write_text(law)
    study = tmp_path / "study.toml"
    study.write_text('[run]\nduration = 160.0\nseeds = [1]\n[laws.mine]\nlaw = "mine.py:Mine"\n')
    code, _, said = run("compare", study, "--no-search", "--out", tmp_path / "out", "--workers", 1)
    assert code == 0 and "Note: mine uses random, sqlite3, subprocess: " in said, said
