"""A device as a file: what is written is what is read, what no device can be is refused by file, entry and mend."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from command_line import Run

import gyroctl as gy
from gyroctl.comparison.experiment import build_experiment
from gyroctl.devices.entries import ENTRIES
from gyroctl.devices.file import HEAD, database_of, new_device, write_device
from gyroctl.devices.identity import changed, device_record, identity, is_shipped
from gyroctl.froude import power
from gyroctl.hydrodynamics import save, shipped
from gyroctl.hydrodynamics.scaling import scaled
from gyroctl.orbits import critical_damping, lock_map, tongue
from gyroctl.studies.device.assumed import doubts


def written(folder: Path, **changes: Any) -> Path:
    return write_device(folder / "mine.toml", new_device("mine", **changes))


# --- reading


def test_every_parameter_is_an_entry_with_a_unit() -> None:
    assert set(ENTRIES) == {f.name for f in dataclasses.fields(gy.Parameters)}
    for name, entry in ENTRIES.items():
        assert entry.unit == "" or math.isfinite(power(entry.unit)), name


@pytest.mark.parametrize("variant", ["corrected", "paper", "realistic"])
def test_new_file_is_the_device_of_the_paper_to_the_bit(tmp_path: Path, variant: str) -> None:
    plant, expected = gy.device(written(tmp_path, variant=variant)), gy.zhang2017(variant)
    assert plant.parameters == expected.parameters and plant.coefficients == expected.coefficients
    assert plant.excitation.sha256 == expected.excitation.sha256 and plant.water == expected.water
    assert plant.name == f"mine (zhang2017 {variant})" and is_shipped(plant) and identity(plant) == identity(expected)


def test_every_entry_stands_in_the_file_with_its_unit(tmp_path: Path) -> None:
    text = written(tmp_path).read_text(encoding="utf-8")
    for name, entry in {**HEAD, **ENTRIES}.items():
        line = next(line for line in text.splitlines() if line.removeprefix("# ").startswith(f"{name} ="))
        assert entry.words in line and (not entry.unit or f"[{entry.unit}]" in line)


def test_device_is_named_by_what_was_changed(tmp_path: Path) -> None:
    plant = gy.device(written(tmp_path, J14=0.18355, r2=0.21))
    assert plant.name == "mine (zhang2017 corrected), r2 = 0.21 (0.203), J14 = 0.18355 (0.3671)"
    assert set(changed(plant)) == {"r2", "J14"} and not is_shipped(plant)
    record = device_record(plant)
    assert record["changed"]["J14"] == {"table_1": 0.3671, "device": 0.18355, "unit": "kg m^2"}
    assert record["sha256"] not in (identity(gy.zhang2017()), identity(plant.replace(J14=0.2)))


def test_what_is_left_out_is_table_1_at_the_length(tmp_path: Path) -> None:
    file = tmp_path / "long.toml"
    file.write_text("length_scale = 4\nhydrodynamics_length = 4\n", encoding="utf-8")
    p, first = gy.device(file).parameters, gy.Parameters()
    assert p.a == pytest.approx(4 * first.a) and p.J14 == pytest.approx(4**5 * first.J14)
    assert p.k1 == pytest.approx(4**4 * first.k1) and p.d1 == pytest.approx(4**4.5 * first.d1)
    assert p.k3 == pytest.approx(4**4 * shipped().stiffness)


def test_hydrodynamics_of_ones_own_give_k3_and_added_inertia(tmp_path: Path) -> None:
    own = scaled(shipped(), 1.1)
    save(own, tmp_path / "own.nc")
    p = gy.device(written(tmp_path, hydrodynamics="own.nc")).parameters
    assert (p.k3, p.Jh1, p.Jh3) == (own.stiffness, *own.added_mass_inf)
    other = tmp_path / "given.toml"
    write_device(other, new_device("given", hydrodynamics="own.nc", k3=3000.0))
    assert gy.device(other).parameters.k3 == 3000.0 and device_record(gy.device(other))["hydrodynamics"] == "own"


def test_a_body_that_does_not_turn_is_allowed(tmp_path: Path) -> None:
    assert gy.device(written(tmp_path, J11=1e15)).parameters.J11 == 1e15


@pytest.mark.parametrize(
    ("text", "field", "mend"),
    [
        ("J_14 = 2", "J_14", "J14"),
        ("Depth = 2", "Depth", ""),
        ("d3 = -1", "d3", "0.0"),
        ("d3 = nan", "d3", "SI"),
        ("a = true", "a", "SI"),
        ('m1 = "x"', "m1", "SI"),
        ("k3 = 1e16", "k3", "SI"),
        ("r1 = 0.3", "r2", "r1"),
        ("r1 = 1e-320", "r1", "SI"),
        ("drag_area = [1, 2, 3]", "drag_area", "two"),
        ("drag_height = 3", "drag_height", "height"),
        ("contact = 'sticky'", "contact", "friction"),
        ("length_scale = 0", "length_scale", "1.0"),
        ("length_scale = 1e9", "length_scale", "Table 1"),
        ("length_scale = '2'", "length_scale", ""),
        ("hydrodynamics_length = 0", "hydrodynamics_length", "20"),
        ("hydrodynamics = 'no.nc'", "hydrodynamics", ""),
        ("hydrodynamics = 3", "hydrodynamics", "path"),
        ("radiation = 'best'", "radiation", "accurate"),
        ("excitation_phase = 'none'", "excitation_phase", "complex"),
        ("variant = 'x'", "variant", "corrected"),
        ("variant = ['paper']", "variant", "corrected"),
        ("name = 'a/b'", "name", ""),
        ("[plant]\nJ14 = 1", "plant", ""),
    ],
)
def test_bad_entry_is_refused_by_file_and_entry(tmp_path: Path, text: str, field: str, mend: str) -> None:
    file = tmp_path / "bad.toml"
    file.write_bytes(b"\xef\xbb\xbf" + text.encode())
    with pytest.raises(gy.InputError) as caught:
        gy.device(file)
    assert caught.value.field == f"bad.toml: {field}" and mend in caught.value.mend


def test_database_of_a_device_is_that_of_its_model(tmp_path: Path) -> None:
    file = tmp_path / "long.toml"
    file.write_text("length_scale = 4\nhydrodynamics_length = 4\n", encoding="utf-8")
    assert database_of(file).sha256 == shipped().sha256
    file.write_text("length_scale = 4\nhydrodynamics_length = 8\n", encoding="utf-8")
    assert database_of(file).stiffness == pytest.approx(16.0 * shipped().stiffness)


# --- commands and experiments


def test_new_check_and_scale_by_command(tmp_path: Path, run: Run) -> None:
    mine, big, out = tmp_path / "mine.toml", tmp_path / "big.toml", tmp_path / "check"
    assert run("device", "new", mine, "--set", "J14=0.18355")[0] == 0
    assert run("device", "new", mine)[0] == 2  # it is there already
    code, said, _ = run("device", "check", mine, "--out", out)
    assert code == 0 and "J14 = 0.18355" in said and "FAIL" not in said
    content = json.loads((out / "device.json").read_text())
    assert content["plausible"] and content["natural_frequencies"]["phi1"]["frequency"] == pytest.approx(1.21, abs=0.01)
    assert (out / "geometry.png").stat().st_size > 10_000 and "</svg>" in (out / "geometry.svg").read_text()
    assert run("device", "scale", mine, "--length", 20, "--out", big)[0] == 0
    assert gy.device(big).parameters.J14 == pytest.approx(20**5 * 0.18355)
    assert run("device", "scale", mine, "--length", 0, "--out", tmp_path / "none.toml")[0] == 2
    assert not (tmp_path / "none.toml").exists()
    assert run("device", "scale", mine, "--length", 20)[0] == 0
    assert (tmp_path / "mine-x20.toml").read_bytes() == big.read_bytes()


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ({"J14": 5.0}, "flywheel"),
        ({"m1": 2.0}, "float and lever"),
        ({"r2": 0.3}, "ring within the float"),
        ({"J11": 0.1}, "triangle"),
        ({"m4": 200.0}, "float carries"),
        ({"a": 3.0}, "lever"),
        ({"length_scale": 10.0, "a": 0.9891}, "size"),
    ],
)
def test_check_finds_what_no_device_can_be(tmp_path: Path, run: Run, change: dict[str, float], line: str) -> None:
    code, said, _ = run("device", "check", written(tmp_path, **change))
    assert code == 1 and any(row.startswith("FAIL") and line in row for row in said.splitlines()), said


def test_every_command_repeats_what_is_doubtful(tmp_path: Path, run: Run) -> None:
    """Whoever never asked for the check is told all the same, the report of a comparison too."""
    file = written(tmp_path, a=1.05)
    short = ("--law", "constant", "--duration", "120", "--blend", "20", "--out", tmp_path / "run.nc")
    for command in (("waves",), ("simulate", *short)):
        code, _, said = run(*command, "--device", file)
        assert code == 0 and "Doubtful device: lever: a + b = " in said and "device check mine.toml" in said, said
    code, _, said = run("waves")
    assert code == 0 and "Doubtful" not in said
    assert doubts(gy.zhang2017()) == [] and len(doubts(gy.device(file))) == 1


def test_experiment_names_a_device_relative_to_itself(tmp_path: Path) -> None:
    written(tmp_path, J14=0.18355)
    setup = build_experiment({"plant": {"device": "mine.toml", "d1": 3.0}, "laws": {"load_angle": {}}}, folder=tmp_path)
    assert setup.plant.parameters.J14 == 0.18355 and setup.plant.parameters.d1 == 3.0
    assert setup.laws["load_angle"].J4 == 0.18355  # type: ignore[attr-defined]
    assert setup.foreign == ["load_angle"]
    assert setup.record()["plant"]["J14"] == 0.18355
    with pytest.raises(gy.InputError, match=r"plant\.variant"):
        build_experiment({"plant": {"device": "mine.toml", "variant": "paper"}}, folder=tmp_path)
    with pytest.raises(gy.InputError, match="no such file"):
        build_experiment({"plant": {"device": "other.toml"}}, folder=tmp_path)


def test_sets_of_a_device_beside_its_file_are_used_for_it_alone(tmp_path: Path) -> None:
    file = written(tmp_path, J14=0.18355)
    found = {"device_sha256": identity(gy.device(file)), "seeds": {"first": 100200, "last": 100203}}
    sets = {"law": "load_angle", "sets": {"all": {"parameters": {"share": 0.123}, "found": found}}}
    (tmp_path / "mine.tuned").mkdir()
    (tmp_path / "mine.tuned" / "load_angle.json").write_text(json.dumps(sets))
    tables: dict[str, Any] = {"plant": {"device": "mine.toml"}, "laws": {"load_angle": {}}}
    setup = build_experiment(tables, folder=tmp_path)
    assert setup.laws["load_angle"].share == 0.123 and setup.foreign == []  # type: ignore[attr-defined]
    assert 100200 in setup.tuning_seeds
    (tmp_path / "mine.toml").write_text(file.read_text().replace("J14 = 0.18355", "J14 = 0.2"))
    other = build_experiment(tables, folder=tmp_path)
    assert other.laws["load_angle"].share != 0.123 and other.foreign == ["load_angle"]  # type: ignore[attr-defined]


def with_sets(tmp_path: Path, law: str = "load_angle", knob: str = "share", **sets: float) -> Path:
    """File of a device of its own, and sets of a law that were tuned on it."""
    file = written(tmp_path, J14=0.18355)
    found = {"device_sha256": identity(gy.device(file)), "seeds": {"first": 100200, "last": 100203}}
    content = {name: {"parameters": {knob: value}, "found": found} for name, value in sets.items()}
    (tmp_path / "mine.tuned").mkdir()
    (tmp_path / "mine.tuned" / f"{law}.json").write_text(json.dumps({"law": law, "sets": content}))
    return file


def test_set_of_a_device_is_chosen_by_its_name(tmp_path: Path) -> None:
    with_sets(tmp_path, gamma5=0.123, **{"real-gamma5": 0.234})
    for tuning, share in (("gamma5", 0.123), ("real-gamma5", 0.234), ("real", 0.234)):
        tables: dict[str, Any] = {"plant": {"device": "mine.toml"}, "laws": {"load_angle": {"tuning": tuning}}}
        setup = build_experiment(tables, folder=tmp_path)
        assert setup.laws["load_angle"].share == share and setup.foreign == []  # type: ignore[attr-defined]
    tables["laws"] = {"mine": {"law": "load_angle", "tuning": "gamma7"}}
    with pytest.raises(gy.InputError, match=r"laws\.mine\.tuning = 'gamma7'.*gamma5.*mine\.tuned.*all"):
        build_experiment(tables, folder=tmp_path)


def test_law_whose_own_sets_are_not_used_is_told_of_them(tmp_path: Path) -> None:
    """Sets for a sea alone do not hide that the law runs with a set of another device."""
    with_sets(tmp_path, gamma5=0.123)
    tables: dict[str, Any] = {"plant": {"device": "mine.toml"}, "laws": {"load_angle": {}}}
    setup = build_experiment(tables, folder=tmp_path)
    assert setup.laws["load_angle"].share == gy.law("load_angle").share  # type: ignore[attr-defined]
    assert setup.foreign == ["load_angle"]
    assert "load_angle (for it: tuning = gamma5)" in setup.foreign_note and "mine.toml" in setup.foreign_note
    tables["laws"] = {"load_angle": {"tuning": "real-gamma5"}}  # one that ships
    assert build_experiment(tables, folder=tmp_path).foreign == ["load_angle"]


def test_every_command_takes_the_sets_of_a_device(tmp_path: Path, run: Run) -> None:
    """A set with a knob that the law does not have is refused, which tells that it was taken."""
    file, named = str(with_sets(tmp_path, knob="shear", gamma5=1.0)), ("--set", "tuning=gamma5")
    for command in (
        ("simulate", "--law", "load_angle", *named),
        ("margins", "--law", "load_angle", *named),
        ("bound", "--law", "load_angle tuning=gamma5", "--seeds", "1"),
    ):
        code, _, said = run(*command, "--device", file, "--out", str(tmp_path / "out"))
        assert code == 2 and "laws.load_angle.shear" in said and "another device" not in said, said


def test_law_from_python_takes_the_sets_beside_the_file(tmp_path: Path) -> None:
    file = with_sets(tmp_path, all=0.123, gamma5=0.2)
    law = gy.law("load_angle", device=file)
    assert law.share == 0.123 and law.J4 == 0.18355  # type: ignore[attr-defined]
    assert gy.law("load_angle", "gamma5", device=str(file)).share == 0.2  # type: ignore[attr-defined]
    assert gy.law("load_angle", device=file, share=0.3).share == 0.3  # type: ignore[attr-defined]
    shipped = gy.law("load_angle", device=gy.device(file))  # a plant alone knows of no file
    assert shipped.share == gy.law("load_angle").share  # type: ignore[attr-defined]


def test_evaluation_refuses_a_device_that_it_cannot_serve(tmp_path: Path, run: Run) -> None:
    file = tmp_path / "long.toml"
    file.write_text("length_scale = 4\nhydrodynamics_length = 4\n", encoding="utf-8")
    code, _, said = run("evaluate", "--device", file)
    assert code == 2 and "--device" in said and "compare" in said


@pytest.mark.parametrize("variant", ["corrected", "paper", "realistic"])
def test_new_device_at_a_length_is_that_of_a_file_which_says_no_more_than_the_length(
    variant: str, tmp_path: Path
) -> None:
    """What a variant adds to Table 1, damping of the hinge, friction, greatest torque, is at that length too."""
    asked = {"length_scale": 2.0, "hydrodynamics_length": 2.0}
    whole = gy.device(write_device(tmp_path / "whole.toml", new_device("mine", variant, **asked)))
    short = tmp_path / "short.toml"
    short.write_text(f'variant = "{variant}"\nlength_scale = 2.0\nhydrodynamics_length = 2.0\n', encoding="utf-8")
    assert whole.parameters == gy.device(short).parameters
    first = gy.zhang2017(variant).parameters
    assert whole.parameters.d1 == pytest.approx(first.d1 * 2**4.5)
    assert whole.parameters.bearing == pytest.approx(first.bearing * 2**4)


# --- the path of a device in place of a device ---------------------------------------------------------------------

WAVE = gy.Regular(0.2, 3.14)
WAVES = gy.realise(gy.zhang2017(), gy.SeaState(), 1, 60.0)

PATHS: list[tuple[str, Callable[[Any], Any]]] = [
    ("plant", lambda path: gy.check_law("coupling", path)),
    ("plant", lambda path: gy.find_yardstick(path, gy.SeaState())),
    ("plant", lambda path: gy.realise(path, gy.SeaState(), 1)),
    ("plant", lambda path: gy.simulate(path, "constant", WAVES)),
    ("plant", lambda path: gy.compare(path, {"a": "constant"}, [WAVES])),
    ("plant", lambda path: gy.scan(path, gy.SeaState(), [(0.052, 3.5e-4)], [1])),
    ("plant", lambda path: gy.margins(path, WAVE, 0.052, 3.5e-4)),
    ("plant", lambda path: gy.lock_orbit(path, WAVE, 0.052, 3.5e-4)),
    ("plant", lambda path: lock_map(path, WAVE)),
    ("plant", lambda path: tongue(path, WAVE, 0.052, 3.5e-4)),
    ("plant", lambda path: critical_damping(path, WAVE, 3.5e-4)),
]


@pytest.mark.parametrize("path", ["fly.toml", Path("fly.toml")])
@pytest.mark.parametrize(("field", "call"), PATHS, ids=[f"{i}-{field}" for i, (field, _) in enumerate(PATHS)])
def test_path_of_a_device_is_refused_with_how_it_is_read(field: str, call: Callable[[Any], Any], path: Any) -> None:
    with pytest.raises(gy.InputError, match=r'gyroctl\.device\("fly\.toml"\)') as caught:
        call(path)
    assert caught.value.field == field
