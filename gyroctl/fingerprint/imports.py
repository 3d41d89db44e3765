"""Which files a file imports, read from its text: nothing is imported for it.

Every import counts, wherever it stands: within a function, for types alone, as ``import_module`` of a literal, through
a name of a lazy face. What looks like an import within a text counts as well: a file too many makes a result stale that
need not be, a file too few takes a stale one for fresh.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from pathlib import Path

FROM = re.compile(r"^[ \t]*from[ \t]+(\.*[\w.]*)[ \t]+import[ \t]+(\([^)]*\)|(?:[^\n\\]|\\\n)+)", re.MULTILINE)
IMPORT = re.compile(r"^[ \t]*import[ \t]+([\w., \t]+)", re.MULTILINE)
BY_NAME = re.compile(r"""(?:import_module|__import__)\(\s*["']([\w.]+)["']""")
NAME = re.compile(r"\w+")

Import = tuple[str, tuple[str, ...]]
"""A module, perhaps with dots before it, and the names that are taken from it."""


@lru_cache(maxsize=1024)
def imports_of(text: str) -> tuple[Import, ...]:
    """Imports of a Python text."""
    found: list[Import] = []
    for module, names in FROM.findall(text):
        plain = re.sub(r"#[^\n]*", "", names).strip("() \t").replace("\\\n", " ")
        words = (NAME.match(part.strip()) for part in plain.split(","))
        found.append((module, tuple(word.group() for word in words if word)))
    for names in IMPORT.findall(text):
        found += [(part.split()[0], ()) for part in names.split(",") if part.split()]
    return tuple(found + [(module, ()) for module in BY_NAME.findall(text)])


def absolute(module: str, package: str) -> str:
    """Name of a module that may be relative to a package."""
    level = len(module) - len(module.lstrip("."))
    if level == 0:
        return module
    above = package.split(".")[: len(package.split(".")) - level + 1]
    return ".".join(part for part in (*above, module[level:]) if part)


def reached(begin: Sequence[str], found: Callable[[str], Path | None]) -> dict[str, Path]:
    """Files that modules reach by imports, themselves among them, by module name.

    Parameters
    ----------
    begin : sequence of str
        Names of the modules.
    found : callable
        File of a module by its name, None for what is not to be followed.
    """
    files: dict[str, Path] = {}
    todo = list(begin)
    while todo:
        name = todo.pop()
        path = found(name)
        if name in files or path is None:
            continue
        files[name] = path
        above = name.rpartition(".")[0]
        todo += [above] if above else []  # a package is run before what is in it
        if path.suffix == ".py":
            package = name if path.name == "__init__.py" else above
            todo += targets(path.read_text(encoding="utf-8", errors="replace"), package, found)
    return files


def targets(text: str, package: str, found: Callable[[str], Path | None]) -> Iterator[str]:
    """Names of the modules that a text imports."""
    for module, names in imports_of(text):
        source = absolute(module, package)
        face = _face(source, found(source)) if source else {}
        yield source
        yield from (face.get(name, f"{source}.{name}" if source else name) for name in names)


def _face(module: str, path: Path | None) -> dict[str, str]:
    """Modules that define the names of a lazy face, from the stub beside its ``__init__.py``."""
    stub = path.with_suffix(".pyi") if path is not None and path.name == "__init__.py" else None
    if stub is None or not stub.is_file():
        return {}
    text = stub.read_text(encoding="utf-8")
    return {name: absolute(source, module) for source, names in imports_of(text) for name in names}
