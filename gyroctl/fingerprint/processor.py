"""The instruction set that code is compiled and dispatched for.

Machine code of the plant, the waves and the rule-based laws gives the same bits whether it is compiled for this
processor, for an older one or for a generic one: fused operations are asked for by name, and contraction is off. Linear
algebra does not: with the routines of another processor the planning law gives other bits, and so may a user's law or a
margin. Nobody can tell from outside which work asks for linear algebra, so that the processor counts for all of it.
"""

from __future__ import annotations

import os
from functools import cache


def processor() -> str:
    """Instructions that numba compiles for, and those that NumPy found and linear algebra was told to use."""
    return " ".join(part for part in (_compiled_for(), _numpy(), os.environ.get("OPENBLAS_CORETYPE", "")) if part)


@cache
def _compiled_for() -> str:
    """Vector instructions that the compiler may use, or the processor that it was told to take for this one."""
    from llvmlite.binding import get_host_cpu_features  # type: ignore[import-untyped]
    from numba import config

    if config.CPU_NAME:
        return f"{config.CPU_NAME} {config.CPU_FEATURES or ''}".strip()
    features = get_host_cpu_features()
    wanted = ("sse4.2", "avx", "avx2", "fma", "avx512f", "avx512vl", "neon", "sve")
    return " ".join(name for name in wanted if features.get(name))


@cache
def _numpy() -> str:
    import numpy as np

    found = np.show_config(mode="dicts").get("SIMD Extensions", {})  # type: ignore[call-overload, union-attr]
    return " ".join([*found.get("baseline", ()), *found.get("found", ())])
