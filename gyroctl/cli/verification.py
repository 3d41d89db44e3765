"""A study verified by its own command: what `gyroctl verify` does for margins, bounds and evaluations."""

from __future__ import annotations

import shlex
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import typer

from gyroctl.cli.options import answer

COMMANDS = ("margins", "bound", "evaluate", "reproduce", "site", "tune")
"""What can be run again on a copy of its folder."""

COVERS = "verify covers compare, margins, bound, evaluate, reproduce, site and tune"

ELSEWHERE = ("--ship",)
"""Options that write beside laws, and are left out."""


def made_by_command(folder: Path, typed: str, by_note: bool) -> list[str]:
    """Words of the command that made a folder: as typed, or as noted there; none where it was a comparison.

    Raises
    ------
    InputError
        For another command, several ones, or one that names code: what may run is not for a folder to say.
    """
    from gyroctl.engine.plan import in_force, plans
    from gyroctl.engine.state import RUNS
    from gyroctl.errors import InputError

    how = 'Give the command by --command "margins --law tracking"'
    if typed:
        words = _words(typed)
        if not words or words[0] not in COMMANDS:
            raise InputError("--command", typed, f"is none that can be verified: {COVERS}", how)
        return words
    if not by_note:
        return []
    last = [plan for place in (folder, folder / RUNS) for plan in in_force(plans(place))]
    noted = sorted({plan.command for plan in last if plan.command})
    ours = [text for text in noted if (_words(text) or [""])[0] in COMMANDS]
    if len(ours) > 1:
        raise InputError("dir", str(folder), f"was made by several commands: {'; '.join(ours)[:2000]}", how)
    if ours and (".py" in ours[0] or "allow-code" in ours[0] or _names_code(_words(ours[0]))):
        raise InputError("dir", ours[0], "names code, and what may run is not for a folder to say", how)
    if not noted and not (folder / RUNS).is_dir() and any(folder.glob("*.jsonl")):
        problem = "holds steps of a tuning, and does not say of which command"
        raise InputError("dir", str(folder), problem, 'Give it by --command "tune load_angle --budget 4e5"')
    return _words(ours[0]) if ours else []


def _names_code(words: Sequence[str]) -> bool:
    """Whether a file that a command names, an experiment or a task, names code."""
    from gyroctl.reading import read_text

    files = [word for word in words if word.endswith(".toml") and Path(word).is_file()]
    return any(".py" in read_text("command", name, "Give the command") for name in files)


class Compared(NamedTuple):
    """What was compared: experiment file, None for the default one, and whether quickly and with whole series."""

    experiment: Path | None
    quick: bool
    full_series: bool


def noted_comparison(folder: Path) -> Compared:
    """Read from a folder what was compared last in it.

    Raises
    ------
    InputError
        For an experiment file that is not where the command runs, or that names code: it is to be given.
    """
    from gyroctl.engine.plan import plans
    from gyroctl.engine.state import results_folder
    from gyroctl.errors import InputError
    from gyroctl.reading import read_text

    noted = sorted(plans(results_folder(folder)), key=lambda plan: plan.begun)
    words = next((w for plan in reversed(noted) if (w := _words(plan.command))[:1] == ["compare"]), [])
    name = next((word for word in words if word.endswith(".toml")), "")
    mend = f"Give it: gyroctl verify {folder} EXPERIMENT.toml"
    if name and not Path(name).is_file():
        raise InputError("dir", str(folder), f"is of the experiment {name}, and there is no such file here", mend)
    if name and ".py" in read_text("experiment", name, mend):
        problem = f"is of the experiment {name}, which names code, and what may run is not for a folder to say"
        raise InputError("dir", str(folder), problem, mend)
    return Compared(Path(name) if name else None, "--quick" in words, "--full-series" in words)


def _words(text: str) -> list[str]:
    try:
        words = shlex.split(text)
    except ValueError:  # a quote without its end
        return []
    return words[1:] if words[:1] == ["gyroctl"] else words


def verify_command(
    folder: Path, words: Sequence[str], share: float, count: int | None, seed: int | None, told: bool | None = None
) -> None:
    """Run a command on a copy of its folder in which a sample is missing, and compare what it makes."""
    from gyroctl.comparison.verification import CLOCKS
    from gyroctl.engine.again import compared, withhold
    from gyroctl.engine.state import RUNS, results_folder, state
    from gyroctl.errors import InputError
    from gyroctl.tuning.steps_kept import compared as compared_steps
    from gyroctl.tuning.steps_kept import done
    from gyroctl.tuning.steps_kept import withhold as withhold_steps

    tuned = words[0] == "tune"
    if (not tuned and results_folder(folder).name != RUNS) or folder.name == RUNS:
        raise InputError("dir", str(folder), "is not the folder of a study", "Give the folder that --out named")
    if left := state(folder, done(folder)).left if tuned else state(folder / RUNS).left:
        mend = "Give the command once more to finish it"
        raise InputError("dir", str(folder), f"{left} pieces of work are not finished", mend)
    line = [word for word in (sys.executable, "-m", "gyroctl", *words) if word not in ELSEWHERE]
    with tempfile.TemporaryDirectory(prefix="gyroctl-verify-") as place:
        copy, apart = Path(place) / "copy", dict[str, int]()
        if tuned:
            steps = withhold_steps(folder, copy, share, count, seed)
            stored, many = steps.stored, len(steps.steps)
        else:
            sample = withhold(folder, copy, share, count, seed)
            stored, many, apart = sample.stored, len(sample.records), dict(sample.apart)
        if not many:
            others = "".join(f"; {number} were made with {what}" for what, number in apart.items())
            problem = f"holds no result that this installation would make{others}"
            raise InputError("dir", str(folder), problem, "Use the versions that made them")
        line += ["--out", str(copy)]
        finished = subprocess.run(line, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, check=False)
        found = compared_steps(steps.steps, copy) if tuned else compared(sample, copy, CLOCKS)
    same = sum(not each.differs for each in found)
    content: dict[str, Any] = {
        "verified": len(found),
        "same": same,
        "stored": stored,
        "command": " ".join(words),
        "exit_code": finished.returncode,
        "apart": apart,
        "runs": [{"of": _of(each.about), "differs": list(each.differs), "made": made(each.about)} for each in found],
    }
    lines = [f"{_of(each.about)}: {judged(each.differs)}; made by {made(each.about)}" for each in found]
    lines += [f"{number} results were made with {what}: not verified here" for what, number in apart.items()]
    answer(content, [*lines, f"{same} of {len(found)} are the same bits; {stored} stored"], told)
    if same != len(found):
        raise typer.Exit(1)


def _of(about: Any) -> str:
    """What a result is of, in words."""
    case, step, law, seed = (about.get(name, "") for name in ("case", "step", "law", "seed"))
    what = f"{step}" if step else f"{law}, seed {seed}"
    return f"{case}: {what}" if case else what


def made(about: Any) -> str:
    """Version, libraries and processor that made a result, in words."""
    parts = about.get("made_with", {})
    words = ", ".join(f"{name} {value}" for name, value in parts.items()) if isinstance(parts, dict) else ""
    commit = f" {about['commit']}" if about.get("commit") else ""
    return f"gyroctl {about.get('gyroctl', 'unknown')}{commit} ({words})"


def judged(differs: Sequence[str]) -> str:
    """Whether results are the same, in words."""
    return "the same bits" if not differs else f"DIFFERS in {', '.join(differs[:5])}" + (" .." if differs[5:] else "")
