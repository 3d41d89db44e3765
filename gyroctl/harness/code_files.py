"""Laws as "file.py:Name" that data names: to build one runs its file, so that a file from elsewhere must be allowed.

A name that is typed, on the command line or in Python, is asked for and runs. A name that stands in data, as in an
experiment, a task, a tuned set, or the experiment within results, runs where its file lies in the own folder of that
data, links resolved; elsewhere only where the file was asked for by name. docs/experiment.md, What runs code.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from gyroctl.errors import InputError

OPTION, PARAMETER = "--allow-code", "allow_code"
"""What asks for a file by name: on the command line, and in Python."""


class Trust(NamedTuple):
    """What may run that data names.

    Parameters
    ----------
    folder : Path
        The data's own folder; relative names are relative to it.
    allowed : tuple of Path
        Files asked for by name, or folders of them.
    """

    folder: Path
    allowed: tuple[Path, ...] = ()

    def name(self, field: str, name: str) -> str:
        """Return the name of a law from data, with its file's whole path where it is "file.py:Name".

        Raises
        ------
        InputError
            Field `field`: a file outside the folder that was not asked for, or what is no path.
        """
        if not is_file(name):
            return name
        path, attribute = parted(name)
        try:
            file = (self.folder / path).resolve()
            trusted = [place.resolve() for place in (self.folder, *self.allowed)]
        except (OSError, ValueError, RuntimeError) as error:  # a circle of links, a zero byte
            raise InputError(field, name, f"is no path of a file: {error}", "Give it as file.py:Name") from None
        if not any(file.is_relative_to(place) for place in trusted):
            problem = f"would run {file}, which is outside the folder of what names it, {trusted[0]}"
            raise InputError(field, name, problem, f"Read that file, and allow it by name: {OPTION} {file}")
        return f"{file}:{attribute}"

    def names(self, field: str, value: Any) -> Any:
        """Return entries from data, each name of a law within them as `name` gives it."""
        if isinstance(value, str):
            return self.name(field, value)
        if isinstance(value, Mapping):
            if PARAMETER in value:
                problem = "what may run is not for data to say"
                raise InputError(
                    f"{field}.{PARAMETER}", value[PARAMETER], problem, f"Give {OPTION} on the command line"
                )
            return {key: self.names(f"{field}.{key}", entry) for key, entry in value.items()}
        if isinstance(value, list):
            return [self.names(field, entry) for entry in value]
        return value


def is_file(name: str) -> bool:
    """Whether the name of a law is that of a file, "file.py:Name"."""
    return ".py:" in name


def parted(name: str) -> tuple[str, str]:
    """Path and attribute of "file.py:Name"."""
    path, _, attribute = name.rpartition(":")
    return path, attribute


def asked_for(paths: Iterable[str | Path] | str | Path | None) -> tuple[Path, ...]:
    """Files and folders that are allowed by name: paths, or "file.py:Name".

    Raises
    ------
    InputError
        Field ``--allow-code``, for a path where there is nothing.
    """
    found = []
    for path in [paths] if isinstance(paths, str | Path) else paths or ():
        text = str(path)
        one = Path(parted(text)[0] if is_file(text) else text)
        if not one.exists():
            raise InputError(OPTION, text, "there is no such file", "Give the path of a Python file")
        found.append(one)
    return tuple(found)
