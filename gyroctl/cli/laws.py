"""`gyroctl laws`: what is registered, with parameters and what each law looks at."""

from __future__ import annotations


def laws() -> None:
    """List the registered laws with their shipped tuning."""
    from rich.console import Console
    from rich.table import Table

    from gyroctl.harness.laws import describe, law, registered

    table = Table("law", "looks at", "period [s]", "parameters (shipped tuning)", "what it does")
    for name in registered():
        built = law(name)
        parameters = ", ".join(f"{key} {_short(value)}" for key, value in describe(built).items() if key != "period")
        summary = (type(built).__doc__ or "").strip().splitlines()[0]
        table.add_row(name, built.information, f"{built.period:g}", parameters, summary)
    Console().print(table)


def _short(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
