"""What is kept between runs belongs to the user alone, and code in it is run only as it was written."""

from __future__ import annotations

import hashlib
import io
import os
import pickle
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gyroctl import cache
from gyroctl.cache import cache_folder, private_folder, sealed, unsealed
from gyroctl.controllers.nmpc.kept_code import kept_function
from gyroctl.engine import Store
from gyroctl.engine.record import MAGIC
from gyroctl.plant import machine_code
from gyroctl.plant.compiled import entry_point

TEXT = """
from numba import float64, void

@kept(void(float64[::1]))
def doubled(x):
    x[0] = 2.0 * x[0] + {}
"""


@pytest.fixture(autouse=True)
def forgotten(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Each test looks at folders anew, and may say what is said once."""
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv(cache.SAID, "")
    looked_up = (private_folder, cache._usual, cache._key)
    for known in looked_up:
        known.cache_clear()
    yield
    for known in looked_up:
        known.cache_clear()


def mode(path: Path) -> int:
    return path.stat().st_mode & 0o777


def test_folder_is_closed_to_others_however_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GYROCTL_CACHE", str(tmp_path))
    assert cache_folder() == tmp_path / "gyroctl" and mode(tmp_path / "gyroctl") == 0o700
    assert mode(machine_code.folder() or tmp_path) == 0o700
    (tmp_path / "gyroctl").chmod(0o755)
    private_folder.cache_clear()
    cache_folder()
    assert mode(tmp_path / "gyroctl") == 0o700


@pytest.mark.skipif(os.name == "nt", reason="rights of folders")
def test_folder_that_everybody_may_put_another_one_in_the_place_of_is_not_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """As in a folder where all may write and rename; where each may rename his own alone, as in /tmp, it is used."""
    monkeypatch.delenv("GYROCTL_CACHE_SAID", raising=False)
    monkeypatch.setenv("GYROCTL_CACHE", str(tmp_path))
    tmp_path.chmod(0o1777)
    assert cache_folder() == tmp_path / "gyroctl"
    private_folder.cache_clear()
    tmp_path.chmod(0o777)
    assert cache_folder() is None
    assert "everybody may put another folder" in capsys.readouterr().err


@pytest.mark.parametrize("open_to", [0o770, 0o777, 0o702])
def test_code_that_others_could_have_written_is_removed(
    open_to: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    place = tmp_path / "kept"
    (place / "machine-code").mkdir(parents=True)
    code = ("tangent_0123456789abcdef.py", "machine-code/a.nbi", "machine-code/a.1.nbc", "machine-code/seal.key")
    for name in (*code, "pair.json", "mine.py"):
        (place / name).write_bytes(b"x")
    place.chmod(open_to)
    assert private_folder(place) == place and mode(place) == 0o700
    assert sorted(path.name for path in place.rglob("*") if path.is_file()) == ["mine.py", "pair.json"]
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and str(place) in said and "4 files" in said


def test_folder_of_another_user_is_not_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(cache, "USER", lambda: tmp_path.stat().st_uid + 1)
    monkeypatch.setenv("GYROCTL_CACHE", str(tmp_path))
    assert cache_folder() is None and machine_code.folder() is None
    assert not machine_code.kept("")
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and "another user" in said and "GYROCTL_CACHE" in said


def test_no_place_of_everybody_unless_the_user_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    home = tmp_path / "home"
    home.mkdir()
    for name in ("GYROCTL_CACHE", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", str(home))
    assert cache_folder() is not None
    home.chmod(0o1777)  # as the folder for temporary files is
    cache._usual.cache_clear()
    assert cache_folder() is None and "shared" in capsys.readouterr().err
    monkeypatch.setenv("HOME", str(tmp_path / "gone"))
    assert cache_folder() is None and not (tmp_path / "gone").exists()
    monkeypatch.setenv("GYROCTL_CACHE", str(home))
    assert cache_folder() == home / "gyroctl"


@pytest.mark.slow
def test_without_a_folder_work_goes_on_and_it_is_said_once(tmp_path: Path) -> None:
    """In a process and one that it starts; nothing is left in the folder for temporary files."""
    (tmp_path / "file").write_text("")
    (tmp_path / "tmp").mkdir()
    program = """
import subprocess, sys
import numpy as np
from gyroctl.controllers.nmpc.kept_code import kept_function
from gyroctl.plant.compiled import entry_point
kept_function("doubled", {text!r})
print(entry_point(lambda x: x + 1.0)(2.0), flush=True)
if len(sys.argv) < 2:
    subprocess.run([sys.executable, "-c", {again!r}], check=True)
"""
    again = "from gyroctl.cache import cache_folder; print(cache_folder())"
    environment = {**os.environ, "GYROCTL_CACHE": str(tmp_path / "file"), "TMPDIR": str(tmp_path / "tmp")}
    command = [sys.executable, "-c", program.format(text=TEXT.format(1.0), again=again)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == ["3.0", "None"]
    assert done.stderr.count("Nothing is kept") == 1 and done.stderr.count("\n") == 1
    assert not [path for path in (tmp_path / "tmp").iterdir() if "gyroctl" in path.name]


def test_seal_holds_content_name_and_folder_together(tmp_path: Path) -> None:
    other = tmp_path / "other"
    other.mkdir()
    content = sealed(tmp_path, "a", b"some code")
    assert unsealed(tmp_path, "a", content) == b"some code"
    assert mode(tmp_path / cache.KEY) == 0o600
    for i in range(8 * len(content)):
        bad = bytearray(content)
        bad[i // 8] ^= 1 << i % 8
        with pytest.raises(ValueError, match="not as it was written"):
            unsealed(tmp_path, "a", bytes(bad))
    for folder, name, text in ((tmp_path, "b", content), (other, "a", content), (tmp_path, "a", b"")):
        with pytest.raises(ValueError, match="not as it was written"):
            unsealed(folder, name, text)


class Trap:
    """A pickle that leaves a mark when it is read."""

    def __init__(self, mark: Path) -> None:
        self.mark = mark

    def __reduce__(self) -> tuple[Any, tuple[Any, ...]]:
        return os.mkdir, (str(self.mark),)


@pytest.mark.parametrize("suffix", [".nbi", ".nbc"])
def test_pickle_under_no_seal_is_never_read(suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GYROCTL_CACHE", str(tmp_path))

    def halved(x: Any) -> Any:
        return x / 2

    assert entry_point(halved)(3.0) == 1.5
    (file,) = (machine_code.folder() or tmp_path).glob(f"*{suffix}")
    whole, trap = file.read_bytes(), pickle.dumps(Trap(tmp_path / "ran"))
    for bad in (trap, whole[:32] + trap, bytes(32) + trap):
        file.write_bytes(bad)
        assert entry_point(halved)(3.0) == 1.5
        assert not (tmp_path / "ran").exists()
        assert trap not in file.read_bytes()  # replaced
    assert not (tmp_path / "ran").exists()


def test_text_in_the_folder_is_not_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nor is it written there: what is compiled is what this process wrote."""
    monkeypatch.setenv("GYROCTL_CACHE", str(tmp_path))
    x = np.ones(1)
    kept = kept_function("doubled", TEXT.format(3.0))
    stem = next(name for name in sys.modules if name.startswith("doubled_"))
    monkeypatch.delitem(sys.modules, stem)
    (tmp_path / "gyroctl" / f"{stem}.py").write_text(TEXT.format(4.0))
    again = kept_function("doubled", TEXT.format(3.0))
    assert again._cache_hits == 1 and kept._cache_hits == 0
    again.__wrapped__(x)
    assert x[0] == 5.0
    assert not list(tmp_path.rglob("*.pyc"))


def test_stored_run_is_no_pickle(tmp_path: Path) -> None:
    """A folder that a user names may come from anywhere: a run in it that is a pickle is computed again.

    Each is under a checksum of its own, which whoever made it could compute too.
    """
    trap = Trap(tmp_path / "ran")
    objects, one = io.BytesIO(), io.BytesIO()
    np.savez(objects, power=np.array([trap], dtype=object))
    np.save(one, np.zeros(3))
    store = Store(tmp_path)
    for name, arrays in (("a", pickle.dumps(trap)), ("b", objects.getvalue()), ("c", one.getvalue()), ("d", b"PK")):
        body = f'{{"key": "{name}", "about": {{}}, "content": {{}}}}\n'.encode() + arrays
        store.path(name).write_bytes(MAGIC + hashlib.sha256(body).hexdigest().encode() + b"\n" + body)
        assert store.load(name) is None
    assert not (tmp_path / "ran").exists()
