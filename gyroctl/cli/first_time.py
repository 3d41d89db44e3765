"""What the first run on a machine does before anything is seen of it: said in a line, where it is so."""

from __future__ import annotations

import typer

LOOP = "loop._closed_loop"
"""Compiled by every run of a law."""


def say_first_time(what: str, seconds: int) -> None:
    """Say that something is compiled and how long that takes [s], where nothing of it has been kept yet."""
    from gyroctl.plant.machine_code import kept

    if not kept(LOOP):
        typer.echo(f"Compiling {what} for this machine, once: about {seconds} s", err=True)
