"""Fixtures that several files of tests share."""

from __future__ import annotations

import sys

import hypothesis
import pytest
from command_line import Run

import gyroctl as gy
from gyroctl.cli import main

# a busy machine is no fault of what is tested: no example has a deadline, and none is called slow
hypothesis.settings.register_profile(
    "any machine", deadline=None, suppress_health_check=[hypothesis.HealthCheck.too_slow]
)
hypothesis.settings.load_profile("any machine")


@pytest.fixture(scope="session")
def device() -> gy.Plant:
    """Return the corrected plant; it is frozen, so all tests may share it."""
    return gy.zhang2017()


@pytest.fixture(scope="session")
def printed() -> gy.Plant:
    """Return the plant as the paper prints it."""
    return gy.zhang2017("paper")


@pytest.fixture(scope="module")
def waves(device: gy.Plant) -> gy.WaveRealisation:
    """Two minutes of the default sea, blended in over 20 s."""
    return gy.realise(device, gy.SeaState(), 6, 120.0).blended(20.0)


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """Call the command line in this process: exit code, stdout, stderr."""

    def call(*arguments: object) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["gyroctl", *map(str, arguments)])
        code = 0
        try:
            main()
        except SystemExit as stop:
            code = stop.code if isinstance(stop.code, int) else 1 if stop.code else 0
        caught = capsys.readouterr()
        return code, caught.out, caught.err

    return call
