"""A law on its way to another process or machine, which does not have the modules of a user."""

from __future__ import annotations

import io
import sys
from collections import ChainMap
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any, ClassVar

import cloudpickle

from gyroctl.errors import InputError
from gyroctl.fingerprint.local import sources
from gyroctl.harness.protocol import Law, Wrapping, innermost

PACKAGE = "gyroctl."


def is_ours(law: Law | None) -> bool:
    """Whether the law, and every law within it, comes with this package: such a law keeps the protocol."""
    while law is not None and type(law).__module__.startswith(PACKAGE):
        law = law.law if isinstance(law, Wrapping) else None
    return law is None


def modules_of(law: Law) -> Iterator[str]:
    """Modules of this package that a law and those within it are of."""
    one: Any = law
    while one is not None:
        name = type(one).__module__
        if name.startswith(PACKAGE):
            yield name
        one = one.law if isinstance(one, Wrapping) else None


def by_value(law: Law) -> bytes:
    """Pack a law with the text of its own modules.

    Raises
    ------
    InputError
        For a law that holds what cannot be packed.
    """
    module = sys.modules.get(type(innermost(law)).__module__)
    local = [] if is_ours(law) else [one for one in _local_modules(law) if one.__name__ != "__main__"]
    if module is not None and not is_ours(law) and module.__name__ != "__main__" and module not in local:
        local.append(module)
    for one in local:
        cloudpickle.register_pickle_by_value(one)
    packed = io.BytesIO()
    try:
        _Packing(packed).dump(law)
    except Exception as error:  # what a user's object may do when it is asked for its parts
        problem = f"cannot be sent to a process of its own, nor to another machine ({type(error).__name__}: {error})"
        mend = "Keep plain values, functions and classes in it and in its file, and open what else it needs in init"
        raise InputError("law", type(law).__name__, problem, mend) from error
    finally:
        for one in local:
            cloudpickle.unregister_pickle_by_value(one)
    return packed.getvalue()


def _kept_anew(function: Any) -> Any:
    """How a function that keeps its results travels: with an empty memory, where its module stays behind."""
    module = function.__module__
    known = module in sys.modules and module != "__main__" and module not in cloudpickle.list_registry_pickle_by_value()
    return function.__qualname__ if known else (_keeping, (function.__wrapped__, function.cache_parameters()))


def _keeping(function: Any, how: dict[str, Any]) -> Any:
    return lru_cache(**how)(function)


class _Packing(cloudpickle.Pickler):  # type: ignore[misc]
    dispatch_table: ClassVar = ChainMap({type(lru_cache(int)): _kept_anew}, cloudpickle.Pickler.dispatch_table)


def _local_modules(law: Law) -> list[Any]:
    """Modules that lie beside a law from elsewhere and that it imports, one through another."""
    file = vars(type(innermost(law)))["step"].__code__.co_filename if "step" in vars(type(innermost(law))) else ""
    files = {str(path) for path in sources([Path(file)]).files} if file else set()
    found = []
    for one in list(sys.modules.values()):
        where = getattr(one, "__file__", None)
        if where and str(Path(where).resolve()) in files:
            found.append(one)
    return found
