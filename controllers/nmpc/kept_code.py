"""Functions written as text: a module of their own in the cache folder, whose machine code numba keeps beside it."""

from __future__ import annotations

import hashlib
import sys
from importlib.util import module_from_spec, spec_from_file_location
from typing import Any

from gyroctl.cache import cache_folder
from gyroctl.writing import write_text


def kept_function(name: str, text: str) -> Any:
    """Return the function `name` of a module with this text; it is kept by the hash of the text."""
    stem = f"{name}_{hashlib.sha256(text.encode()).hexdigest()[:16]}"
    if stem not in sys.modules:
        file = cache_folder() / f"{stem}.py"
        if not file.is_file():  # whole: another process may do the same at the same time
            write_text(file, text)
        spec = spec_from_file_location(stem, file)
        assert spec is not None and spec.loader is not None
        module = module_from_spec(spec)
        sys.modules[stem] = module  # numba finds a cached function again by the name of its module
        try:
            spec.loader.exec_module(module)
        except BaseException:
            del sys.modules[stem]
            raise
    return getattr(sys.modules[stem], name)
