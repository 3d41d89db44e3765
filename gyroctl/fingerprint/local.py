"""What a law from elsewhere is made of: its file, the local modules that it imports, and the tables that it reads.

Local is what is neither of Python's own library, nor installed, nor of this package: it has no version that would tell
one text from another. Files are known by their names and contents and never by the folder that they lie in.
"""

from __future__ import annotations

import hashlib
import re
import sys
import sysconfig
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import cache, lru_cache
from importlib.metadata import PackageNotFoundError, packages_distributions, version
from pathlib import Path
from typing import Any, NamedTuple

from gyroctl.fingerprint.imports import absolute, imports_of
from gyroctl.fingerprint.package import PACKAGE, ROOT

LITERAL = re.compile(r"""["']([^"'\n]{1,200})["']""")
"""A text within a text, which may be the name of a table."""

INSTALLED = ("site-packages", "dist-packages")


class Sources(NamedTuple):
    """What files rest on."""

    files: tuple[Path, ...]  # of Python and others that are read
    ours: tuple[str, ...]  # modules of this package
    versions: tuple[str, ...]  # of installed packages, "name version"

    def lines(self) -> str:
        """Return a line for each: name and hash of a file, name and version of a package."""
        texts = sorted(f"{path.name} {_digest(path, *_stamp(path))}\n" for path in self.files)
        return "".join([*texts, *(f"{line}\n" for line in self.versions)])


def sources(files: Iterable[Path]) -> Sources:
    """What files rest on: local modules that they import, one through another, and files that they name or read.

    A module is looked for beside the file, in the packages around it, and where Python looks. What is computed while it
    runs, as a name of a table put together from parts, is seen where it is read as the file is loaded, see `noted`.
    """
    found: dict[Path, None] = {}
    ours: set[str] = set()
    versions: set[str] = set()
    todo = [path.resolve() for path in files]
    while todo:
        path = todo.pop()
        if path in found or not path.is_file():
            continue
        found[path] = None
        todo += [read for read in READ.get(path, ()) if read.is_file()]
        if path.suffix != ".py":
            continue
        text = path.read_text(encoding="utf-8", errors="replace")
        todo += _named(path, text)
        for module in _imported(path, text):
            first = module.partition(".")[0]
            if first == PACKAGE:
                ours.add(module)
            elif (local := _local(path, module)) is not None:
                todo.append(local)
            elif first and first not in sys.stdlib_module_names and "." not in module:
                versions.add(_version(first))
    return Sources(tuple(found), tuple(sorted(ours)), tuple(sorted(versions - {""})))


READ: dict[Path, set[Path]] = {}
"""Files that were read while a file was loaded, by that file."""

_noting: list[set[Path]] = []


@contextmanager
def noted(path: Path) -> Iterator[None]:
    """Note the local files that are opened while `path` is loaded, or while what it defines is built."""
    _listen()
    seen: set[Path] = set()
    _noting.append(seen)
    try:
        yield
    finally:
        _noting.remove(seen)
        READ.setdefault(path.resolve(), set()).update(file for file in seen if is_local(file))


@cache
def _listen() -> None:
    """Hear which files this process opens; a hook stays, and costs nothing while nobody notes."""

    def hear(event: str, arguments: tuple[Any, ...]) -> None:
        if _noting and event in ("open", "sqlite3.connect") and isinstance(arguments[0], str | Path):
            mode = arguments[1] if event == "open" else "r"
            if not (isinstance(mode, str) and any(sign in mode for sign in "wxa+")):
                for seen in _noting:
                    seen.add(Path(arguments[0]).absolute())

    sys.addaudithook(hear)


def _imported(path: Path, text: str) -> Iterator[str]:
    package = ".".join(reversed([folder.name for folder in _packages(path)]))
    for module, names in imports_of(text):
        source = absolute(module, package) if module.startswith(".") else module
        yield from (part for part in (source, *(f"{source}.{name}" for name in names)) if part)
        if not source:  # from . import x, of a file in no package
            yield from names


def _packages(path: Path) -> list[Path]:
    """Folders around a file that are packages, from the inside out."""
    found = []
    for folder in path.parents:
        if not (folder / "__init__.py").is_file():
            break
        found.append(folder)
    return found


def _local(path: Path, module: str) -> Path | None:
    """File of a module as seen from a file, where it is local."""
    known = getattr(sys.modules.get(module), "__file__", None)
    around = [folder.parent for folder in _packages(path)[-1:]]
    places = [path.parent, *around, *(Path(place or ".") for place in sys.path)]
    parts = module.split(".")
    for place in places:
        inside = place.joinpath(*parts)
        for file in (inside / "__init__.py", inside.with_name(f"{inside.name}.py")):
            if file.is_file() and is_local(file):
                return file.resolve()
    return Path(known).resolve() if known and Path(known).is_file() and is_local(Path(known)) else None


def _named(path: Path, text: str) -> Iterator[Path]:
    """Files that texts within a text name, also as "file.py:Name": beside it, or where the program runs."""
    for literal in {found.rpartition(":")[0] if ".py:" in found else found for found in LITERAL.findall(text)}:
        for place in (path.parent, Path()):
            try:
                file = place / literal
                if file.is_file() and is_local(file.absolute()):
                    yield file.resolve()
            except (OSError, ValueError):
                continue


@lru_cache(maxsize=4096)
def is_local(file: Path) -> bool:
    """Whether a file is neither installed, nor of Python, nor of this package, nor compiled from another one."""
    parts = file.parts
    if file.suffix in (".pyc", ".so", ".pyd") or any(name in parts for name in (*INSTALLED, "__pycache__")):
        return False
    apart = (_standard(), ROOT)
    return not any(file.is_relative_to(folder) or file.resolve().is_relative_to(folder) for folder in apart) and (
        parts[1:2] not in (("proc",), ("sys",), ("dev",))
    )


@cache
def _standard() -> Path:
    return Path(sysconfig.get_path("stdlib")).resolve()


@cache
def _version(name: str) -> str:
    """Name and version of the distribution that an installed module is of; empty where there is none."""
    try:
        return f"{name} {version(name)}"
    except PackageNotFoundError:
        homes = packages_distributions().get(name, ())
        return f"{name} {' '.join(version(home) for home in homes)}" if homes else ""


def _stamp(path: Path) -> tuple[int, int]:
    state = path.stat()
    return state.st_mtime_ns, state.st_size


@lru_cache(maxsize=4096)
def _digest(path: Path, changed: int, size: int) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
