"""A casadi function as compiled machine code, without a C compiler: its instructions written as plain Python for numba.

casadi's own virtual machine takes some nanoseconds per operation; a function of a few hundred operations that is
called 10 000 times per second of simulated time is worth compiling. `Function.generate` would need a C compiler on the
user's machine. An SX function is a straight line of scalar operations, which numba compiles as it stands.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Sequence
from importlib.util import module_from_spec, spec_from_file_location
from typing import Any

from gyroctl.cache import cache_folder
from gyroctl.writing import write_text

SIGNS = {"ADD": "+", "SUB": "-", "MUL": "*", "DIV": "/", "POW": "**", "CONSTPOW": "**"}
FUNCTIONS = ("sin", "cos", "exp", "log", "sqrt", "tanh")
OPERATIONS = {
    **{f"OP_{name}": f"{{0}} {sign} {{1}}" for name, sign in SIGNS.items()},
    **{f"OP_{name.upper()}": f"math.{name}({{0}})" for name in FUNCTIONS},
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
    text = source(name, inputs, outputs)
    stem = f"{name}_{hashlib.sha256(text.encode()).hexdigest()[:16]}"
    file = cache_folder() / f"{stem}.py"
    if not file.is_file():  # whole: another process may do the same at the same time
        write_text(file, text)
    spec = spec_from_file_location(stem, file)
    assert spec is not None and spec.loader is not None
    module = module_from_spec(spec)
    sys.modules[stem] = module  # numba finds a cached function again by the name of its module
    spec.loader.exec_module(module)
    return getattr(module, name)


def source(name: str, inputs: Sequence[Any], outputs: Sequence[Any]) -> str:
    """Return the text of a module that defines the function, see `compiled`."""
    import casadi

    function = casadi.Function(name, list(inputs), [casadi.densify(o) for o in outputs])
    names = {getattr(casadi, key): pattern for key, pattern in OPERATIONS.items()}
    arguments = [f"i{i}" for i in range(len(inputs))] + [f"o{i}" for i in range(len(outputs))]
    lines = [
        "import math\n\nfrom numba import cfunc, float64, void\n\n",
        f"@cfunc(void({', '.join(['float64[::1]'] * len(arguments))}), cache=True, error_model='numpy')",
        f"def {name}({', '.join(arguments)}):",
    ]
    for k in range(function.n_instructions()):
        operation, into = function.instruction_id(k), function.instruction_output(k)
        if operation == casadi.OP_CONST:
            lines.append(f"    w{into[0]} = {float(function.instruction_constant(k))!r}")
            continue
        of = function.instruction_input(k)
        if operation == casadi.OP_INPUT:
            lines.append(f"    w{into[0]} = i{of[0]}[{of[1]}]")
        elif operation == casadi.OP_OUTPUT:
            lines.append(f"    o{into[0]}[{into[1]}] = w{of[0]}")
        elif operation in names:
            lines.append(f"    w{into[0]} = " + names[operation].format(*(f"w{i}" for i in of)))
        else:
            raise NotImplementedError(f"casadi operation {operation} in {name}: add it to OPERATIONS")
    return "\n".join(lines) + "\n"
