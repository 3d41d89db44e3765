"""Tuning on a device of one's own: the task at its length, laws with its numbers, the yardstick in its units."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from command_line import Run
from small_task import SMALL

import gyroctl as gy
from gyroctl.cli.tune import circumstances
from gyroctl.devices.file import new_device, write_device
from gyroctl.devices.identity import identity
from gyroctl.devices.scaling import scaled_plant
from gyroctl.harness.for_device import belongs, design_in
from gyroctl.harness.registry import tuned_sets
from gyroctl.harness.yardstick import BASELINE, with_yardstick
from gyroctl.tuning.best_pair import KNOWN, Lengths, first_grid
from gyroctl.tuning.record import plant_hash, provenance
from gyroctl.tuning.task import build_task, tasked
from gyroctl.tuning.waters import on_device
from gyroctl.tuning.yardstick import unsearched

LENGTH = 16.0
UNIT = LENGTH**4.5


@pytest.fixture(scope="module")
def big() -> gy.Plant:
    """The device of the paper, sixteen times as long."""
    return scaled_plant(gy.zhang2017(), LENGTH)


def test_task_is_in_the_units_of_the_device() -> None:
    task = build_task(SMALL)
    large = task.at_length(LENGTH)
    assert task.at_length(1.0) is task and large.knobs == task.knobs and large.goals == task.goals
    for name, one in task.seas.items():
        other = large.seas[name]
        assert other.sea.hs == LENGTH * one.sea.hs and other.sea.wp == one.sea.wp / 4.0
        assert other.power == one.power * LENGTH**3.5 and other.runs == one.runs
    assert large.search.window == 4.0 * task.search.window and large.search.dt == 4.0 * task.search.dt
    assert large.search.confirm == 4.0 * task.search.confirm


def test_all_laws_with_a_task_can_be_tuned_at_once() -> None:
    assert {"constant", "load_angle", "coupling", "nmpc"} <= set(tasked()) and "best_constant" not in tasked()


def test_circumstances_of_a_device_are_in_its_units(big: gy.Plant) -> None:
    on = on_device(big, "linear")
    assert on.device is big and on.settings.dt == pytest.approx(0.04)
    assert on.settings.actuators.cc_max == pytest.approx(0.3 * UNIT)
    assert on.settings.actuators.period == pytest.approx(0.4)
    assert on.settings.sensors.psi_rate.noise == pytest.approx(0.02 / 4.0)
    assert on.settings.sensors.phi1 == gy.Sensors().phi1
    real = on_device(gy.zhang2017("realistic"), "real")
    assert real.plant.parameters.wetted == "reduced" and real.settings.actuators.cc_lag == 0.02
    with pytest.raises(gy.InputError, match="--water"):
        on_device(big, "deep")


def test_settings_out_of_bounds_are_refused_by_the_size_of_the_device(big: gy.Plant) -> None:
    actuators = gy.Actuators(cc_max=20.0, length=LENGTH)
    with pytest.raises(gy.InputError, match=r"actuators\.cc_max"):
        gy.Actuators(cc_max=20.0)
    actuators.fit(LENGTH)
    with pytest.raises(gy.InputError, match=r"actuators\.cc_max"):
        actuators.fit(1.0)
    waves = gy.realise(gy.zhang2017(), gy.SeaState(), 1, 20.0)
    with pytest.raises(gy.InputError, match=r"actuators\.cc_max"):
        gy.simulate(gy.zhang2017(), "constant", waves, gy.Settings(blend=0.0, actuators=actuators))


def test_pairs_of_a_search_are_as_large_as_the_device(big: gy.Plant) -> None:
    settings = gy.Settings()
    usual, large = first_grid(settings), first_grid(settings.at(LENGTH), unit=UNIT)
    np.testing.assert_allclose(np.array(large), UNIT * np.array(usual), rtol=1e-12)
    assert Lengths(0.025, 1000.0, 2000.0).at(LENGTH) == (0.1, 4000.0, 8000.0) and len(KNOWN) == 3
    pair = unsearched(gy.SeaState(0.283 * LENGTH, 3.14 / 4.0), "no search was wanted", big)
    usual_pair = unsearched(gy.SeaState(), "no search was wanted")
    assert pair.cc == pytest.approx(UNIT * usual_pair.cc) and pair.cg == pytest.approx(UNIT * usual_pair.cg)
    laws, _ = with_yardstick({BASELINE: gy.law(BASELINE, device=big)}, pair, LENGTH)
    assert laws[BASELINE].period == pytest.approx(0.4) and laws[BASELINE].cc == pair.cc  # type: ignore[attr-defined]
    with pytest.raises(gy.InputError, match="yardstick"):
        with_yardstick({BASELINE: gy.law("constant", device=big, cc=1.0, cg=1.0)}, None, LENGTH)


def test_sets_tell_the_device_they_were_found_on(big: gy.Plant) -> None:
    half = gy.zhang2017(J14=0.18355)
    found = provenance(build_task(SMALL), on_device(half, "linear"))
    assert found["device_sha256"] == identity(half) and found["plant_sha256"] == plant_hash(half)
    assert belongs(found, half) and not belongs(found, big) and not belongs(found, gy.zhang2017())
    for entry in tuned_sets("load_angle").values():
        assert belongs(entry["found"], gy.zhang2017("realistic")) and not belongs(entry["found"], half)


def test_laws_are_given_the_numbers_of_the_device(big: gy.Plant) -> None:
    half = gy.zhang2017(J14=0.18355, r2=0.21)
    for name in ("load_angle", "coupling", "threshold"):
        law = gy.law(name, device=half)
        assert law.J4 == 0.18355 and law.N == half.parameters.N, name  # type: ignore[attr-defined]
    assert gy.law("load_angle", device=half, J4=0.3).J4 == 0.3  # type: ignore[attr-defined]
    assert gy.law("load_angle", device=gy.zhang2017("realistic")) == gy.law("load_angle")
    assert gy.law("nmpc", device=half).plant.parameters.J14 == 0.18355  # type: ignore[attr-defined]
    within = gy.law("supervisor", device=half).law  # type: ignore[attr-defined]
    assert within.J4 == 0.18355
    model = gy.law("nmpc", device=big).law.plant.parameters  # type: ignore[attr-defined]
    assert model.J14 == pytest.approx(0.3671) and model.length_scale == pytest.approx(1.0)


def test_design_model_in_real_water_is_that_of_the_device() -> None:
    half = gy.zhang2017(J14=0.18355)
    design = design_in(half, {"variant": "realistic", "wetted": "reduced", "d1": 3.0}).parameters
    assert design.J14 == 0.18355 and design.d1 == 3.0 and design.contact == "friction" and design.wetted == "reduced"
    with pytest.raises(gy.InputError):
        design_in(half, "imaginary")


def test_tuning_for_a_device_is_not_shipped(tmp_path: Path, run: Run) -> None:
    file = write_device(tmp_path / "mine.toml", new_device("mine", J14=0.18355))
    study = tmp_path / "study.toml"
    study.write_text('[plant]\ndevice = "mine.toml"\n')
    for given in (("--device", file), ("--experiment", study)):
        code, _, said = run("tune", "load_angle", *given, "--ship")
        assert code == 2 and "--ship" in said and "mine.tuned" in said
    code, _, said = run("tune", "load_angle", "--device", file, "--experiment", study)
    assert code == 2 and "--experiment" in said and "[plant]" in said
    assert not (tmp_path / "mine.tuned").exists()


def test_experiment_beside_a_device_gives_its_actuators(tmp_path: Path) -> None:
    file = write_device(tmp_path / "mine.toml", new_device("mine", J14=0.18355))
    study = tmp_path / "study.toml"
    study.write_text("[actuators]\ncg_max = 0.004\n[run]\nseeds = [100007]\n")
    on, kept_at = circumstances(study, device=file)
    assert kept_at == file and on.settings.actuators.cg_max == 0.004 and on.evaluation == {100007}
    assert on.device is not None and on.device.parameters.J14 == 0.18355
    study.write_text('[plant]\ndevice = "mine.toml"\n[actuators]\ncg_max = 0.004\n')
    same, beside = circumstances(study)
    assert beside == file and same.own and same.settings == on.settings
    assert identity(same.plant) == identity(on.plant)
    study.write_text("[actuators]\ncg_max = 0.004\n")
    assert circumstances(study)[1] is None and not circumstances(study)[0].own


def test_sets_go_beside_the_device_that_an_experiment_names(tmp_path: Path, run: Run) -> None:
    """Also printed: the numbers that were found, and what of the goal they miss."""
    write_device(tmp_path / "mine.toml", new_device("mine", J14=0.18355))
    study, task = tmp_path / "study.toml", tmp_path / "task.toml"
    study.write_text('[plant]\ndevice = "mine.toml"\n')
    task.write_text(
        'law = "load_angle"\n[knobs]\nshare = {start = 0.4, width = 0.1}\n[seas.mild]\nhs = 0.25\ngamma = 5.0\n'
        "power = 2.0\nruns = 1\n[search]\npopulation = 4\nwindow = 160.0\nconfirm = 200.0\nruns = 1\n"
        "[seeds]\nfirst = 100128\ncount = 2\n[goal]\nturns = 0.999\nmotion = 0.001\n"
    )
    out = ("--out", tmp_path / "out", "--budget", "3000", "--for", "mild")
    code, said, error = run("tune", task, "--experiment", study, *out)
    assert code == 0, error
    assert "mine.tuned" in said and "share = " in said and "98 % motion of phi1" in said and "at most 0.001" in said
    kept = json.loads((tmp_path / "mine.tuned" / "load_angle.json").read_text())["sets"]["mild"]
    assert belongs(kept["found"], gy.device(tmp_path / "mine.toml"))
