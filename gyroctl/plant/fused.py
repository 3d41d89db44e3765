"""A product and a sum in one rounding: half the operations of long sums of products, and the same bits everywhere.

A compiler that is free to contract would do so on some machines and not on others. Asked for by name, the fused
operation is rounded once wherever it runs; a processor without one takes the system's library, correct and slow.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any, cast

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic, lower_builtin, type_callable


def fma(a: float, b: float, c: float) -> float:
    """``a * b + c``, rounded once; as plain Python by fractions, which is slow."""
    if math.isfinite(a) and math.isfinite(b) and math.isfinite(c):
        exact = Fraction(a) * Fraction(b) + Fraction(c)
        if exact != 0:
            return float(exact)
    return a * b + c


@type_callable(fma)  # type: ignore[untyped-decorator]
def _typed(context: Any) -> Any:
    return lambda a, b, c: types.float64


@lower_builtin(fma, types.float64, types.float64, types.float64)  # type: ignore[untyped-decorator]
def _fused(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    return builder.fma(*arguments)


EIGHT = 8
"""Numbers that `add_eight` takes side by side."""


def _eights(typing_context: Any, factors: Any, first: Any, rows: Any, row: Any, out: Any, at: Any) -> Any:
    def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kinds = signature.args
        start, source, target = (context.make_array(kinds[i])(context, builder, arguments[i]).data for i in (0, 2, 4))
        vector, whole = ir.VectorType(ir.DoubleType(), EIGHT), ir.IntType(64)
        kind = ir.FunctionType(vector, [vector] * 3)
        fused = cgutils.get_or_insert_function(builder.module, kind, f"llvm.fma.v{EIGHT}f64")

        def eight(data: Any, number: Any) -> Any:
            place = builder.gep(data, [builder.mul(number, whole(EIGHT))])
            return builder.bitcast(place, vector.as_pointer())

        place = eight(target, arguments[5])
        total = builder.load(place, align=EIGHT)
        for i in range(4):
            factor = builder.load(builder.gep(start, [builder.add(arguments[1], whole(i))]))
            one = builder.insert_element(ir.Constant(vector, ir.Undefined), factor, ir.IntType(32)(0))
            alike = builder.shuffle_vector(one, one, ir.Constant(ir.VectorType(ir.IntType(32), EIGHT), [0] * EIGHT))
            numbers = builder.load(eight(source, builder.add(arguments[3], whole(i))), align=EIGHT)
            total = builder.call(fused, [alike, numbers, total])
        builder.store(total, place, align=EIGHT)
        return context.get_dummy_value()

    return types.void(factors, types.int64, rows, types.int64, out, types.int64), build


add_eights = cast(Callable[[Any, int, Any, int, Any, int], None], intrinsic(_eights))
"""``add_eights(factors, first, rows, row, out, at)``: add four rows of eight numbers to another one, ``out[at]``.

Each times its factor, ``factors[first] rows[row]`` first and that of ``row + 3`` last. All are flat arrays without
gaps; rows are counted in eights, and nothing looks whether they are there.
"""
