"""What the result of a kind of work rests on beside its own input.

The rooms that its code reaches by imports, whole; the libraries that compute; the processor. Whatever is not reached
changes no bit: a new colour in a report makes no run stale, nor does a change in a law that was not run.
"""

from __future__ import annotations

import hashlib
import json
import platform
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

from gyroctl.fingerprint.imports import reached
from gyroctl.fingerprint.package import LAWS, PACKAGE, listing, room_folder, versions
from gyroctl.fingerprint.processor import processor

APIECE = (LAWS, "studies")
"""Rooms whose folders stand each for itself: no law imports another one."""

LOOKS = ("faces", "palette", "plots")
"""Rooms that show what others have computed, called by `__repr__`, `plot` and the like alone: no bit is theirs."""

DATA = ("data", "version.py")
"""What no import shows: tables that are read, and the version."""


def code_of(*modules: str) -> str:
    """SHA-256 of all code of this package that can change a bit of what the modules compute, and of `made_with`.

    The files are read once in a process.

    Parameters
    ----------
    *modules : str
        Modules of the package, by their dotted names.

    Returns
    -------
    str
        64 digits.
    """
    text = json.dumps(made_with(), sort_keys=True) + text_of(*modules)
    return hashlib.sha256(text.encode()).hexdigest()


def text_of(*modules: str) -> str:
    """SHA-256 of the code alone, whatever libraries it runs with.

    Parameters
    ----------
    *modules : str
        Modules of the package, by their dotted names.

    Returns
    -------
    str
        64 digits.
    """
    return hashlib.sha256(_listed(tuple(sorted(set(modules)))).encode()).hexdigest()


@cache
def _listed(modules: tuple[str, ...]) -> str:
    """Lines of all files of the rooms; of a law's only its code: a table acts through the law's fields alone."""
    lines = listing({name: room for name, room in _rooms(modules).items() if room.exists()})
    return "".join(line for line in lines.splitlines(True) if not _table_of_a_law(line.split(" ")[0]))


def _table_of_a_law(name: str) -> bool:
    return name.startswith(f"{LAWS}/") and not name.endswith(".py")


def rooms_of(*modules: str) -> list[str]:
    """Names of the rooms that modules of this package reach."""
    return sorted(_rooms(tuple(modules)))


def _rooms(modules: Iterable[str]) -> dict[str, Path]:
    names = {_room(module) for module in reached(list(modules), _own)}
    return {name: _folder(name) for name in {*names, *DATA} - {*LOOKS} if name}


def _room(module: str) -> str:
    parts = module.split(".")[1:]
    if len(parts) > 1 and parts[0] in APIECE:
        return "/".join(parts[:2])
    return parts[0] if parts and parts[0] not in APIECE else ""


def _folder(name: str) -> Path:
    first, _, rest = name.partition("/")
    folder = room_folder(first) / rest if rest else room_folder(first)
    return folder if folder.exists() else folder.with_name(f"{folder.name}.py")


@cache
def _own(module: str) -> Path | None:
    """File of a module of this package."""
    first, *rest = module.split(".")
    if first != PACKAGE:
        return None
    if not rest:
        return room_folder("__init__.py")
    place = room_folder(rest[0]).joinpath(*rest[1:])
    for path in (place / "__init__.py", place.with_name(f"{place.name}.py")):
        if path.is_file():
            return path
    return None


def made_with() -> dict[str, Any]:
    """Versions and processor on which bits depend, in words: of two results they say why the keys differ."""
    import numba
    import numpy
    import scipy

    loaded = {"numpy": numpy.__version__, "scipy": scipy.__version__, "numba": numba.__version__}
    told = dict(line.split(" ", 1) for line in _installed().splitlines())
    known = {name: told[name] if told[name] == loaded.get(name, told[name]) else loaded[name] for name in told}
    return {
        "python": ".".join(platform.python_version_tuple()[:2]),
        **known,
        "blas": _blas(),
        "system": f"{platform.system()} {platform.machine()} {' '.join(platform.libc_ver())}".strip(),
        "processor": processor(),
    }


@cache
def _installed() -> str:
    """Versions as they are installed; read once, since each is a file of its own."""
    return versions()


@cache
def _blas() -> str:
    """Library of linear algebra that NumPy was built with: two builds of one version may differ by it."""
    import numpy as np

    built: Any = np.show_config(mode="dicts")
    found = (built or {}).get("Build Dependencies", {}).get("blas", {})
    return f"{found.get('name', '')} {found.get('version', '')}".strip()
