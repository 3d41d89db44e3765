"""The two ways in which this package compiles: parts that melt into their caller, and entry points that are cached.

The machine code of an entry point is kept under a hash of all that is compiled into it, see `ingredients`: edit the
equations, and everything that contains them is compiled anew. What is found by the types of the arguments alone no such
hash can see: an entry point therefore names the files that may be compiled into it as well. Where the function is a
closure of their stamp, numba hashes it with the code; `stamped` puts it into the name of the cache file.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from functools import lru_cache, wraps
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np
from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic, overload, register_jitable

from gyroctl.fingerprint import fingerprint
from gyroctl.plant.ingredients import Untold, ingredients
from gyroctl.plant.machine_code import keep, kept_callback

F = TypeVar("F", bound=Callable[..., Any])

# numpy's error model: a division by zero gives inf; a check would put a branch into the vectorised loop.
# No fastmath: the same run gives the same bits alone and in the company of others.
INLINED = {"forceinline": True, "error_model": "numpy"}


def inlined(function: F) -> F:
    """Leave `function` as it is for Python and let compiled callers absorb it."""
    return cast(F, register_jitable(**INLINED)(function))


def entry_point(function: F) -> F:
    """Compile `function` on its first call, without the interpreter lock, and keep the machine code on disk."""
    cells = [cell.cell_contents for cell in function.__closure__ or ()]  # type: ignore[attr-defined]
    told = [value for value in cells if isinstance(value, str | int | float)]
    if told:  # numba finds machine code by the function's name: closures of one text must not share that
        function.__qualname__ += "_" + hashlib.sha256(repr(told).encode()).hexdigest()[:16]
    return cast(F, keep(njit(nogil=True, error_model="numpy")(function), lambda: content_of(function)))


def content_of(function: Any) -> str:
    """Hash of what is compiled into a function; of the whole package where that cannot be told."""
    try:
        return ingredients(function)
    except Untold:
        return fingerprint()


def callback(function: Any, signature: Any) -> Any:
    """Compile `function` for one signature to a function pointer, and keep the machine code as `entry_point` does."""
    content = content_of(function)
    function.__qualname__ += f"_{content[:16]}"  # see `entry_point`
    return kept_callback(function, signature, content, error_model="numpy")


def stamped(sources: Sequence[str]) -> Callable[[F], F]:
    """Make a decorator like `entry_point` for functions into which the named files are compiled."""
    stamp = source_stamp(sources)[:16]

    def compiled(function: F) -> F:
        function.__qualname__ += f"_{stamp}"  # numba names the cache file by it
        return entry_point(function)

    return compiled


def source_stamp(modules: Sequence[str]) -> str:
    """SHA-256 over the text of the named files."""
    digest = hashlib.sha256()
    for path in modules:
        digest.update(Path(path).read_bytes())
    return digest.hexdigest()


def part(sources: Sequence[str] = ()) -> Callable[[F], F]:
    """Make a decorator for what is compiled with each compiled caller, and on its own for Python.

    For what is long to compile and belongs to one entry point: as an entry point itself it would be compiled and kept
    by itself, and then once more with its caller, whose stamp counts. `sources` is for its use from Python, as in
    `stamped`; a closure of a stamp needs none.
    """

    def parted(function: F) -> F:
        alone = stamped(sources)(function) if sources else entry_point(function)

        @wraps(function)
        def called(*given: Any) -> Any:
            return alone(*given)

        overload(called, jit_options={"error_model": "numpy"}, strict=False)(lambda *given: function)
        return cast(F, called)

    return parted


@inlined
def aligned(size: int) -> Any:
    """Room for so many numbers that begins where a cache line does: eight of them side by side then lie in one."""
    room = np.empty(size + 7)
    skip = (-(room.ctypes.data >> 3)) & 7
    return room[skip : skip + size]


def within(function: Any) -> Any:
    """Make of a `part` what is taken into the text of its caller: for what is called at one place, sooner compiled."""
    return njit(inline="always", error_model="numpy")(function.__wrapped__)


@part((__file__,))
def zeros(size: int) -> Any:
    """Room for so many numbers, of one text: `np.zeros` is compiled at every place anew."""
    return np.zeros(size)


@part((__file__,))
def zero_table(rows: int, columns: int) -> Any:
    """Room for a table, see `zeros`."""
    return np.zeros((rows, columns))


@inlined
def put(values: Any, out: Any) -> None:
    """Copy one row of numbers into another: ``out[:] = values`` would compile seconds of text for an error first."""
    for i in range(out.shape[0]):
        out[i] = values[i]


@inlined
def put_table(values: Any, out: Any) -> None:
    """Copy a table into another, see `put`."""
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            out[i, j] = values[i, j]


def lent(array: Any) -> Any:
    """Return the same array, without a count of those who hold it.

    Every view of an array counts up and down, and an inner loop of many views does little else. Whoever calls this
    holds the array for as long as what is lent is used: a compiled function's arguments are held by its caller.
    An array that was made in the same function is not: it is given back after the last line that names it.
    """
    return array


@intrinsic  # type: ignore[untyped-decorator]
def _lent(_: Any, array: Any) -> Any:
    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        same = context.make_array(array)(context, builder, args[0])
        same.meminfo = cgutils.get_null_value(same.meminfo.type)
        same.parent = cgutils.get_null_value(same.parent.type)
        return same._getvalue()

    return array(array), codegen


def stepped(law: Any, t: float, y: Any, state: Any) -> Any:
    """Take a step of a law within a law: its method, which compiled callers find by the law's type."""
    return law.step(t, y, state)


def begun(law: Any, first: Any) -> Any:
    """State of a law within a law before its first sample: compiled callers take the one that was kept, `first`."""
    return law.init()


def _stepped(law: Any, t: float, y: Any, state: Any) -> Any:
    if not isinstance(law, types.BaseNamedTuple):
        return None
    step = _compiled_step(law.instance_class)
    return lambda law, t, y, state: step(law, t, y, state)


@lru_cache(maxsize=256)
def _compiled_step(kind: Any) -> Any:
    return njit(**INLINED, no_cpython_wrapper=True, no_cfunc_wrapper=True)(kind.step)  # called within others alone


overload(lent, strict=False, jit_options=INLINED)(lambda array: lambda array: _lent(array))
overload(stepped, strict=False)(_stepped)
overload(begun, strict=False)(lambda law, first: lambda law, first: first)
