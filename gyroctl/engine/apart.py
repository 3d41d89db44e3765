"""Processes that do not run the user's script anew.

A process that Python spawns imports the script that began it, so that a script which compares laws without
``if __name__ == "__main__":`` would compare them anew in each of its processes, without end. Ours need nothing of it:
laws that are written in a script go to them whole, by cloudpickle.
"""

from __future__ import annotations

from multiprocessing import spawn
from multiprocessing.context import SpawnContext, SpawnProcess
from threading import local
from typing import Any

SCRIPT = ("init_main_from_name", "init_main_from_path")
"""What a process is told of the script."""

_begun_here = local()
_preparation = spawn.get_preparation_data


def _without_script(name: str) -> dict[str, Any]:
    """What a process is told before it begins; of the script only where it is none of ours."""
    told = _preparation(name)
    if getattr(_begun_here, "ours", False):
        return {key: value for key, value in told.items() if key not in SCRIPT}
    return told


setattr(spawn, "get_preparation_data", _without_script)  # noqa: B010 - there is no other way to leave the script out


class Apart(SpawnProcess):
    """A process without the script."""

    def start(self) -> None:
        """Begin it."""
        _begun_here.ours = True
        try:
            super().start()
        finally:
            _begun_here.ours = False


class _Context(SpawnContext):
    Process = Apart  # type: ignore[assignment]


CONTEXT = _Context()
"""For pools of processes."""
