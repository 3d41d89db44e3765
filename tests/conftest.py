"""Fixtures that several files of tests share."""

from __future__ import annotations

import pytest

import gyroctl as gy


@pytest.fixture(scope="session")
def device() -> gy.Plant:
    """Return the corrected plant; it is frozen, so all tests may share it."""
    return gy.zhang2017()


@pytest.fixture(scope="session")
def printed() -> gy.Plant:
    """Return the plant as the paper prints it."""
    return gy.zhang2017("paper")
