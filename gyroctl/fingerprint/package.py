"""The package as it is on the disk: whole rooms and no list of modules.

A list kept by hand forgets one, and a stale result is taken for a fresh one.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from functools import cache
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

PACKAGE = __name__.partition(".")[0]
ROOT = Path(__file__).resolve().parents[1]

APART = frozenset({"reports", "cli", "studies"})
"""Rooms that only ask for results or show them."""

LAWS = "controllers"
SHIPPED = "tuned"
"""Numbers that ship beside a law act through its parameters alone, and with those they are hashed: a tuning that has
shipped its first set finds the steps of the second one again."""

LEDGER = "seeds.toml"
"""The ledger of seeds says who may run on what and computes nothing: to mark a seed spent makes no run stale."""

LIBRARIES = ("numpy", "scipy", "numba", "llvmlite", "casadi", "osqp", "cmaes")
"""What computes a run, and what draws the samples of a search."""


@cache
def fingerprint() -> str:
    """SHA-256 of all code and data of this package and of the versions of the libraries that compute.

    The version of the package stands in one of its files.
    """
    names = [path.name for path in ROOT.iterdir() if path.name not in APART]
    rooms = {name: room_folder(name) for name in {*names, LAWS}}
    return hashlib.sha256((versions() + listing(rooms)).encode()).hexdigest()


def versions() -> str:
    """Versions of the libraries that compute, a line each."""
    return "".join(f"{name} {version(name)}\n" for name in LIBRARIES)


def room_folder(name: str) -> Path:
    """Folder, or file, of a room; in a checkout without symbolic links laws and studies are elsewhere."""
    here = ROOT / name
    if here.is_file() or (here.is_dir() and (here / "__init__.py").is_file()):
        return here
    spec = find_spec(f"{PACKAGE}.{name}") if name.isidentifier() else None
    return Path(spec.submodule_search_locations[0]) if spec and spec.submodule_search_locations else here


def listing(rooms: Mapping[str, Path]) -> str:
    """Return a line for each file of the rooms (files or folders by name): its name and the hash of its content.

    Parameters
    ----------
    rooms : mapping of str to Path
        Files or folders by name.

    Returns
    -------
    str
        One line a file, in the order of the names.
    """
    lines = []
    for room, root in rooms.items():
        for path in [root] if root.is_file() else root.rglob("*"):
            inside = path.relative_to(root).parts
            passing = any(
                part.startswith((".", "__pycache__")) or part in (SHIPPED, LEDGER) for part in (room, *inside)
            )
            if path.is_file() and not passing:
                lines.append(f"{'/'.join((room, *inside))} {hashlib.sha256(path.read_bytes()).hexdigest()}\n")
    return "".join(sorted(lines))
