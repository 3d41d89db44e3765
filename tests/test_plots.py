"""Pictures that objects draw of themselves: what they show, in which units, in whose colour."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from test_faces import comparison, trajectory

import gyroctl as gy
from gyroctl.linearisation.averaged import AveragedModel
from gyroctl.palette import law_styles

UNIT = re.compile(r"\[[^\]]+\]$")


@pytest.fixture(scope="module")
def orbit(device: gy.Plant) -> gy.PeriodicOrbit:
    return gy.lock_orbit(device, gy.Regular(0.2, 3.14), 0.052, 3.5e-4)


@pytest.fixture(scope="module")
def averaged(orbit: gy.PeriodicOrbit) -> AveragedModel:
    return orbit.linearise().averaged()


def lines(axes: Any) -> list[Any]:
    return [line for line in axes.lines if len(line.get_xdata()) > 2]


def test_every_axis_has_its_unit(orbit: gy.PeriodicOrbit, averaged: AveragedModel) -> None:
    for figure in (orbit.plot(), averaged.bode(), trajectory().plot()):
        for axes in figure.axes:
            assert UNIT.search(axes.get_ylabel()), axes.get_ylabel()
        assert any(UNIT.search(axes.get_xlabel()) for axes in figure.axes)
        assert figure.get_suptitle() and figure.get_supxlabel()
    for axes in comparison().plot().axes:
        assert UNIT.search(axes.get_xlabel())


def test_orbit_shows_ring_float_and_multipliers(orbit: gy.PeriodicOrbit) -> None:
    ring, body, circle = orbit.plot().axes
    speed = lines(ring)[0].get_ydata()
    assert np.mean(speed[:-1]) == pytest.approx(3.14, rel=1e-4)  # a turn of the ring to a wave
    assert speed[0] == speed[-1]
    phi3 = lines(body)[1].get_ydata()
    row = orbit.plant.labels.index("phi3")
    assert np.max(phi3) == pytest.approx(np.max(orbit.states(96)[:, row]))
    drawn = np.concatenate([line.get_xdata() + 1j * line.get_ydata() for line in circle.lines[1:]])
    for multiplier in orbit.multipliers:
        assert np.min(np.abs(drawn - multiplier)) < 1e-6  # by the half map and by modes


def test_bode_plot_shows_the_response_of_the_model(averaged: AveragedModel) -> None:
    figure = averaged.bode(inputs=["cg"], outputs=["psi"])
    magnitude, phase = figure.axes
    curve = magnitude.lines[0]
    omega = curve.get_xdata()
    i, j = averaged.outputs.index("psi"), averaged.inputs.index("cg")
    exact = averaged.response(omega)[:, i, j]
    np.testing.assert_allclose(curve.get_ydata(), np.abs(exact))
    system = averaged.to_control()
    np.testing.assert_allclose(exact, [system(1j * w)[i, j] for w in omega], rtol=1e-9)
    shown = phase.lines[0].get_ydata()
    assert np.max(np.abs(np.diff(shown))) < 90.0, "no jumps"
    np.testing.assert_allclose(np.exp(1j * np.radians(shown)), exact / np.abs(exact), atol=1e-9)
    assert omega[0] < 0.1 * np.min(np.abs(averaged.poles)) and omega[-1] == pytest.approx(1.57)
    assert magnitude.get_ylabel() == "[rad per Nms]"


def test_bode_plot_by_default_is_small_and_shades_what_does_not_hold(averaged: AveragedModel) -> None:
    assert len(averaged.bode().axes) == 8  # cc and cg to psi and power, magnitude and phase
    omega = np.geomspace(0.01, 4.0, 50)
    shaded = averaged.bode(inputs=["cg"], outputs=["psi"], omega=omega).axes[0].patches
    assert shaded and shaded[0].get_x() == pytest.approx(averaged.valid_frequency)


@pytest.mark.parametrize(
    ("field", "choices"),
    [("inputs", {"inputs": ["speed"]}), ("outputs", {"outputs": []}), ("omega", {"omega": np.array([1.0, 0.5])})],
)
def test_bode_plot_refuses_what_it_does_not_have(averaged: AveragedModel, field: str, choices: Any) -> None:
    with pytest.raises(gy.InputError) as caught:
        averaged.bode(**choices)
    assert caught.value.field == field


def test_run_is_drawn_between_two_times_in_the_colour_of_its_law() -> None:
    power = trajectory().plot(10.0, 20.0).axes[-1].lines[0]
    assert power.get_xdata()[0] == pytest.approx(10.0) and power.get_xdata()[-1] == pytest.approx(20.0)
    assert power.get_color() == law_styles(["coupling"])["coupling"].colour
    with pytest.raises(gy.InputError) as caught:
        trajectory().plot(100.0, 200.0)
    assert caught.value.field == "begin"


def test_comparison_shows_each_run_and_the_mean_in_the_colour_of_each_law() -> None:
    ds = comparison()
    power, _, _, lock = ds.plot().axes
    looks = law_styles([str(name) for name in ds.law.values])
    for row, name in enumerate(str(law) for law in ds.law.values):
        dots, mean = power.lines[2 * row], power.lines[2 * row + 1]
        np.testing.assert_allclose(np.sort(dots.get_xdata()), np.sort(ds.mean_power.sel(law=name).values))
        assert mean.get_xdata()[0] == pytest.approx(float(ds.mean_power.sel(law=name).mean()))
        assert dots.get_color() == looks[name].colour
        assert lock.patches[row].get_width() == pytest.approx(100.0 * float(ds.locked.sel(law=name).mean()))
    assert [text.get_text() for text in power.get_yticklabels()] == [str(name) for name in ds.law.values]


def test_formulas_in_names_stay_text() -> None:
    figure = comparison(("$\\frac{1}{2}", "a$b$")).plot()
    assert figure._repr_png_()[:4] == b"\x89PNG"


def test_what_was_read_from_a_file_is_drawn_by_the_accessor(tmp_path: Path) -> None:
    for name, ds in (("run.nc", trajectory()), ("results.nc", comparison())):
        ds.to_netcdf(tmp_path / name, engine="scipy")
        with xr.open_dataset(tmp_path / name, engine="scipy") as read:
            assert type(read) is xr.Dataset
            assert len(read.gyroctl.plot().axes) == len(ds.plot().axes)
    with pytest.raises(gy.InputError) as caught:
        xr.Dataset({"a": 1.0}).gyroctl.plot()
    assert caught.value.field == "dataset"


def test_plots_of_xarray_are_still_there() -> None:
    assert trajectory().plot.scatter is not None
    with pytest.raises(gy.InputError, match="not in it"):
        trajectory()[["cc"]].plot()


def test_no_orbit_is_not_drawn(device: gy.Plant) -> None:
    none = gy.lock_orbit(device, gy.Regular(0.05, 3.14), 0.052, 4e-3, nearest=False)
    assert none.status == "no orbit"
    with pytest.raises(gy.InputError) as caught:
        none.plot()
    assert caught.value.field == "orbit"
