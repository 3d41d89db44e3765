"""The pages for readers name what exists: tests, choices, parameters, states, metrics, folders."""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path

import pytest

import gyroctl as gy
from gyroctl.devices import VARIANTS
from gyroctl.simulation.metrics import UNITS

ROOT = Path(__file__).parents[1]
CONVENTIONS = (ROOT / "docs" / "conventions.md").read_text(encoding="utf-8")
NOMENCLATURE = (ROOT / "docs" / "nomenclature.md").read_text(encoding="utf-8")
ARCHITECTURE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")


def test_every_proof_named_by_the_conventions_exists() -> None:
    named = re.findall(r"`(tests/\w+\.py)::(\w+)`", CONVENTIONS)
    assert len(named) > 20
    for file, test in named:
        assert re.search(rf"^def {test}\(", (ROOT / file).read_text(encoding="utf-8"), re.M), f"{file}::{test}"


@pytest.mark.parametrize("trap", ["1", "2", "3", "3b", "4", "5", "6", "7"])
def test_each_trap_has_a_proof(trap: str) -> None:
    section = re.search(rf"^### {trap}\. .*?(?=^##)", CONVENTIONS, re.M | re.S)
    assert section is not None
    assert "Proof: `tests/" in section.group()


def test_each_choice_of_the_presets_is_explained() -> None:
    for choice in VARIANTS["corrected"]:
        assert f"`{choice}" in CONVENTIONS


def test_nomenclature_names_every_parameter_state_and_metric() -> None:
    code = set(re.findall(r"`(\w+)`", NOMENCLATURE))
    assert {field.name for field in fields(gy.Parameters)} <= code
    assert {label for label in gy.zhang2017().labels if not label.startswith("z")} <= code
    assert set(UNITS) <= code


def test_nomenclature_gives_the_values_of_table_1() -> None:
    parameters = gy.Parameters()
    for row in re.findall(r"^\|[^|]*\| (`[^|]*) \| ([-\d., ]+) \|", NOMENCLATURE, re.M):
        names, values = re.findall(r"`(\w+)`", row[0]), [float(value) for value in row[1].split(",")]
        for name, value in zip(names, values, strict=False):
            assert getattr(parameters, name) == pytest.approx(value, rel=6e-3), name


def test_architecture_names_files_that_exist() -> None:
    for folder, start in re.findall(r"^\| `([\w/.]+)` \|[^|]*\| `([\w/.]+)` \|$", ARCHITECTURE, re.M):
        place = ROOT / folder
        assert place.exists(), folder
        if place.is_dir():
            assert (place / start).exists(), f"{folder}/{start}"
