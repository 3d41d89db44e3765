"""One folder, results of several versions: kept apart, told, and removed when it is asked for."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from command_line import Run

from gyroctl.engine import Store
from gyroctl.engine.steps import Steps
from gyroctl.engine.store import made_by

MODULES = ("gyroctl.studies.margins.measures",)


def computed(folder: Path, calls: list[str], name: str) -> float:
    """A step of a study, from the folder or computed."""

    def compute() -> float:
        calls.append(np.__version__)
        return 0.1 + 0.2

    return Steps(folder, "a device", MODULES, ())(name, compute)


def test_another_numpy_is_told_kept_apart_and_removed_when_asked_for(
    tmp_path: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    runs, calls, here = tmp_path / "runs", list[str](), np.__version__
    for version in (here, "99.0", "99.0", here):
        monkeypatch.setattr("numpy.__version__", version)
        made_by.cache_clear()
        assert computed(runs, calls, "one") == 0.1 + 0.2
    assert calls == [here, "99.0"], "each by its own version, once"
    made_by.cache_clear()
    told = json.loads(run("status", tmp_path)[1])
    assert told["made_here"] == 1 and told["made_elsewhere"] == {f"numpy 99.0 (here {here})": 1}
    told = json.loads(run("clean", tmp_path)[1])
    assert told["kept_of_other_versions"] == 1 and len(list(Store(runs).files())) == 2
    told = json.loads(run("clean", tmp_path, "--other-versions")[1])
    (left,) = Store(runs).files()
    record = Store(runs).load(left.stem)
    assert told["other_versions"]["files"] == 1 and record is not None
    assert record.about["made_with"]["numpy"] == here
