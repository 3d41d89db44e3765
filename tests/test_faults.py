"""A study under faults of disk, processes and scheduler: `benchmarks/faults.py` in small, and what failed once."""

from __future__ import annotations

import json
import sys
from collections import Counter
from pathlib import Path
from types import ModuleType

import pytest

FOLDER = Path(__file__).resolve().parents[1] / "benchmarks"

HISTORIES = 2000


@pytest.fixture
def history(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    if not FOLDER.is_dir():
        pytest.skip("the tests run outside a clone")
    monkeypatch.syspath_prepend(str(FOLDER))
    import faults_history

    return sys.modules.get("faults_history", faults_history)


def test_nothing_is_lost_whatever_happens(history: ModuleType) -> None:
    """Two thousand histories, and all that broke something once; the number of each plays it again."""
    seen: Counter[str] = Counter()
    kept = json.loads((FOLDER / "faults_seeds.json").read_text(encoding="utf-8"))
    for seed in [*kept, *range(HISTORIES)]:
        try:
            seen.update(history.played(seed))
        except BaseException as error:
            raise AssertionError(f"python benchmarks/faults.py --only {seed}: {error!r}") from error
    expected = ("came through", "killed", "power cut", "disk refused", "ConnectionError", "worker lost", "twice")
    for what in (*expected, "worker left out", "damaged: flip", "damaged: another's"):
        assert seen[what] > 20, f"{what}: hardly ever played"


def test_a_history_is_told_by_its_number(history: ModuleType) -> None:
    """With threads that take turns, too: 31 is one of those."""
    for seed in (3, 31):
        assert history.History(seed).threads == (seed == 31)
        assert history.played(seed) == history.played(seed)
