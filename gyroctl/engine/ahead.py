"""Steps done on other machines before they are asked for here: kept as they end, and found when they are asked for."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Sequence
from contextlib import closing
from typing import Any, NamedTuple

from gyroctl.engine.cluster import Lost, Task, hand_out
from gyroctl.engine.steps import Failed, Steps
from gyroctl.errors import in_words
from gyroctl.fingerprint import code_of


class Piece(NamedTuple):
    """A step, and what a worker does for it."""

    steps: Steps
    name: str
    do: Callable[..., Any]  # of a module of this package
    given: tuple[Any, ...]  # what `do` is given; values that can be sent
    modules: tuple[str, ...] = ()  # that do it beside those of the steps, such as a law's


def do_ahead(client: Any, pieces: Sequence[Piece], done: Callable[[], None] = lambda: None) -> None:
    """Let the workers of a scheduler do the steps that are not kept yet; what fails there fails where it is asked for.

    Parameters
    ----------
    client : dask.distributed.Client
        Of the scheduler.
    pieces : sequence of Piece
        Steps that do not wait for one another.
    done : callable
        Told of each piece, also of those that were kept before.

    Raises
    ------
    ConnectionError
        Where the scheduler is lost; what had ended is kept.
    InputError
        Field ``scheduler``, where no worker would give the same bits.
    OSError
        Where a result cannot be stored.
    """
    tasks = []
    for piece in pieces:
        if piece.steps.kept(piece.name) is not None:
            done()
            continue
        modules = tuple(sorted({*piece.steps.modules, *piece.modules}))
        tasks.append(Task((piece.do, piece.given), piece, modules, code_of(*modules)))
    with closing(hand_out(client, do_there, tasks, lambda task: [task])) as ended:
        for task, found in ended:
            if isinstance(found, Lost):
                found = Failed(RuntimeError(f"{task.own.name} {found.value}"))
            task.own.steps.give(task.own.name, found)
            done()


def do_there(what: tuple[Callable[..., Any], tuple[Any, ...]]) -> Any:
    """Do a step on a worker; an error of the step is its answer, and concerns no other one."""
    do, given = what
    try:
        return do(*given)
    except (MemoryError, ImportError):  # of the worker, not of the step
        raise
    except Exception as error:  # whatever a user's law can raise
        return Failed(_that_travels(error))


def _that_travels(error: Exception) -> Exception:
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:  # what a class of a user's own may do
        return RuntimeError(in_words(error))
    return error
