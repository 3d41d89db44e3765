"""What a report says of how it was made: the command that was typed, the day, the realisations and their state."""

from __future__ import annotations

import datetime
import json
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from gyroctl.cli.app import app
from gyroctl.provenance import made, typed
from gyroctl.reports.wording import seed_ranges


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["env/bin/gyroctl", "bound", "--seeds", "1-4"], "gyroctl bound --seeds 1-4"),
        (["gyroctl.exe", "margins"], "gyroctl margins"),
        (["lib/gyroctl/__main__.py", "evaluate", "seas"], "gyroctl evaluate seas"),
        (["gyroctl/studies/startup/__main__.py", "--seeds", "1:9"], "python -m gyroctl.studies.startup --seeds 1:9"),
        (["bin/pytest", "tests"], ""),
        (["mine/startup/__main__.py"], ""),
        ([""], ""),
    ],
)
def test_command_is_told_where_it_was_one_of_ours(words: list[str], said: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", words)
    assert typed() == said


def test_report_says_its_day() -> None:
    assert abs(datetime.date.fromisoformat(made()["date"]) - datetime.datetime.now(datetime.UTC).date()).days <= 1


@pytest.mark.slow
def test_rows_of_a_table_name_their_realisations_and_their_state(tmp_path: Path) -> None:
    asked = ["evaluate", "robustness", "--laws", "constant", "--seeds", "2,3", "--seeds", "@nominal=5"]
    done = CliRunner().invoke(app, [*asked, "--duration", "140", "--out", str(tmp_path)])
    assert done.exit_code == 0, done.output
    cases = json.loads((tmp_path / "robustness.json").read_text(encoding="utf-8"))["cases"]
    for name, rows in cases.items():
        seeds = (5,) if name == "nominal" else (2, 3)
        for row in rows:
            assert row["seeds"] == seed_ranges(seeds) and row["runs"] == len(seeds)
            assert row["seed_states"] == {"spent": len(seeds)} and row["failed"] == 0


def test_check_of_the_database_can_be_kept(tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["hydro", "check", "--out", str(tmp_path / "hydro.json")])
    assert done.exit_code == 0
    kept = json.loads((tmp_path / "hydro.json").read_text(encoding="utf-8"))
    assert kept["ok"] and {"k3", "Jh1", "Jh3"} <= {row["name"] for row in kept["rows"]}
    assert all(row["name"] in done.output for row in kept["rows"])
