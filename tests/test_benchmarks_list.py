"""The list of what is asked of speed says what its parts have written, and leaves nothing out."""

from __future__ import annotations

import importlib.util
import json
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import gyroctl as gy

ROOT = Path(gy.__file__).resolve().parents[1]


@pytest.fixture
def script() -> ModuleType:
    path = ROOT / "benchmarks" / "all.py"
    if not path.is_file():
        pytest.skip("the tests run outside a clone")
    spec = importlib.util.spec_from_file_location("all_benchmarks", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def listed(script: ModuleType) -> Mapping[str, Any]:
    return {row["figure"]: row for row in script.listed()}


def test_list_is_that_of_the_parts(script: ModuleType) -> None:
    kept = json.loads((ROOT / "benchmarks" / "all.json").read_text(encoding="utf-8"))["figures"]
    assert script.listed() == kept
    ran = {part for part in script.PARTS if (ROOT / "benchmarks" / f"{part}.json").is_file()}
    assert all((row["value"] is not None) == (row["part"] in ran) for row in kept), "a part that ran has all figures"


def test_what_was_not_measured_is_said_and_not_met(
    script: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(script, "HERE", tmp_path)
    (tmp_path / "tuning.json").write_text(json.dumps({"times_as_fast": 2.4}))
    found = listed(script)
    assert len(found) == len(script.FIGURES)
    tuning = found.pop("tuning of load_angle, times the older")
    assert tuning["value"] == 2.4 and not tuning["met"]
    assert all(row["value"] is None and not row["met"] for row in found.values())


def test_bars_have_a_direction(script: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(script, "HERE", tmp_path)
    for value, met in ((0.1, True), (0.6, False)):
        (tmp_path / "nmpc.json").write_text(json.dumps({"horizon_4_s": {"median_ms": value, "p99_ms": 1.0}}))
        assert listed(script)["a sample of nmpc, horizon 4 s, median"]["met"] is met
