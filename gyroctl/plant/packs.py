"""LANES runs as one number: texts that are written for a scalar run many side by side.

Compiled, a pack is a vector of the processor, or as many of them as LANES doubles fill, and each arithmetic operation
on it one instruction of each; no loop over the lanes has to be recognised as one. Each lane is rounded by itself, as a
scalar would be. In plain Python a pack is an array of LANES numbers.
"""

from __future__ import annotations

import operator
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AbstractTemplate, infer_global
from numba.extending import intrinsic, lower_builtin, make_attribute_wrapper, models, overload, register_model
from numpy.typing import NDArray

from gyroctl.plant.compiled import INLINED, inlined

LANES = 16
"""Runs side by side in the compiled ensemble: two vectors of eight, whose instructions fill each other's waits."""

ROOM = 64
"""Rows of the working space of a text, at most."""

ALIGNED = 8  # bytes that are relied on; where packs lie in a cache line each, see `compiled.aligned`, it goes faster

VECTOR = ir.VectorType(ir.DoubleType(), LANES)


class Packs:
    """Packs one after the other in a flat array of doubles."""

    def __init__(self, array: NDArray[np.float64]) -> None:
        self.array = array

    def __getitem__(self, i: int) -> NDArray[np.float64]:
        """Pack number `i`, (LANES,)."""
        return self.array[i * LANES : (i + 1) * LANES].copy()

    def __setitem__(self, i: int, value: Any) -> None:
        """Write pack number `i`."""
        self.array[i * LANES : (i + 1) * LANES] = value


def packs(array: Any) -> Any:
    """See the flat `array` as packs."""
    return Packs(array)


def room() -> Any:
    """Room for ROOM packs within one text: the compiler keeps of it what is read, in registers where it can."""
    return Packs(np.empty(ROOM * LANES))


def settle(written: Any) -> None:
    """Have all packs computed that were written to `written` before anything that is read from it later.

    The order in which a text names independent results is lost on the compiler, which computes late what is used late.
    """


@inlined
def check_room(rows: int) -> None:
    """Refuse more rows than a text has room for."""
    if rows > ROOM:
        raise ValueError("a pack of runs has room for 64 rows of state and ledger")


def prefetch(array: Any, i: int) -> None:
    """Tell the processor that entry `i` of a flat array will be wanted soon."""


# --- what the compiler knows of them -----------------------------------------------------------------------------


class PackType(types.Type):  # type: ignore[misc]
    """A pack, compiled."""

    def __init__(self) -> None:
        super().__init__(name=f"Pack({LANES})")


class PacksType(types.Type):  # type: ignore[misc]
    """Packs in an array, compiled."""

    def __init__(self, array: Any) -> None:
        self.array = array
        super().__init__(name=f"Packs({array})")


class RoomType(types.Type):  # type: ignore[misc]
    """Packs on the stack."""

    def __init__(self) -> None:
        super().__init__(name=f"Room({ROOM}, {LANES})")


PACK, STACKED = PackType(), RoomType()


@register_model(PackType)
class _PackModel(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, VECTOR)


@register_model(PacksType)
class _PacksModel(models.StructModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, [("array", kind.array)])


@register_model(RoomType)
class _RoomModel(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, VECTOR.as_pointer())


make_attribute_wrapper(PacksType, "array", "array")


def _first(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    """Pointer to the first pack."""
    if isinstance(kind, RoomType):
        return value
    whole = cgutils.create_struct_proxy(kind)(context, builder, value)
    data = context.make_array(kind.array)(context, builder, whole.array).data
    return builder.bitcast(data, VECTOR.as_pointer())


def _splat(builder: Any, kind: Any, value: Any) -> Any:
    """Return `value` in every lane, a pack as it is."""
    if isinstance(kind, PackType):
        return value
    nothing = ir.Constant(VECTOR, ir.Undefined)
    first = builder.insert_element(nothing, value, ir.Constant(ir.IntType(32), 0))
    return builder.shuffle_vector(first, nothing, ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES))


@intrinsic  # type: ignore[untyped-decorator]
def _packs(_: Any, array: Any) -> Any:
    kind = PacksType(array)

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        whole = cgutils.create_struct_proxy(kind)(context, builder)
        whole.array = args[0]
        context.nrt.incref(builder, array, args[0])
        return whole._getvalue()

    return kind(array), codegen


@intrinsic  # type: ignore[untyped-decorator]
def _room(_: Any) -> Any:
    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return cgutils.alloca_once(builder, VECTOR, size=ROOM)

    return STACKED(), codegen


@intrinsic  # type: ignore[untyped-decorator]
def _settle(_: Any, held: Any) -> Any:
    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        place = _first(context, builder, held, args[0])  # no instruction, but for all that the compiler knows it might
        builder.asm(ir.FunctionType(ir.VoidType(), [place.type]), "", "r,~{memory}", [place], True)  # read and write it
        return context.get_dummy_value()

    return types.void(held), codegen


@intrinsic  # type: ignore[untyped-decorator]
def _prefetch(_: Any, array: Any, i: Any) -> Any:
    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        place = builder.gep(context.make_array(array)(context, builder, args[0]).data, [args[1]])
        place, number = builder.bitcast(place, ir.IntType(8).as_pointer()), ir.IntType(32)
        kind = ir.FunctionType(ir.VoidType(), [place.type, number, number, number])
        fetch = cgutils.get_or_insert_function(builder.module, kind, "llvm.prefetch.p0")
        builder.call(fetch, [place, number(0), number(3), number(1)])  # to read, into the nearest cache, data
        return context.get_dummy_value()

    return types.void(array, types.intp), codegen


# Arithmetic and indices are told to the compiler directly: as functions of their own, each compiled for each pair of
# types that it meets, they would take seconds.


def _either(a: Any, b: Any) -> Any:
    """Types of an operation's two numbers, of which one is a pack."""
    if PACK not in (a, b) or not all(isinstance(kind, PackType | types.Float | types.Integer) for kind in (a, b)):
        return None
    return [kind if kind == PACK else types.float64 for kind in (a, b)]


def _teach(sign: Any, instruction: str) -> None:
    """Teach an operation on two packs, or on a pack and a number."""

    @infer_global(sign)
    class _Typed(AbstractTemplate):  # type: ignore[misc]
        def generic(self, args: Any, kws: Any) -> Any:
            kinds = _either(*args)
            return None if kinds is None else PACK(*kinds)

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return getattr(builder, instruction)(*map(_splat, (builder, builder), signature.args, args))

    for kinds in ((PACK, PACK), (PACK, types.float64), (types.float64, PACK)):
        lower_builtin(sign, *kinds)(codegen)


for _sign, _instruction in (
    (operator.add, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
    (operator.truediv, "fdiv"),
):
    _teach(_sign, _instruction)


@infer_global(operator.getitem)
class _Read(AbstractTemplate):  # type: ignore[misc]
    def generic(self, args: Any, kws: Any) -> Any:
        held, i = args
        fits = isinstance(held, PacksType | RoomType) and isinstance(i, types.Integer)
        return PACK(held, types.intp) if fits else None


@infer_global(operator.setitem)
class _Write(AbstractTemplate):  # type: ignore[misc]
    def generic(self, args: Any, kws: Any) -> Any:
        held, i, value = args
        fits = isinstance(held, PacksType | RoomType) and isinstance(i, types.Integer) and value == PACK
        return types.void(held, types.intp, PACK) if fits else None


def _load(context: Any, builder: Any, signature: Any, args: Any) -> Any:
    place = builder.gep(_first(context, builder, signature.args[0], args[0]), [args[1]])
    return builder.load(place, align=ALIGNED)


def _store(context: Any, builder: Any, signature: Any, args: Any) -> Any:
    place = builder.gep(_first(context, builder, signature.args[0], args[0]), [args[1]])
    builder.store(args[2], place, align=ALIGNED)
    return context.get_dummy_value()


for _held in (PacksType, RoomType):
    lower_builtin(operator.getitem, _held, types.intp)(_load)
    lower_builtin(operator.setitem, _held, types.intp, PACK)(_store)

overload(packs, jit_options=INLINED, strict=False)(lambda array: lambda array: _packs(array))
overload(room, jit_options=INLINED)(lambda: lambda: _room())
overload(prefetch, jit_options=INLINED, strict=False)(lambda array, i: lambda array, i: _prefetch(array, i))
overload(settle, jit_options=INLINED, strict=False)(lambda written: lambda written: _settle(written))
