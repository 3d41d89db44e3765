"""Sums of rows four at a time: those of a plain loop, to the last bit."""

from __future__ import annotations

import numpy as np
import pytest

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
            expected[column] = expected[column] + factors[k] * rows[k, column]
    add_rows(factors, rows, first, end, out, low, high)
    np.testing.assert_array_equal(out, expected)
