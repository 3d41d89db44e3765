"""Stored results are believed only where every byte is what was written, and writing leaves whole files or none."""

from __future__ import annotations

import errno
import os
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import Run

import gyroctl as gy
from gyroctl.cli import app
from gyroctl.cli.compare import write
from gyroctl.comparison.compare import Realisations, compare
from gyroctl.engine import Store
from gyroctl.engine.store import made_by
from gyroctl.errors import went_wrong
from gyroctl.harness.run import Settings
from gyroctl.reports import open_results
from gyroctl.writing import left_over, seal, seal_of, write_text, written_as_hdf5, written_whole

KEY = "ab" * 32
CONTENT = {"sha256": "waves", "values": {"mean_power": 0.1 + 0.2, "loss_time": float("inf"), "x": float("nan")}}
ARRAYS = {"time": np.arange(3.0)}


@pytest.fixture
def stored(tmp_path: Path) -> Path:
    Store(tmp_path).save(KEY, CONTENT, ARRAYS, {"law": "mine"})
    return tmp_path / f"{KEY}.run"


def test_what_is_stored_comes_back_to_the_last_bit(stored: Path) -> None:
    record = Store(stored.parent).load(KEY)
    assert record is not None and record.about["law"] == "mine"
    values = record.content["values"]
    assert values["mean_power"] == 0.1 + 0.2 and np.isinf(values["loss_time"]) and np.isnan(values["x"])
    np.testing.assert_array_equal(record.arrays["time"], [0.0, 1.0, 2.0])
    assert {"numpy", "python", "processor"} <= set(record.about["made_with"])


def test_no_flipped_bit_is_believed(stored: Path) -> None:
    content = stored.read_bytes()
    for at in range(len(content)):
        bit = 1 << (at * 5 % 8)
        stored.write_bytes(content[:at] + bytes([content[at] ^ bit]) + content[at + 1 :])
        assert Store(stored.parent).load(KEY) is None, at
    stored.write_bytes(content)
    assert Store(stored.parent).load(KEY) is not None


@pytest.mark.parametrize("change", ["cut", "longer", "empty", "renamed", "edited", "folder"])
def test_nothing_else_is_believed(stored: Path, change: str) -> None:
    content, said = stored.read_bytes(), list[str]()
    key = KEY
    if change == "renamed":
        key = "cd" * 32
        stored.rename(stored.with_name(f"{key}.run"))
    elif change == "folder":
        stored.unlink()
        stored.mkdir()
    else:
        edited = content.replace(b"0.30000000000000004", b"167000.00000000004")
        stored.write_bytes({"cut": content[:-1], "longer": content + b"\n", "empty": b"", "edited": edited}[change])
    store = Store(stored.parent, said.append)
    assert store.load(key) is None
    store.tell()
    store.tell()
    assert len(said) == 1 and "not believed, computed again" in said[0]


def test_without_a_folder_or_a_key_nothing_is_stored(tmp_path: Path) -> None:
    Store(None).save(KEY, {})
    Store(tmp_path).save("", {})
    assert not list(tmp_path.iterdir()) and Store(None).load(KEY) is None and Store(tmp_path).load(KEY) is None


def test_results_of_the_earlier_format_are_named_once(tmp_path: Path) -> None:
    said: list[str] = []
    (tmp_path / f"{KEY}.npz").write_bytes(b"PK")
    Store(tmp_path, said.append).tell()
    assert len(said) == 1 and "no checksum" in said[0]


def test_what_other_libraries_made_is_named(stored: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[str] = []
    monkeypatch.setattr("numpy.__version__", "99.0")
    made_by.cache_clear()
    Store(stored.parent, said.append).tell_apart({"another key"}, {("another", "mine")})
    assert not said, "of another case"
    Store(stored.parent).save("cd" * 32, CONTENT, ARRAYS, {"law": "mine", "case": ""})
    monkeypatch.undo()
    made_by.cache_clear()
    Store(stored.parent, said.append).tell_apart({"another key"}, {("", "mine")})
    assert len(said) == 1 and "numpy 99.0 (here" in said[0]


# --- the disk ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("call", ["fsync", "replace"])
def test_full_disk_leaves_no_trace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call: str) -> None:
    (tmp_path / "file.txt").write_text("before")

    def full(*given: Any, **named: Any) -> Any:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), "file.txt")

    monkeypatch.setattr(os, call, full)
    with pytest.raises(OSError, match="No space left"):
        write_text(tmp_path / "file.txt", "after")
    monkeypatch.undo()
    assert [path.name for path in tmp_path.iterdir()] == ["file.txt"]
    assert (tmp_path / "file.txt").read_text() == "before"


def test_full_disk_ends_a_comparison_in_one_line(
    device: gy.Plant, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    waves, written = Realisations(gy.SeaState(), (3, 1, 8), duration=60.0), list[str]()
    plain = Store.save

    def filling(store: Store, key: str, *given: Any) -> None:
        written.append(key)
        if len(written) > 1:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(store.folder))
        plain(store, key, *given)

    monkeypatch.setattr(Store, "save", filling)

    def command() -> None:
        laws = {"plain": gy.law("constant")}
        compare(device, laws, waves, Settings(blend=40.0), 1, tmp_path / "runs", quiet=True)

    monkeypatch.setattr(app, "app", command)
    with pytest.raises(SystemExit) as end:
        app.main()
    said = capsys.readouterr().err.strip()
    assert end.value.code == 1 and said.count("\n") == 0
    assert (
        said.startswith(f"Error: No space left on device: {tmp_path / 'runs'}")
        and "stored whole" in said
        and "make room" in said
    )
    names = {path.suffix for path in (tmp_path / "runs").iterdir()}
    assert names <= {".run", ".json"} and len(list((tmp_path / "runs").glob("*.run"))) == 1


@pytest.mark.skipif(os.name == "nt" or not hasattr(os, "access"), reason="rights of folders")
def test_folder_that_must_not_be_written_to(tmp_path: Path) -> None:
    closed = tmp_path / "closed"
    closed.mkdir(mode=0o500)
    if os.access(closed, os.W_OK):
        pytest.skip("this user may write everywhere")
    with pytest.raises(PermissionError) as error:
        write_text(closed / "file.txt", "text")
    assert "folder that you may write to" in went_wrong(error.value)


def test_words_of_what_the_system_refused() -> None:
    from concurrent.futures.process import BrokenProcessPool

    for error in (MemoryError(), BrokenProcessPool("died"), OSError(errno.EROFS, "Read-only file system", "runs")):
        line = went_wrong(error)
        assert "stored whole" in line and "\n" not in line
    assert went_wrong(ConnectionError("lost")).endswith("where a scheduler runs, or without --scheduler.")
    assert "ulimit -f" in went_wrong(OSError(errno.EFBIG, "File too large", "runs"))
    library = went_wrong(ImportError("x.so: failed to map segment from shared object"))
    assert "x.so" in library and "ulimit -v" in library and "stored whole" in library and "\n" not in library
    assert "memory" in went_wrong(RuntimeError("can't start new thread"))
    assert "memory" in went_wrong(MemoryError()) and "lost" in went_wrong(BrokenProcessPool(""))


@pytest.mark.parametrize("kind", [ImportError, RuntimeError])
def test_library_or_thread_that_is_refused_ends_in_one_line(
    kind: type[Exception], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def command() -> None:
        raise kind("can't start new thread")

    monkeypatch.setattr(app, "app", command)
    with pytest.raises(SystemExit) as end:
        app.main()
    said = capsys.readouterr().err.strip()
    assert end.value.code == 1 and said.count("\n") == 0 and "stored whole" in said


def test_libraries_of_the_report_are_loaded_before_the_runs(
    tmp_path: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gyroctl.cli.compare.WRITING", ("no_such_library",))
    code, _, said = run("compare", "--quick", "--out", tmp_path / "out", "--no-search")
    assert code == 1 and "no_such_library" in said and said.count("\n") == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.skipif(os.name == "nt", reason="rename onto a folder")
def test_folder_in_place_of_a_result_is_named(tmp_path: Path, run: Run) -> None:
    """And not the temporary name, which is no more."""
    key = "ab" * 32
    (tmp_path / "runs" / f"{key}.run").mkdir(parents=True)
    with pytest.raises(IsADirectoryError) as error:
        Store(tmp_path / "runs").save(key, {})
    line = went_wrong(error.value)
    assert f": {tmp_path / 'runs' / key}.run. " in line and "part" not in line and "remove that folder" in line
    (tmp_path / "results.nc").mkdir()
    code, _, said = run("compare", "--out", tmp_path)
    assert code == 2 and f"{tmp_path / 'results.nc'} is a folder where a file belongs. Remove it" in said


def test_disk_without_room_is_named_where_a_library_writes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(OSError, match="No space left") as error, written_as_hdf5(tmp_path / "results.nc"):
        print("Traceback: of a part that cannot be closed", file=sys.stderr)
        raise RuntimeError(f"Can't close file (file write failed: errno = {errno.ENOSPC}, error message = 'full')")
    assert f"No space left on device: {tmp_path / 'results.nc'}. " in went_wrong(error.value)
    assert capsys.readouterr().err == ""
    with pytest.raises(RuntimeError), written_as_hdf5(tmp_path / "results.nc"):
        print("A warning", file=sys.stderr)
        raise RuntimeError("another one")
    assert capsys.readouterr().err == "A warning\n" and not list(tmp_path.iterdir())


@pytest.mark.skipif(os.name == "nt", reason="links need rights there")
def test_links_under_the_names_are_not_followed(tmp_path: Path) -> None:
    (tmp_path / "precious").write_text("keep")
    (tmp_path / "out.txt").symlink_to(tmp_path / "precious")
    with written_whole(tmp_path / "out.txt") as part:
        assert not part.is_symlink() and part.parent == tmp_path
        part.write_text("new")
    assert (tmp_path / "precious").read_text() == "keep" and (tmp_path / "out.txt").read_text() == "new"


@pytest.mark.skipif(os.name == "nt", reason="asks for a process")
def test_what_a_dead_process_left_is_cleaned_at_the_next_start(tmp_path: Path) -> None:
    with written_whole(tmp_path / "x.run") as part:
        mine = part.name
        dead = part.with_name(part.name.replace(str(os.getpid()), "999999999"))
        dead.write_bytes(b"half")
        assert left_over(tmp_path) == [dead]
        Store(tmp_path)
        assert [path.name for path in tmp_path.iterdir()] == [mine], "that of a process that lives stays"


# --- results.nc ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("stride", [1511, pytest.param(97, marks=pytest.mark.slow)])
def test_no_flipped_bit_of_results_is_believed(device: gy.Plant, tmp_path: Path, stride: int) -> None:
    waves = Realisations(gy.SeaState(), (3,), duration=60.0)
    ds = compare(device, {"plain": gy.law("constant")}, waves, Settings(blend=40.0), 1, quiet=True)
    write(ds.drop_vars([name for name in ds if str(name).startswith("example_")]), tmp_path)
    file = tmp_path / "results.nc"
    content = file.read_bytes()
    assert open_results(file).mean_power.item() == ds.mean_power.item()
    places = [*range(0, len(content), stride), *range(len(content) - 90, len(content), 1 + stride // 200)]
    for at in places:
        file.write_bytes(content[:at] + bytes([content[at] ^ (1 << (at * 5 % 8))]) + content[at + 1 :])
        with pytest.raises(gy.InputError):
            open_results(file)
    for damaged in (content[:-1], content[:-90], content[: len(content) // 2], content[:100], content + b"x"):
        file.write_bytes(damaged)
        with pytest.raises(gy.InputError, match=r"not what was written|cannot be read") as error:
            open_results(file)
        told = str(error.value)
        assert "un gyroctl compare again with the same --out" in told and told.count(str(file)) == 1, "one message"


def test_seal_is_of_every_byte_above_it(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_bytes(b"numbers")
    assert seal_of(file) is None
    seal(file)
    assert seal_of(file) is True
    file.write_bytes(file.read_bytes().replace(b"numbers", b"numberz"))
    assert seal_of(file) is False
