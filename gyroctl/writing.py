"""Files that appear whole or not at all, and what JSON can hold."""

from __future__ import annotations

import csv
import json
import math
import os
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gyroctl.errors import in_words
from gyroctl.names import in_cell


@contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """Give a path beside `path` to write to; what was written replaces `path` at the end, or leaves no trace.

    The name cannot be guessed and is made by this process alone, so that two writers do not meet and no link that
    waits under the name is followed. What is written is on the disk before the name is.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.stem}.", suffix=f".part{path.suffix}")
    os.close(handle)
    part = Path(name)
    try:
        part.chmod(0o666 & ~_umask())
        yield part
        with part.open("rb+") as file:
            os.fsync(file.fileno())
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> Path:
    """Write a text file whole or not at all."""
    with written_whole(path) as part:
        part.write_text(text, encoding="utf-8", newline="\n")
    return path


def write_json(path: Path, content: Any) -> Path:
    """Write a JSON file whole or not at all, see `plain`."""
    return write_text(path, json.dumps(plain(content), indent=1, allow_nan=False, ensure_ascii=False) + "\n")


class Kept:
    """A report in JSON that is made in stages: what is finished is on the disk, whatever happens to the rest.

    Parameters
    ----------
    content : dict
        What is written; the stages add to it.
    path : Path, optional
        JSON file, written after each stage; without it nothing is written.
    """

    def __init__(self, content: dict[str, Any], path: Path | None = None) -> None:
        self.content, self.path = content, path
        self.failed: dict[str, str] = {}
        self.errors: list[Exception] = []

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Do a part of the work: where it fails, its name and the reason are kept, and the others go on."""
        try:
            yield
        except Exception as error:  # also what a user's law can raise: the other stages do not depend on it
            self.failed[name] = in_words(error)
            self.errors.append(error)
        self.write()

    def write(self) -> None:
        """Write what there is, what failed beside it."""
        self.content["failed"] = dict(self.failed)
        if self.path is not None:
            write_json(self.path, self.content)


def write_rows(path: Path, rows: Iterable[Iterable[Any]]) -> Path:
    """Write a CSV file whole or not at all; no text in it is a formula."""
    with written_whole(path) as part, part.open("w", newline="", encoding="utf-8") as stream:
        csv.writer(stream).writerows([in_cell(value) for value in row] for row in rows)
    return path


def plain(value: Any) -> Any:
    """Return what JSON can hold.

    NumPy's numbers and arrays become Python's, records tables, complex numbers pairs; what is not finite becomes null.
    """
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, complex):
        return [plain(value.real), plain(value.imag)]
    if is_dataclass(value) and not isinstance(value, type):
        value = asdict(value)
    elif isinstance(value, tuple) and hasattr(value, "_asdict"):
        value = value._asdict()
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [plain(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _umask() -> int:
    """Permissions that this process withholds from new files; mkstemp withholds all but the owner's."""
    mask = os.umask(0)
    os.umask(mask)
    return mask
