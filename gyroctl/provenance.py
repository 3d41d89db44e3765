"""What made a result beside its own input: version, commit, libraries, machine and command, without a path of it."""

from __future__ import annotations

import platform
import subprocess
import sys
from collections.abc import Sequence
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import version
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any

from gyroctl.version import VERSION

LIBRARIES = ("numpy", "scipy", "numba", "casadi")
"""What computes a run."""

ROOT = Path(__file__).resolve().parents[1]
"""Folder above the package: that of the checkout, where there is one."""


def provenance() -> dict[str, Any]:
    """All of it but the command, by the names it has in datasets and JSON files; a part that is not known is empty."""
    return {"gyroctl_version": VERSION, "commit": commit(), "versions": versions(), "platform": machine()}


def made() -> dict[str, Any]:
    """What made a report that is written once: with the command, where it was one of this package, and the day."""
    return {**provenance(), "command": typed(), "date": datetime.now(UTC).date().isoformat()}


def typed() -> str:
    """Command of this process: ``gyroctl``, a study by ``python -m`` or a benchmark; empty within any other program."""
    program = Path(sys.argv[0])
    if program.resolve().parent == ROOT / "benchmarks":
        return " ".join([f"python benchmarks/{program.name}", *command_line().split(" ")[1:]])
    if program.name == "__main__.py" and program.parent.parent.name == "studies":
        words = command_line().split(" ")[1:]
        return " ".join(["python -m", f"gyroctl.studies.{program.parent.name}", *words])
    ours = program.stem == "gyroctl" or (program.name == "__main__.py" and program.parent.name == "gyroctl")
    return command_line() if ours else ""


def versions() -> dict[str, str]:
    """Versions of Python and of the libraries that compute, by name."""
    return {"python": platform.python_version(), **{name: version(name) for name in LIBRARIES}}


@cache
def machine() -> str:
    """Operating system, and processor with the instructions that NumPy found on it, which may change a last bit."""
    return f"{platform.system()} {platform.machine()}; {processor()}"


@cache
def processor() -> str:
    """Processor as the compiler calls it, and its vector instructions."""
    import numpy as np
    from llvmlite.binding import get_host_cpu_name  # type: ignore[import-untyped]

    found = np.show_config(mode="dicts").get("SIMD Extensions", {})  # type: ignore[call-overload, union-attr]
    instructions = [*found.get("baseline", ()), *found.get("found", ())]
    return " ".join([f"{get_host_cpu_name()}:", *instructions])


@cache
def commit(root: Path = ROOT) -> str:
    """Commit of the checkout that the package runs from, with "changed" where files differ from it; else empty."""
    if not (root / ".git").exists():  # installed, perhaps within somebody else's repository
        return ""
    git = ["git", "-C", str(root)]
    try:
        head = subprocess.run([*git, "rev-parse", "HEAD"], capture_output=True, text=True, check=True, timeout=10.0)
        state = [*git, "status", "--porcelain", "--untracked-files=no"]
        changes = subprocess.run(state, capture_output=True, text=True, check=True, timeout=10.0)
    except (OSError, subprocess.SubprocessError):
        return ""
    return head.stdout.strip() + (", changed" if changes.stdout.strip() else "")


def command_line(arguments: Sequence[str] | None = None) -> str:
    """Command as it was typed; of a path only its last part, which tells the file and not the machine."""
    given = sys.argv[1:] if arguments is None else arguments
    return " ".join(["gyroctl", *(_quoted(_without_folders(word)) for word in given)])


def _without_folders(word: str) -> str:
    """Shorten absolute paths, also behind ``--out=`` and in ``file.py:Name``."""
    option, equals, value = word.partition("=")
    if equals and option.startswith("-"):
        return f"{option}={_without_folders(value)}"
    if PurePosixPath(word).is_absolute():
        return PurePosixPath(word).name or word
    return PureWindowsPath(word).name if PureWindowsPath(word).is_absolute() else word


def _quoted(word: str) -> str:
    return f'"{word}"' if not word or any(sign.isspace() for sign in word) else word
