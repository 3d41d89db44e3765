"""The compiled kernel against an independent integrator, plain sums of cosines, and itself in any company."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

import gyroctl as gy
from gyroctl.harness.run import run_law
from gyroctl.harness.start import locked_start
from gyroctl.plant import kernel
from gyroctl.plant.compiled import source_stamp
from gyroctl.plant.equations import LEDGER
from gyroctl.plant.kernel import hold_one, interpolate, slip_rate, steps_for
from gyroctl.simulation import EnsembleRun, evaluate, run_ensemble

Array = NDArray[np.float64]
PAIRS = [(0.052, 3.5e-4), (0.052, 1e-3), (0.2, 5e-4), (0.0, 0.0)]
SEA = gy.SeaState()


# --- the integrator ----------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def segment(device: gy.Plant) -> tuple[Array, Array, float, Array]:
    """Start, wave grid, spacing, and the exact end of one period of a regular wave of 0.1 m by scipy's DOP853."""
    from scipy.integrate import solve_ivp

    wp, cc, cg = 3.14, 0.02, 3.5e-4
    period = 2 * np.pi / wp
    amplitude = 0.1 * device.excitation(np.array([wp]))[:, 0]
    dt = period / 128
    grid = np.arange(-8, 128 + 9) * dt
    waves = np.ascontiguousarray(np.real(np.exp(1j * wp * grid)[:, None] * amplitude)).ravel()
    start = np.array([0.02, 0.1, 5.0, 0.0, 0.1, -0.2, 3.3, 69.0, 1e-4, 2e-4, -1e-3, 3e-3, 1e-3, -2e-2])

    def rate(t: float, y: Array) -> Array:
        moments = np.real(np.exp(1j * wp * t) * amplitude)
        powers = device.powers(y[:14], (cc, cg), moments)
        return np.array([*device.derivative(y[:14], (cc, cg), moments), *powers.values()])

    whole = solve_ivp(rate, (0.0, period), [*start, *np.zeros(5)], "DOP853", rtol=1e-13, atol=1e-13)
    return start, waves, dt, whole.y[:, -1]


def errors(device: gy.Plant, segment: tuple[Array, Array, float, Array], steps: int) -> Array:
    start, waves, dt, exact = segment
    y = np.concatenate([start, np.zeros(len(LEDGER))])
    end = hold_one(y, device.coefficients, 0.02, 3.5e-4, 8 * dt, 128 * dt, steps, waves, dt)
    return np.abs(end - exact) / np.maximum(np.abs(exact), 1e-2)


def test_runge_kutta_converges_with_the_fourth_power(
    device: gy.Plant, segment: tuple[Array, Array, float, Array]
) -> None:
    """Against DOP853 at 1e-13, state and ledger alike; halving the step divides the error by sixteen."""
    coarse, middle, fine = (float(np.max(errors(device, segment, n))) for n in (100, 200, 400))
    assert coarse / middle == pytest.approx(16.0, rel=0.2)
    assert middle / fine == pytest.approx(16.0, rel=0.2)
    assert fine < 1e-7


def test_default_step_is_accurate_to_1e_7_over_a_wave(
    device: gy.Plant, segment: tuple[Array, Array, float, Array]
) -> None:
    assert np.max(errors(device, segment, 201)) < 5e-7


def test_held_intervals_join_without_a_seam(device: gy.Plant, segment: tuple[Array, Array, float, Array]) -> None:
    """Four quarters with the step of the whole are the whole, to rounding."""
    start, waves, dt, _ = segment
    y = np.concatenate([start, np.zeros(len(LEDGER))])
    whole = hold_one(y, device.coefficients, 0.02, 3.5e-4, 8 * dt, 128 * dt, 400, waves, dt)
    for quarter in range(4):
        begin = (8 + 32 * quarter) * dt
        y = hold_one(y, device.coefficients, 0.02, 3.5e-4, begin, 32 * dt, 100, waves, dt)
    np.testing.assert_allclose(y, whole, rtol=1e-11, atol=1e-12)


def test_complex_step_through_the_kernel_is_the_derivative_of_its_map(
    device: gy.Plant, segment: tuple[Array, Array, float, Array]
) -> None:
    """By the reversed road: the map of a perturbed start differs by the Jacobian times the perturbation."""
    start, waves, dt, _ = segment
    y = np.concatenate([start, np.zeros(len(LEDGER))])
    rng = np.random.default_rng(0)
    direction = np.concatenate([rng.standard_normal(14), np.zeros(5)])

    def flow(x: Any) -> Any:
        cc, cg = (complex(0.02), complex(3.5e-4)) if x.dtype == complex else (0.02, 3.5e-4)
        return hold_one(x, device.coefficients, cc, cg, 8 * dt, 64 * dt, 200, waves, dt)

    exact = flow(y + 1e-30j * direction).imag / 1e-30
    # Richardson's extrapolation of central differences as a coarse oracle
    central = [(flow(y + e * direction) - flow(y - e * direction)) / (2 * e) for e in (1e-3, 5e-4)]
    np.testing.assert_allclose(exact, (4 * central[1] - central[0]) / 3, rtol=1e-5, atol=1e-6)


# --- step count --------------------------------------------------------------------------------------------------


def test_number_of_steps_keeps_both_bounds(device: gy.Plant) -> None:
    rate = float(slip_rate(device.coefficients, 0.3))
    assert steps_for(0.1, 0.01, 0.0) == 10
    assert steps_for(0.1, 0.025, 0.0) == 4
    assert steps_for(0.1, 0.03, 0.0) == 4
    assert steps_for(0.1, 1.0, 0.0) == 1
    for cc in np.linspace(0.0, 0.3, 50):
        for dt in (0.005, 0.01):
            h = 0.1 / steps_for(0.1, dt, rate / 0.3 * cc)
            assert h <= dt * (1 + 1e-9)
            assert h * 683 * cc <= 0.51


# --- interpolation -----------------------------------------------------------------------------------------------


def test_interpolated_moments_are_the_sum_of_cosines(device: gy.Plant) -> None:
    """DESIGN: 1.6e-7 of the standard deviation between the samples of a JONSWAP sea on the 0.05 s grid."""
    from gyroctl.waves import prepare

    synthesis = prepare(device, SEA, 400.0, 0.05)
    moments = synthesis.moments(3)
    waves = np.ascontiguousarray(moments.T).ravel()
    rng = np.random.default_rng(1)
    position = np.concatenate([rng.uniform(8, 7990, 400), np.arange(100, 110) + 0.5])
    out, weight = np.empty(2 * position.size), np.empty(8)
    for i, at in enumerate(position):
        interpolate(waves, 1, float(at), weight, out, i)
    found = out.reshape(-1, 2).T

    turned = synthesis.response * np.exp(1j * synthesis.phases(3))
    omega = synthesis.waves.omega
    exact = np.array([np.real(turned @ np.exp(1j * omega * at * 0.05)) for at in position]).T
    error = np.abs(found - exact) / np.std(moments, axis=1, keepdims=True)
    assert np.max(error) < 2e-6
    assert np.sqrt(np.mean(error**2)) < 3e-7


def test_interpolation_keeps_the_samples_and_polynomials_of_seventh_degree() -> None:
    """Also at both ends of the record, where the eight samples lie on one side."""
    polynomials = [np.polynomial.Polynomial(c) for c in np.random.default_rng(2).standard_normal((2, 8))]
    grid = np.arange(40)
    waves = np.stack([p(grid / 40.0) for p in polynomials], axis=1).ravel()
    out, weight = np.empty(2), np.empty(8)
    for position in (0.0, 0.3, 2.9, 3.0, 17.37, 20.0, 36.2, 38.99, 39.0):
        interpolate(waves, 1, position, weight, out, 0)
        np.testing.assert_allclose(out, [p(position / 40.0) for p in polynomials], rtol=1e-9, atol=1e-10)
    interpolate(waves, 1, 11.0, weight, out, 0)
    np.testing.assert_allclose(out, waves[22:24], rtol=1e-14)


# --- lanes -------------------------------------------------------------------------------------------------------


def ensemble(device: gy.Plant, pairs: list[tuple[float, float]], seeds: list[int], workers: int = 1) -> EnsembleRun:
    start, _ = locked_start(device, SEA)
    return run_ensemble(device, SEA, pairs, seeds, start, 200.0, 50.0, workers=workers, quiet=True)


def bits(run: EnsembleRun) -> NDArray[Any]:
    """All results of an ensemble, (quantity, pair, seed), as bit patterns: NaN compares equal to itself."""
    return np.array([getattr(run, name) for name in EnsembleRun.__dataclass_fields__]).view(np.int64)


@pytest.fixture(scope="module")
def whole(device: gy.Plant) -> NDArray[Any]:
    return bits(ensemble(device, PAIRS, list(range(1, 8))))


def test_ensemble_has_something_to_compare(whole: NDArray[Any]) -> None:
    assert len(np.unique(whole[4])) == whole[4].size  # no two runs are alike


def test_a_run_has_the_same_bits_alone(device: gy.Plant, whole: NDArray[Any]) -> None:
    for pair, seed in ((0, 3), (2, 6), (3, 0)):
        alone = bits(ensemble(device, [PAIRS[pair]], [seed + 1]))
        np.testing.assert_array_equal(alone[:, 0, 0], whole[:, pair, seed])


def test_order_and_company_change_no_bit(device: gy.Plant, whole: NDArray[Any]) -> None:
    pairs, seeds = [2, 0, 3, 1], [6, 2, 0, 4]
    other = bits(ensemble(device, [PAIRS[p] for p in pairs], [s + 1 for s in seeds]))
    np.testing.assert_array_equal(other, whole[:, pairs][:, :, seeds])


def test_number_of_workers_changes_no_bit(device: gy.Plant, whole: NDArray[Any]) -> None:
    np.testing.assert_array_equal(bits(ensemble(device, PAIRS, list(range(1, 8)), workers=2)), whole)


def test_ensemble_is_the_closed_loop_with_a_constant_law(device: gy.Plant) -> None:
    """Sixteen lanes and the single run share one text: the same motion to the last bit, the same metrics."""
    run = ensemble(device, PAIRS[:2], [5])
    waves = gy.realise(device, SEA, 5, 200.0).blended(50.0)
    for index, (cc, cg) in enumerate(PAIRS[:2]):
        record, _ = run_law(device, gy.law("constant", cc=cc, cg=cg), waves, gy.Settings(blend=50.0))
        values = evaluate(device, record, waves.moments[1], waves.dt, SEA.wp, 50.0, 1.0)
        np.testing.assert_array_equal(run.mean_power[index, 0], values["generated_w"])
        for name in ("phi1_p98", "phi3_p98", "loss_time"):
            np.testing.assert_array_equal(getattr(run, name)[index, 0], values[name])
        for name in ("power_cv", "slip_loss_w", "wave_input_w"):
            assert getattr(run, name)[index, 0] == pytest.approx(values[name], rel=1e-9)


@pytest.mark.parametrize(
    ("field", "pairs", "dt"),
    [
        ("cc", [(0.05, 1e-4), (-0.01, 1e-4)], 0.01),
        ("cg", [(0.05, -1e-4)], 0.01),
        ("cc", [(float("nan"), 1e-4)], 0.01),
        ("run.dt", [(0.3, 1e-4)], 0.0125),  # h * 683 cc = 2.56
        ("run.dt", [(0.3, 1e-4)], 0.0),
        ("run.dt", [(0.3, 1e-4)], float("nan")),
    ],
)
def test_ensemble_refuses_what_it_cannot_run(
    device: gy.Plant, field: str, pairs: list[tuple[float, float]], dt: float
) -> None:
    with pytest.raises(gy.InputError) as caught:
        gy.scan(device, SEA, pairs, [1], 200.0, dt=dt, quiet=True)
    assert caught.value.field == field
    assert caught.value.mend


def test_step_just_below_the_stability_limit_runs(device: gy.Plant) -> None:
    """The other side of the bound of 2.5: accepted, and finite."""
    run = gy.scan(device, SEA, [(0.3, 3.5e-4)], [1], 60.0, 20.0, dt=0.0121, workers=1, quiet=True)
    assert np.isfinite(run.mean_power[0, 0])


# --- ledger ------------------------------------------------------------------------------------------------------


class Dice(NamedTuple):
    """State of a linear congruential generator."""

    seed: float


class Switching(NamedTuple):
    """Throw both controls anew at every sample: the coupling on or off, the generator anywhere."""

    cc_max: float = 0.3
    cg_max: float = 0.002
    period: float = 0.1

    @property
    def information(self) -> Literal["none"]:
        return "none"

    def init(self) -> Dice:
        return Dice(12345.0)

    def step(self, t: float, y: Any, state: Dice) -> tuple[tuple[float, float], Dice]:
        seed = (state.seed * 1103515.0 + 12345.0) % 2147483647.0
        other = (seed * 1103515.0 + 12345.0) % 2147483647.0
        cc = self.cc_max if seed > 1073741823.0 else 0.0
        return (cc, self.cg_max * other / 2147483647.0), Dice(other)


LAWS = [*(gy.law(name) for name in ("constant", "load_angle", "coupling")), Switching()]


@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
def test_energy_ledger_closes_over_2000_s(device: gy.Plant, law: Any) -> None:
    """To 1e-6 of the wave input, also while the coupling switches between 0 and its limit ten times a second."""
    waves = gy.realise(device, SEA, 2, 2000.0).blended(100.0)
    record, _ = run_law(device, law, waves, gy.Settings())
    values = evaluate(device, record, waves.moments[1], waves.dt, SEA.wp, 100.0, 1.0)
    assert values["ledger_residual"] < 1e-6
    parts = ("generated_w", "radiated_w", "hinge_w", "slip_loss_w", "stored_w")
    assert sum(values[name] for name in parts) == pytest.approx(values["wave_input_w"], rel=2e-6)
    if isinstance(law, Switching):
        assert np.count_nonzero(np.diff(record.controls[:, 0])) > 8000


def test_ledger_shows_the_excess_work_of_the_printed_reaction(device: gy.Plant) -> None:
    """Trap 3: what the ledger lacks is cg omega' u1 integrated over the run, here by a trapezoid of 0.02 s."""
    plant = device.replace(generator_reaction=True)
    waves = gy.realise(plant, SEA, 4, 300.0).blended(50.0)
    settings = gy.Settings(actuators=gy.Actuators(period=0.02))
    record, _ = run_law(plant, gy.law("constant", period=0.02), waves, settings)
    x = record.states[:, :14]
    u1 = np.cos(x[:, 2]) * x[:, 4] - np.sin(x[:, 2]) * x[:, 5]
    excess = np.trapezoid(3.5e-4 * x[:, 7] * u1, dx=0.02)
    energy = record.states[-1, 14:]
    stored = plant.stored_energy(x[-1]) - plant.stored_energy(x[0])
    gained = stored - energy[0] + np.sum(energy[1:])
    assert gained == pytest.approx(excess, abs=2e-7 * energy[0])
    assert abs(excess) > 2e-5 * energy[0]  # a hundred times the tolerance, though it swings about zero in this sea


# --- cache -------------------------------------------------------------------------------------------------------


def test_stamp_covers_every_source_compiled_into_the_kernel() -> None:
    """The compiled functions carry the stamp of the texts that flow into them."""
    names = {Path(source).name for source in kernel.SOURCES}
    own = {"beyond.py", "friction.py", "gripping.py", "equations.py", "course.py", "near.py", "held.py", "kernel.py"}
    own |= {"hyperbolic.py", "lagrange.py", "reduced.py", "wetted.py", "instants.py", "packs.py"}
    assert names == {"compiled.py", "trigonometry.py", *own}
    for function in (kernel.hold_into, kernel.move_into, kernel.run_lanes):
        name = function.py_func.__qualname__
        assert name.endswith(f"_{source_stamp(kernel.SOURCES)[:16]}")
        assert not name.endswith(source_stamp(kernel.SOURCES[::-1])[:16])  # order is part of it


def test_stamp_changes_with_any_byte(tmp_path: Path) -> None:
    one, two = tmp_path / "one.py", tmp_path / "two.py"
    one.write_text("a = 1\n")
    two.write_text("b = 1\n")
    before = source_stamp([str(one), str(two)])
    assert source_stamp([str(one), str(two)]) == before
    two.write_text("b = 2\n")
    assert source_stamp([str(one), str(two)]) != before


PROBE = """
import numpy as np
from gyroctl.plant.equations import Coefficients
from gyroctl.plant.kernel import hold_one
names = [name for name in Coefficients._fields if name != "beyond"]
k = Coefficients(**{n: 1.0 for n in names[:-4]}, p1=(1.0,), q1=(1.0,), p3=(1.0,), q3=(1.0,))
print(float(hold_one(np.ones(15), k, 0.1, 0.1, 0.0, 0.1, 4, np.zeros(40), 0.05)[4]))
"""


@pytest.mark.slow
def test_edited_equations_are_compiled_anew(tmp_path: Path) -> None:
    """Only equations.py changes, kernel.py stays and so does what was kept: stale code would give the old number."""
    package = tmp_path / "gyroctl"
    shutil.copytree(
        Path(gy.__file__).parent, package, ignore=shutil.ignore_patterns("__pycache__", "data"), symlinks=True
    )

    def probe() -> float:
        environment = {**os.environ, "PYTHONPATH": str(tmp_path), "GYROCTL_CACHE": str(tmp_path / "cache")}
        environment.pop("NUMBA_CACHE_DIR", None)
        done = subprocess.run(
            [sys.executable, "-c", PROBE], env=environment, cwd=tmp_path, capture_output=True, text=True, check=True
        )
        return float(done.stdout)

    first = probe()
    assert list(tmp_path.glob("cache/gyroctl/machine-code/kernel.hold_into*.nbi")), "nothing was kept"
    assert probe() == first
    text = package / "plant" / "equations.py"
    text.write_text(text.read_text().replace("- k.k1 * phi1 -", "- 2.0 * k.k1 * phi1 -"))
    assert probe() != first
