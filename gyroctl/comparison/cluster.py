"""Work items on other machines: pieces of one law each, by the cluster of the engine."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from contextlib import closing
from typing import Any, NamedTuple

from gyroctl.comparison import items as work
from gyroctl.comparison.alone import in_a_process
from gyroctl.comparison.execution import is_machine, perform_packed
from gyroctl.comparison.items import Item, Outcome, failed
from gyroctl.comparison.parcels import Parcel, law_of, opened, parcels
from gyroctl.engine.cluster import FEWEST, Lost, Task, connected, hand_out, threads_of, told_if_lost
from gyroctl.errors import InputError
from gyroctl.fingerprint import code_of
from gyroctl.harness.law_entry import compile_law
from gyroctl.harness.together import pieces
from gyroctl.harness.travelling import by_value, is_ours, modules_of

__all__ = ["Piece", "connected", "run_far", "run_there"]


class Piece(NamedTuple):
    """Items of one law that are handed out at once."""

    parcels: tuple[Parcel, ...]
    ours: bool  # whether the law comes with this package, and keeps its protocol
    machine: bool  # whether it runs side by side


def run_far(client: Any, items: Sequence[Item], _: int = 0) -> Generator[tuple[Item, Outcome], None, None]:
    """Run items on the workers of a scheduler, however many, and yield each with its outcome as they end.

    Raises
    ------
    ConnectionError
        Where the scheduler is lost.
    InputError
        Field ``scheduler``, where no worker would give the same bits.
    """
    with told_if_lost(client):
        threads = max(threads_of(client), FEWEST)
    of_law: dict[str, list[Item]] = {}
    for item in items:
        of_law.setdefault(item.name, []).append(item)
    packed: dict[str, bytes] = {}
    for name, own in of_law.items():
        try:
            packed[name] = by_value(own[0].law)
        except InputError as error:  # its runs fail, and no others
            yield from ((item, failed(item, f"law {name!r} {error.problem}. {error.mend}")) for item in own)
    there = [(own, packed[name]) for name, own in of_law.items() if name in packed]
    with closing(hand_out(client, run_there, _handed_out(there, threads), _apart)) as ended:
        for task, found in ended:
            if isinstance(found, Lost):
                found = [failed(item, f"law {item.name!r} {found.value}") for item in task.own]
            yield from zip(task.own, found, strict=True)


def _handed_out(of_laws: Sequence[tuple[list[Item], bytes]], threads: int) -> Iterator[Task]:
    """Share out items law by law, each packed, those that run side by side together."""
    for own, law in of_laws:
        piece, modules, code = _kind(own[0].law)
        sent = list(parcels(own, law))
        alone = [slice(i, i + 1) for i in range(len(own))]
        for part in pieces(len(own), threads) if piece.machine else alone:
            yield Task(piece._replace(parcels=tuple(sent[part])), own[part], modules, code)


def _kind(law: Any) -> tuple[Piece, tuple[str, ...], str]:
    """Piece of work of a law, without its items, and the modules of this package that do it with their hash."""
    ours, modules = is_ours(law), tuple(sorted({work.__name__, *modules_of(law)}))
    return Piece((), ours, ours and is_machine(law)), modules, code_of(*modules)


def _apart(task: Task) -> list[Task]:
    """Items of a task, each as a task of its own."""
    pairs = zip(task.what.parcels, task.own, strict=True)
    return [task._replace(what=task.what._replace(parcels=(sent,)), own=[item]) for sent, item in pairs]


def run_there(piece: Piece) -> list[Outcome]:
    """Run a piece of work on a worker."""
    if not piece.ours:  # whatever such a law does, its run fails alone and can be stopped
        return [outcome for parcel in piece.parcels for outcome in in_a_process(parcel)]
    if not piece.machine:
        return [outcome for parcel in piece.parcels for outcome in perform_packed(parcel)]
    law = law_of(piece.parcels[0])
    compile_law(law)
    return work.perform([opened(parcel, law) for parcel in piece.parcels])
