"""The set of planted faults: it fits the sources, is large enough, and its check finds what no longer fits."""

from __future__ import annotations

import importlib.util
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import pytest

import gyroctl as gy

ROOT = Path(gy.__file__).resolve().parents[1]
ROOMS = {
    "bound",
    "comparison",
    "devices",
    "engine",
    "faults",
    "gauge",
    "growth",
    "harness",
    "hydrodynamics",
    "kept",
    "laws",
    "margins",
    "order",
    "outside",
    "panels",
    "physics",
    "pictures",
    "planner",
    "played",
    "price",
    "python_face",
    "real",
    "real_water",
    "reports",
    "rows",
    "seas",
    "simulation",
    "site",
    "statistics",
    "verdict",
    "water",
    "waves",
}


@pytest.fixture(scope="module")
def tool() -> ModuleType:
    path = ROOT / "benchmarks" / "mutants.py"
    if not path.is_file():
        pytest.skip("the tests run outside a clone")
    spec = importlib.util.spec_from_file_location("mutants", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["mutants"] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module


def test_set_fits_the_sources(tool: ModuleType) -> None:
    mutants = tool.read_mutants()
    assert tool.stale(mutants) == []
    assert len(mutants) >= 120
    assert {mutant.room for mutant in mutants} == ROOMS


def test_what_may_survive_is_said_and_is_little(tool: ModuleType) -> None:
    mutants = tool.read_mutants()
    excused = [mutant for mutant in mutants if mutant.survives]
    assert len(excused) <= 0.05 * len(mutants)
    assert all(len(mutant.survives) > 40 for mutant in excused), "an explanation is a sentence"


def test_check_finds_what_no_longer_fits(tool: ModuleType) -> None:
    sound = next(mutant for mutant in tool.read_mutants() if mutant.room == "rows")
    for change, said in (
        ({"old": "a text that is nowhere"}, "0 times"),
        ({"old": "\n"}, "times in"),
        ({"file": "gyroctl/gone.py"}, "0 times"),
        ({"new": "def ("}, "no Python"),
        ({"new": sound.old}, "changes nothing"),
        ({"tests": ()}, "names no test"),
        ({"tests": ("test_of_another_project",)}, "there is not one test_of_another_project"),
        ({"tests": ("test_bad_request_is_named",)}, "there is not one test_bad_request_is_named"),
        ({"tests": ("tests/test_gone.py",)}, "there is not one tests/test_gone.py"),
    ):
        (problem, *_) = tool.stale([replace(sound, **change)])
        assert said in problem
    assert "two mutants of that name" in tool.stale([sound, sound])[0]


def test_score_counts_the_killed_and_names_the_others(tool: ModuleType) -> None:
    found = [tool.Found("a", name, status, "", 1.0, "") for name, status in (("x", "killed"), ("y", "survived"))]
    assert tool.score(found) == "1 of 2 killed, 50.0 %; not killed: a/y"
