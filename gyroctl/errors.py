"""The one error that bad input raises: it names the field, the value and the mend. And errors in words."""

from __future__ import annotations

import errno
import re
import traceback
from enum import Enum
from pathlib import Path


class NotGiven(Enum):
    """Stands for a value where there is none."""

    NOT_GIVEN = "not given"


NOT_GIVEN = NotGiven.NOT_GIVEN
"""In place of the value in an error about something that was left out."""


class InputError(ValueError):
    """Input that cannot be used.

    Parameters
    ----------
    field : str
        Name of the field as the user typed or should have typed it, e.g. ``"sea.hs"``.
    value : object
        The value that was given, or `NOT_GIVEN`, which is kept as None.
    problem : str
        What is wrong with it, one clause without a full stop.
    mend : str
        What to do about it, one sentence without a full stop.
    """

    def __init__(self, field: str, value: object, problem: str, mend: str) -> None:
        self.field, self.problem, self.mend = field, problem, mend
        self.value, self._told = None if value is NOT_GIVEN else value, value
        given = "is not given" if value is NOT_GIVEN else f"= {_shown(value)}"
        super().__init__(f"{_line(field)} {given}: {_line(problem)}. {_line(mend)}.")

    def __reduce__(self) -> tuple[type[InputError], tuple[str, object, str, str]]:
        """Keep the four parts when the error crosses a process boundary."""
        return InputError, (self.field, self._told, self.problem, self.mend)


LONGEST = 300
"""Characters of a value, and of each other part, that an error shows."""


def _shown(value: object) -> str:
    """Value as an error shows it: whatever was given, in one line of bounded length."""
    if isinstance(value, int) and value.bit_length() > 1000:  # Python refuses to write out what is larger still
        return f"a whole number of {value.bit_length()} bits"
    if isinstance(value, str):
        value = value if len(value) <= LONGEST else value[:LONGEST] + "..."
    try:
        return _line(repr(value))
    except (ValueError, RecursionError):
        return f"a {type(value).__name__}"


def _line(text: str) -> str:
    """Text that cannot steer a terminal, shortened."""
    plain = visible(text[: 4 * LONGEST]).replace("\n", "\\n").replace("\t", "\\t")
    return plain if len(text) <= 4 * LONGEST else plain + "..."


def check_kind(field: str, value: object, kind: type | tuple[type, ...], what: str, mend: str) -> None:
    """Refuse an argument of another kind.

    Raises
    ------
    InputError
        Field `field`, with the name of the kind that was given as its value.
    """
    if not isinstance(value, kind):
        raise InputError(field, type(value).__name__, f"is not {what}", mend)


def in_words(error: BaseException) -> str:
    """Tell an error: what refuses input, or names a law, says all in its text; of any other also kind and place."""
    text = visible(without_addresses(str(error)))
    if isinstance(error, InputError) or type(error).__name__ == "LawError":
        return text
    last = traceback.extract_tb(error.__traceback__)[-1:]
    place = "".join(f" ({Path(frame.filename).name}, line {frame.lineno})" for frame in last)
    return f"{type(error).__name__}: {text}{place}"


def visible(text: str) -> str:
    """Text with escapes for what cannot be printed: a message steers no terminal, and can always be written."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c in "\n\t" else c.encode("unicode_escape").decode() for c in text)


SAFE = "What is finished is stored whole and will not be computed again"

MEND = "mend that, and give the same command again"

ANEW = "give the same command again where a scheduler runs, or without --scheduler"

MENDS = {
    errno.ENOSPC: "make room, and give the same command again",
    errno.EDQUOT: "make room, and give the same command again",
    errno.EFBIG: "allow larger files (ulimit -f), and give the same command again",
    errno.EISDIR: "remove that folder, and give the same command again",
    errno.EROFS: "choose a folder that can be written to",
    errno.EACCES: "choose a folder that you may write to, or ask for the right to",
    errno.EPERM: "choose a folder that you may write to, or ask for the right to",
    errno.EMFILE: "allow more open files (ulimit -n), or give fewer --workers",
    errno.ENOMEM: "give fewer --workers or a shorter duration, and the same command again",
}
"""What to do where the system refuses."""


def went_wrong(error: BaseException) -> str:
    """Tell in one line what the system refused, what is safe, and what to do."""
    mend = "give fewer --workers or a shorter duration, and the same command again"
    if isinstance(error, OSError):
        what = (error.strerror or str(error) or type(error).__name__) + (
            f": {error.filename}" if error.filename else ""
        )
        other = ANEW if isinstance(error, ConnectionError) else MEND
        mend = MENDS.get(error.errno or 0, other)
    elif isinstance(error, ImportError):
        what = f"a library could not be loaded ({visible(str(error))})"
        mend = "allow more memory (ulimit -v) or mend the installation, and give the same command again"
    elif isinstance(error, MemoryError) or type(error) is RuntimeError:  # of a thread that cannot be started
        what = "there is not memory enough" + (f" ({error})" if str(error) else "")
    else:
        what = "a worker process was lost: it was killed, perhaps for want of memory"
    return f"{what}. {SAFE}: {mend}.".replace("\n", " ")


def without_addresses(text: str) -> str:
    """Text of an error without the addresses of objects, which differ from run to run and tell nobody anything."""
    return re.sub(r"<?([\w.]+)?( object)? at 0x[0-9a-fA-F]+>?", lambda found: found.group(1) or "an object", text)
