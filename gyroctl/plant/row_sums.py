"""Sums of rows, the inner loop of small dense linear algebra, in an order that is the same on every machine.

BLAS would be quicker for large matrices, and sums in another order on another machine or number of threads.
"""

from __future__ import annotations

from typing import Any

from gyroctl.plant import fused
from gyroctl.plant.compiled import stamped
from gyroctl.plant.fused import fma


@stamped((fused.__file__, __file__))
def add_rows(factors: Any, rows: Any, first: int, end: int, out: Any, low: int, high: int) -> None:
    """Add ``factors[k] rows[k]`` for k from `first` up to `end`, one after the other, to `out` from `low` up to `high`.

    Four at a time: `out` is loaded and stored once for all four, in the order of a plain sum. Each product is rounded
    together with its sum.

    Parameters
    ----------
    factors : (n,) array
    rows : (n, c) array
    first, end : int
        Rows that count.
    out : (c,) array
        Changed in place; it may be a row that does not count.
    low, high : int
        Columns that count.
    """
    k = first
    while k + 4 <= end:
        f0, f1, f2, f3 = factors[k], factors[k + 1], factors[k + 2], factors[k + 3]
        r0, r1, r2, r3 = rows[k], rows[k + 1], rows[k + 2], rows[k + 3]
        for b in range(low, high):
            out[b] = fma(f3, r3[b], fma(f2, r2[b], fma(f1, r1[b], fma(f0, r0[b], out[b]))))
        k += 4
    while k < end:
        f, row = factors[k], rows[k]
        for b in range(low, high):
            out[b] = fma(f, row[b], out[b])
        k += 1
