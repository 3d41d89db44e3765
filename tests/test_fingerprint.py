"""What a stored result rests on: the package as it is on the disk, and the law that was run."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.controllers.supervisor import wrap
from gyroctl.fingerprint import fingerprint, listing
from gyroctl.harness.law_fingerprint import law_fingerprint, law_source

ROOT = Path(__file__).parents[1]
EXAMPLE = ROOT / "docs" / "examples" / "my_law.py"


# --- the package ---------------------------------------------------------------------------------------------------


@pytest.fixture
def package(tmp_path: Path) -> Path:
    for name, text in {
        "room/one.py": "x = 1",
        "room/deep/two.py": "y = 2",
        "room/tuned/law.json": "{}",
        "room/__pycache__/one.pyc": "machine",
        "data/table.nc": "numbers",
        "alone.py": "z = 3",
    }.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path


def of(package: Path) -> str:
    return listing({path.name: path for path in package.iterdir()})


def test_every_file_that_computes_is_listed(package: Path) -> None:
    names = [line.split()[0] for line in of(package).splitlines()]
    assert names == ["alone.py", "data/table.nc", "room/deep/two.py", "room/one.py"]


@pytest.mark.parametrize("name", ["alone.py", "room/deep/two.py", "data/table.nc", "room/new.py"])
def test_whatever_computes_changes_the_fingerprint(package: Path, name: str) -> None:
    before = of(package)
    (package / name).write_text("changed")
    assert of(package) != before


def test_moved_file_changes_the_fingerprint(package: Path) -> None:
    before = of(package)
    shutil.move(package / "room" / "one.py", package / "room" / "deep" / "one.py")
    assert of(package) != before


@pytest.mark.parametrize("name", ["room/tuned/law.json", "room/__pycache__/one.pyc", "room/.hidden"])
def test_what_ships_and_what_is_compiled_does_not(package: Path, name: str) -> None:
    before = of(package)
    (package / name).write_text("changed")
    assert of(package) == before


@pytest.mark.parametrize(
    ("file", "counts"),
    [
        ("gyroctl/plant/equations.py", True),
        ("gyroctl/waves/spectrum.py", True),
        ("gyroctl/data/hydrodynamics.nc", True),
        ("gyroctl/__init__.py", True),
        ("controllers/nmpc/law.py", True),
        ("controllers/gain_scheduled/scheduled_lqr.toml", True),
        ("gyroctl/cli/app.py", False),
        ("gyroctl/reports/summary.py", False),
        ("studies/style.py", False),
    ],
)
def test_fingerprint_of_this_package_is_that_of_its_rooms(
    file: str, counts: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    def read(path: Path) -> bytes:
        content = plain(path)
        return content + b"changed" if path.resolve() == (ROOT / file).resolve() else content

    plain, before = Path.read_bytes, fingerprint()
    monkeypatch.setattr(Path, "read_bytes", read)
    assert fingerprint() == before, "hashed more than once"
    assert (fingerprint.__wrapped__() != before) is counts


def test_versions_of_what_computes_are_part_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    before, asked = fingerprint(), []

    def version(name: str) -> str:
        asked.append(name)
        return "0.0"

    monkeypatch.setattr("gyroctl.fingerprint.package.version", version)
    assert fingerprint.__wrapped__() != before
    assert {"numpy", "scipy", "numba", "llvmlite", "casadi", "osqp", "cmaes"} == set(asked)


# --- the law -------------------------------------------------------------------------------------------------------


def test_law_is_told_by_its_text_and_its_parameters(tmp_path: Path) -> None:
    text = EXAMPLE.read_text() + "\n\nLIMIT = 0.02\n\n\ndef held(cg):\n    return min(max(cg, 0.0), LIMIT)\n"
    text = text.replace("min(max(cg, 0.0), 0.02)", "held(cg)")

    def known(changed: str, **parameters: float) -> str:
        (tmp_path / "mine.py").write_text(changed)
        return law_fingerprint(gy.law(f"{tmp_path}/mine.py:MyLaw", **parameters))

    first = known(text)
    assert first and known(text) == first
    found = [
        first,
        known(text, cg=6e-4),
        known(text.replace("speed - 3.14", "speed - 3.1")),
        known(text.replace("LIMIT = 0.02", "LIMIT = 0.01")),
        known(text.replace("max(cg, 0.0)", "max(cg, 1e-5)")),
    ]
    assert len(set(found)) == len(found)


def test_law_in_a_package_is_told_by_every_file_of_it(tmp_path: Path) -> None:
    (tmp_path / "__init__.py").write_text("")
    (tmp_path / "mine.py").write_text(EXAMPLE.read_text())
    (tmp_path / "beside.py").write_text("GAIN = 1.0")
    before = law_fingerprint(gy.law(f"{tmp_path}/mine.py:MyLaw"))
    (tmp_path / "beside.py").write_text("GAIN = 2.0")
    assert law_fingerprint(gy.law(f"{tmp_path}/mine.py:MyLaw")) != before


class Hiding:
    """A law that tells no fields."""

    period, information = 0.1, "none"

    def __init__(self, cg: float) -> None:
        self.cg = cg

    def init(self) -> None: ...

    def step(self, t: float, y: Any, state: None) -> tuple[tuple[float, float], None]:
        return (0.052, self.cg), state


@dataclass(frozen=True)
class Holding:
    """A law with a part of any kind."""

    part: Any
    period: float = 0.1
    information: Any = "none"

    def init(self) -> None: ...

    def step(self, t: float, y: Any, state: None) -> tuple[tuple[float, float], None]:
        return (0.052, 3e-4), state


def test_law_with_hidden_state_cannot_be_hashed() -> None:
    for law in (Hiding(3e-4), Holding(lambda: None), wrap(Hiding(3e-4))):
        assert law_fingerprint(law) == ""
    assert law_source(Hiding(3e-4)) == law_source(Hiding(4e-4)) != ""
    assert law_fingerprint(Holding(np.array([1.0]))) != law_fingerprint(Holding(np.array([2.0]))) != ""


def test_law_that_was_typed_in_by_hand_cannot_be_hashed() -> None:
    typed: dict[str, Any] = {}
    exec(compile(EXAMPLE.read_text().replace("from __future__", "# from __future__"), "<stdin>", "exec"), typed)
    assert law_fingerprint(typed["MyLaw"]()) == law_source(typed["MyLaw"]()) == ""
    assert law_fingerprint(wrap(typed["MyLaw"]())) == law_source(wrap(typed["MyLaw"]())) == ""
