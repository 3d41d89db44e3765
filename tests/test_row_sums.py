"""Sums of rows four at a time: those of a plain loop, to the last bit; sums and products in one rounding."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from numba import njit

from gyroctl.plant.fused import EIGHT, add_eights, fma
from gyroctl.plant.row_sums import add_rows


@pytest.mark.parametrize(
    ("first", "end", "low", "high"), [(0, 0, 0, 23), (0, 9, 0, 23), (2, 6, 3, 20), (1, 4, 0, 1), (3, 11, 7, 23)]
)
def test_rows_are_added_in_the_order_of_a_plain_sum(first: int, end: int, low: int, high: int) -> None:
    """Whatever is left over by groups of four; outside of the columns asked for nothing is touched."""
    rng = np.random.default_rng(first + 10 * end)
    factors, rows, out = rng.standard_normal(11), rng.standard_normal((11, 23)), rng.standard_normal(23)
    expected = out.copy()
    for column in range(low, high):
        for k in range(first, end):
            expected[column] = fma(factors[k], rows[k, column], expected[column])
    add_rows(factors, rows, first, end, out, low, high)
    np.testing.assert_array_equal(out, expected)


@njit
def compiled_fma(a: float, b: float, c: float) -> float:
    return fma(a, b, c)


@pytest.mark.parametrize("way", [fma, compiled_fma])
def test_product_and_sum_are_rounded_once(way) -> None:
    """Against exact fractions: 1 + eps squared, less one, is 2 eps + eps squared, which two roundings lose."""
    eps = 2.0**-30
    assert way(1.0 + eps, 1.0 + eps, -1.0) == 2.0 * eps + eps * eps != (1.0 + eps) * (1.0 + eps) - 1.0
    rng = np.random.default_rng(1)
    for a, b, c in rng.standard_normal((200, 3)):
        assert way(a, b, c) == float(Fraction(a) * Fraction(b) + Fraction(c))
    assert np.isnan(way(np.inf, 0.0, 1.0)) and way(0.0, 2.0, -0.0) == 0.0


@njit
def compiled_eights(factors, first, rows, row, out, at) -> None:
    add_eights(factors, first, rows, row, out, at)


def test_four_rows_of_eight_are_added_one_after_the_other() -> None:
    rng = np.random.default_rng(2)
    factors, rows, out = rng.standard_normal(9), rng.standard_normal(6 * EIGHT), rng.standard_normal(3 * EIGHT)
    expected = out.copy()
    for k in range(4):
        for i in range(EIGHT):
            expected[EIGHT + i] = fma(factors[3 + k], rows[EIGHT * (2 + k) + i], expected[EIGHT + i])
    compiled_eights(factors, 3, rows, 2, out, 1)
    np.testing.assert_array_equal(out, expected)
