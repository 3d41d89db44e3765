"""Text from outside gives a sound result or a refusal that names field, value and mend. Findings, one each."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gyroctl as gy
from gyroctl.comparison.experiment import read_experiment
from gyroctl.controllers.gain_scheduled.table import law_of, read_table, table_file
from gyroctl.errors import InputError
from gyroctl.harness.seed_ledger import read_ledger
from gyroctl.harness.tuned_sets import read_sets, seeds_of
from gyroctl.hydrodynamics import nemoh
from gyroctl.hydrodynamics.site import mode_number
from gyroctl.reading import DEEPEST, TOML_MAX, read_json, read_text, read_toml
from gyroctl.tuning.goal import WORST
from gyroctl.tuning.log import TuningLog
from gyroctl.tuning.stages import stored_rows
from gyroctl.tuning.task import read_task
from gyroctl.waves import read_record, read_spectrum

MEND = "Correct it"


def written(folder: Path, content: str | bytes, name: str = "file.toml") -> Path:
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def refused(read: Callable[[], object], *parts: str) -> InputError:
    with pytest.raises(InputError) as caught:
        read()
    error = caught.value
    assert error.field and error.problem and error.mend
    assert str(error).isprintable() and len(str(error)) < 5000
    for part in parts:
        assert part in str(error)
    return error


# --- what an error shows -------------------------------------------------------------------------------------------


SHOWN = {
    "whole": 10**5000,
    "long": "y" * 10**6,
    "steering": "\x1b[2J",
    "nested": [[1] * 1000] * 100,
    "zero": {"a": "\x00"},
}


@pytest.mark.parametrize("value", SHOWN.values(), ids=SHOWN)
def test_any_value_is_shown_in_a_short_line(value: object) -> None:
    text = str(InputError("a.\x1b[31m", value, "is strange\n", MEND))
    assert text.isprintable() and len(text) < 5000


def test_plain_values_are_shown_as_ever() -> None:
    assert str(InputError("sea.hs", -0.1, "must be positive", "Give metres")) == (
        "sea.hs = -0.1: must be positive. Give metres."
    )


# --- text, TOML, JSON ----------------------------------------------------------------------------------------------


def test_marks_and_ends_of_other_systems_are_read(tmp_path: Path) -> None:
    assert read_toml("file", written(tmp_path, b"\xef\xbb\xbfa = 1\r\nb = 2\r\n")) == {"a": 1, "b": 2}


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (b"a = '\xe9'", "UTF-8"),
        (b"a = 1\x00", "control character in line 1"),
        (b"a = 1\n\x1b = 2", "control character in line 2"),
        ('a = "\\u001b[31m"', "a = "),
        ('"\\u0007" = 1', "name with a control character"),
        ("a = " + "[" * 5000 + "]" * 5000, "nested"),
        ("a = " + "[" * (DEEPEST + 5) + "]" * (DEEPEST + 5), "nested"),
        ("a." * 50_000 + "a = 1", "too many parts"),
        ("a = " + "9" * 30, "too large a number"),
        ("a = " + "9" * 5000, "is no TOML"),
        ("a = 0x" + "f" * 5000, "too large a number"),
        ("a = 1\na = 2", "is no TOML"),
        (b"#" * (TOML_MAX + 1), "larger than"),
    ],
    ids=lambda part: str(part[:12]).encode("unicode_escape").decode(),
)
def test_strange_toml_is_refused(tmp_path: Path, content: str | bytes, why: str) -> None:
    refused(lambda: read_toml("file", written(tmp_path, content)), why)


@pytest.mark.parametrize(
    "text", ["{", "[" * 100_000, "NaN", "[1e999]", "9" * 5000, '{"a": Infinity}', '["\\u0000"]'], ids=range(7)
)
def test_strange_json_is_refused(tmp_path: Path, text: str) -> None:
    refused(lambda: read_json("file", written(tmp_path, text), MEND))


def test_what_is_no_file_with_an_end_is_refused(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path, tmp_path / "pipe", Path("/dev/zero"), tmp_path / ("y" * 5000), tmp_path / "\x00"):
        refused(lambda path=path: read_text("file", path, MEND), "file = ")


# --- experiment and task -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "field"),
    [
        ("[sea]\nkind = []", "sea.kind"),
        ('[sea]\nkind = "record"\nfile = "/dev/zero"', "sea.file"),
        ('[sea]\nkind = "record"\nfile = "' + "y" * 5000 + '"', "sea.file"),
        ("[laws.constant]\nname = 1", "laws.constant.name"),
        ("[laws.load_angle]\ntuning = []", "laws.load_angle.tuning"),
        ("[laws.supervisor]\nwraps = {law = 'constant', name = 'x'}", "laws.constant.name"),
        ("[laws.load_angle]\nplant = {variant = []}", "laws.load_angle.plant"),
        ("[laws.scheduled_lqr]\nplant = 1979-05-27", "laws.scheduled_lqr"),
        ("[laws.supervisor]\nwraps = [1]", "laws.supervisor"),
        ("[plant]\nm1 = 1e308", "plant.m1"),
        ('[plant]\nhydrodynamics = "/dev/zero"', "path"),
        ("[actuators]\ncc_max = nan", "actuators.cc_max"),
        ("[run]\nduration = -1", "run.duration"),
        ("[run]\nseeds = [1.5]", "run.seeds"),
    ],
)
def test_experiment_is_refused_by_name(tmp_path: Path, text: str, field: str) -> None:
    assert refused(lambda: read_experiment(written(tmp_path, text))).field.startswith(field)


KNOBS = "law = 'constant'\n[knobs]\ncc = {start = 0.05, width = 0.2}\n"


@pytest.mark.parametrize(
    ("text", "field"),
    [
        (KNOBS + "[seeds]\ncount = 1e11", "seeds.count"),
        (KNOBS + "[seeds]\nfirst = 1e300", "seeds.first"),
        (KNOBS + "[search]\npopulation = 1e11", "search.population"),
        (KNOBS + "[search]\nwindow = 1e308", "search.window"),
        (KNOBS + "[search]\ndt = 1e-320", "search.dt"),
        (KNOBS + "[search]\nruns = 1e11", "search.runs"),
        (KNOBS + "[seas.rough]\nruns = 1.5", "seas.rough.runs"),
        (KNOBS + "[seas.rough]\npower = 1e-320", "seas.rough.power"),
        ("real = 5\n" + KNOBS, "real"),
        (KNOBS + "tuning = {start = 1, width = 1}", "tuning"),
        (KNOBS + "allow_code = {start = 1, width = 1}", "allow_code"),
        (KNOBS.replace("0.2", "1e308"), "knobs.cc.width"),
    ],
)
def test_task_is_refused_by_name(tmp_path: Path, text: str, field: str) -> None:
    water = "real" if text.startswith("real") else "linear"
    assert refused(lambda: read_task(str(written(tmp_path, text)), water)).field == field


# --- tuned sets, ledger, log ---------------------------------------------------------------------------------------


def a_set(**found: Any) -> str:
    return json.dumps({"law": "mine", "sets": {"all": {"parameters": {"cc": 0.1}, "found": found}}})


@pytest.mark.parametrize(
    "seeds",
    [
        {"first": 0, "last": 10**11},
        {"first": 0, "last": 1e11},
        {"first": 5, "last": 1},
        {"first": -1, "last": 1},
        {"first": True, "last": 1},
        {"first": "a", "last": 1},
        {"first": 1},
        [1, 2],
        None,
    ],
)
def test_seeds_of_a_tuned_set_are_few_whole_numbers(tmp_path: Path, seeds: object) -> None:
    path = written(tmp_path, a_set(seeds=seeds), "mine.json")
    refused(lambda: read_sets(path), "sets.all.found.seeds")


def test_tuned_set_that_hides_its_seeds_judges_nothing(tmp_path: Path) -> None:
    sets = read_sets(written(tmp_path, a_set(), "mine.json"))
    refused(lambda: seeds_of(sets), "sets.all.found.seeds")


@pytest.mark.parametrize(
    "text",
    [
        '{"sets": []}',
        "[]",
        '{"sets": {"all": 1}}',
        '{"sets": {"all": {"parameters": []}}}',
        '{"sets": {"all": {"parameters": {"cc": [1]}}}}',
        '{"sets": {"all": {"parameters": {"cc": NaN}}}}',
        a_set(spent_s=-1.0),
        a_set(budget_s="x"),
    ],
)
def test_tuned_file_of_another_kind_is_refused(tmp_path: Path, text: str) -> None:
    refused(lambda: read_sets(written(tmp_path, text, "mine.json")))


LEDGER = '[judging]\nfirst = 0\nlast = 9\n[[seeds]]\nfirst = {}\nlast = {}\nstate = {}\nsince = 2026-01-01\nuse = "x"\n'


@pytest.mark.parametrize(
    "text",
    [
        LEDGER.format(1, 10**11, '"tuning"'),
        LEDGER.format(1, "inf", '"tuning"'),
        LEDGER.format('"a"', '"b"', '"tuning"'),
        LEDGER.format(1, 2, "[]"),
        LEDGER.replace("last = 9", "last = 1.5").format(1, 2, '"tuning"'),
        "seeds = [1]\n[judging]\nfirst = 0\nlast = 1\n",
        "judging = []\n",
    ],
)
def test_ledger_is_refused(tmp_path: Path, text: str) -> None:
    refused(lambda: read_ledger(written(tmp_path, text)), "ledger = ")


DAMAGED = (
    "{]",
    "[1]",
    '{"key": 1, "value": 2}',
    '{"key": "x"}',
    '{"key": "x", "value": NaN}',
    "\x00" * 100,  # after the power has failed
    "\udcff",
    "[" * 100_000,
    '{"key": "x", "value": ' + "9" * 5000 + "}",
    '{"key": "sear',  # cut short by a kill
)


@pytest.mark.parametrize("line", DAMAGED, ids=range(len(DAMAGED)))
def test_damaged_line_of_a_tuning_is_not_believed_and_said(
    tmp_path: Path, line: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "law.jsonl"
    log = TuningLog(path)
    log.add("search 0", [WORST] * 2)
    whole = path.read_bytes()
    for end in ("", "\n"):
        path.write_bytes(whole + (line + end).encode("utf-8", "surrogateescape"))
        log = TuningLog(path)
        assert log.steps == {"search 0": [list(WORST)] * 2}
        assert "1 lines are not what was written" in capsys.readouterr().err
        log.add("search 1", 0.1 + 0.2)
        assert TuningLog(path).steps == {"search 0": [list(WORST)] * 2, "search 1": 0.1 + 0.2}


def test_log_that_is_no_file_is_refused(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path, tmp_path / "pipe", Path("/dev/zero")):
        refused(lambda path=path: TuningLog(path), "out = ")


@pytest.mark.parametrize("rows", [[WORST], 5, [[1.0] * 3] * 2, [["x"] * len(WORST)] * 2, [None, None], {"a": 1}])
def test_rows_of_another_tuning_are_refused(rows: object) -> None:
    log = TuningLog(None)
    log.add("search 0", rows)
    refused(lambda: stored_rows(log, "search 0", 2), "search 0")
    assert stored_rows(log, "search 1", 2) is None


# --- gain table ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("old", "new", "field"),
    [
        ("share = 0.76,", "share = nan,", "point.share"),
        ("cc = { envelope = 0.0366209", "cc = { envelope = inf", "cc.envelope"),
        ("cc = { envelope = 0.0366209", "cc = { envelope = 1e308", "cc.envelope"),
        ("point = { cc = 0.06, share = 0.76", "point = { cc = -0.06, share = 0.76", "point.cc"),
        ("envelope = [0.06, 0.15, 0.3]", "envelope = [0.15, 0.06, 0.3]", "nodes.envelope"),
        ("envelope = [0.06, 0.15, 0.3]", "envelope = [0.06, 0.15, nan]", "nodes.envelope"),
        ("envelope = [0.06, 0.15, 0.3]", "envelope = 3", "nodes.envelope"),
        ("envelope = [0.06, 0.15, 0.3]", "envelope = [0.06, 0.16, 0.3]", "cells"),
        ("memory = 60.0", "memory = 0.0", "filters.memory"),
        ("memory = 60.0", "cg_max = 60.0", "filters.cg_max"),
        ("frequency = 2.7\nbandwidth = 0.3\n", "frequency = 3.6\nbandwidth = 0.3\n", "cells"),
    ],
)
def test_gain_table_is_refused_by_name(tmp_path: Path, old: str, new: str, field: str) -> None:
    text = table_file("scheduled_lqr").read_text()
    assert old in text
    path = written(tmp_path, text.replace(old, new, 1))
    assert field in refused(lambda: read_table(path)).field


def test_gain_table_that_has_changed_is_read_again(tmp_path: Path) -> None:
    text = table_file("scheduled_lqr").read_text()
    path = written(tmp_path, text)
    assert law_of(read_table(path)).memory == 60.0
    written(tmp_path, text.replace("memory = 60.0", "memory = 600.0"))
    assert law_of(read_table(path)).memory == 600.0


# --- waves ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "rows",
    [
        "1_0 2\n3 4",
        "1 2\n\u0663 4",
        "1 1e308\n2 1",
        "1 1\n2e8 1",
        "0 1\n1 0",
        "1 1e-320\n2 1e-320",
        "1 nan\n2 3\n4 5\n6",
    ],
)
def test_spectrum_is_refused(tmp_path: Path, rows: str) -> None:
    refused(lambda: read_spectrum(written(tmp_path, "0.5 0.0\n" + rows), unit="rad/s"), "sea.")


@pytest.mark.parametrize(("step", "size"), [(1e-300, 1.0), (0.1, 1e308), (1e9, 1.0), (1e-6, 1.0)])
def test_elevation_of_another_world_is_refused(tmp_path: Path, step: float, size: float) -> None:
    rows = "\n".join(f"{i * step} {size * (-1) ** i}" for i in range(40))
    refused(lambda: read_record(written(tmp_path, rows)), "sea.")


def test_numbers_beyond_any_float_are_refused() -> None:
    refused(lambda: gy.SeaState(hs=10**400), "sea.hs")
    refused(lambda: gy.zhang2017(m1=10**400), "plant.m1")
    refused(lambda: gy.law("constant", cc=10**400), "laws.constant.cc")
    refused(lambda: gy.zhang2017(hydrodynamics=5), "path")  # type: ignore[arg-type]


SPECTRUM = "\n".join(f"{f:.2f};{1.0 / (1.0 + (f - 0.2) ** 2 / 1e-3):.6f}" for f in np.arange(0.05, 0.5, 0.01))
RECORD = "\n".join(f"{0.1 * k:.1f};{k % 7}" for k in range(600))


@pytest.mark.parametrize(
    ("read", "head", "rows"),
    [
        (read_spectrum, "f [H\t\tz];S [m2/Hz]", SPECTRUM),
        (read_spectrum, "f [\x1b[2JHz];S [m2/Hz]", SPECTRUM),
        (read_spectrum, "\u202ef [Hz];S [m\u200b2/Hz]", SPECTRUM),
        (read_record, "t [\ts];eta [m\t\tm]", RECORD),
        (read_record, "t [s];\u202eeta [\x1b[2Jmm]", RECORD),
    ],
)
def test_heading_that_hides_something_is_told_as_text(tmp_path: Path, read: Any, head: str, rows: str) -> None:
    try:
        notes = read(written(tmp_path, f"{head}\n{rows}\n", "s.csv")).notes
    except InputError as error:
        assert str(error).isprintable()
    else:
        assert notes and all(note.isprintable() for note in notes)


@pytest.mark.parametrize("digits", ["1" * 5000, "0" * 5000 + "1"])
def test_number_of_thousands_of_digits_is_none(digits: str) -> None:
    """Python refuses to turn them into a number."""
    for title in (f"Motion of body {digits} in DoF 1", f"Motion of body 1 in DoF {digits}"):
        zone = nemoh.Zone(title, [1], np.zeros((1, 3)))
        assert nemoh._by_motion([zone]) == {1: zone}
    refused(lambda: mode_number(digits), "no mode")
