"""The one error that bad input raises: it names the field, the value and the mend."""

from __future__ import annotations


class InputError(ValueError):
    """Input that cannot be used.

    Parameters
    ----------
    field : str
        Name of the field as the user typed or should have typed it, e.g. ``"sea.hs"``.
    value : object
        The value that was given.
    problem : str
        What is wrong with it, one clause without a full stop.
    mend : str
        What to do about it, one sentence without a full stop.
    """

    def __init__(self, field: str, value: object, problem: str, mend: str) -> None:
        self.field, self.value, self.problem, self.mend = field, value, problem, mend
        super().__init__(f"{field} = {value!r}: {problem}. {mend}.")

    def __reduce__(self) -> tuple[type[InputError], tuple[str, object, str, str]]:
        """Keep the four parts when the error crosses a process boundary."""
        return InputError, (self.field, self.value, self.problem, self.mend)
