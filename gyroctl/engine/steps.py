"""The steps of a piece of work that takes long: each is kept when it is finished, and found again."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple, TypeVar

from gyroctl.engine.packing import packed, unpacked
from gyroctl.engine.plan import Plan, Wanted
from gyroctl.engine.record import Damaged
from gyroctl.engine.store import Store
from gyroctl.errors import in_words
from gyroctl.fingerprint import code_of, text_of

Result = TypeVar("Result")


class Steps:
    """Keeps the results of steps.

    Parameters
    ----------
    folder : Path or None
        Of the stored results; None keeps nothing.
    given : str
        Hash of all that the steps are given; empty where it is not known, and then nothing is kept.
    modules : sequence of str
        Modules that compute them.
    kinds : sequence of type
        Classes of which their results are made.
    case : str
        What they are of, in words.
    """

    def __init__(
        self, folder: Path | None, given: str, modules: Sequence[str], kinds: Sequence[type], case: str = ""
    ) -> None:
        self.store = Store(folder)
        self.given, self.modules, self.kinds, self.case = given, tuple(modules), tuple(kinds), case
        self.plan = Plan(None, case, ())

    def key(self, name: str) -> str:
        """Key of a step."""
        text = json.dumps([code_of(*self.modules), self.given, name])
        return hashlib.sha256(text.encode()).hexdigest() if self.given else ""

    def __call__(self, name: str, compute: Callable[[], Result]) -> Result:
        """Return the result of a step: as it was kept, or computed now and kept."""
        key = self.key(name)
        record = self.store.load(key)
        if record is not None:
            try:
                kept: Result = unpacked(record.content.get("result"), record.arrays, self.kinds)
            except Damaged as error:
                self.store.refused[str(error)] += 1
            else:
                return kept
        self.store.tell()
        try:
            result = compute()
        except Exception as error:
            self.plan.failed(key or f"{name} 0", in_words(error))
            raise
        content, arrays = packed(result)
        about = {"case": self.case, "step": name, "code": {" ".join(self.modules): text_of(*self.modules)}}
        self.store.save(key, {"result": content}, arrays, about)
        return result


class Asked(NamedTuple):
    """A step that is wanted, and how it is called where its state is told."""

    steps: Steps
    name: str
    law: str
    seed: int = 0


@contextmanager
def planned(folder: Path | None, case: str, asked: Sequence[Asked]) -> Iterator[None]:
    """Note which steps are wanted while they are done: by it `gyroctl status` tells what is left."""
    with Plan(folder, case, [Wanted(one.steps.key(one.name), one.law, one.seed) for one in asked]) as plan:
        for one in asked:
            one.steps.plan = plan
        yield
