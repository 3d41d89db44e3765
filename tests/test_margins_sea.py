"""Margins and lock maps of a sea: those of the regular wave of its energy, frequency and heading."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import gyroctl as gy
from gyroctl.cli.app import app
from gyroctl.errors import InputError
from gyroctl.studies.margins import request

HS, WP = 0.3, 2.9
SEA = f"[sea]\nhs = {HS}\nwp = {WP}\ngamma = 3.3\n"


def run(*words: str | Path) -> Any:
    return CliRunner().invoke(app, [str(word) for word in words])


def test_lock_map_of_a_sea_is_that_of_the_wave_that_stands_for_it(tmp_path: Path) -> None:
    (tmp_path / "sea.toml").write_text(SEA)
    (tmp_path / "aside.toml").write_text(SEA + "heading = 40.0\n")
    waves = {
        "sea": ("--sea", tmp_path / "sea.toml"),
        "wave": ("--height", f"{HS / math.sqrt(2.0)!r}", "--wp", f"{WP}"),
        "aside": ("--sea", tmp_path / "aside.toml"),
    }
    found = {}
    for name, words in waves.items():
        assert run("lockmap", *words, "--out", tmp_path / name).exit_code == 0
        found[name] = json.loads((tmp_path / name / "lockmap.json").read_text())
    told = run("waves", "--sea", tmp_path / "sea.toml").output.strip()
    assert found["sea"]["sea"]["words"] == told and found["sea"]["sea"]["hs_m"] == HS and "sea" not in found["wave"]
    asked = found["sea"]["request"]["wave"]
    assert asked["equal_energy_hs_m"] == pytest.approx(HS, rel=1e-12) and asked["wp_rad_s"] == WP
    assert found["sea"]["map"] == found["wave"]["map"] and found["sea"]["request"] == found["wave"]["request"]
    assert found["aside"]["request"]["wave"]["heading_deg"] == 40.0
    assert found["aside"]["map"] != found["sea"]["map"], "the excitation is another one"


def test_sea_stands_alone(tmp_path: Path) -> None:
    (tmp_path / "sea.toml").write_text(SEA)
    for command in ("margins", "lockmap"):
        for words in (("--height", "0.2"), ("--wp", "3.0")):
            answer = run(command, "--sea", tmp_path / "sea.toml", *words, "--out", tmp_path / "out")
            assert isinstance(answer.exception, (InputError, SystemExit)) and answer.exit_code != 0
            assert not (tmp_path / "out").exists()


def test_heading_of_the_wave_is_part_of_what_is_asked(device: gy.Plant) -> None:
    straight, aside = (request(device, 0.2, 3.14, 0.052, 3.5e-4, heading=heading) for heading in (0.0, 30.0))
    assert aside.wave == gy.Regular(0.2, 3.14, 30.0) and aside.sea != straight.sea and "30" in aside.sea
    first, second = (gy.lock_orbit(device, asked.wave, asked.cc, asked.cg) for asked in (straight, aside))
    assert second.lock_share > 1.05 * first.lock_share, "aside there is less that pulls"
