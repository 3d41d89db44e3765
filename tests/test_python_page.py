"""The page of the Python face: its examples run in their order, and what it says is printed is printed."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

import gyroctl as gy

PAGE = Path(gy.__file__).resolve().parents[1] / "docs" / "python.md"


def blocks(kind: str) -> list[str]:
    if not PAGE.is_file():
        pytest.skip("the tests run outside a clone")
    return re.findall(rf"^```{kind}\n(.*?)^```$", PAGE.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)


def run(codes: list[str]) -> dict[str, Any]:
    scope: dict[str, Any] = {}
    for code in codes:
        exec(compile(code, str(PAGE), "exec"), scope)
    return scope


def test_page_prints_what_it_says(device: gy.Plant) -> None:
    assert blocks("text")[0] == f"{device}\n"


def test_examples_run_in_their_order(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    scope = run(blocks("python")[:-1])  # the check of a law, which runs it for long, is in the slow test
    assert (tmp_path / "run.svg").is_file() and len(scope["laws"]) == 4
    assert (tmp_path / "report.html").read_text(encoding="utf-8").startswith("<!doctype html")


@pytest.mark.slow
def test_check_of_the_page_passes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    scope = run(blocks("python"))
    assert all(line.passed for line in scope["checks"] if line.name != "step size")
