"""The four commands of docs/device.md, as they stand there, at a reduced size."""

from __future__ import annotations

import json
import re
import shlex
import shutil
from pathlib import Path

import pytest
from command_line import Run

import gyroctl as gy

PAGE = Path(__file__).parents[1] / "docs" / "device.md"

TASK = """
law = "load_angle"

[knobs]
share = { start = 0.35, width = 0.2, scale = "linear", least = 0.0 }
damping = { start = 0.6, width = 0.4 }

[seas.mild]
hs = 0.25
power = 2.0
runs = 1

[search]
population = 4
window = 160
confirm = 200
runs = 1

[seeds]
first = 100128
count = 2
"""
"""What is searched instead of the whole task: two knobs in one sea, on short runs."""

SHORTER = {"[1, 2, 3, 4, 5, 6, 7, 8]": "[1, 2]\nduration = 340\nblend = 100"}


def block(kind: str) -> str:
    found = re.search(rf"^```{kind}\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    assert found is not None
    return found[1]


def test_tutorial_is_four_commands_and_an_experiment() -> None:
    commands = [shlex.split(line)[:2] for line in block("sh").strip().splitlines()]
    assert commands == [["gyroctl", "device"], ["gyroctl", "device"], ["gyroctl", "tune"], ["gyroctl", "compare"]]
    assert 'device = "half.toml"' in block("toml")


@pytest.mark.slow
def test_tutorial_leads_from_a_file_to_a_report(tmp_path: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    experiment = block("toml")
    for long, short in SHORTER.items():
        assert long in experiment
        experiment = experiment.replace(long, short)
    Path("half-study.toml").write_text(experiment, encoding="utf-8")
    Path("load_angle.toml").write_text(TASK, encoding="utf-8")
    new, check, tune, compare = (shlex.split(line)[1:] for line in block("sh").strip().splitlines())
    assert run(*new)[0] == 0
    code, said, _ = run(*check)
    assert code == 0 and "FAIL" not in said and Path("half-check/geometry.svg").is_file()
    small = ["load_angle.toml" if word == "load_angle" else word for word in tune]
    code, said, why = run(*small, "--budget", "4000", "--out", "tuning")
    assert code == 0, why
    plant = gy.device("half.toml")
    kept = json.loads(Path("half.tuned/load_angle.json").read_text())["sets"]["all"]
    assert kept["found"]["plant"] == plant.name
    code, said, why = run(*compare, "--no-search")
    assert code == 0, why
    assert "another device" not in why
    summary = json.loads(Path("half-results/summary.json").read_text())
    assert set(summary["laws"]) == {"load_angle", "best_constant"} and summary["tuned_for_another_device"] == []
    assert summary["plant"] == plant.name and "J14" in summary["device"]["changed"]
    assert summary["device"]["length_scale"] == 2.0
    page = Path("half-results/report.html").read_text(encoding="utf-8")
    assert plant.name in page and "Changed against Table 1" in page
    shutil.rmtree("half.tuned")
    code, said, why = run("laws", "--device", "half.toml")
    assert code == 0 and "load_angle: its tuned sets belong to another device" in said
