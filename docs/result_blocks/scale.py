"""Blocks of the page on many runs: what one costs part by part, a large study, a larger one on paper, and kills."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from gyroctl.reports.wording import number
from result_blocks.source import ROOT, of_file, read, table

PARTS = (
    ("run_ms", "the run itself, waves and metrics included", "ms"),
    ("key_ms", "key", "ms"),
    ("handed_out_ms", "handing out, and taking what came", "ms"),
    ("stored_ms", "storing it", "ms"),
    ("synced_wall_ms", "waiting for the disk, beside other work", "ms"),
    ("found_ms", "finding it again, instead of all that", "ms"),
    ("told_ms", "table, statistics and report", "ms"),
    ("asked_kb", "memory of the process that was started, for what is asked", "kB"),
    ("held_kb", "and for what came of it", "kB"),
    ("record_kb", "on disk", "kB"),
    ("told_kb", "of report and summary", "kB"),
)


def kept(path: str, command: str, make: Callable[[Mapping[str, Any]], str]) -> str:
    """A block from a file of the benchmarks, or what makes that file."""
    if not (ROOT / path).is_file():
        return f"*Not run yet: `{command}`.*"
    found = read(path)
    return f"{make(found)}\n\n{of_file(path, command, found['machine'])}"


def parts() -> str:
    """What a run of a law costs."""

    def make(found: Mapping[str, Any]) -> str:
        lines = [[what, f"{number(found['parts'][name], 2)} {unit}"] for name, what, unit in PARTS]
        return table((f"a run of {found['duration_s']:g} s", "processor time of one core, or size"), lines)

    return kept("benchmarks/scale.json", "python benchmarks/scale.py --whole", make)


def memory() -> str:
    """What a worker takes."""

    def make(found: Mapping[str, Any]) -> str:
        one = found["parts"]
        return (
            f"The libraries and what they compile take {number(one['libraries_mb'], 2)} MB, a piece of sixteen runs of "
            f"2000 s {number(one['piece_mb'], 2)} MB at most, one run of 100 000 s {number(one['long_run_mb'], 2)} MB."
        )

    return kept("benchmarks/scale.json", "python benchmarks/scale.py --whole", make)


def whole() -> str:
    """A study in one command."""

    def make(found: Mapping[str, Any]) -> str:
        if "whole" not in found:
            return "The study in one command has not been run yet."
        one = found["whole"]
        return (
            f"{one['realisations']} realisations of {one['duration_s']:g} s with {one['laws']} compiled laws took "
            f"{one['wall_s'] / 60.0:.1f} minutes ({one['machine']}). The process that was started took "
            f"{number(one['driver_mb'], 3)} MB at most, the runs included; {one['records']} records are "
            f"{number(one['records_mb'], 3)} MB on disk, the report {number(one['report.html_mb'], 2)} MB."
        )

    return kept("benchmarks/scale.json", "python benchmarks/scale.py --whole", make)


def on_paper() -> str:
    """A study that nobody has run, by the number of cores."""

    def make(found: Mapping[str, Any]) -> str:
        lines = [
            [
                f"{row['cores']}",
                number(row["wall_h"], 2),
                number(row["runs_h"], 2),
                number(row["driver_h"], 2),
                number(row["disk_h"], 2),
                number(row["core_h"], 3),
                number(row["driver_gb"], 2),
                number(row["stored_gb"], 2),
            ]
            for row in found["on_paper"]
        ]
        heads = ("cores", "time [h]", "runs, shared out [h]", "the driver [h]", "the disk [h]", "core hours")
        told = (
            f"{found['realisations']:,} realisations of {found['duration_s']:g} s with {found['laws']} compiled laws."
        )
        return f"{told.replace(',', ' ')}\n\n{table((*heads, 'driver [GB]', 'stored [GB]'), lines, 0)}"

    return kept("benchmarks/scale.json", "python benchmarks/scale.py --whole", make)


def overhead() -> str:
    """What a second worker is worth, and what the engine takes of each item."""

    def make(found: Mapping[str, Any]) -> str:
        rows = [(name, row) for name, row in found.items() if isinstance(row, Mapping) and "times" in row]
        lines = [
            [
                name,
                number(row["item_s"], 3),
                number(row["times"], 3),
                *(number(row[one], 2) for one in ("overhead_ms", "overhead_of_2_ms")),
            ]
            for name, row in rows
        ]
        nothing = found["nothing"]
        told = (
            f"Of items that take no time, key and store take {number(nothing['key_ms'] + nothing['stored_ms'], 2)} ms "
            f"each, finding them again {number(nothing['found_ms'], 2)} ms."
        )
        heads = (
            "items of a law from a file",
            "an item [s]",
            "2 workers, times the rate of 1",
            "overhead of an item [ms]",
            "with 2 workers [ms]",
        )
        return f"{table(heads, lines)}\n\n{told}"

    path, command = "benchmarks/engine_overhead.json", "python benchmarks/engine_overhead.py"
    return kept(path, read(path)["command"] if (ROOT / path).is_file() else command, make)


def site() -> str:
    """How long a year at a site takes."""

    def make(found: Mapping[str, Any]) -> str:
        first, again = found["first"], found["all_stored"]
        runs = f"{found['realisations']} realisations of {number(found['duration_s'], 3)} s"
        return (
            f"{found['sea_states']} sea states, {runs} and {len(found['laws'].split(','))} compiled laws take "
            f"{number(first['wall_s'] / 60.0, 2)} minutes on two cores, the search of the constant pairs included, and "
            f"{number(again['wall_s'], 2)} s where all of it is stored."
        )

    return kept("benchmarks/site.json", "python -P benchmarks/site.py", make)


def kills() -> str:
    """What became of a study whose processes were killed."""

    def make(found: Mapping[str, Any]) -> str:
        shown = (
            ("items", "items"),
            ("commands", "times that the command was given"),
            ("runs_begun", "runs begun"),
            ("lost", "lost"),
            ("other_bits", "of other bits than the serial study"),
            ("stored_twice", "stored twice"),
            ("computed_again_though_stored", "computed again though stored"),
            ("half_written", "files left half-written"),
            ("processes_left", "processes left"),
        )
        modes = [mode for mode in ("scheduler", "alone") if mode in found]
        lines = [["killed", *("; ".join(f"{n} × {who}" for who, n in found[m]["killed"].items()) for m in modes)]]
        lines += [[what, *(str(found[mode][name]) for mode in modes)] for name, what in shown]
        return table(("", *({"scheduler": "4 workers of Dask", "alone": "alone"}[mode] for mode in modes)), lines)

    return kept("benchmarks/kills.json", "python benchmarks/kills.py", make)


BLOCKS: Mapping[str, Callable[[], str]] = {
    "scale-parts": parts,
    "scale-memory": memory,
    "scale-whole": whole,
    "scale-paper": on_paper,
    "engine-overhead": overhead,
    "kills": kills,
    "site-cost": site,
}
