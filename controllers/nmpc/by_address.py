"""Functions by their address: compiled code takes them as whole numbers, which costs nothing.

A function object that is handed to compiled code is asked for its address through Python at every call, some 15 us
each; bound into the code it would keep that from being cached, and be compiled again with it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

ROW = types.float64[::1]


def function_at(count: int) -> Callable[[int], Any]:
    """Return what makes a function of `count` arrays out of its address, within compiled code.

    Whoever keeps the address keeps the function as well: the machine code goes with it.
    """
    return function_of(types.void(*[ROW] * count))


def function_of(signature: Any) -> Callable[[int], Any]:
    """Return what makes a function of a signature out of its address, as `function_at` does."""
    kind = types.FunctionType(signature)

    def make(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        found = cgutils.create_struct_proxy(kind)(context, builder)
        nothing = cgutils.voidptr_t(None)
        found.c_addr = builder.inttoptr(arguments[0], cgutils.voidptr_t)
        found.py_addr = found.jit_addr = nothing
        return found._getvalue()

    def at(typing_context: Any, address: Any) -> Any:
        return kind(types.intp), make

    return cast(Callable[[int], Any], intrinsic(at))
