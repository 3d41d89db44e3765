"""What the benchmarks measure of a command is its own."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "benchmarks"))

import clock  # noqa: E402


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_memory_of_a_command_is_not_that_of_who_began_it(tmp_path: Path) -> None:
    """The kernel hands the most of a parent on to its child, which a study of 20 000 realisations was charged with."""
    (tmp_path / "taking.py").write_text("import sys\ntaken = bytearray(b'1') * int(float(sys.argv[1]) * 1e6)\n")
    held = bytearray(b"1") * 400_000_000
    little, much = (clock.watched("taking", [size], tmp_path, tmp_path) for size in ("1", "200"))
    assert len(held) > 0 and little.memory < 100.0
    assert much.memory == pytest.approx(little.memory + 199.0, abs=5.0)
    assert 0.0 < little.processor < 10.0 and 0.0 < little.wall
