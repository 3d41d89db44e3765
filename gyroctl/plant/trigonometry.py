"""Cosine and sine of one angle, by the library on any type and by a polynomial when compiled for floats and packs.

The compiled form is branch-free, so that sixteen runs go side by side; a call to the system's sine would stop that.
Coefficients: minimax polynomials on [-pi/4, pi/4] as in the Cephes library (S. L. Moshier, 1984).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic, overload

from gyroctl.plant.compiled import INLINED, inlined
from gyroctl.plant.packs import PackType

TWO_OVER_PI = 2.0 / math.pi
# pi/2 in three parts (Cody and Waite): products with turn numbers below 2^20 are exact
PART_1, PART_2, PART_3 = 1.57079625129699707031e00, 7.54978941586159635335e-08, 5.39030285815811905290e-15
TO_INTEGER = 6755399441055744.0  # 1.5 * 2^52: adding and subtracting rounds to the nearest integer


def cos_sin(angle: Any) -> tuple[Any, Any]:
    """Cosine and sine of `angle` [rad] for floats, arrays, complex numbers and casadi symbols."""
    return np.cos(angle), np.sin(angle)


@intrinsic  # type: ignore[untyped-decorator]
def _of_quadrant(_: Any, shifted: Any, cosine: Any, sine: Any) -> Any:
    """Cosine and sine of the angle from those of what is left of it after its quarter turns.

    The last two bits of `shifted` count those turns: odd ones swap the two, turns 2, 3 change the sign of the sine, and
    1, 2 that of the cosine. Bits are moved, not multiplied: a third of the instructions, and nothing is rounded.
    """

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        kind = args[0].type
        bits = ir.VectorType(ir.IntType(64), kind.count) if isinstance(kind, ir.VectorType) else ir.IntType(64)

        def each(value: int) -> Any:
            return ir.Constant(bits, [value] * kind.count if isinstance(kind, ir.VectorType) else value)

        def signed(value: Any, turn: Any) -> Any:
            sign = builder.and_(builder.shl(turn, each(62)), each(-(2**63)))
            return builder.bitcast(builder.xor(builder.bitcast(value, bits), sign), kind)

        turn = builder.bitcast(args[0], bits)
        odd = builder.icmp_unsigned("!=", builder.and_(turn, each(1)), each(0))
        found = (
            signed(builder.select(odd, args[2], args[1]), builder.add(turn, each(1))),
            signed(builder.select(odd, args[1], args[2]), turn),
        )
        return context.make_tuple(builder, signature.return_type, found)

    return types.UniTuple(shifted, 2)(shifted, shifted, shifted), codegen


@inlined
def turned(angle: Any) -> Any:
    """Number of quarter turns in `angle` as the last bits of a float, and cosine and sine of what is left of it."""
    shifted = angle * TWO_OVER_PI + TO_INTEGER
    turns = shifted - TO_INTEGER  # quarter turns, to nearest
    r = ((angle - turns * PART_1) - turns * PART_2) - turns * PART_3
    z = r * r
    p = 1.58962301576546568060e-10
    p = p * z - 2.50507477628578072866e-8
    p = p * z + 2.75573136213857245213e-6
    p = p * z - 1.98412698295895385996e-4
    p = p * z + 8.33333333332211858878e-3
    p = p * z - 1.66666666666666307295e-1
    sine = r + r * z * p
    p = -1.13585365213876817300e-11
    p = p * z + 2.08757008419747316778e-9
    p = p * z - 2.75573141792967388112e-7
    p = p * z + 2.48015872888517045348e-5
    p = p * z - 1.38888888888730564116e-3
    p = p * z + 4.16666666666665929218e-2
    cosine = 1.0 - 0.5 * z + z * z * p
    return shifted, cosine, sine


def _polynomial(angle: Any) -> Any:
    shifted, cosine, sine = turned(angle)
    return _of_quadrant(shifted, cosine, sine)


def _library(angle: Any) -> Any:
    return np.cos(angle), np.sin(angle)


@overload(cos_sin, jit_options=INLINED)  # type: ignore[untyped-decorator]
def _cos_sin_compiled(angle: Any) -> Any:
    if isinstance(angle, types.Float | PackType):
        return _polynomial
    return _library
