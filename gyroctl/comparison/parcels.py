"""Items on their way to a process: what many of them share is packed once, and unpacked once where they run.

What a plant and the synthesis of a sea are asked for is kept by those who are asked, or for the very same objects, see
`gyroctl.waves.realise`. An item that brought its own copies would compute all of it anew.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import cloudpickle

from gyroctl.comparison.items import Item

SHARED = ("plant", "waves", "settings")
NOTHING: dict[str, Any] = dict.fromkeys((*SHARED, "law"))


class Parcel(NamedTuple):
    """An item, taken apart."""

    item: Item  # without its law and what it shares
    law: bytes
    shared: bytes


def parcels(items: Iterable[Item], law: bytes) -> Iterator[Parcel]:
    """Pack items of one law, which is packed already; plant and waves that are shared are the same bytes."""
    last: Item | None = None
    shared = b""
    for item in items:
        if last is None or any(getattr(item, name) is not getattr(last, name) for name in SHARED):
            shared = cloudpickle.dumps(tuple(getattr(item, name) for name in SHARED))
        last = item
        yield Parcel(replace(item, **NOTHING), law, shared)


def opened(parcel: Parcel, law: Any) -> Item:
    """Return the item, of a law that is unpacked."""
    return replace(parcel.item, law=law, **dict(zip(SHARED, _shared(parcel.shared), strict=True)))


def law_of(parcel: Parcel) -> Any:
    """Return the law that every parcel of it brings: it holds no state of a run, or a run must have its own copy."""
    return _law(parcel.law)


@lru_cache(maxsize=2)  # a plant has its tables with it, and a worker does one study at a time
def _shared(packed: bytes) -> Any:
    return cloudpickle.loads(packed)


@lru_cache(maxsize=64)
def _law(packed: bytes) -> Any:
    return cloudpickle.loads(packed)
