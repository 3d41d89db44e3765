"""Views of a row of numbers, by place and shape: a slice would be compiled with all that slices can be asked for."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import populate_array


def _view(typing_context: Any, row: Any, begin: Any, shape: Any) -> Any:
    kind = types.Array(row.dtype, shape.count, "C")

    def build(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        source = context.make_array(signature.args[0])(context, builder, arguments[0])
        made = context.make_array(kind)(context, builder)
        size = context.get_constant(types.intp, context.get_abi_sizeof(context.get_data_type(kind.dtype)))
        lengths, last = cgutils.unpack_tuple(builder, arguments[2], shape.count), size
        strides: list[Any] = []
        for length in reversed(lengths):
            strides.insert(0, last)
            last = builder.mul(last, length)
        data = builder.gep(source.data, [arguments[1]])
        nothing = context.get_constant_null(types.MemInfoPointer(kind.dtype))
        populate_array(made, data=data, shape=lengths, strides=strides, itemsize=size, meminfo=nothing)
        return made._getvalue()

    return kind(row, types.intp, types.UniTuple(types.intp, shape.count)), build


view = cast(Callable[[Any, int, tuple[int, ...]], Any], intrinsic(_view))
"""``view(row, begin, shape)``: an array of a shape over the numbers of `row` from a place on.

The row has to outlive it, and nothing looks whether the numbers are there.
"""
