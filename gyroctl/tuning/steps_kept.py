"""What a folder of tunings holds: steps that are done or left, and a sample of them computed again."""

from __future__ import annotations

import json
import math
import random
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from gyroctl.engine.again import Again, copy_study
from gyroctl.engine.plan import Plan, Wanted, plans
from gyroctl.errors import in_words
from gyroctl.tuning.log import TuningLog
from gyroctl.tuning.stages import Plan as Budget

LOG = "*.jsonl"


@contextmanager
def noted(folder: Path | None, log: TuningLog, case: str, budget: Budget) -> Iterator[None]:
    """Note which steps a tuning is going to take, and at which it fails: by it `gyroctl status` tells what is left."""
    name = log.path.name if log.path is not None else ""
    counts = {"search": budget.generations, "confirm": budget.points}
    items = [Wanted(f"{name} {what} {n}", what, n) for what, most in counts.items() for n in range(most)]
    with Plan(folder, case, items) as plan:
        try:
            yield
        except Exception as error:
            kept = done(folder) if folder is not None else ()
            for item in [item for item in items if item.key not in kept][:1]:
                plan.failed(item.key, in_words(error))
            raise


def done(folder: Path) -> set[str]:
    """Keys of the steps that are done, as `noted` names them."""
    logs = {path.name: path for path in sorted(folder.glob(LOG))}
    ended = [item.key for plan in plans(folder) if plan.ended for item in plan.items]
    found = {key for key in ended if key.rsplit(" ", 2)[0] in logs}  # of points that are the same one was confirmed
    for path in logs.values():
        steps = TuningLog(path).steps
        confirmed = sum(key.startswith("confirm ") for key in steps)
        found |= {f"{path.name} {key}" for key in steps if not key.startswith("confirm ")}
        found |= {f"{path.name} confirm {number}" for number in range(confirmed)}
    return found


class Kept(NamedTuple):
    """A step that was withheld."""

    file: str
    key: str
    value: Any
    made: dict[str, Any]


class Sample(NamedTuple):
    """Steps that were withheld, and how many there are in all."""

    steps: tuple[Kept, ...]
    stored: int


def withhold(folder: Path, into: Path, share: float, count: int | None, seed: int | None) -> Sample:
    """Copy a folder of tunings but for a sample of its steps.

    Parameters
    ----------
    folder : Path
        Of the tunings.
    into : Path
        New folder.
    share : float
        Part of the steps that are withheld, one at least. [1]
    count : int, optional
        How many instead.
    seed : int, optional
        Of the sample, to draw it again.
    """
    kept = [step for path in sorted(folder.glob(LOG)) for step in _steps(path)]
    many = count if count is not None else math.ceil(share * len(kept))
    sample = random.Random(seed).sample(kept, min(many, len(kept)))
    held = {(step.file, step.key) for step in sample}
    copy_study(folder, into, {path.name for path in folder.glob(LOG)})
    for path in sorted(folder.glob(LOG)):
        log = TuningLog(into / path.name)
        for step in _steps(path):
            if (step.file, step.key) not in held:
                log.add(step.key, step.value)
    return Sample(tuple(sample), len(kept))


def compared(sample: Sequence[Kept], folder: Path) -> list[Again]:
    """Compare the steps that were withheld with what was made instead of them, bit by bit."""
    return [
        Again({"step": f"{step.file}: {step.key}"[:120], **step.made}, tuple(_differs(step, folder))) for step in sample
    ]


def _differs(step: Kept, folder: Path) -> Iterator[str]:
    value = TuningLog(folder / step.file).get(step.key)
    if value is None:
        yield "not made again: the command asks for other work, or other versions made it"
    elif json.dumps(value) != json.dumps(step.value):  # floats to the last bit
        yield "its numbers"


def _steps(path: Path) -> list[Kept]:
    log = TuningLog(path)
    return [Kept(path.name, key, value, log.made.get(key, {})) for key, value in log.steps.items()]
