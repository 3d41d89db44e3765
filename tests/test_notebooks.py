"""The notebooks: short, without logic of their own, stored with small outputs, and executed without an error."""

from __future__ import annotations

import ast
import itertools
import re
from pathlib import Path
from typing import Any

import nbformat
import pytest

FOLDER = Path(__file__).parents[1] / "notebooks"
NAMES = (
    "the_device_and_its_lock",
    "linearisation_and_margins",
    "a_law_of_ones_own",
    "planning_and_the_price_of_information",
    "from_the_linear_sea_to_real_water",
    "does_the_coupling_help",
)
LAW = "a_law_of_ones_own"
"""The one that defines something: a law, as a file."""

CELLS, BYTES, SECONDS = 15, 300_000, 90.0
CORES = 2

MACHINE = re.compile(
    r"/(?:tmp|home|root|usr|opt|work|Users|var)/|[A-Z]:\\\\|site-packages|ipykernel_\d+|0x[0-9a-f]{8,}"
)
"""What tells of the machine that ran it: paths, processes, addresses."""

SPENT = "import os; print(sum(os.times()[:4]))"
"""Processor time of kernel and children. [s]"""


def read(name: str) -> Any:
    return nbformat.read(FOLDER / f"{name}.ipynb", as_version=4)


def code_of(notebook: Any) -> list[Any]:
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


def plain(source: str) -> str:
    """Python of a cell, without the magics of IPython."""
    return "\n".join(line for line in source.splitlines() if not line.startswith("%"))


def texts(cell: Any) -> list[str]:
    """All that the outputs of a cell say, but for pictures."""
    found = []
    for output in cell.get("outputs", []):
        found.append(output.get("text", ""))
        found += [value for kind, value in output.get("data", {}).items() if kind.startswith("text/")]
    return found


def pictures(notebook: Any) -> list[str]:
    return [o.data["image/png"] for cell in code_of(notebook) for o in cell.outputs if "image/png" in o.get("data", {})]


def test_every_notebook_is_on_the_list_and_on_the_page() -> None:
    assert sorted(path.stem for path in FOLDER.glob("*.ipynb")) == sorted(NAMES)
    page = (FOLDER / "README.md").read_text(encoding="utf-8")
    assert re.findall(r"\]\((\w+)\.ipynb\)", page) == list(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_notebook_is_short_and_begins_with_what_it_shows(name: str) -> None:
    notebook = read(name)
    nbformat.validate(notebook)
    assert 5 <= len(notebook.cells) <= CELLS
    assert notebook.cells[0].cell_type == "markdown" and notebook.cells[0].source.startswith("# ")


@pytest.mark.parametrize("name", NAMES)
def test_notebook_has_no_logic_of_its_own(name: str) -> None:
    """No function, class, branch or loop that waits: what is worth one is in the package, with a test."""
    logic = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef, ast.Lambda, ast.While, ast.If, ast.Try)
    for cell in code_of(read(name)):
        if not cell.source.startswith("%%writefile"):
            assert not [node for node in ast.walk(ast.parse(plain(cell.source))) if isinstance(node, logic)], (
                cell.source
            )


@pytest.mark.parametrize("name", NAMES)
def test_only_the_law_of_ones_own_is_defined_and_is_nothing_but_a_law(name: str) -> None:
    written = [cell for cell in code_of(read(name)) if cell.source.startswith("%%writefile")]
    assert len(written) == (1 if name == LAW else 0)
    for cell in written:
        body = ast.parse(plain(cell.source)).body
        classes = [node.name for node in body if isinstance(node, ast.ClassDef)]
        assert classes == ["GovernorState", "Governor"] and not [n for n in body if isinstance(n, ast.FunctionDef)]


@pytest.mark.parametrize("name", NAMES)
def test_notebook_is_stored_with_small_outputs_that_tell_nothing_of_the_machine(name: str) -> None:
    assert (FOLDER / f"{name}.ipynb").stat().st_size < BYTES
    notebook = read(name)
    counts = [cell.execution_count for cell in code_of(notebook)]
    assert counts == list(range(1, len(counts) + 1)), "executed from above to below, once"
    assert pictures(notebook)
    for cell in code_of(notebook):
        assert not [o for o in cell.outputs if o.output_type == "error" or o.get("name") == "stderr"]
        assert not [text for text in [cell.source, *texts(cell)] if MACHINE.search(text)]


def test_links_of_the_notebooks_lead_somewhere() -> None:
    for name in NAMES:
        for cell in read(name).cells:
            if cell.cell_type == "markdown":
                named = re.findall(r"\]\((?!https://)([^)]+)\)", cell.source)
                assert not [link for link in named if not (FOLDER / link).exists()], name
                pages = re.findall(r"`(docs/[\w./]+)`", cell.source)
                assert not [page for page in pages if not (FOLDER.parent / page).exists()], name


def kinds(cell: Any) -> list[str]:
    """What a cell shows, in order. How the printed text was cut into messages depends on the machine's speed alone."""
    return [kind for kind, _ in itertools.groupby(o.output_type for o in cell.outputs)]


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_notebook_runs_in_its_time_and_shows_as_much_as_is_stored(name: str, tmp_path: Path) -> None:
    from nbclient import NotebookClient

    stored, notebook = read(name), read(name)
    notebook.cells.append(nbformat.v4.new_code_cell(SPENT))
    NotebookClient(notebook, timeout=600, resources={"metadata": {"path": str(tmp_path)}}).execute()
    spent = float(texts(notebook.cells.pop())[0])
    assert spent < CORES * SECONDS
    assert len(pictures(notebook)) == len(pictures(stored))
    for now, then in zip(code_of(notebook), code_of(stored), strict=True):
        assert kinds(now) == kinds(then)
    assert not [o for cell in code_of(notebook) for o in cell.outputs if o.output_type == "error"]


def test_the_first_notebook_says_that_the_orbit_is_stable() -> None:
    assert any("stable" in text for cell in code_of(read(NAMES[0])) for text in texts(cell))
