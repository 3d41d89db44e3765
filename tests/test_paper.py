"""The paper's numerical example: entry function, figures and their data, the statement table."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path

import numpy as np
import pytest
from command_line import Run
from PIL import Image

import gyroctl as gy
from gyroctl.hydrodynamics import shipped
from gyroctl.studies.paper import EXTRAS, FIGURES, Setup, reproduce
from gyroctl.studies.paper.drawing import gain
from gyroctl.studies.paper.ensembles import GAINS, ensemble, lock_grid
from gyroctl.studies.paper.reproduce import chosen
from gyroctl.studies.paper.statement_table import as_json, cell, markdown, tally
from gyroctl.studies.paper.statements import STATEMENTS, Finding, evaluate
from gyroctl.studies.paper.verdicts import Result, holds, loses, one_draw, within

SHORT = Setup(seeds=(1, 2, 3, 4), duration=250.0, examples=3, workers=1, quiet=True)


def columns(path: Path) -> dict[str, list[str]]:
    with path.open(encoding="utf-8") as stream:
        rows = list(csv.reader(stream))
    return {name: [row[i] for row in rows[1:]] for i, name in enumerate(rows[0])}


def numbers(path: Path, name: str) -> np.ndarray:
    return np.array([float(value) for value in columns(path)[name]])


# --- what is asked for --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("asked", [["fig7"], ["fig8", "fig16"], [], ["Fig8"], [""]])
def test_unknown_figure_is_named_before_anything_is_written(tmp_path: Path, asked: list[str]) -> None:
    with pytest.raises(gy.InputError) as caught:
        reproduce(asked, tmp_path / "out", quiet=True)
    assert caught.value.field == "figures"
    assert "fig8" in caught.value.mend and "all" in caught.value.mend
    assert not (tmp_path / "out").exists()


def test_all_is_everything_once_and_in_order() -> None:
    assert FIGURES == tuple(f"fig{i}" for i in range(8, 16))
    assert chosen(["all"]) == (*FIGURES, *EXTRAS)
    assert chosen(["fig12", "fig9", "fig12"]) == ("fig9", "fig12")


def test_a_file_in_the_place_of_the_directory_is_refused(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("mine")
    for out in (tmp_path / "taken", tmp_path / "taken" / "below"):
        with pytest.raises(gy.InputError) as caught:
            reproduce(["fig8"], out, quiet=True)
        assert caught.value.field == "out"
    assert (tmp_path / "taken").read_text() == "mine"


def test_what_made_earlier_figures_is_kept(tmp_path: Path) -> None:
    other = Setup(seeds=(1, 2), duration=SHORT.duration, examples=2, workers=1, quiet=True)
    reproduce(["fig8"], tmp_path, quiet=True, setup=SHORT)
    reproduce(["fig9"], tmp_path, quiet=True, setup=other)
    record = json.loads((tmp_path / "reproduce.json").read_text())
    assert list(record["figures"]) == ["fig8", "fig9"] and record["made"] == ["fig9"]
    assert record["figures"]["fig8"]["seeds"] == [1, 2, 3, 4] and record["figures"]["fig9"]["seeds"] == [1, 2]
    assert {"gyroctl_version", "command", "duration_s"} <= set(record["figures"]["fig8"])
    before = {key: value for key, value in record.items() if key != "figures"}
    (tmp_path / "reproduce.json").write_text(json.dumps({**before, "made": ["fig14"]}))
    reproduce(["fig8"], tmp_path, quiet=True, setup=SHORT)
    assert list(json.loads((tmp_path / "reproduce.json").read_text())["figures"]) == ["fig8", "fig14"]
    (tmp_path / "reproduce.json").write_text("no record")
    reproduce(["fig8"], tmp_path, quiet=True, setup=SHORT)
    assert list(json.loads((tmp_path / "reproduce.json").read_text())["figures"]) == ["fig8"]


def test_help_names_all_that_can_be_made(run: Run) -> None:
    said = " ".join(run("reproduce", "--help")[1].replace("│", " ").split())
    assert all(name in said for name in (FIGURES[0], FIGURES[-1], *EXTRAS))


# --- figures and their data ---------------------------------------------------------------------------------------


@pytest.mark.slow
def test_every_figure_gives_a_picture_and_data_that_belong_together(
    tmp_path: Path, recwarn: pytest.WarningsRecorder
) -> None:
    written = reproduce(FIGURES, tmp_path, quiet=True, setup=SHORT)
    assert all(path.is_file() for path in written)
    assert not list(tmp_path.glob("*.part"))
    for name in FIGURES:
        assert tmp_path / f"{name}.png" in written
        assert tmp_path / f"{name}.csv" in written
        picture = Image.open(tmp_path / f"{name}.png")
        assert picture.width >= 1500
        assert len(np.unique(np.asarray(picture.convert("L")))) > 50
    assert not [str(w.message) for w in recwarn if "Glyph" in str(w.message)]
    record = json.loads((tmp_path / "reproduce.json").read_text())
    assert record["seeds"] == [1, 2, 3, 4]
    text = (tmp_path / "fig14.svg").read_text(encoding="utf-8")
    assert "Mean power of all runs, corrected plant" in text and "95 %." in text and "Grey dashes: " in text

    # figure 8: the data are those of the shipped table where it has a row, and the fit follows it
    fit, omega = numbers(tmp_path / "fig8.csv", "damping_3_accurate_nms"), numbers(tmp_path / "fig8.csv", "omega_rad_s")
    hydro = shipped()
    at = float(np.interp(3.1, omega, fit))
    assert at == pytest.approx(float(np.interp(3.1, hydro.omega, hydro.damping[1])), rel=0.05)

    # figure 9: area of each spectrum is Hs^2/16, but for what lies outside the plotted band
    omega = numbers(tmp_path / "fig9.csv", "omega_rad_s")
    for gamma, missing in ((5, 0.05), (50, 0.02)):
        area = float(np.trapezoid(numbers(tmp_path / "fig9.csv", f"gamma{gamma}_elevation_m2s"), omega))
        assert (1.0 - missing) * 0.283**2 / 16 < area < 0.283**2 / 16

    # figure 10: power is cg times the square of the flywheel speed, and that of the realisation lies in the band
    power, speed = (numbers(tmp_path / "fig10.csv", name) for name in ("power_w", "flywheel_speed_rad_s"))
    np.testing.assert_allclose(power, 3.5e-4 * speed**2, rtol=1e-6)
    low, high = (numbers(tmp_path / "fig10.csv", f"power_{name}_w") for name in ("p5", "p95"))
    assert np.all(low <= high)

    # figures 12 to 14: the table repeats the runs that the statements are judged on
    for name, gamma in (("fig12", 5.0), ("fig13", 50.0), ("fig14", 1.0)):
        table = columns(tmp_path / f"{name}.csv")
        assert len(table["cg_nms"]) == 2 * 3 * len(GAINS[gamma])
        for i, variant in enumerate(table["variant"]):
            case = lock_grid(SHORT, variant, gamma)[float(table["cc_nms"][i]), float(table["cg_nms"][i])]
            assert float(table["lock_share"][i]) == pytest.approx(case.locked.mean())
            assert float(table["mean_power_w"][i]) == pytest.approx(case.power.mean(), rel=1e-6)


def test_time_series_and_ensemble_are_the_same_runs() -> None:
    """The closed loop with a constant law and the compiled ensemble: two ways to one run."""
    from gyroctl.studies.paper.time_series import time_series

    runs = time_series(SHORT, 5.0, 0.052, 3.5e-4)
    case = lock_grid(SHORT, "corrected", 5.0)[0.052, 3.5e-4]
    scored = runs.time >= 100.0
    mean = np.trapezoid(runs.power[:, scored], runs.time[scored], axis=1) / 150.0
    np.testing.assert_allclose(mean, case.power[:3], rtol=1e-4)


def test_gains_are_written_as_in_the_paper() -> None:
    assert [gain(value) for value in (3.5e-4, 1e-3, 1.25e-3, 0.02)] == ["3.5e-4", "1e-3", "1.25e-3", "2e-2"]


# --- the statement table ------------------------------------------------------------------------------------------


def test_statements_have_keys_of_their_own_and_every_pair_is_on_the_grid() -> None:
    keys = [statement.key for statement in STATEMENTS]
    assert len(set(keys)) == len(keys) >= 20
    assert {"k3", "jh1", "jh3", "omega1", "g5_input", "g5_earlier", "g50_earlier"} <= set(keys)
    assert 3.5e-4 in GAINS[5.0] and 1e-3 in GAINS[5.0] and 7.5e-4 in GAINS[50.0] and 1.5e-4 in GAINS[1.0]


@pytest.fixture(scope="module")
def findings() -> tuple[Finding, ...]:
    return evaluate(SHORT)


def test_table_says_for_both_presets_what_was_found(findings: tuple[Finding, ...]) -> None:
    assert [finding.statement for finding in findings] == list(STATEMENTS)
    by_key = {finding.statement.key: finding.results for finding in findings}
    assert all(set(results) == {"corrected", "paper"} for results in by_key.values())
    # numbers without chance, against the paper's own
    for key, stated in (("k3", 2945.0), ("jh1", 14.39), ("jh3", 32.16), ("omega1", 1.29), ("omega3", 5.28)):
        for result in by_key[key].values():
            assert result.value == pytest.approx(stated, rel=0.01)
            assert result.verdict == "agree"
    assert by_key["regular_lock"]["corrected"].verdict == "agree"
    assert by_key["regular_lock"]["paper"].verdict == "differ"  # no damping of phi1: a Neimark-Sacker pair
    assert by_key["regular_lock"]["paper"].value > 1.0
    total = tally(findings)
    assert all(sum(row.values()) == len(STATEMENTS) for row in total.values())
    rows = json.loads(as_json(findings, SHORT))["statements"]
    assert [row["key"] for row in rows] == [statement.key for statement in STATEMENTS]
    text = markdown(findings, SHORT)
    assert "4 realisations of 250 s" in text
    for finding in findings:
        assert finding.statement.says in text
    for line in text.splitlines():
        if line.startswith("|"):
            assert len(re.findall(r"(?<!\\)\|", line)) == 7


def test_cells_show_number_interval_and_unit(findings: tuple[Finding, ...]) -> None:
    finding = next(f for f in findings if f.statement.key == "g5_holds")
    assert cell(finding, Result(0.9375, 0.85, 0.975, "", "agree")) == "93.8 (85.0 to 97.5) %"
    power = next(f for f in findings if f.statement.key == "g5_power")
    assert cell(power, Result(1.716, 1.71, 1.72, "W", "agree")) == "1.72 (1.71 to 1.72) W"
    assert cell(power, Result(np.nan, np.nan, np.nan, "W", "open")) == "none"
    assert cell(power, Result(2945.4, np.nan, np.nan, "Nm/rad", "agree")) == "2945 Nm/rad"


def test_statement_files_are_written_and_printed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    loud = Setup(seeds=SHORT.seeds, duration=SHORT.duration, examples=3, workers=1, quiet=True)
    written = reproduce(["statements"], tmp_path, quiet=False, setup=loud)
    assert {path.name for path in written} == {"statements.md", "statements.json", "reproduce.json"}
    shown = capsys.readouterr().out
    assert "corrected" in shown and "as printed" in shown and "agree" in shown
    reproduce(["statements"], tmp_path, quiet=True, setup=loud)
    assert capsys.readouterr().out == ""


@pytest.mark.slow
def test_the_paper_s_main_statements_on_many_realisations() -> None:
    """The corrected plant keeps and loses lock where the paper does, at its power; as printed it loses it at once."""
    setup = Setup(seeds=tuple(range(1, 33)), workers=1, quiet=True)
    device, printed = gy.zhang2017(), gy.zhang2017("paper")
    five = ensemble(setup, device, 5.0, [(0.052, 3.5e-4), (0.052, 1e-3)], "gamma 5")
    fifty = ensemble(setup, device, 50.0, [(0.052, 7.5e-4)], "gamma 50")[0.052, 7.5e-4]
    one = ensemble(setup, device, 1.0, [(0.104, 1.5e-4)], "gamma 1")[0.104, 1.5e-4]
    kept = five[0.052, 3.5e-4]
    for case in (kept, fifty, one):
        assert holds(case.locked).verdict == "agree"
    assert loses(five[0.052, 1e-3].locked).verdict == "agree"
    assert within(kept.power[kept.locked], (1.6, 2.0), "W", "").verdict == "agree"
    assert one_draw(fifty.power[fifty.locked], 3.5, 0.05, "W", "").verdict == "agree"
    as_printed = ensemble(setup, printed, 5.0, [(0.052, 3.5e-4)], "as printed")[0.052, 3.5e-4]
    assert holds(as_printed.locked).verdict == "differ"
