"""The wetted surface in the plant: refusals, ledger, identity of the waves, bits, and the reduced form against it."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import gyroctl as gy
from gyroctl.cli.app import app
from gyroctl.errors import InputError
from gyroctl.harness.run import Settings, lead_in, run_law
from gyroctl.hydrodynamics import load, save, shipped
from gyroctl.hydrodynamics.excitation import ExcitationTable
from gyroctl.hydrodynamics.floating import floating
from gyroctl.hydrodynamics.geometry import Geometry
from gyroctl.hydrodynamics.panels import capsule
from gyroctl.orbits import find_orbit
from gyroctl.plant.reduced import clipped, reduced, reduced_moments
from gyroctl.simulation.ensemble import run_ensemble
from gyroctl.waves.pressure import wetted_surface
from gyroctl.waves.wetted_fit import Drawn, draw, ends, fit_wetted, fitted

SEA = gy.SeaState()
PAIR = (0.052, 3.5e-4)


def without(**parts: Any) -> Any:
    """The shipped table without some of what it holds."""
    return dataclasses.replace(shipped(), **{name: None for name in parts})


@pytest.mark.parametrize("wetted", ["reduced", "surface"])
def test_choices_that_the_database_cannot_serve_are_refused(wetted: str) -> None:
    with pytest.raises(InputError, match="geometry"):
        gy.zhang2017(hydrodynamics=without(hull=0), wetted=wetted)
    with pytest.raises(InputError, match="Froude-Krylov and diffraction apart"):
        gy.zhang2017(hydrodynamics=without(diffraction=0), wetted=wetted)
    with pytest.raises(InputError, match="phases"):
        gy.zhang2017("paper", wetted=wetted)


def test_reduced_needs_a_fit_and_surface_does_not() -> None:
    with pytest.raises(InputError, match="fit for this float"):
        gy.zhang2017(hydrodynamics=without(wetted=0), wetted="reduced")
    plant = gy.zhang2017(hydrodynamics=without(wetted=0), wetted="surface")
    assert plant.smooth.parameters.wetted == "linear"
    assert gy.zhang2017(wetted="surface").smooth.parameters.wetted == "reduced"


def test_a_surface_cannot_be_differentiated_and_says_so() -> None:
    plant = gy.zhang2017(wetted="surface")
    with pytest.raises(InputError, match="cannot be differentiated"):
        find_orbit(plant, gy.Regular(height=0.2, wp=3.14), *PAIR)
    with pytest.raises(InputError, match="known to a run alone"):
        plant.derivative(np.zeros(len(plant.labels)), PAIR, (0.0, 0.0, 0.0))


def test_waves_are_the_same_whatever_the_surface() -> None:
    plants = [gy.zhang2017(wetted=choice) for choice in ("linear", "reduced", "surface")]
    waves = [gy.realise(plant, SEA, 3, 60.0) for plant in plants]
    assert len({w.sha256 for w in waves}) == 1
    for plant, w in zip(plants, waves, strict=True):
        np.testing.assert_array_equal(w.moments, waves[0].moments)
        np.testing.assert_array_equal(w.signals(plant)[:2], waves[0].moments)
    assert waves[0].held(plants[0]) is None and waves[0].held(plants[1]) is None


@pytest.mark.parametrize("choices", [{"wetted": "reduced"}, {"wetted": "surface"}, {"wetted": "surface", "drag": 0.5}])
def test_ledger_closes_and_counts_what_the_surface_brings_in(choices: dict[str, Any]) -> None:
    plant, settings = gy.zhang2017(**choices), Settings(blend=20.0)
    waves = gy.realise(plant, SEA, 3, 120.0)
    ds = gy.compare(plant, {"constant": gy.law("constant", cc=PAIR[0], cg=PAIR[1])}, [waves], settings, quiet=True)
    assert float(ds.ledger_residual.squeeze()) < 1e-6
    record, _ = run_law(plant, gy.law("constant", cc=PAIR[0], cg=PAIR[1]), lead_in(waves, settings), settings)
    second = record.states[-1, len(plant.labels) + plant.ledger.index("second_order")]
    assert abs(second) > 1.0  # J: it does something


@pytest.mark.parametrize("choice", ["reduced", "surface"])
def test_small_waves_leave_the_linear_plant(choice: str) -> None:
    """What the surface changes is of second order: it falls with the height of the waves relative to the motion."""
    settings, start, gaps = Settings(blend=10.0, start="rest"), np.zeros(len(gy.zhang2017().labels)), []
    for hs in (0.01, 0.002):
        motions = []
        for wetted in ("linear", choice):
            plant = gy.zhang2017(wetted=wetted)
            waves = gy.realise(plant, gy.SeaState(hs=hs), 3, 40.0)
            record, _ = run_law(plant, gy.law("constant", cc=0.0, cg=0.0), waves, settings, start=start)
            motions.append(record.states[:, :2])
        gaps.append(np.std(motions[1] - motions[0], axis=0) / np.std(motions[0], axis=0))
    assert np.all(gaps[1] < 0.03)
    assert np.all(gaps[1] < 0.3 * gaps[0])


@pytest.mark.slow
@pytest.mark.parametrize("choices", [{"wetted": "reduced"}, {"wetted": "surface"}])
def test_a_run_has_the_same_bits_alone_and_in_company(choices: dict[str, Any]) -> None:
    plant = gy.zhang2017(**choices)
    start = np.zeros(len(plant.labels))
    start[6], start[7] = 3.14, 70.0
    args: dict[str, Any] = {"start": start, "duration": 40.0, "blend": 10.0, "workers": 1, "quiet": True}
    company = run_ensemble(plant, SEA, [PAIR, (0.06, 2e-4)], [5, 6, 7], **args)
    alone = run_ensemble(plant, SEA, [PAIR], [6], **args)
    for name in ("mean_power", "phi1_p98", "phi3_p98", "wave_input_w"):
        assert getattr(alone, name)[0, 0] == getattr(company, name)[0, 1]


def test_reduced_is_smooth_and_linear_at_rest() -> None:
    fit = shipped().wetted
    assert fit is not None
    r = reduced(fit, False)
    assert clipped(r, 0.0) == 0.0
    assert np.imag(clipped(r, 1e-30j)) / 1e-30 == pytest.approx(1.0, rel=1e-12)
    x = np.linspace(-0.6, 0.6, 241)
    inside = clipped(r, x)
    assert np.all(np.diff(inside) > 0.0)
    assert inside[0] == pytest.approx(fit.low, rel=0.01) and inside[-1] == pytest.approx(fit.high, rel=0.01)
    # a dry float: nothing of the waves is left, and the weight is no longer carried
    one, three = reduced_moments(r, 0.5, 50.0, 100.0)
    assert abs(50.0 + one) < 0.1 * 50.0
    surface = wetted_surface(capsule(Geometry()), 0.7)
    assert -fit.stiffness * 0.5 + 100.0 + three == pytest.approx(-surface.still, rel=0.05)


def test_fit_finds_the_polynomials_that_made_its_data() -> None:
    fit = shipped().wetted
    assert fit is not None
    rng = np.random.default_rng(1)
    linear, x = rng.normal(0.0, [[50.0], [150.0]], (2, 4000)), rng.normal(0.0, 0.1, 4000)
    phi3 = x + linear[1] / fit.stiffness
    added = np.stack(reduced_moments(reduced(fit, False), phi3, linear[0], linear[1]))
    again = fitted(Drawn(linear, phi3, added), fit.low, fit.high, fit.soft, fit.stiffness)
    assert again.moment1 == pytest.approx(fit.moment1, rel=1e-6)
    assert again.moment3 == pytest.approx(fit.moment3, rel=1e-6)
    assert max(again.error1, again.error3) < 1e-9


def test_shipped_fit_holds_on_instants_it_has_not_seen() -> None:
    hydro = shipped()
    fit = hydro.wetted
    assert fit is not None and hydro.hull is not None
    assert ends(hydro.hull) == pytest.approx((fit.low, fit.high))
    surface = wetted_surface(hydro.hull, 0.7)
    fresh = draw(surface, SEA, 0.1, np.random.default_rng(77))
    found = np.stack(reduced_moments(reduced(fit, False), fresh.phi3, fresh.linear[0], fresh.linear[1]))
    miss = np.sqrt(np.mean((found - fresh.added) ** 2, axis=1) / np.mean(fresh.added**2, axis=1))
    assert miss == pytest.approx([fit.error1, fit.error3], rel=0.35)
    assert np.all(miss < 0.2)


@pytest.mark.slow
def test_any_float_can_be_fitted_and_its_error_is_told(tmp_path: Path) -> None:
    """A sphere on a horizontal lever, half as large, in deep water: from the command line."""
    ball = capsule(Geometry(diameter=0.3, cylinder=0.0, inclination=0.0, arm=0.6, moment=4.0), None, 16, 8)
    path = save(without(wetted=0), tmp_path / "ball.nc")
    save(dataclasses.replace(load(path), hull=ball, depth=float("inf")), path)
    answer = CliRunner().invoke(app, ["hydro", "fit-wetted", str(path)])
    assert answer.exit_code == 0 and "misses" in answer.output
    fit = load(path).wetted
    assert fit is not None and fit == fit_wetted(load(path)).wetted
    assert 0.0 < fit.error1 < 0.4 and 0.0 < fit.error3 < 0.3
    assert fit.low == pytest.approx(-np.arcsin((0.15 + ball.hinge[2]) / 0.6), abs=0.02)
    with pytest.raises(InputError, match="geometry"):
        fit_wetted(without(hull=0))


def test_float_is_equal_by_its_numbers() -> None:
    one, two = floating(shipped()), floating(dataclasses.replace(shipped()))
    assert one == two and hash(one) == hash(two) and one is not None
    assert isinstance(one.undisturbed, ExcitationTable)
    assert one != dataclasses.replace(one, rho=1025.0)


@pytest.mark.slow
def test_reduced_runs_as_the_surface_does() -> None:
    """At rest position with drag: mean power within 5 %, 98 % of phi1 within 20 %, over sixteen realisations."""
    means = {}
    for choice in ("reduced", "surface"):
        plant = gy.zhang2017(wetted=choice, drag=0.5)
        waves = [gy.realise(plant, SEA, seed, 600.0) for seed in range(1, 17)]
        best = gy.law("constant", cc=0.052, cg=5e-4)  # the best pair there
        laws = {"constant": best, "load_angle": gy.law("load_angle")}
        ds = gy.compare(plant, laws, waves, quiet=True)
        means[choice] = {name: ds[name].mean("realisation").values for name in ("mean_power", "phi1_p98")}
    np.testing.assert_allclose(means["reduced"]["mean_power"], means["surface"]["mean_power"], rtol=0.05)
    np.testing.assert_allclose(means["reduced"]["phi1_p98"], means["surface"]["phi1_p98"], rtol=0.2)


@pytest.mark.parametrize("position", ["rest", "moving"])
def test_one_text_serves_numpy_casadi_and_complex_step(position: str) -> None:
    plant = gy.zhang2017(wetted="reduced", position=position, drag=0.5)
    rng = np.random.default_rng(5)
    x = np.concatenate([[0.2, -0.15, 1.0, 0.0, 0.3, -0.4, 3.2, 70.0], 0.1 * rng.standard_normal(len(plant.labels) - 8)])
    moments = 50.0 * rng.standard_normal(len(plant.channels))
    slope = plant.derivative(x, PAIR, moments)
    symbolic = np.array(plant.casadi()(x, PAIR, plant.near(x, moments)).full()).ravel()
    assert symbolic == pytest.approx(slope, rel=1e-12, abs=1e-9)
    A, B = plant.jacobians(x, PAIR, moments)
    step = 1e-6
    for column in (0, 1):
        shift = step * (np.arange(len(x)) == column)
        centred = (plant.derivative(x + shift, PAIR, moments) - plant.derivative(x - shift, PAIR, moments)) / (2 * step)
        assert A[:, column] == pytest.approx(centred, rel=1e-5, abs=1e-5)
    assert np.all(np.isfinite(B))


def test_reduced_terms_are_the_printed_polynomials() -> None:
    """R1 and R3 act on phi1 and phi3 through the inertia; their power is the row second_order."""
    fit, x = shipped().wetted, np.zeros(len(gy.zhang2017().labels))
    assert fit is not None
    x[1], x[4], x[5] = 0.1, 0.2, -0.3
    f1, f3 = 40.0, 200.0
    more = gy.zhang2017(wetted="reduced").powers(x, PAIR, (0.0, 0.0, f1, f3))["second_order"]
    immersion = clipped(reduced(fit, False), 0.1 - f3 / fit.stiffness)
    one = f1 * sum(a * immersion ** (i + 1) for i, a in enumerate(fit.moment1))
    three = sum(a * immersion ** (i + 2) for i, a in enumerate(fit.moment3)) + immersion - (0.1 - f3 / fit.stiffness)
    assert more == pytest.approx(0.2 * one + 0.3 * fit.stiffness * three, rel=1e-12)
