"""Waves out again: tables and WEC-Sim's elevation, read back as the same numbers; the command that tells a sea."""

import math
from pathlib import Path

import numpy as np
import pytest
from command_line import Run

import gyroctl as gy
from gyroctl.errors import InputError
from gyroctl.waves import WaveRealisation, read_record
from gyroctl.waves.export import VARIABLE, write_waves


@pytest.fixture(scope="module")
def made(device: gy.Plant) -> WaveRealisation:
    return gy.realise(device, gy.SeaState(), 5, 60.0)


def test_a_table_is_read_back_to_the_last_bit(tmp_path: Path, made: WaveRealisation) -> None:
    path = write_waves(tmp_path / "waves.csv", made)
    assert path.read_text().splitlines()[0] == "time [s],elevation [m],Me1 [Nm],Me3 [Nm]"
    table = np.genfromtxt(path, delimiter=",", skip_header=1)
    assert np.array_equal(table.T, np.vstack((made.time, made.elevation, made.moments)))
    record = read_record(path, column="elevation")
    assert np.array_equal(record.eta, made.elevation) and np.array_equal(record.time, made.time)


def test_wec_sim_gets_one_variable_of_two_columns(tmp_path: Path, made: WaveRealisation) -> None:
    from scipy.io import loadmat

    found = loadmat(write_waves(tmp_path / "waves.mat", made))
    assert [name for name in found if not name.startswith("__")] == [VARIABLE]
    assert np.array_equal(found[VARIABLE], np.column_stack((made.time, made.elevation)))
    assert found[VARIABLE].dtype == np.float64


def test_wec_sim_gets_text_without_a_heading(tmp_path: Path, made: WaveRealisation) -> None:
    path = write_waves(tmp_path / "waves.txt", made)
    assert np.array_equal(np.loadtxt(path), np.column_stack((made.time, made.elevation)))
    assert np.array_equal(read_record(path).eta, made.elevation)


def test_waves_that_come_back_move_the_device_alike(tmp_path: Path, device: gy.Plant) -> None:
    """Within the record; near its ends the moments depend on waves that it does not have."""
    first = gy.realise(device, gy.SeaState(), 5, 200.0)
    again = gy.realise(device, read_record(write_waves(tmp_path / "w.txt", first)), 1, 200.0)
    inside = slice(600, -600)
    off = np.std((again.moments - first.moments)[:, inside], axis=1)
    assert np.all(off < 0.01 * np.std(first.moments, axis=1))


def test_another_ending_is_refused_and_nothing_written(tmp_path: Path, made: WaveRealisation) -> None:
    with pytest.raises(InputError, match="out"):
        write_waves(tmp_path / "waves.xlsx", made)
    assert not list(tmp_path.iterdir())


def test_the_command_tells_a_sea_and_writes_its_waves(tmp_path: Path, run: Run) -> None:
    (tmp_path / "lab.csv").write_text("f [Hz],S [m2/Hz]\n0.3,0\n0.5,0.04\n0.8,0\n")
    (tmp_path / "sea.toml").write_bytes(b'\xef\xbb\xbf[sea]\r\nkind = "spectrum"\r\nfile = "lab.csv"\r\n')
    code, out, err = run("waves", tmp_path / "w.mat", "--sea", tmp_path / "sea.toml", "--duration", 30)
    assert code == 0, err
    assert "Hs 0.4 m, Tp 2 s (3.142 rad/s)" in out and "WEC-Sim" in out
    assert "converted from Hz, m2/Hz" in err and (tmp_path / "w.mat").is_file()


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("hs = 6.7\nwp = 0.6\n", "cannot follow"),
        ("hs = 0.001\nwp = 30.0\n", "sea.wp"),
        ('kind = "spectrum"\nfile = "s.txt"\n', "scale"),
        ('kind = "record"\nfile = "r.csv"\n', "sea.eta"),
    ],
)
def test_a_sea_that_no_run_takes_is_told_with_a_remark(tmp_path: Path, run: Run, content: str, words: str) -> None:
    """The text of s.txt is as WAFO writes a spectrum."""
    (tmp_path / "s.txt").write_text("w;S\n0.2;0.1\n0.5;3\n0.6;8\n0.8;4\n1.5;0.5\n2.5;0\n")
    time = np.arange(0.0, 300.0, 0.5)
    rows = "".join(f"{t:.1f},{3.0 * math.cos(0.8 * t):.4f}\n" for t in time.tolist())
    (tmp_path / "r.csv").write_text("time [s],eta [m]\n" + rows)
    (tmp_path / "sea.toml").write_text("[sea]\n" + content)
    code, out, err = run("waves", "--sea", tmp_path / "sea.toml")
    assert code == 0 and out.startswith("Hs ")
    assert "a run of this device refuses it" in err and words in err
    (tmp_path / "sea.toml").write_text("[sea]\nhs = 0.2\n")
    assert "refuses" not in run("waves", "--sea", tmp_path / "sea.toml")[2]


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        (["w.pdf"], ["out", "waves.csv"]),
        (["w.csv", "--hs", "28"], ["sea.hs", "breaks"]),
        (["w.csv", "--sea", "gone.toml"], ["sea", "gone.toml"]),
        (["--sea", "empty.toml"], ["sea", "[sea]"]),
        (["--sea", "sea.toml", "--hs", "0.2"], ["sea", "--hs"]),
        (["gone/w.csv"], ["out", "folder"]),
    ],
)
def test_the_command_refuses_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run: Run, asked: list[str], words: list[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "empty.toml").write_text("[run]\nduration = 30.0\n")
    (tmp_path / "sea.toml").write_text("[sea]\nhs = 0.2\n")
    code, _, err = run("waves", *asked)
    assert code == 2 and len(err.strip().splitlines()) == 1
    for word in words:
        assert word in err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["empty.toml", "sea.toml"]


def test_one_run_in_a_sea_of_a_file(tmp_path: Path, run: Run) -> None:
    omega = np.linspace(1.5, 8.0, 200)
    density = gy.SeaState().spectrum(omega)
    rows = "".join(f"{w:.3f},{s:.8f}\n" for w, s in zip(omega.tolist(), density.tolist(), strict=True))
    (tmp_path / "s.csv").write_text("omega [rad/s],S [m2 s/rad]\n" + rows)
    (tmp_path / "sea.toml").write_text('[sea]\nkind = "spectrum"\nfile = "s.csv"\nspreading = "cos2s"\nwidth = 30.0\n')
    asked = ("--law", "constant", "--sea", tmp_path / "sea.toml", "--duration", 60, "--blend", 20)
    code, out, err = run("simulate", *asked, "--out", tmp_path / "run.nc")
    assert code == 0 and "W mean power" in out and (tmp_path / "run.nc").is_file(), err


TIME = np.arange(0.0, 400.0, 0.2)
LEVEL = 0.1 * np.cos(3.1 * TIME) + 0.03 * np.cos(2.6 * TIME + 1.0) + 0.03 * np.cos(3.6 * TIME + 2.0)


def rows(time: np.ndarray, level: np.ndarray, head: str = "time,elevation\n") -> bytes:
    return (head + "".join(f"{t:.3f},{e:.5f}\n" for t, e in zip(time, level, strict=True))).encode()


FOREIGN = {
    # kind of file: (its content, entries of [sea], what the one line has to say)
    "drift": (rows(TIME, LEVEL + 0.3 * TIME / 400.0), 'kind = "record"', ["sea.eta", "drifts", "detrend"]),
    "millimetres": (rows(TIME, 1000.0 * LEVEL), 'kind = "record"', ["sea.eta", "millimetres"]),
    "centimetres": (rows(TIME, 100.0 * LEVEL), 'kind = "record"', ["sea.eta", "breaks", "millimetres"]),
    "a second apart": (rows(TIME[::5], LEVEL[::5]), 'kind = "record"', ["sea.time = 1.0", "beyond"]),
    "a gap": (rows(np.delete(TIME, 70), np.delete(LEVEL, 70)), 'kind = "record"', ["sea.time", "gap", "13.8"]),
    "no unit": (b"0.3,0\n0.5,0.04\n0.8,0\n", 'kind = "spectrum"', ["sea.unit", "Hz", "rad/s"]),
    "in UTF-16": ("time,elevation\n0,1\n".encode("utf-16"), 'kind = "record"', ["sea.file", "UTF-16", "UTF-8"]),
    "full scale": (
        b"f [Hz],S [m2/Hz]\n0.05,0\n0.1,40\n0.2,0\n",
        'kind = "spectrum"',
        ["sea.density", "breaks", "scale"],
    ),
    "swell of the ocean": (
        b"f [Hz],S [m2/Hz]\n0.015,0\n0.02,4\n0.025,0\n",
        'kind = "spectrum"',
        ["sea.wp", "0.1256", "scale"],
    ),
}


@pytest.mark.parametrize("kind", FOREIGN)
def test_a_comparison_refuses_foreign_seas_in_one_line(tmp_path: Path, run: Run, kind: str) -> None:
    content, entries, words = FOREIGN[kind]
    (tmp_path / "sea.csv").write_bytes(content)
    short = "[run]\nduration = 60.0\nblend = 20.0\n[laws.constant]\n"
    (tmp_path / "mine.toml").write_text(f'[sea]\nfile = "sea.csv"\n{entries}\n{short}')
    code, out, err = run("compare", tmp_path / "mine.toml", "--out", tmp_path / "out", "--no-search")
    lines = [line for line in err.strip().splitlines() if not line.startswith("sea: ")]
    assert code == 2 and lines[0].startswith("Error: ") and "Traceback" not in out + err
    for word in words:
        assert word in lines[0], lines
