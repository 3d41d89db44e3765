"""Entry of the study: figures by name, each as picture and data, and the statement table."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any, cast

import numpy as np

from gyroctl.engine.cluster import connected
from gyroctl.engine.state import RUNS
from gyroctl.errors import InputError
from gyroctl.harness.seed_ledger import ledger
from gyroctl.provenance import made
from gyroctl.reading import read_json
from gyroctl.studies.paper.drawing import Drawing, Table
from gyroctl.studies.paper.ensembles import Setup
from gyroctl.studies.style import save, styled, written
from gyroctl.writing import write_rows, write_text

FIGURES = ("fig8", "fig9", "fig10", "fig11", "fig12", "fig13", "fig14", "fig15")
"""Figures of the paper's numerical example."""

NOTE = "reproduce.json"
"""What made each figure of a folder, and what its last command was."""

EXTRAS = ("hinge_damping", "choices", "statements")
"""What the paper does not have: two studies of our own, and the table of its statements."""


def reproduce(
    figures: Sequence[str], out: Path, quiet: bool = False, setup: Setup | None = None, scheduler: Any = None
) -> list[Path]:
    """Make figures of the paper.

    Parameters
    ----------
    figures : sequence of str
        Any of "fig8" to "fig15", "hinge_damping", "choices", "statements", or "all".
    out : Path
        Directory for NAME.png, NAME.svg, NAME.pdf, NAME.csv, statements.md and statements.json; made where it is
        missing. Runs that are finished are kept in its folder ``runs``, and not made again.
    quiet : bool
        Print nothing.
    setup : Setup, optional
        Realisations; 64 of 2000 s by default.
    scheduler : str or dask.distributed.Client, optional
        Address of a Dask scheduler whose workers run the ensembles; the same bits.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    ConnectionError
        Where the scheduler is lost; ensembles that had ended are kept.
    InputError
        For an unknown figure or an empty list, or a scheduler that does not answer, before anything is computed; or
        where `out` is a file.
    """
    names = chosen(figures)
    if scheduler is not None:
        with connected(scheduler) as client:
            here = setup or Setup(quiet=quiet, folder=out / RUNS)
            return reproduce(names, out, quiet, replace(here, client=client))
    setup = setup or Setup(quiet=quiet, folder=out / RUNS)
    try:
        out.mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError):
        raise InputError("out", str(out), "is not a directory", "Give the name of a directory") from None
    done: list[Path] = []
    for name in names:
        files = _statements(setup, out, quiet) if name == "statements" else _figure(name, setup, out)
        done += files
        if not quiet:
            _say(f"{name}: {', '.join(path.name for path in files)}")
    record = {**made(), "seeds": list(setup.seeds), "seed_states": ledger().states(setup.seeds)}
    record |= {"duration_s": setup.duration, "made": list(names)}
    own = {key: value for key, value in record.items() if key != "made"}
    kept = _earlier(out / NOTE) | {name: own for name in names}
    record["figures"] = {name: kept[name] for name in (*FIGURES, *EXTRAS) if name in kept}
    return [*done, write_text(out / NOTE, json.dumps(record, indent=2) + "\n")]


def _earlier(note: Path) -> dict[str, Any]:
    """What made the figures that lie in the folder by an earlier command, by their names; none that cannot be read."""
    try:
        record = read_json("results", note, "Make the figures again")
    except InputError:
        return {}
    if not isinstance(record, Mapping):
        return {}
    figures, last = record.get("figures"), record.get("made")
    if isinstance(figures, Mapping):
        return dict(figures)
    if not isinstance(last, list):
        return {}
    return {name: {k: v for k, v in record.items() if k != "made"} for name in last if isinstance(name, str)}


def chosen(figures: Sequence[str]) -> tuple[str, ...]:
    """Names in the order in which they are made, each once; "all" stands for everything."""
    known = (*FIGURES, *EXTRAS)
    asked = [figures] if isinstance(figures, str) else list(figures)
    mend = f"Choose from {', '.join(known)}, or all"
    if not asked:
        raise InputError("figures", asked, "no figure is named", mend)
    for name in asked:
        if name not in (*known, "all"):
            raise InputError("figures", name, "unknown figure", mend)
    return tuple(name for name in known if name in asked or "all" in asked)


def _figure(name: str, setup: Setup, out: Path) -> list[Path]:
    draw = cast(Callable[[Setup], Drawing], import_module(f"gyroctl.studies.paper.{name}").draw)
    with styled():
        drawing = draw(setup)
        picture = save(drawing.figure, out / f"{name}.png")
    tables = [_csv(out / f"{name}{f'_{s}' if s else ''}.csv", table) for s, table in drawing.tables.items()]
    return [*written(picture), *tables]


def _statements(setup: Setup, out: Path, quiet: bool) -> list[Path]:
    from gyroctl.studies.paper.statement_table import as_json, markdown, terminal
    from gyroctl.studies.paper.statements import evaluate

    findings = evaluate(setup)
    if not quiet:
        from rich.console import Console

        console = Console()
        # a pipe has no width of its own: give the table the room it needs
        Console(width=None if console.is_terminal else 170).print(terminal(findings, setup))
    return [
        write_text(out / "statements.md", markdown(findings, setup)),
        write_text(out / "statements.json", as_json(findings, setup)),
    ]


def _csv(path: Path, table: Table) -> Path:
    columns = {name: np.asarray(values) for name, values in table.items()}
    if len({len(values) for values in columns.values()}) > 1:
        raise ValueError(f"columns of {path.name} differ in length")
    rows = zip(*columns.values(), strict=True)
    printed = ([f"{value:.8g}" if isinstance(value, float | np.floating) else value for value in row] for row in rows)
    return write_rows(path, [columns, *printed])


def _say(text: str) -> None:
    from rich.console import Console

    Console(stderr=True).print(text, highlight=False)
