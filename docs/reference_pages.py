"""Write the pages of the reference, ``docs/reference``: every public name by room, and the commands with their options.

Called by ``docs/build_site.py``; the pages are made at each build and kept by nobody. What stands in them is the
docstrings and the help texts alone.
"""

from __future__ import annotations

import re
import shutil
from collections.abc import Sequence
from pathlib import Path

from public_names import Name, first_named, groups, names_of, rooms_in_order

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "docs" / "reference"


def heading(title: str, mark: str = "=") -> list[str]:
    """Lines of a heading."""
    return [title, mark * len(title), ""]


def summary(names: Sequence[Name], module: str) -> list[str]:
    """Lines of a table of names, each with a page of its own."""
    if not names:
        return []
    rows = [f"   {name.name}" for name in names]
    return [
        f".. currentmodule:: {module}",
        "",
        ".. autosummary::",
        "   :toctree: names",
        "   :nosignatures:",
        "",
        *rows,
        "",
    ]


def front() -> str:
    """The names of ``gyroctl`` along the flow, and the rooms below."""
    lines = heading("Reference")
    lines += ["``import gyroctl as gy``: what is called day by day, along the flow from the sea to the report.", ""]
    for title, names in groups().items():
        lines += heading(title, "-") + summary(names, "gyroctl")
    lines += heading("Rooms", "-")
    lines += ["Each room of the package exports what serves a study of its own. Their order is that of the flow.", ""]
    lines += [
        ".. toctree::",
        "   :maxdepth: 1",
        "",
        *(f"   room_{room.replace('.', '_')}" for room in rooms_in_order()),
        "",
    ]
    return "\n".join(lines)


def shown_above(name: Name) -> Name | None:
    """The same thing where its page is: with the room that exports it first, None where that is this one."""
    first = first_named()[name.key]
    return None if first == name else first


def in_place(name: Name) -> bool:
    """Whether a name is explained on the page of its room."""
    return name.constant or name.filled


def page_of(name: Name) -> str:
    """File of the site that explains a name, from the folder of the reference."""
    room = name.room.removeprefix("gyroctl.").replace(".", "_")
    return f"room_{room}.html" if in_place(name) else f"names/{name.path}.html"


def room_page(room: str) -> str:
    """The names of a room: those that ``gyroctl`` exports by a link, the others by pages, constants in place."""
    import importlib

    module = f"gyroctl.{room}"
    names = names_of(room)
    about = (importlib.import_module(module).__doc__ or "").strip()
    lines = [*heading(module), about, ""]
    above = [first for name in names if (first := shown_above(name)) is not None]
    if above:
        lines += [f"Explained elsewhere: {', '.join(f':obj:`{name.path}`' for name in above)}.", ""]
    own = [name for name in names if shown_above(name) is None]
    lines += summary([name for name in own if not in_place(name)], module)
    for title, chosen in (
        ("Functions with arguments filled in", [name for name in own if name.filled]),
        ("Constants", [name for name in own if name.constant]),
    ):
        lines += heading(title, "-") if chosen else []
        for name in chosen:
            lines += [f".. autodata:: {name.home}.{name.name}", "   :no-value:", ""]
    behind = sorted({f"{name.thing.func.__module__}.{name.thing.func.__name__}" for name in own if name.filled})
    for function in behind:
        lines += ["Their arguments are those that are not filled in of", "", f".. autofunction:: {function}", ""]
    return "\n".join(lines)


def commands_page() -> str:
    """The commands with arguments and options, from their help texts."""
    import typer
    from typer.cli import get_docs_for_click

    from gyroctl.cli.app import app

    command = typer.main.get_command(app)
    context = typer.Context(command, info_name="gyroctl")
    text = get_docs_for_click(obj=command, ctx=context, name="gyroctl", title="Commands")
    # links to places within the page are of another renderer, and what looks like markup in a help text is none
    return re.sub(r"\[required\]", "required", text)


def write(folder: Path = FOLDER) -> list[Path]:
    """Write all pages anew; return them."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    pages = {"index.rst": front(), "commands.md": commands_page()}
    pages.update({f"room_{room.replace('.', '_')}.rst": room_page(room) for room in rooms_in_order()})
    for name, text in pages.items():
        (folder / name).write_text(text, encoding="utf-8", newline="\n")
    return [folder / name for name in pages]


if __name__ == "__main__":
    print("\n".join(path.relative_to(ROOT).as_posix() for path in write()))
