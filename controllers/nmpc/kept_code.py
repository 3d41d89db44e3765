"""Functions written as text: a module of their own in memory, of which the machine code is kept under the text's hash.

The text is never read from a file: it is written anew by each process that needs it, and only what came of it is kept,
under a seal (`gyroctl.plant.machine_code`).
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Callable
from types import ModuleType
from typing import Any

from gyroctl.plant.machine_code import kept_callback


def kept_function(name: str, text: str) -> Any:
    """Return the function `name` of a module with this text, in which ``@kept(signature)`` makes a function pointer."""
    stamp = hashlib.sha256(text.encode()).hexdigest()
    stem = f"{name}_{stamp[:16]}"
    if stem not in sys.modules:

        def kept(signature: Any) -> Callable[[Any], Any]:
            return lambda function: kept_callback(function, signature, stamp, error_model="numpy")

        module = ModuleType(stem)
        module.__dict__["kept"] = kept
        sys.modules[stem] = module  # numba finds a cached function again by the name of its module
        try:
            exec(compile(text, f"<{stem}>", "exec"), module.__dict__)
        except BaseException:
            del sys.modules[stem]
            raise
    return getattr(sys.modules[stem], name)
