"""The continuation machinery on maps whose bifurcations are known in closed form."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import gyroctl as gy
from gyroctl.orbits.bifurcation import curve
from gyroctl.orbits.continuation import ScaledMap, SpecialPoint, continue_fixed_point
from gyroctl.orbits.orbit_map import Evaluation
from gyroctl.orbits.pseudo_arclength import Palc, begin, follow, locate


@dataclass(frozen=True)
class KnownMap:
    """A map of the plane from a table of formulas, differentiated by complex step."""

    name: str
    at: tuple[tuple[str, float], ...]
    parameters: tuple[str, ...]
    symmetric: bool = False

    def over(self, parameters: tuple[str, ...]) -> KnownMap:
        return dataclasses.replace(self, parameters=parameters)

    def value(self, name: str) -> float:
        return dict(self.at)[name]

    def least(self, name: str) -> float:
        return -10.0

    def span(self, values: NDArray[np.float64]) -> float:
        return 1.0

    def orbit(self, x: Any, values: Any) -> Any:
        raise AssertionError("a map of numbers has no orbits")

    def evaluate(self, x: NDArray[np.float64], values: NDArray[np.float64], derivative: bool = True) -> Evaluation:
        def image(z: Any) -> Any:
            p = dict(self.at) | dict(zip(self.parameters, z[2:], strict=True))
            return np.array(FORMULAS[self.name](z[0], z[1], p))

        z = np.concatenate([x, values]).astype(complex)
        columns = [image(z + 1e-30j * unit).imag / 1e-30 for unit in np.eye(z.size)]
        J = np.stack(columns, axis=1)
        return Evaluation(image(z).real, J[:, :2], J[:, 2:], 0.0)


FORMULAS = {
    "circle": lambda x, y, p: (x + 0.3 * (1.0 - x**2 - p["a"] ** 2), 0.5 * y),
    "henon": lambda x, y, p: (1.0 - p["a"] * x**2 + y, p["b"] * x),
    # Neimark-Sacker at r = 1 + 1/(1 - e), trace there 1 - e/(1 - e)
    "delayed": lambda x, y, p: (p["r"] * x * (1.0 - (1.0 - p["e"]) * y - p["e"] * x), x),
}


def henon(b: float = 0.3, symmetric: bool = False) -> tuple[ScaledMap, NDArray[np.float64]]:
    a = 0.2
    x = (-(1 - b) + np.sqrt((1 - b) ** 2 + 4 * a)) / (2 * a)
    scaled = ScaledMap(KnownMap("henon", (("a", a), ("b", b)), ("a",), symmetric), np.ones(2), np.array([1.0]))
    return scaled, scaled.join(np.array([x, b * x]), np.array([a]))


def delayed(e: float = 0.0) -> tuple[ScaledMap, NDArray[np.float64]]:
    r = 1.6
    scaled = ScaledMap(KnownMap("delayed", (("r", r), ("e", e)), ("r",)), np.ones(2), np.array([2.0]))
    return scaled, scaled.join(np.full(2, 1 - 1 / r), np.array([r]))


def special(kind: str, found: tuple[SpecialPoint, ...]) -> SpecialPoint:
    (one,) = [point for point in found if point.kind == kind]
    return one


def test_tracer_goes_round_a_circle() -> None:
    def system(y: Any) -> Any:
        return np.array([y @ y - 1.0]), 2.0 * y[None, :]

    options = Palc(step=0.05, longest=0.1, points=100)
    start = begin(system, np.array([0.8, 0.6]), options)
    assert start is not None
    points = list(follow(lambda _: system, start, options, lambda y: True))
    angles = np.unwrap([np.arctan2(p.y[1], p.y[0]) for p in points])
    assert abs(angles[-1] - angles[0]) > 2 * np.pi  # past both folds and round again
    assert max(abs(p.y @ p.y - 1.0) for p in points) < 1e-10
    turns = [
        locate(system, a, b, lambda p: float(p.tangent[-1]), options)
        for a, b in pairwise(points)
        if a.tangent[-1] * b.tangent[-1] < 0
    ]
    assert len(turns) >= 2
    for turn in turns:
        assert turn is not None
        assert abs(turn.y[-1]) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("b", [0.3, -0.2])
def test_fold_and_flip_of_the_henon_map(b: float) -> None:
    """Fold at a = -(1-b)^2/4, flip at a = 3(1-b)^2/4; the branch goes round the fold."""
    scaled, y = henon(b)
    branch = continue_fixed_point(scaled, y, (-1.0, 2.0), Palc())
    fold, flip = special("fold", branch.points), special("period doubling", branch.points)
    assert fold.value == pytest.approx(-((1 - b) ** 2) / 4, abs=1e-10)
    assert flip.value == pytest.approx(3 * (1 - b) ** 2 / 4, abs=1e-10)
    assert fold.error < 1e-6 and flip.error < 1e-8
    assert {p.kind for p in branch.points} <= {"fold", "period doubling"}
    assert np.min(branch.values) == pytest.approx(fold.value, abs=1e-2)
    assert branch.values[-1] == pytest.approx(2.0, abs=1e-12)  # one end on the limit, the other runs off to infinity
    assert np.max(np.abs(branch.states[0])) > 10.0
    # stable exactly between fold and flip on the sheet that does not run off
    near = branch.states[:, 0] < scaled.split(fold.point.y)[0][0]
    between = near & (branch.values < flip.value) & (branch.values > fold.value)
    np.testing.assert_array_equal(
        branch.stable[np.abs(branch.values - flip.value) > 1e-9], between[np.abs(branch.values - flip.value) > 1e-9]
    )


def test_the_square_root_of_a_map_breaks_symmetry_where_the_map_doubles() -> None:
    scaled, y = henon(symmetric=True)
    branch = continue_fixed_point(scaled, y, (-1.0, 2.0), Palc())
    assert special("symmetry breaking", branch.points).value == pytest.approx(3 * 0.49 / 4, abs=1e-10)
    plain = continue_fixed_point(*henon(), (-1.0, 2.0), Palc())
    assert np.max(np.abs(branch.multipliers[0])) == pytest.approx(np.max(np.abs(plain.multipliers[0])) ** 2)


def test_neimark_sacker_of_the_delayed_logistic_map() -> None:
    """At r = 2, with multipliers exp(+-i pi/3)."""
    branch = continue_fixed_point(*delayed(), (1.2, 3.0), Palc())
    point = special("Neimark-Sacker", branch.points)
    assert point.value == pytest.approx(2.0, abs=1e-10)
    assert abs(np.angle(point.multiplier)) == pytest.approx(np.pi / 3, abs=1e-9)
    assert point.frequency == pytest.approx(np.pi / 3, abs=1e-9)
    np.testing.assert_array_equal(branch.stable, branch.values < 2.0)


def test_closed_branch_is_followed_once_round() -> None:
    scaled = ScaledMap(KnownMap("circle", (("a", 0.2),), ("a",)), np.ones(2), np.array([1.0]))
    branch = continue_fixed_point(scaled, np.array([np.sqrt(0.96), 0.0, 0.2]), (-2.0, 2.0), Palc())
    assert branch.closed
    np.testing.assert_allclose(sorted(p.value for p in branch.points), [-1.0, 1.0], atol=1e-10)
    assert np.ptp(branch.states[:, 0]) > 1.9
    np.testing.assert_allclose(branch.states[:, 0] ** 2 + branch.values**2, 1.0, atol=1e-9)


@pytest.mark.parametrize(("kind", "factor"), [("fold", -0.25), ("period doubling", 0.75)])
def test_curves_of_the_henon_map(kind: str, factor: float) -> None:
    branch = continue_fixed_point(*henon(), (-1.0, 2.0), Palc())
    found = curve(special(kind, branch.points), "b", (-0.8, 0.8), first_limits=(-2.0, 4.0))
    assert found.kind == kind and found.ends == ("limit", "limit")
    assert {round(found.second[0], 9), round(found.second[-1], 9)} == {-0.8, 0.8}
    np.testing.assert_allclose(found.first, factor * (1 - found.second) ** 2, atol=1e-9)
    assert np.max(found.error) < 1e-5
    # the other multiplier: the product is -b
    np.testing.assert_allclose(found.others, np.abs(found.second), atol=1e-5)


def test_curve_of_neimark_sacker_points() -> None:
    branch = continue_fixed_point(*delayed(), (1.2, 3.0), Palc())
    point = special("Neimark-Sacker", branch.points)
    found = curve(point, "e", (-0.5, 0.7), first_limits=(1.0, 5.0))
    np.testing.assert_allclose(found.first, 1 + 1 / (1 - found.second), atol=1e-8)
    np.testing.assert_allclose(np.cos(found.frequency), 0.5 - 0.5 * found.second / (1 - found.second), atol=1e-8)
    assert np.ptp(found.second) > 0.9
    assert np.max(found.error) < 1e-9
    assert found.first_at(0.2) == pytest.approx([2.25], abs=5e-3)


def test_neimark_sacker_curve_ends_in_the_resonance() -> None:
    """At e = 3/4 both multipliers are -1: theta = pi, where the curve of pairs ends."""
    branch = continue_fixed_point(*delayed(), (1.2, 3.0), Palc())
    found = curve(special("Neimark-Sacker", branch.points), "e", (-0.5, 0.9), first_limits=(1.0, 9.0))
    assert "resonance" in found.ends
    assert 0.7 < np.max(found.second) < 0.75


def test_bad_requests_are_named() -> None:
    branch = continue_fixed_point(*henon(), (-1.0, 2.0), Palc())
    fold = special("fold", branch.points)
    with pytest.raises(gy.InputError, match="second"):
        curve(fold, "a", (-1.0, 1.0))
    with pytest.raises(gy.InputError, match="limits"):
        curve(fold, "b", (0.5, 0.8))
    with pytest.raises(gy.InputError, match="no fixed point"):
        continue_fixed_point(henon()[0], np.array([np.nan, 0.0, 0.2]), (-1.0, 2.0), Palc())
