"""`gyroctl tune`: tune laws with equal budgets on tuning seeds."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gyroctl.cli.options import AllowCode, Device, Scheduler, Workers, failures, plant_of, warn_doubtful

if TYPE_CHECKING:
    from gyroctl.tuning.task import Task
    from gyroctl.tuning.tune import Start, Tuned
    from gyroctl.tuning.waters import Circumstances


def tune(
    laws: Annotated[
        list[str], typer.Argument(help='Laws: registered name, "file.py:Name", or a task, TASK.toml; all of them: all.')
    ],
    sets: Annotated[
        str, typer.Option("--for", help="Sets to tune, with commas: all (one for all seas), or seas of the task.")
    ] = "all",
    budget: Annotated[
        float | None,
        typer.Option(help="Simulated time for each set of each law [s].", show_default="4e6 at the size of Table 1"),
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder for steps, tables and figures.")] = Path("results/tuning"),
    workers: Workers = 0,
    scheduler: Scheduler = "",
    begin: Annotated[
        str, typer.Option("--from", help="Begin at a set that is tuned already, instead of the task's start.")
    ] = "",
    water: Annotated[
        str, typer.Option(help="Water to tune in: linear, or real, the realistic device with a lag of its coupling.")
    ] = "linear",
    experiment: Annotated[
        Path | None,
        typer.Option(help="Experiment file: plant, sensors, actuators, seeds to keep away.", show_default=False),
    ] = None,
    ship: Annotated[bool, typer.Option("--ship", help="Also write the sets beside the law.")] = False,
    allow_code: AllowCode = None,
    device: Device = None,
) -> None:
    """Tune laws; a tuning that was stopped goes on where it was, one with a larger budget too."""
    from gyroctl.errors import InputError
    from gyroctl.froude import growth
    from gyroctl.harness.code_files import is_file
    from gyroctl.harness.device_sets import sets_file, sets_folder
    from gyroctl.harness.registry import home, tuned_sets
    from gyroctl.harness.tuned_sets import tuned_file, write_sets
    from gyroctl.names import file_in
    from gyroctl.tuning.bench import workers_wanted
    from gyroctl.tuning.task import read_task, tasked
    from gyroctl.tuning.tune import BUDGET
    from gyroctl.tuning.tune import tune as run
    from gyroctl.writing import Kept

    (on, file), allowed = circumstances(experiment, water, allow_code or (), device), allow_code or ()
    if file is not None and ship:
        problem = f"ships sets of the paper's device, and {file.name} is another one"
        raise InputError("--ship", True, problem, f"Leave it out: they are kept in {sets_folder(file).name} beside it")
    length = on.plant.parameters.length_scale if on.own else 1.0
    budget = BUDGET * growth("s", length) if budget is None else budget
    wanted = [name.strip() for name in sets.split(",") if name.strip()]
    laws = [own for name in laws for own in (tasked() if name == "all" else [name])]
    tasks = [read_task(name, water, allowed).at_length(length) for name in laws]
    for task in tasks:  # all that can be refused is refused before the first run
        for which in wanted:
            task.served(which)
    kept = Kept({})
    for task in tasks:
        for which in wanted:
            with kept.stage(f"{task.stem} for {which}"):  # a law that fails does not stop the tuning of the others
                start = _start(tuned_sets(task.law, allowed), begin)
                many = workers_wanted(workers)
                found = run(task, which, on, budget, out, many, start=start, scheduler=scheduler or None)
                write_sets(file_in(out, task.stem, ending=".json"), task.law, found.sets)
                if file is not None:
                    write_sets(sets_file(file, task.law), task.law, found.sets)
                if ship:
                    folder, stem = home(task.law)
                    write_sets(tuned_file(folder, stem), task.stem if is_file(task.law) else task.law, found.sets)
                _front(task, task.named(which), found, out)
                _table(task, found)
    if len(kept.failed) == len(tasks) * len(wanted):
        raise kept.errors[0]
    beside = " and beside the law" if ship else "" if file is None else f" and to {sets_folder(file)}"
    typer.echo(f"Written to {out}{beside}")
    failures(kept.failed)


def circumstances(
    experiment: Path | None, water: str = "linear", allow_code: Sequence[Path] = (), device: Path | None = None
) -> tuple[Circumstances, Path | None]:
    """Plant, sensors and actuators of an experiment, those of a water, or those of a device of one's own; and its file.

    An experiment beside a device gives sensors, actuators and the seeds to keep away.
    """
    from gyroctl.comparison.experiment import build_experiment
    from gyroctl.errors import InputError
    from gyroctl.tables import read_tables
    from gyroctl.tuning.waters import Circumstances, circumstances_of, on_device

    if experiment is None and device is None:
        return circumstances_of(water), None
    if experiment is None:
        return on_device(plant_of(device, "corrected"), water), device
    tables = dict(read_tables(experiment, "experiment"))
    if device is not None:
        if tables.get("plant"):
            problem = "has a table [plant] of its own beside --device"
            raise InputError("--experiment", str(experiment), problem, "Leave one of the two out")
        tables["plant"] = {"device": str(device.resolve())}
    setup = build_experiment(tables, False, experiment.parent, allow_code)
    own = setup.device_file is not None
    plant = on_device(setup.plant, water).plant if own else setup.plant
    warn_doubtful(setup.plant, device or setup.device_file)
    return Circumstances(plant, setup.settings, frozenset(setup.run.seeds), own), device or setup.device_file


def _start(sets: dict[str, Any], name: str) -> Start | None:
    from gyroctl.errors import NOT_GIVEN, InputError
    from gyroctl.tuning.tune import Start

    if not name:
        return None
    if name not in sets:
        raise InputError("--from", name, "there is no such tuned set", f"Choose one of {', '.join(sets) or 'none yet'}")
    found = sets[name].get("found", {})
    if "spent_s" not in found:
        mend = "Begin at another set, or at the task's start"
        raise InputError(f"sets.{name}.found.spent_s", NOT_GIVEN, "does not say what was spent on it", mend)
    return Start(name, sets[name]["parameters"], found["spent_s"] + found.get("spent_before_s", 0.0))


def _front(task: Task, which: str, found: Tuned, out: Path) -> None:
    from gyroctl.names import file_in
    from gyroctl.reports.tuning_front import write_tuning_front
    from gyroctl.tuning.pareto_front import front_rows, write_front

    goals = task.goals[""]
    rows = front_rows(found.archive, found.sets, {name: goal.motion for name, goal in goals.items()})
    limits = {name: goal.power_cv for name, goal in goals.items() if goal.power_cv < 10.0}
    write_front(rows, file_in(out, task.stem, which, ending=".front.csv"))
    picture = file_in(out, task.stem, which, ending=".front.png")
    write_tuning_front(rows, picture, f"{task.stem}, tuned for {which}", limits)


def _table(task: Task, found: Tuned) -> None:
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    from gyroctl.tuning.goal import Goal

    first = next(iter(found.sets.values()))["found"]
    title = f"{escape(task.stem)}: {first['spent_s']:.3g} s of {first['budget_s']:.3g} s simulated"
    caption = "power in W, 98 % motion of phi1 and phi3 in rad, turns kept, cycle slips per 1000 waves"
    head = ("set", "sea", "power", "CV", "locked", "95 %", "motion", "turns", "slips", "goal")
    left: dict[str, Any] = {"title_justify": "left", "caption_justify": "left"}
    table = Table(*head, title=title, caption=caption, box=SIMPLE_HEAD, padding=(0, 1, 0, 0), **left)
    for name, entry in found.sets.items():
        for sea, result in entry["result"].items():
            low, high = result["locked_ci95"]
            table.add_row(
                escape(name),
                escape(sea),
                f"{result['mean_power']:.2f}",
                f"{result['power_cv']:.2f}",
                f"{round(result['locked'] * result['runs'])}/{result['runs']}",
                f"{low:.2f}-{high:.2f}",
                f"{result['phi1_p98']:.2f} {result['phi3_p98']:.2f}",
                f"{result['turns_kept']:.3f}" if "turns_kept" in result else "-",
                f"{result['cycle_slips']:.0f}" if "cycle_slips" in result else "-",
                "met" if entry["met"][sea] else "missed",
            )
    console = Console()
    console.print(table)
    for name, entry in found.sets.items():
        for sea, result in entry["result"].items():
            missed = ", ".join(Goal(**entry["goal"][sea]).missed(result))
            if missed and not entry["met"][sea]:
                console.print(f"{escape(name)} in {escape(sea)} misses: {escape(missed)}", highlight=False)
        knobs = ", ".join(f"{key} = {value}" for key, value in entry["parameters"].items())
        console.print(f"{escape(name)}: {escape(knobs)}", highlight=False)
