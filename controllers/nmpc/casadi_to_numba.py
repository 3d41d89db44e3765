"""A casadi function as compiled machine code, without a C compiler: its instructions written as plain Python for numba.

casadi's own virtual machine takes some nanoseconds per operation; a function of a few hundred operations that is
called 10 000 times per second of simulated time is worth compiling. `Function.generate` would need a C compiler on the
user's machine. An SX function is a straight line of scalar operations, which numba compiles as it stands.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from gyroctl.controllers.nmpc.kept_code import kept_function
from gyroctl.plant import compiled as ways
from gyroctl.plant import fused as fused_sums
from gyroctl.plant import trigonometry
from gyroctl.plant.compiled import inlined, source_stamp

SIGNS = {"ADD": "+", "SUB": "-", "MUL": "*", "DIV": "/", "POW": "**", "CONSTPOW": "**"}
FUNCTIONS = ("exp", "log", "sqrt", "tanh")
OPERATIONS = {
    **{f"OP_{name}": f"{{0}} {sign} {{1}}" for name, sign in SIGNS.items()},
    **{f"OP_{name.upper()}": f"math.{name}({{0}})" for name in FUNCTIONS},
    "OP_COS": "cos_sin({0})[0]",  # of the two, the compiler works out once what both need
    "OP_SIN": "cos_sin({0})[1]",
    "OP_ASSIGN": "{0}",
    "OP_NEG": "-{0}",
    "OP_TWICE": "2.0 * {0}",
    "OP_SQ": "{0} * {0}",
    "OP_INV": "1.0 / {0}",
    "OP_FABS": "abs({0})",
    "OP_FMAX": "max({0}, {1})",
    "OP_FMIN": "min({0}, {1})",
    "OP_SIGN": "math.copysign(1.0, {0}) if {0} != 0.0 else 0.0",
    "OP_LT": "1.0 if {0} < {1} else 0.0",
    "OP_LE": "1.0 if {0} <= {1} else 0.0",
    "OP_NOT": "0.0 if {0} else 1.0",
    "OP_IF_ELSE_ZERO": "{1} if {0} else 0.0",
}
"""casadi's operations that equations of motion and costs are made of."""


BESIDE = 8
"""Points and columns that are worked out side by side: the number of columns is rounded up to a multiple of it."""

HEAD = """import math

from numba import float64, void

from gyroctl.plant.fused import fma
from gyroctl.plant.trigonometry import cos_sin

STAMP = {stamp!r}


@kept(void({types}))
def {name}({arguments}):
"""


def compiled(name: str, inputs: Sequence[Any], outputs: Sequence[Any]) -> Any:
    """Compile SX expressions.

    Parameters
    ----------
    name : str
        Of the function.
    inputs : sequence of casadi.SX
        Column vectors of symbols.
    outputs : sequence of casadi.SX
        What is computed; matrices come out dense, column by column.

    Returns
    -------
    numba cfunc
        ``f(*inputs, *outputs)``, all float arrays without gaps, the outputs overwritten. Its type is that of its
        signature alone, so that compiled code which takes it as an argument is compiled once for all devices.
        Kept on disk, by the hash of its text.
    """
    return kept_function(name, source(name, inputs, outputs))


def compiled_columns(
    name: str,
    inputs: Sequence[Any],
    common: Sequence[Any],
    middle: Sequence[Any],
    between: Sequence[Any],
    column: Any,
    after: Any,
    chained: int,
) -> Any:
    """Compile what is done to the columns of matrices, with numbers that are worked out for BESIDE points at once.

    Parameters
    ----------
    name, inputs
        As in `compiled`.
    common : sequence of casadi.SX
        Further inputs, the same for all points.
    middle : sequence of casadi.SX
        Vectors of expressions of the inputs.
    between : sequence of casadi.SX
        Vectors of symbols that stand for them in `after`.
    column, after : casadi.SX
        Vector of symbols (m,), and what becomes of its first entries (a,), a <= m.
    chained : int
        Points that change the same matrix, one after the other.

    Returns
    -------
    numba cfunc
        ``f(*common, room, columns)``, flat arrays. The `room` begins with the inputs, one after the other, entry j of
        all of them at ``BESIDE j + point``, and takes as many numbers for each of the middle; `columns` is an array
        (BESIDE / chained, m, `row_of(m)`), changed in place.
    """
    return kept_function(name, columns_source(name, inputs, common, middle, between, column, after, chained))


def compiled_beside(name: str, inputs: Sequence[Any], common: Sequence[Any], output: Any) -> Any:
    """Compile what is done to BESIDE points side by side.

    Parameters
    ----------
    name : str
        Of the function.
    inputs : sequence of casadi.SX
        Column vectors of symbols, each point with its own.
    common : sequence of casadi.SX
        Further inputs, the same for all points.
    output : casadi.SX
        Column vector; it is not longer than the inputs.

    Returns
    -------
    numba cfunc
        ``f(*common, room)``, flat arrays. The `room` holds the inputs, one after the other, entry j of all of them at
        ``BESIDE j + point``; the output overwrites the first of them.
    """
    return kept_function(name, beside_source(name, inputs, common, output))


@inlined
def row_of(count: int) -> int:
    """Length of a row of so many columns."""
    return -(-count // BESIDE) * BESIDE


def source(name: str, inputs: Sequence[Any], outputs: Sequence[Any]) -> str:
    """Return the text of a module that defines the function, see `compiled`."""
    import casadi

    function = casadi.Function(name, list(inputs), [casadi.densify(o) for o in outputs])
    arguments = [f"i{i}" for i in range(len(inputs))] + [f"o{i}" for i in range(len(outputs))]
    lines = _lines(function, "    ", lambda i, j: f"i{i}[{j}]", lambda i, j: f"o{i}[{j}]", "w")
    return _head(name, arguments) + "\n".join(lines) + "\n"


def columns_source(
    name: str,
    inputs: Sequence[Any],
    common: Sequence[Any],
    middle: Sequence[Any],
    between: Sequence[Any],
    column: Any,
    after: Any,
    chained: int,
) -> str:
    """Return the text of a module that defines the function, see `compiled_columns`.

    Inputs and middle share one array: of several, the compiler would have to ask at run time whether they overlap, and
    gives so short a loop up.
    """
    import casadi

    own = casadi.vertcat(*inputs)
    first = casadi.Function(name, [own, *common], casadi.cse([casadi.vertcat(*middle)]))
    second = casadi.Function(name, [casadi.vertcat(*between), column], [casadi.densify(after)])
    arguments = [*(f"i{i}" for i in range(1, 1 + len(common))), "room", "columns"]
    row, size, begin = row_of(column.numel()), column.numel(), own.numel()
    lines = _beside(first, common, lambda i, j: f"room[{BESIDE * (begin + j)} + l]")
    lines.append(f"    for q in range({BESIDE}):")
    lines += [f"        s{j} = room[{BESIDE * (begin + j)} + q]" for j in range(first.numel_out(0))]
    lines.append(f"        at = q // {chained} * {row * size}")
    lines.append(f"        for l in range(at, at + {row}):")
    lines += _lines(
        second, "            ", lambda i, j: f"columns[{row * j} + l]" if i else f"s{j}", lambda i, j: f"a{j}", "v"
    )
    lines += [f"            columns[{row * j} + l] = a{j}" for j in range(after.numel())]  # once all of them are read
    return _head(name, arguments) + "\n".join(lines) + "\n"


def beside_source(name: str, inputs: Sequence[Any], common: Sequence[Any], output: Any) -> str:
    """Return the text of a module that defines the function, see `compiled_beside`."""
    import casadi

    function = casadi.Function(name, [casadi.vertcat(*inputs), *common], [casadi.densify(output)])
    arguments = [*(f"i{i}" for i in range(1, 1 + len(common))), "room"]
    lines = _beside(function, common, lambda i, j: f"a{j}")
    lines += [f"        room[{BESIDE * j} + l] = a{j}" for j in range(output.numel())]  # once all of them are read
    return _head(name, arguments) + "\n".join(lines) + "\n"


def _beside(function: Any, common: Sequence[Any], write: Callable[[int, int], str]) -> list[str]:
    """Loop over the points: their own inputs are in the `room`, what is common to them is read before."""

    def given(i: int, j: int) -> str:
        return f"c{i}_{j}" if i else f"room[{BESIDE * j} + l]"

    lines = [f"    c{i + 1}_{j} = i{i + 1}[{j}]" for i, one in enumerate(common) for j in range(one.numel())]
    return [*lines, f"    for l in range({BESIDE}):", *_lines(function, "        ", given, write, "w")]


def _head(name: str, arguments: Sequence[str]) -> str:
    stamp = source_stamp((trigonometry.__file__, fused_sums.__file__, ways.__file__))
    types = ", ".join(["float64[::1]"] * len(arguments))
    return HEAD.format(stamp=stamp, types=types, name=name, arguments=", ".join(arguments))


def _lines(
    function: Any, indent: str, read: Callable[[int, int], str], write: Callable[[int, int], str], work: str
) -> list[str]:
    """Instructions as Python: `read` and `write` give the places of inputs and outputs, `work` the names between.

    A product that is only added to something is taken into the sum, see `fma`.
    """
    import casadi

    names = {getattr(casadi, key): pattern for key, pattern in OPERATIONS.items()}
    steps, uses = _single_assignments(function)
    products: dict[int, tuple[str, str]] = {}
    lines = []

    def fused(operation: int, of: Sequence[int]) -> str | None:
        """Sum or difference with a product in it."""
        if operation not in (casadi.OP_ADD, casadi.OP_SUB):
            return None
        minus = "-" if operation == casadi.OP_SUB else ""
        if of[1] in products:
            first, second = products.pop(of[1])
            return f"fma({minus}{first}, {second}, {value(of[0])})"
        if of[0] in products:
            first, second = products.pop(of[0])
            return f"fma({first}, {second}, {minus}{value(of[1])})"
        return None

    def value(of: int) -> str:
        """Name of a value; a product that was put off is written down now."""
        if of in products:
            first, second = products.pop(of)
            lines.append(f"{indent}{work}{of} = {first} * {second}")
        return f"{work}{of}"

    for operation, into, of, constant in steps:
        if operation == casadi.OP_CONST:
            lines.append(f"{indent}{work}{into} = {constant!r}")
        elif operation == casadi.OP_INPUT:
            lines.append(f"{indent}{work}{into} = {read(of[0], of[1])}")
        elif operation == casadi.OP_OUTPUT:
            lines.append(f"{indent}{write(of[1], of[2])} = {value(of[0])}")
        elif operation == casadi.OP_MUL and uses.get(into) == 1:
            products[into] = value(of[0]), value(of[1])
        elif operation in names:
            text = fused(operation, of) or names[operation].format(*(value(i) for i in of))
            lines.append(f"{indent}{work}{into} = {text}")
        else:
            raise NotImplementedError(f"casadi operation {operation} in {function.name()}: add it to OPERATIONS")
    return lines


def _single_assignments(function: Any) -> tuple[list[tuple[int, int, list[int], float]], dict[int, int]]:
    """Instructions with every value under a number of its own, and how often each value is read.

    Each is the operation, the number of its value, the values it reads and its constant; an input reads the places it
    is at, an output its value and the places it goes to.
    """
    import casadi

    steps: list[tuple[int, int, list[int], float]] = []
    uses: dict[int, int] = {}
    now: dict[int, int] = {}  # number of the value that a place of casadi's holds
    for k in range(function.n_instructions()):
        operation, into = function.instruction_id(k), function.instruction_output(k)
        of = function.instruction_input(k)
        if operation in (casadi.OP_CONST, casadi.OP_INPUT):
            constant = float(function.instruction_constant(k)) if operation == casadi.OP_CONST else 0.0
            steps.append((operation, k, list(of), constant))
        else:
            read = [now[i] for i in of]
            for i in read:
                uses[i] = uses.get(i, 0) + 1
            steps.append((operation, k, read + (list(into) if operation == casadi.OP_OUTPUT else []), 0.0))
        if operation != casadi.OP_OUTPUT:
            now[into[0]] = k
    return steps, uses
