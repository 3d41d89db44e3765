"""Which law it is: a hash of the text that defines it and of its parameters."""

from __future__ import annotations

import hashlib
import pickle
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from typing import Any, cast

UNKNOWN = ""
"""Instead of a hash, where a law cannot be told from another one."""


def law_fingerprint(law: Any) -> str:
    """SHA-256 of a law: its source and every field, for a law around a law those of both.

    `UNKNOWN` for a law with hidden state, that is neither a NamedTuple nor a dataclass or holds what cannot be
    pickled, and for one that was typed in by hand and has no file.
    """
    source = law_source(law)
    try:
        state = b"".join(pickle.dumps((type(one).__qualname__, _values(one))) for one in _layers(law))
    except (AttributeError, TypeError, pickle.PicklingError):
        return UNKNOWN
    return hashlib.sha256(state + source.encode()).hexdigest() if source else UNKNOWN


def law_source(law: Any) -> str:
    """SHA-256 of the text of a law and of the law within it: its file, or in a package every file of that.

    `UNKNOWN` where there is no such file. It tells a law that is built from nothing but its name and numbers.
    """
    digest = hashlib.sha256()
    try:
        for one in _layers(law):
            file = Path(type(one).step.__code__.co_filename)
            packed = (file.parent / "__init__.py").is_file()
            for path in sorted(file.parent.rglob("*.py")) if packed else [file]:
                digest.update(path.read_bytes())
    except (AttributeError, OSError):
        return UNKNOWN
    return digest.hexdigest()


def _values(law: Any) -> list[tuple[str, Any]]:
    if isinstance(law, tuple):
        return list(cast(Any, law)._asdict().items())
    return [(field.name, getattr(law, field.name)) for field in fields(law)]


def _layers(law: Any) -> Iterator[Any]:
    """Yield a law and what it is around, from the outside in."""
    while law is not None:
        yield law
        law = getattr(law, "law", None)
