"""Files from outside, read with care: what is no sound file is refused by name, whatever is wrong with it.

Every text that others may have written comes in through here: one place that knows how large, how deep and how strange
a file may be. What it says is checked by those who asked for it.
"""

from __future__ import annotations

import json
import math
import os
import re
import stat
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from gyroctl.errors import InputError

TEXT_MAX = 64 << 20
"""Largest text. [bytes]"""

TOML_MAX = 4 << 20
"""Largest TOML file, which takes about a second. [bytes]"""

JSON_MAX = 16 << 20
"""Largest JSON file: of brackets alone it takes twenty times its size in memory. [bytes]"""

DEEPEST = 32
"""Levels of tables and lists."""

DOTS = 64
"""Dots of a key of TOML: a reader takes the square of their number."""

WHOLE_MAX = 2**63 - 1
"""Largest whole number, as TOML has it."""

UTF16 = (b"\xff\xfe", b"\xfe\xff")
"""Marks at the beginning of a text in UTF-16."""

CONTROL = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f]")
"""Characters that no text of ours has: some steer a terminal."""


def is_finite(value: object) -> bool:
    """Whether `value` is a real number, and finite as a float; true and false are none."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) <= WHOLE_MAX if isinstance(value, int) else math.isfinite(value)


def real(text: str) -> float:
    """Return a number as text has it, without what Python alone allows: ``1_0``.

    Raises
    ------
    ValueError
        For what is no number.
    """
    if "_" in text or not text.isascii():
        raise ValueError(text)
    return float(text)


def existing(field: str, path: Path | str, mend: str) -> Path:
    """Return the path of a file that exists; a folder, a device or a pipe is none."""
    try:
        mode = os.stat(path).st_mode
    except (FileNotFoundError, NotADirectoryError):
        raise InputError(field, str(path), "there is no such file", mend) from None
    except (OSError, ValueError) as error:
        raise InputError(field, str(path), f"cannot be read: {_why(error)}", mend) from None
    if not stat.S_ISREG(mode):
        raise InputError(field, str(path), "is a folder" if stat.S_ISDIR(mode) else "is no file with an end", mend)
    return Path(path)


def read_text(field: str, path: Path | str, mend: str, most: int = TEXT_MAX, errors: str = "strict") -> str:
    """Read a text in UTF-8, with or without a mark of byte order, its lines end as those of Python do.

    Parameters
    ----------
    field : str
        Named by an error.
    path : Path or str
        The file.
    mend : str
        What to do about a file that is none.
    most : int
        Largest size. [bytes]
    errors : str
        As `bytes.decode` takes it: "replace" where older programs may have written other letters.

    Raises
    ------
    InputError
        For a file that is missing, larger, in another encoding, or holds control characters.
    """
    try:
        with existing(field, path, mend).open("rb") as file:
            content = file.read(most + 1)
        if len(content) > most:
            raise InputError(field, str(path), f"is larger than {most >> 20} MB", mend)
        if content.startswith(UTF16) or (len(content) > 3 and b"\0\0" in (content[1:4:2], content[0:4:2])):
            raise InputError(field, str(path), "is a text in UTF-16, not in UTF-8", f"{mend}, in UTF-8")
        text = content.decode("utf-8-sig", errors).removesuffix("\x1a")  # the end of a text of old
    except UnicodeDecodeError:
        raise InputError(field, str(path), "is not a text file in UTF-8", mend) from None
    except OSError as error:
        raise InputError(field, str(path), f"cannot be read: {_why(error)}", mend) from None
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    strange = CONTROL.search(text)
    if strange:
        line = text.count("\n", 0, strange.start()) + 1
        raise InputError(field, str(path), f"has a control character in line {line}", mend)
    return text


def cut_short(text: str, cells: Sequence[str]) -> tuple[str, ...]:
    """Tell of a table that may end within its last number.

    Parameters
    ----------
    text : str
        The whole file.
    cells : sequence of str
        Those of its last column, in their order.

    Returns
    -------
    tuple of str
        A sentence where the last line has no end, and its last cell fewer decimals than each cell above it.
    """
    if text.endswith("\n") or len(cells) < 3:
        return ()
    *above, last = cells
    size, before = _digits(last), [found for found in map(_digits, above) if found is not None]
    if size is None or len(before) < 2:
        return ()
    least = min(size for size, _ in before), min(size for _, size in before)
    if size[0] >= least[0] and size[1] >= least[1]:
        return ()
    return (f"the last line has no end, and its last number, {last[:30]}, fewer digits than those above: is it cut?",)


def _digits(cell: str) -> tuple[int, int] | None:
    """Digits of a number behind the point, and of its exponent; None of what is no number."""
    found = re.fullmatch(r"\s*[+-]?\d*(?:[.,](\d*))?(?:[eEdD][+-]?(\d+))?\s*", cell)
    return (len(found[1] or ""), len(found[2] or "")) if found and cell.strip() else None


def read_toml(field: str, path: Path | str, mend: str = "Give the path of a TOML file") -> dict[str, Any]:
    """Read a TOML file; see `check_tree` for what it may hold."""
    text = read_text(field, path, mend, TOML_MAX)
    for number, line in enumerate(text.split("\n"), 1):
        comment = line.count(".") <= DOTS or line.lstrip().startswith("#")
        if not comment and any(part.count(".") > DOTS for part in re.split("[=,]", line)):
            raise InputError(field, str(path), f"has a key of too many parts in line {number}", "Correct the line")
    try:
        tables = tomllib.loads(text)
    except RecursionError:
        raise InputError(field, str(path), "is nested too deeply", f"Nest at most {DEEPEST} levels") from None
    except ValueError as error:
        raise InputError(field, str(path), f"is no TOML: {_why(error)}", "Correct the line") from None
    check_tree(field, tables)
    return tables


def read_json(field: str, path: Path | str, mend: str, most: int = JSON_MAX) -> Any:
    """Read a JSON file; what is not finite is refused, as JSON has it."""
    return parse_json(field, str(path), read_text(field, path, mend, most), mend)


def parse_json(field: str, name: str, text: str, mend: str, finite: bool = True) -> Any:
    """Parse a JSON text that is called `name`; see `check_tree` for what it may hold."""
    try:
        content = json.loads(text, parse_constant=_refused if finite else None)
    except RecursionError:
        raise InputError(field, name, "is nested too deeply", f"Nest at most {DEEPEST} levels") from None
    except ValueError as error:
        raise InputError(field, name, f"cannot be read: is no JSON: {_why(error)}", mend) from None
    check_tree(field, content, finite)
    return content


def check_tree(field: str, content: Any, finite: bool = False) -> None:
    """Refuse what no sound file holds in any of its tables and lists.

    These are names and texts with control characters, whole numbers beyond 64 bits, more than `DEEPEST` levels, and
    where `finite` is asked for, numbers that are not.

    Raises
    ------
    InputError
        Its field is the path of the entry, as ``sea.hs``.
    """
    left: list[tuple[str, Any, int]] = [("", content, 0)]
    while left:
        path, value, depth = left.pop()
        if isinstance(value, str):
            if CONTROL.search(value):
                raise InputError(path or field, value, "holds a control character", "Leave it out")
        elif isinstance(value, int) and abs(value) > WHOLE_MAX:
            raise InputError(path or field, value, "is too large a number", "Give one of at most 18 digits")
        elif finite and isinstance(value, float) and not math.isfinite(value):
            raise InputError(path or field, value, "must be finite", "Correct the number")
        elif isinstance(value, Mapping | list):
            if depth == DEEPEST:
                raise InputError(field, path, "is nested too deeply", f"Nest at most {DEEPEST} levels")
            if isinstance(value, list):
                left += [(path, one, depth + 1) for one in value]
                continue
            for key, one in value.items():
                if not str(key).isprintable():
                    raise InputError(path or field, key, "is a name with a control character", "Give another name")
                left.append((f"{path}.{key}" if path else str(key), one, depth + 1))


def _refused(name: str) -> float:
    raise ValueError(f"{name} is no number")


def _why(error: Exception) -> str:
    """Say in one line what a library said."""
    text = getattr(error, "strerror", None) or str(error) or type(error).__name__
    return " ".join(str(text).split())[:300]
