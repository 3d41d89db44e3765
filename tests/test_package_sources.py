"""The package from every source it may come from: a checkout, one without symbolic links, a source distribution.

The checkout without links lies in a folder with a space and letters beyond ASCII, and is used without installation.
"""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

import gyroctl as gy

ROOT = Path(gy.__file__).resolve().parents[1]
FOLDER = "wave lab ü 波"

PLAIN_LAW = '''
"""A law that only Python can run, and that tells which processes it ran in."""

import os
from dataclasses import dataclass


@dataclass(frozen=True)
class Plain:
    told: str
    period: float = 0.1
    information: str = "none"

    def init(self):
        return {"steps": 0}

    def step(self, t, y, state):
        if state["steps"] == 0:
            open(os.path.join(self.told, str(os.getpid())), "w").close()
        return (0.052, 3.5e-4), {"steps": state["steps"] + 1}
'''

SPAWNED = """
import multiprocessing
import os
import sys

import gyroctl as gy
import plain_law

if __name__ == "__main__":
    multiprocessing.set_start_method("spawn")
    assert os.path.realpath(gy.__file__).startswith(os.path.realpath(sys.argv[1])), gy.__file__
    plant = gy.zhang2017()
    waves = [gy.realise(plant, gy.SeaState(), seed, 60.0) for seed in (1, 2)]
    settings = gy.Settings(blend=20.0)
    laws = {"plain": plain_law.Plain(sys.argv[2]), "compiled": gy.law("constant", cc=0.052, cg=3.5e-4)}
    ds = gy.compare(plant, laws, waves, settings, workers=2, quiet=True)
    power = ds.generated_w.sel(law=["plain", "compiled"]).values
    assert (power[0] == power[1]).all() and (power > 0.0).all(), power
    print(os.getpid())
"""


def run(*command: str | Path, folder: Path, source: Path | None = None) -> str:
    """Run a command of this Python in `folder`, with the package from `source`; return what it prints."""
    environment = {**os.environ, "PYTHONIOENCODING": "utf-8", "COLUMNS": "300"}
    if source is not None:
        environment["PYTHONPATH"] = str(source)
    arguments = [sys.executable, *map(str, command)]
    done = subprocess.run(arguments, cwd=folder, env=environment, capture_output=True, text=True, encoding="utf-8")
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def git(*arguments: str | Path, folder: Path = ROOT) -> str:
    """Run git; outside a clone there is nothing to test here."""
    done = subprocess.run(["git", *map(str, arguments)], cwd=folder, capture_output=True, text=True, encoding="utf-8")
    if done.returncode != 0:
        pytest.skip(f"no clone: {done.stderr.strip()}")
    return done.stdout


def built(source: Path, out: Path, target: str = "wheel") -> Path:
    """Build a wheel or an sdist by the project's own backend, without a network."""
    if importlib.util.find_spec("hatchling") is None:
        pytest.skip("hatchling, the build backend, is not installed here")
    run("-m", "hatchling", "build", "-t", target, "-d", out, folder=source)
    (archive,) = (path for path in out.iterdir() if path.suffix in (".whl", ".gz"))
    return archive


def contents(wheel: Path) -> dict[str, int]:
    """Checksum of each file of a wheel."""
    with zipfile.ZipFile(wheel) as archive:
        return {item.filename: item.CRC for item in archive.infolist()}


@pytest.fixture(scope="module")
def checkout(tmp_path_factory: pytest.TempPathFactory) -> dict[str, int]:
    """What the wheel from this checkout holds."""
    return contents(built(ROOT, tmp_path_factory.mktemp("from-checkout")))


@pytest.fixture(scope="module")
def unlinked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A clone whose symbolic links are plain text files, as on Windows, with what is not committed yet."""
    clone = tmp_path_factory.mktemp("clones") / FOLDER
    git("-c", "core.symlinks=false", "clone", "--quiet", ROOT, clone)
    listed = git("ls-files", "-z", "--cached", "--others", "--exclude-standard").split("\0")
    for name in filter(None, listed):
        here, there = ROOT / name, clone / name
        if here.is_symlink():
            continue
        if here.is_file():
            there.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(here, there)
        else:
            there.unlink(missing_ok=True)
    assert (clone / "gyroctl" / "controllers").is_file() and not (clone / "gyroctl" / "studies").is_symlink()
    return clone


def test_wheel_of_a_checkout_without_links_is_the_same(
    checkout: dict[str, int], unlinked: Path, tmp_path: Path
) -> None:
    """On Windows symbolic links are off by default: the laws must not go missing there without a word."""
    assert contents(built(unlinked, tmp_path)) == checkout
    assert len([name for name in checkout if name.startswith("gyroctl/controllers/")]) > 30


@pytest.fixture
def unpacked(tmp_path: Path) -> Path:
    """The source distribution of this checkout, unpacked."""
    (tmp_path / "sdist").mkdir()
    with tarfile.open(built(ROOT, tmp_path / "sdist", "sdist")) as archive:
        archive.extractall(tmp_path / "unpacked", filter="data")
    (source,) = (tmp_path / "unpacked").iterdir()
    return source


def test_wheel_of_the_source_distribution_is_the_same(checkout: dict[str, int], unpacked: Path, tmp_path: Path) -> None:
    (tmp_path / "wheel").mkdir()
    assert contents(built(unpacked, tmp_path / "wheel")) == checkout
    assert {"gyroctl/py.typed", "gyroctl/__init__.pyi"} <= set(checkout)


def test_wheel_holds_nothing_that_was_compiled_here(checkout: dict[str, int], unpacked: Path, tmp_path: Path) -> None:
    """Neither bytecode nor numba's machine code, which lies beside sources that were used; git is not asked."""
    (unpacked / ".gitignore").unlink(missing_ok=True)
    for folder in ("gyroctl/plant", "controllers/rule_based", "studies"):
        (unpacked / folder / "__pycache__").mkdir()
        for name in ("kernel.py311.nbi", "kernel.1.py311.nbc", "kernel.cpython-311.pyc"):
            (unpacked / folder / "__pycache__" / name).write_bytes(b"machine code")
    (tmp_path / "wheel").mkdir()
    assert set(contents(built(unpacked, tmp_path / "wheel"))) == set(checkout)


@pytest.mark.slow
def test_checkout_without_links_has_the_same_laws_and_studies(unlinked: Path, tmp_path: Path) -> None:
    """Used in place: the package finds its two rooms in the folder above."""
    listed = run("-m", "gyroctl", "laws", folder=tmp_path, source=unlinked)
    assert listed == run("-m", "gyroctl", "laws", folder=tmp_path, source=ROOT)
    assert "load_angle" in listed and "nmpc" in listed
    code = (
        "import gyroctl.studies.paper, gyroctl as gy, importlib, pathlib\n"
        "law = importlib.import_module(type(gy.law('load_angle')).__module__)\n"
        "print(pathlib.Path(law.__file__).resolve(), pathlib.Path(gyroctl.studies.paper.__file__).resolve(), sep='\\n')"
    )
    for place in run("-c", code, folder=tmp_path, source=unlinked).splitlines():
        assert Path(place).is_relative_to(unlinked.resolve())


@pytest.mark.slow
def test_run_in_a_folder_with_a_space_and_letters_beyond_ascii(unlinked: Path) -> None:
    """From the clone itself, machine code beside its sources and the result beside the README."""
    command = ("simulate", "--law", "constant", "--duration", "60", "--blend", "20", "--out", "ein lauf.nc")
    assert "mean power" in run("-m", "gyroctl", *command, folder=unlinked, source=unlinked)
    assert (unlinked / "ein lauf.nc").stat().st_size > 10_000


@pytest.mark.slow
def test_comparison_on_spawned_processes(unlinked: Path, tmp_path: Path) -> None:
    """As on Windows and macOS: a worker imports everything anew, also the user's law and rooms without links."""
    (tmp_path / "plain_law.py").write_text(PLAIN_LAW)
    (tmp_path / "spawned.py").write_text(SPAWNED)
    (tmp_path / "told").mkdir()
    parent = run("spawned.py", unlinked, tmp_path / "told", folder=tmp_path, source=unlinked).split()[-1]
    workers = {path.name for path in (tmp_path / "told").iterdir()}
    assert workers and parent not in workers
