"""The page of an evaluation: one HTML file that works without a network, from the files of its tables."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from gyroctl.errors import InputError
from gyroctl.names import in_markup
from gyroctl.reading import read_json, read_text
from gyroctl.reports import page
from gyroctl.writing import write_text

MEND = "Give the folder that gyroctl evaluate wrote"

NUMBER = re.compile(r"[><~+\N{MINUS SIGN}-]?\s*(?:&[lg]t;\s*)?(?:\d|∞)")
"""How a cell of numbers begins."""


def tables_in(folder: Path, names: tuple[str, ...]) -> list[str]:
    """Tables of an evaluation whose two files lie in a folder, of these names."""
    return [name for name in names if (folder / f"{name}.json").is_file() and (folder / f"{name}.md").is_file()]


def write_page(folder: Path, names: tuple[str, ...], out: Path | None = None) -> Path:
    """Write evaluation.html, whole or not at all, of every table whose files lie in a folder.

    Raises
    ------
    InputError
        Field ``results``, where there is no table, or a file is none of an evaluation.
    """
    there = tables_in(folder, names)
    if not there:
        raise InputError("results", str(folder), "holds no table of an evaluation", MEND)
    tables = [_table(folder, name) for name in there]
    dates = sorted({date for table in tables if (date := table["date"])})
    text = page.render("evaluation.html.j2", {"tables": tables, "dates": dates})
    return write_text((out or folder) / "evaluation.html", text)


def _table(folder: Path, name: str) -> dict[str, Any]:
    content = read_json("results", folder / f"{name}.json", MEND)
    if not isinstance(content, dict) or not isinstance(content.get("table"), str):
        raise InputError("results", str(folder / f"{name}.json"), "is no table of an evaluation", MEND)
    text = read_text("results", folder / f"{name}.md", MEND)
    return {
        "anchor": name,
        "title": str(content.get("title", name)),
        "date": str(content.get("date", "")),
        "picture": page.as_source(folder / f"{name}.png"),
        "width": page.width_of(folder / f"{name}.png"),
        "text": in_html(text, str(content.get("title", name))),
        "provenance": page.provenance(content),
    }


def in_html(text: str, title: str) -> str:
    """Text of a table file as HTML: without its first heading and its picture, which the page has by itself.

    Markup in the text is text: what laws and cases are called cannot leave its place. Tables scroll, and their first
    cells are the headings of their rows.
    """
    from markdown_it import MarkdownIt

    text = re.sub(r"\A# .*\n", "", text)
    text = re.sub(r"^!\[[^\]]*\]\([^)]*\)\n", "", text, flags=re.M)
    found = (
        MarkdownIt("commonmark", {"html": False}).enable("table").disable(["image", "link", "autolink"]).render(text)
    )
    found = re.sub(r"<(/?)h2>", r"<\1h3>", found)
    found = re.sub(r"<th(?=[ >])", '<th scope="col"', found)
    found = re.sub(r"<tr>\s*<td([^>]*)>(.*?)</td>", r'<tr><th scope="row"\1>\2</th>', found, flags=re.S)
    found = re.sub(r' style="text-align:\w+"', "", found)
    count = 0

    def scrolled(table: re.Match[str]) -> str:
        nonlocal count
        count += 1
        label = in_markup(f"{title}, table {count}")
        return f'<div class="scroll" tabindex="0" role="region" aria-label="{label}">{aligned(table.group())}</div>'

    return re.sub(r"<table>.*?</table>", scrolled, found, flags=re.S)


def aligned(table: str) -> str:
    """Table in which columns of words begin at the left: the first, and those without a number in any row."""
    rows = [re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", row, re.S) for row in re.findall(r"<tr>(.*?)</tr>", table, re.S)]
    body = rows[1:]
    words = {0} | {
        k
        for k in range(len(rows[0]) if rows else 0)
        if body and not any(k < len(row) and NUMBER.match(row[k]) for row in body)
    }

    def row_again(row: re.Match[str]) -> str:
        column = -1

        def cell(found: re.Match[str]) -> str:
            nonlocal column
            column += 1
            return f"<{found[1]}{found[2]}{' class=' + chr(34) + 'text' + chr(34) if column in words else ''}>"

        return re.sub(r"<(t[hd])((?: [^>]*)?)>", cell, row.group())

    return re.sub(r"<tr>.*?</tr>", row_again, table, flags=re.S)
