"""Files of experiments: the default, what the summary keeps of one, kinds of seas, paths beside the file."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import LAWS_OF_USERS, SHORT, Run

import gyroctl as gy
from gyroctl.comparison.experiment import build_experiment, read_experiment
from gyroctl.waves import DriftingSea, TwoPeaks


def test_default_experiment_is_that_of_the_design() -> None:
    setup = read_experiment(None)
    assert setup.sea == gy.SeaState(hs=0.283, wp=3.14, gamma=5.0)
    assert len(setup.run.seeds) == 8 and setup.run.duration >= 600.0
    assert (setup.run.dt, setup.run.blend, setup.run.motion_limit) == (0.01, 100.0, 0.35)
    assert {"constant", "best_constant", "load_angle", "coupling"} <= set(setup.laws)
    assert setup.plant.parameters == gy.zhang2017().parameters
    assert (setup.actuators.cc_max, setup.actuators.cg_max, setup.actuators.period) == (0.3, 0.02, 0.1)


def test_quick_is_four_realisations_of_600_s() -> None:
    setup = read_experiment(None, quick=True)
    assert len(setup.run.seeds) == 4 and setup.run.duration == 600.0


def test_record_of_an_experiment_makes_the_same_experiment_again(tmp_path: Path) -> None:
    """What the summary keeps is enough to repeat it: sea, run, plant, sensors and actuators."""
    text = (
        SHORT
        + "[sea]\nhs = 0.2\ngamma = 2\n[plant]\nd1 = 1.5\n[sensors.psi]\nnoise = 0.01\n[actuators]\ncc_lag = 0.2\n"
    )
    one = build_experiment(tomllib.loads(text))
    kept = json.loads(json.dumps(one.record()))
    plant = {key: value for key, value in kept["plant"].items() if key in gy.Parameters.__dataclass_fields__}
    again = build_experiment({**kept, "plant": plant})
    assert again.sea == one.sea and again.run == one.run and again.actuators == one.actuators
    assert again.sensors == one.sensors and again.plant.parameters == one.plant.parameters
    assert dict(again.laws) == dict(one.laws)


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        ({"kind": "regular", "height": 0.2, "wp": 3.0}, gy.Regular(0.2, 3.0)),
        ({"kind": "bichromatic", "heights": [0.1, 0.2], "frequencies": [3, 3.3]}, gy.Bichromatic((0.1, 0.2), (3, 3.3))),
        ({"hs": 1, "wp": 3, "gamma": 1, "heading": 30}, gy.SeaState(1.0, 3.0, 1.0, 30.0)),
        ({"hs": 0.2, "tp": 2.2}, gy.SeaState(0.2, 2.0 * np.pi / 2.2)),
        ({"kind": "regular", "height": 0.2, "tp": 2}, gy.Regular(0.2, np.pi)),
        ({"kind": "two peaks", "tp_second": 4.0}, TwoPeaks(wp_second=np.pi / 2.0)),
        ({"kind": "drifting", "tp": 2.0, "tp_end": 1.9}, DriftingSea(wp=np.pi, wp_end=2.0 * np.pi / 1.9)),
    ],
)
def test_kinds_of_seas(table: dict[str, Any], expected: Any) -> None:
    assert build_experiment({"sea": table, "run": {"seeds": [1]}}).sea == expected


@pytest.mark.parametrize(
    ("sea", "words"),
    [
        ({"tp": 2.2, "wp": 3.0}, "sea.tp = 2.2: stands beside wp"),
        ({"tp": "2 s"}, "sea.tp"),
        ({"tp": 0.0}, "sea.tp"),
        ({"kind": "drifting", "tp_end": 1.9, "wp_end": 3.0}, "sea.tp_end"),
        ({"hight": 1.0}, "hs, wp, tp, gamma, heading"),
        ({"kind": "bichromatic", "heights": [0.1, 0.1], "frequencies": [3.0, 3.3], "tp": 2.0}, "sea.tp = 2.0: unknown"),
    ],
)
def test_peak_period_is_refused_by_its_name(sea: dict[str, Any], words: str) -> None:
    with pytest.raises(gy.InputError, match=re.escape(words)):
        build_experiment({"sea": sea})


def test_peak_period_on_the_command_line(run: Run, tmp_path: Path) -> None:
    (tmp_path / "sea.toml").write_text("[sea]\nhs = 0.2\ntp = 2.2\n")
    told = run("waves", "--sea", tmp_path / "sea.toml")[1]
    assert "Tp 2.2 s" in told and run("waves", "--hs", 0.2, "--tp", 2.2)[1] == told
    for wrong in (("--tp", 2.2, "--wp", 3.0), ("--tp", -1.0), ("--tp", 2.2, "--sea", tmp_path / "sea.toml")):
        code, _, why = run("waves", *wrong)
        assert code == 2 and "tp" in why, why


def test_files_are_found_beside_the_experiment(tmp_path: Path) -> None:
    """Paths in the file are relative to it, not to where the command is typed."""
    home = tmp_path / "home"
    home.mkdir()
    (home / "laws.py").write_text(LAWS_OF_USERS)
    w = np.linspace(1.0, 8.0, 200)
    rows = "\n".join(f"{a},{b}" for a, b in zip(w, gy.SeaState().spectrum(w), strict=True))
    (home / "sea.csv").write_text("omega [rad/s], S [m2 s]\n" + rows + "\n")
    (home / "mine.toml").write_text(
        '[sea]\nkind = "spectrum"\nfile = "sea.csv"\n[laws.mine]\nlaw = "laws.py:NotANumber"\n'
    )
    setup = read_experiment(home / "mine.toml")
    assert type(setup.laws["mine"]).__name__ == "NotANumber"
    assert setup.sea.hs == pytest.approx(0.283, rel=0.01)
