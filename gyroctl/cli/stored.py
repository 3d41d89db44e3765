"""`gyroctl status`, `verify` and `clean`: what a folder of results holds, whether it is true, what can go."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from gyroctl.cli.options import AllowCode, Form, Workers, answer
from gyroctl.cli.verification import judged, made, made_by_command, noted_comparison, verify_command

Folder = Annotated[Path, typer.Argument(metavar="DIR", help="Folder that --out named, or its runs folder.")]

OTHER, EARLIER = "other_versions", "earlier"


def status(folder: Folder, words: Form = None) -> None:
    """Tell what is done, failed and left, by law and case, and the time that is left."""
    from gyroctl.engine.state import CHECKED, results_folders, state
    from gyroctl.tuning.steps_kept import done

    found = [state(place, done(place)) for place in results_folders(folder)]
    rows = [line for part in found for line in part.lines]
    lines = [f"{'case':24} {'law':24} {'done':>6} {'failed':>6} {'left':>6}"]
    commands = list(dict.fromkeys(line.command for line in rows))
    for command in commands:
        if len(commands) > 1:
            lines.append(f"{command or 'of another program'}:")
        for line in (line for line in rows if line.command == command):
            why = f"{line.damaged} damaged  {line.why}" if line.damaged else line.why
            lines.append(f"{line.case[:24]:24} {line.law[:24]:24} {line.done:6} {line.failed:6} {line.left:6}  {why}")
    known = [part.left_s for part in found if part.left_s is not None]
    left, failed, running = sum(p.left for p in found), sum(p.failed for p in found), any(p.running for p in found)
    damaged, earlier, unchecked = (
        sum(getattr(part, what) for part in found) for what in ("damaged", "earlier", "unchecked")
    )
    time = f"{sum(known) / 60.0:.1f} min" if known else "unknown"
    open_work = left or damaged
    doing = f"running, time left {time}" if running else "nothing runs here" if open_work else "all is done"
    apart = {what: number for part in found for what, number in part.apart.items()}
    content: dict[str, Any] = {
        "running": running,
        "time_left_s": sum(known) if known else None,
        "lines": [vars(line) for line in rows],
        "damaged": damaged,
        "made_here": sum(part.here for part in found),
        "made_elsewhere": apart,
        "of_earlier_runs": earlier,
        "unchecked": unchecked,
    }
    lines += [f"{number} stored results were made with {what}: kept apart, not used" for what, number in apart.items()]
    if earlier:
        lines.append(f"{earlier} stored results are of earlier runs of the same commands; clean --earlier removes them")
    if unchecked:
        lines.append(f"{unchecked} stored results beyond the first {CHECKED} were counted without a look at their sums")
    will = f"{damaged} damaged, will be computed again, " if damaged else ""
    answer(content, [*lines, f"{doing}; {left} left, {will}{failed} failed"], words)


def verify(
    folder: Folder,
    experiment: Annotated[
        Path | None, typer.Argument(help="TOML file that was compared; without it the one that is noted in DIR.")
    ] = None,
    share: Annotated[float, typer.Option(help="Part of the stored runs to compute again, one at least.")] = 0.05,
    count: Annotated[int | None, typer.Option(help="How many instead of a share.", show_default=False)] = None,
    seed: Annotated[int | None, typer.Option(help="Of the random sample, to draw it again.")] = None,
    quick: Annotated[bool, typer.Option("--quick", help="As gyroctl compare --quick.")] = False,
    full_series: Annotated[bool, typer.Option("--full-series", help="As gyroctl compare --full-series.")] = False,
    workers: Workers = 0,
    allow_code: AllowCode = None,
    command: Annotated[
        str,
        typer.Option(
            help='Of other studies than compare: the command that made the folder, "margins --law tracking"; '
            "by default the one that is noted there."
        ),
    ] = "",
    words: Form = None,
) -> None:
    """Compute a random sample of stored results again and compare every bit."""
    from gyroctl.comparison.compare import Realisations
    from gyroctl.comparison.experiment import read_experiment
    from gyroctl.comparison.items import work_items
    from gyroctl.comparison.verification import verify as check
    from gyroctl.engine.state import results_folder
    from gyroctl.errors import InputError
    from gyroctl.harness.yardstick import with_yardstick
    from gyroctl.tuning.bench import workers_wanted
    from gyroctl.tuning.yardstick import find_yardstick
    from gyroctl.waves.checks import whole, within

    within("--share", share, 0.0, 1.0, "Give a part, for example 0.05")
    if count is not None:
        whole("--count", count, 1, 1_000_000, "Give how many runs, for example 3")
    if typed := made_by_command(folder, command, experiment is None):
        return verify_command(folder, typed, share, count, seed, words)
    if experiment is None and not quick and not full_series:
        experiment, quick, full_series = noted_comparison(folder)
    place, setup = results_folder(folder), read_experiment(experiment, quick, allow_code or ())
    waves = Realisations(setup.sea, setup.run.seeds, setup.run.duration)
    say = partial(typer.echo, err=True)
    pair = find_yardstick(setup.plant, setup.sea, setup.settings, setup.run.motion_limit, search=False, say=say)
    laws, _ = with_yardstick(dict(setup.laws), pair, setup.plant.parameters.length_scale)
    limit = setup.run.time_limit or max(60.0, waves.duration)
    items = work_items(setup.plant, laws, waves, setup.settings, limit, full_series)
    found = check(items, place, share, count, workers_wanted(workers), seed, say)
    if not found.stored:
        others = "".join(f"; {number} were made with {what}" for what, number in found.apart.items())
        problem = f"holds no run of this experiment that this installation would make{others}"
        raise InputError("dir", str(folder), problem, "Give the experiment file, and the versions that made them")
    content = {
        "verified": len(found.found),
        "same": sum(each.same for each in found.found),
        "stored": found.stored,
        "wanted": found.wanted,
        "apart": dict(found.apart),
        "runs": [
            {"law": r.law, "seed": r.seed, "differs": list(r.differs), "made": made(r.about)} for r in found.found
        ],
    }
    lines = [f"{r.law}, seed {r.seed}: {judged(r.differs)}; made by {made(r.about)}" for r in found.found]
    lines += [f"{number} stored runs were made with {what}: not verified here" for what, number in found.apart.items()]
    same = f"{content['same']} of {len(found.found)} are the same bits"
    answer(content, [*lines, f"{same}; {found.stored} stored of {found.wanted} wanted"], words)
    if content["same"] != len(found.found):
        raise typer.Exit(1)


def clean(
    folder: Folder,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Only say what would go.")] = False,
    other_versions: Annotated[
        bool, typer.Option("--other-versions", help="Also what other libraries or another processor made.")
    ] = False,
    earlier: Annotated[
        bool,
        typer.Option(
            "--earlier",
            help="Also what only earlier runs of the same command asked for: laws or experiment were edited since.",
        ),
    ] = False,
    words: Form = None,
) -> None:
    """Throw away what is stale, damaged or half-written; what can still be used stays."""
    from gyroctl.engine.state import litter, results_folder

    found = litter(results_folder(folder))
    more = {EARLIER: earlier, OTHER: other_versions}
    kinds = ["damaged", "stale", "temporary", *(kind for kind, wanted in more.items() if wanted)]
    content = {kind: {"files": len(getattr(found, kind)), "bytes": _size(getattr(found, kind))} for kind in kinds}
    if not dry_run:
        for path in found.of(kinds):
            path.unlink(missing_ok=True)
    word = "would be removed" if dry_run else "removed"
    lines = [
        f"{told['files']} {kind.replace('_', ' ')}, {told['bytes'] / 1e6:.2f} MB, {word}"
        for kind, told in content.items()
    ]
    if not earlier and found.earlier:
        lines.append(f"{len(found.earlier)} of earlier runs of the same commands stay; --earlier removes them")
    if not other_versions and found.other_versions:
        lines.append(f"{len(found.other_versions)} of other versions stay; --other-versions removes them")
    lines += [f"{path} is a folder where a file belongs, and stays: remove it" for path in found.in_the_way]
    kept = {f"kept_of_{kind}": len(getattr(found, kind)) for kind in (EARLIER, OTHER)}
    answer({"dry_run": dry_run, **content, **kept, "in_the_way": list(map(str, found.in_the_way))}, lines, words)


def _size(paths: list[Path]) -> int:
    return sum(path.lstat().st_size for path in paths if path.exists())
