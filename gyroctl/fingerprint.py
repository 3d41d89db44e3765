"""What a stored result rests on beside its own input: this package as it is on the disk, and what computes with it.

Whole rooms and no list of modules: a list kept by hand forgets one, and a stale result is taken for a fresh one.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from functools import cache
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

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
    """SHA-256 of the code and data of this package and of the versions of the libraries that compute.

    The version of the package stands in one of its files.
    """
    rooms = {path.name: path for path in Path(__file__).parent.iterdir() if path.name not in APART}
    laws = find_spec(f"{__package__}.{LAWS}")  # in a checkout without symbolic links they are elsewhere
    assert laws is not None and laws.submodule_search_locations
    rooms[LAWS] = Path(laws.submodule_search_locations[0])
    versions = "".join(f"{name} {version(name)}\n" for name in LIBRARIES)
    return hashlib.sha256((versions + listing(rooms)).encode()).hexdigest()


def listing(rooms: Mapping[str, Path]) -> str:
    """Return a line for each file of the rooms (files or folders by name): its name and the hash of its content."""
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
