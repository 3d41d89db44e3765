"""The steps of a piece of work that takes long: each is kept when it is finished, and found again."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from gyroctl.engine.packing import packed, unpacked
from gyroctl.engine.plan import Plan, Wanted
from gyroctl.engine.record import Damaged
from gyroctl.engine.store import Store
from gyroctl.errors import in_words
from gyroctl.fingerprint import code_of, text_of

Result = TypeVar("Result")


class Failed(NamedTuple):
    """What a step gave that was done elsewhere and failed."""

    error: Exception


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
        self.given_here: dict[str, Any] = {}  # results of steps done elsewhere that the store does not hold

    def key(self, name: str) -> str:
        """Key of a step."""
        text = json.dumps([code_of(*self.modules), self.given, name])
        return hashlib.sha256(text.encode()).hexdigest() if self.given else ""

    def kept(self, name: str) -> Any:
        """Return the result of a step as it was kept, None where it was not."""
        record = self.store.load(self.key(name))
        if record is None:
            return None
        try:
            return unpacked(record.content.get("result"), record.arrays, self.kinds)
        except Damaged as error:
            self.store.refused[str(error)] += 1
            return None

    def give(self, name: str, result: Any) -> None:
        """Take the result of a step that was done elsewhere, or its `Failed`, for when it is asked for."""
        if isinstance(result, Failed) or not self.key(name) or self.store.folder is None:
            self.given_here[name] = result
        else:
            self._keep(name, result)

    def __call__(self, name: str, compute: Callable[[], Result]) -> Result:
        """Return the result of a step: as it was kept, or computed now and kept."""
        kept = self.kept(name)
        if kept is not None:
            found: Result = kept
            return found
        self.store.tell()
        try:
            result = self._taken(name) if name in self.given_here else compute()
        except Exception as error:
            self.plan.failed(self.key(name) or f"{name} 0", in_words(error))
            raise
        self._keep(name, result)
        return result

    def _taken(self, name: str) -> Any:
        """Take what was done elsewhere; where that failed, raise what it raised."""
        result = self.given_here.pop(name)
        if isinstance(result, Failed):
            raise result.error
        return result

    def _keep(self, name: str, result: Any) -> None:
        content, arrays = packed(result)
        about = {"case": self.case, "step": name, "code": {" ".join(self.modules): text_of(*self.modules)}}
        self.store.save(self.key(name), {"result": content}, arrays, about)


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
