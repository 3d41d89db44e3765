"""A stored result as bytes: a line with the checksum of all that follows, a line of JSON, and arrays.

What is read is believed only where every byte is what was written: a record that was cut short, damaged, edited, or put
under another name is none. Nothing in it is code.
"""

from __future__ import annotations

import hashlib
import io
import json
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

MAGIC = b"gyroctl record 2 "
LARGEST = 1 << 29
"""More than any result takes. What somebody made may tell any size. [B]"""


class Damaged(ValueError):
    """Bytes that are not those of a record that was written."""


@dataclass(frozen=True)
class Record:
    """A result.

    Parameters
    ----------
    key : str
        Hash of all that can change a bit of it.
    content : dict
        Of numbers and texts, as JSON can hold it; floats that are not finite too.
    arrays : dict of str to array
        Numbers, by name. [unit in the name]
    about : dict
        What it is of and what made it: it is told, and no part of the result.
    """

    key: str
    content: dict[str, Any]
    arrays: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    about: Mapping[str, Any] = field(default_factory=dict)


def to_bytes(record: Record) -> bytes:
    """Write a record; floats come back to the last bit."""
    stream = io.BytesIO()
    np.savez(stream, **dict(record.arrays))  # type: ignore[arg-type]
    head = {"key": record.key, "about": dict(record.about), "content": record.content}
    body = json.dumps(head).encode() + b"\n" + stream.getvalue()
    return MAGIC + hashlib.sha256(body).hexdigest().encode() + b"\n" + body


def is_as_written(raw: bytes, key: str) -> bool:
    """Whether the checksum is that of all that follows, and this is of a key."""
    line, _, body = raw.partition(b"\n")
    begin = f'{{"key": {json.dumps(key)},'.encode()
    return body.startswith(begin) and line == MAGIC + hashlib.sha256(body).hexdigest().encode()


def from_bytes(raw: bytes, key: str) -> Record:
    """Read a record that is to have a key.

    Raises
    ------
    Damaged
        For any other bytes than those that were written; the text says what is wrong with them.
    """
    line, _, body = raw.partition(b"\n")
    if not line.startswith(MAGIC):
        raise Damaged("of another format")
    if line != MAGIC + hashlib.sha256(body).hexdigest().encode():
        raise Damaged("not what was written")
    try:
        text, _, arrays = body.partition(b"\n")
        head = json.loads(text)
        with zipfile.ZipFile(io.BytesIO(arrays)) as parts:  # an array that is no archive is none of these
            if sum(part.file_size for part in parts.infolist()) > LARGEST:
                raise Damaged("too large")
        with np.load(io.BytesIO(arrays)) as file:
            record = Record(head["key"], head["content"], {name: file[name] for name in file.files}, head["about"])
    except Damaged:
        raise
    except Exception as error:  # whatever an archive that somebody made with a checksum does to its readers
        raise Damaged(f"not readable ({error})") from error
    if not all(isinstance(part, dict) for part in (record.content, record.about)):
        raise Damaged("of another shape")
    if record.key != key:
        raise Damaged("of other work than its name says")
    return record
