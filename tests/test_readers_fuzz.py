"""Every reader of files from outside holds against files that no writer wrote: `benchmarks/fuzz.py` in small."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]

QUICK = (
    "task",
    "device",
    "tuned",
    "table",
    "ledger",
    "log",
    "stored",
    "wamit",
    "nemoh",
    "elevation",
    "spectrum",
    "records",
    "scatter",
    "seas",
)
"""Readers without a run or a report to prepare."""

SLOW = ("experiment", "results", "results-hdf5", "capytaine", "capytaine-hdf5")


def findings(folder: Path, *arguments: str) -> str:
    """What the command prints; it must have no finding."""
    command = [sys.executable, str(ROOT / "benchmarks" / "fuzz.py"), *arguments, "--out", str(folder)]
    environment = os.environ | {"PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    kept = sorted(folder.rglob("why.txt"))
    assert done.returncode == 0, f"{done.stdout}{done.stderr[-1000:]}{kept[0].read_text() if kept else ''}"
    return done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("reader", QUICK)
def test_reader_holds(tmp_path: Path, reader: str) -> None:
    assert ", 0 findings" in findings(tmp_path, reader, "--inputs", "2000", "--seed", "1")


@pytest.mark.slow
@pytest.mark.parametrize("reader", SLOW)
def test_reader_of_large_files_holds(tmp_path: Path, reader: str) -> None:
    assert ", 0 findings" in findings(tmp_path, reader, "--inputs", "2000", "--hdf5", "200", "--seed", "1")


def test_readers_of_tables_hold_in_small(tmp_path: Path) -> None:
    printed = findings(tmp_path, "tuned", "table", "log", "--inputs", "200", "--seed", "2")
    assert printed.count(", 0 findings") == 3


def test_every_reader_is_in_one_of_the_lists() -> None:
    text = (ROOT / "benchmarks" / "fuzz_readers.py").read_text(encoding="utf-8")
    for name in (*QUICK, *SLOW):
        assert f'"{name}": Reader(' in text
    assert text.count(": Reader(") == len(QUICK) + len(SLOW)
