"""The house in order: no circle of imports, no arrow upward, nothing that only POSIX has, files of a size to be read.

Each check is also run on a small made-up house with the fault planted in it, to show that it can fail.
"""

from __future__ import annotations

import ast
import re
import subprocess
import textwrap
from collections.abc import Iterator
from pathlib import Path

import pytest
from draw_rooms import PICTURE, draw, structure
from import_graph import circles, file_graph, layers, rooms_graph, shipped_files, upward

import gyroctl as gy

ROOT = Path(gy.__file__).resolve().parents[1]

POSIX_MODULES = {"fcntl", "grp", "posix", "pty", "pwd", "resource", "termios"}
POSIX_NAMES = {
    "os": {
        "fork",
        "forkpty",
        "getegid",
        "geteuid",
        "getgid",
        "getpgid",
        "getuid",
        "killpg",
        "mkfifo",
        "setsid",
        "uname",
    },
    "signal": {"SIGALRM", "SIGHUP", "SIGKILL", "SIGQUIT", "SIGUSR1", "SIGUSR2", "alarm", "setitimer"},
}
TEMPORARY = "/" + "tmp"

LONGEST = 400
"""Lines beyond which a file holds more than one idea."""

SKIP = "# fmt: " + "skip"


# --- the checks --------------------------------------------------------------------------------------------------


def posix_only(path: Path) -> list[str]:
    """What a file names that Windows does not have."""
    found = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found += [name.name for name in node.names if name.name in POSIX_MODULES]
        elif isinstance(node, ast.ImportFrom) and node.module:
            found += [node.module] if node.module in POSIX_MODULES else []
            found += [name.name for name in node.names if name.name in POSIX_NAMES.get(node.module, ())]
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            found += [f"{node.value.id}.{node.attr}"] if node.attr in POSIX_NAMES.get(node.value.id, ()) else []
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and TEMPORARY in node.value:
            found.append(repr(node.value))
    return found


def faults(root: Path) -> list[str]:
    """Everything that the four checks find below `root`, each with its name first."""
    graph = file_graph(root)
    files = shipped_files(root)
    found = [f"circle: {' '.join(circle)}" for circle in circles(graph)]
    found += [f"upward: {arrow}" for arrow in upward(graph, layers(root))]
    found += [f"posix: {module}: {name}" for module, path in files.items() for name in posix_only(path)]
    return found


def longer_than(limit: int, paths: Iterator[Path]) -> list[str]:
    """Files of more than `limit` lines."""
    return [path.name for path in paths if len(path.read_text(encoding="utf-8").splitlines()) > limit]


def skipped_lines(paths: Iterator[Path]) -> list[str]:
    """Lines that are kept from the formatter."""
    return [f"{p.name}: {line}" for p in paths for line in p.read_text(encoding="utf-8").splitlines() if SKIP in line]


def python_files() -> Iterator[Path]:
    """Python files that git knows."""
    done = subprocess.run(["git", "ls-files", "-z", "*.py"], cwd=ROOT, capture_output=True, text=True)
    if done.returncode != 0:
        pytest.skip("the tests run outside a clone")
    return (ROOT / name for name in done.stdout.split("\0") if name and (ROOT / name).is_file())


# --- this house --------------------------------------------------------------------------------------------------


def test_no_circle_no_arrow_upward_nothing_of_posix() -> None:
    assert faults(ROOT) == []


@pytest.mark.slow
def test_graph_holds_what_is_known_of_it() -> None:
    """Imports of each kind that the reader claims to see: plain, lazy, by name, through the public face."""
    graph = file_graph(ROOT)
    assert "gyroctl.plant.parameters" in graph["gyroctl.plant.plant"]
    assert "gyroctl.studies.paper.statements" in graph["gyroctl.studies.paper.reproduce"], "inside a function"
    assert "gyroctl.studies.paper.fig8" in graph["gyroctl.studies.paper.reproduce"], "by name"
    assert "gyroctl.waves.estimation" in graph["gyroctl.waves"], "by name, in the lazy face of a room"
    assert "gyroctl.harness.run" in graph["gyroctl.cli.simulate"], "as gy.simulate"
    assert len(graph) > 200


def test_at_most_forty_lines_are_kept_from_the_formatter() -> None:
    assert len(skipped_lines(python_files())) <= 40


def test_at_most_two_shipped_files_are_longer_than_400_lines() -> None:
    assert len(longer_than(LONGEST, iter(shipped_files(ROOT).values()))) <= 2


def test_picture_of_the_rooms_is_that_of_the_code() -> None:
    """Rooms and arrows, not numbers of lines, which change daily: `make docs-rooms` draws it anew."""
    rooms, arrows = structure(PICTURE.read_text(encoding="utf-8"))
    assert rooms == [name for layer in layers(ROOT) for name in layer]
    assert arrows == set(rooms_graph(file_graph(ROOT)))
    assert (rooms, arrows) == structure(draw(ROOT))


# --- the ways to run the checks ----------------------------------------------------------------------------------

CHECKS = ["ruff check .", "ruff format --check .", "mypy", "lint-imports"]


def text(name: str) -> str:
    """A file of the checkout; outside one there is nothing to compare."""
    path = ROOT / name
    if not path.is_file():
        pytest.skip("the tests run outside a clone")
    return path.read_text(encoding="utf-8")


def recipes(makefile: str) -> dict[str, list[str]]:
    """Commands of each target."""
    found: dict[str, list[str]] = {}
    target = ""
    for line in makefile.splitlines():
        if line.startswith("\t"):
            found[target].append(line.strip())
        elif (match := re.match(r"([\w-]+):", line)) is not None:
            target = match[1]
            found[target] = []
    return found


def test_makefile_has_the_two_commands_of_the_readme() -> None:
    commands = re.findall(r"^```sh\n(python3 .*)\n```$", text("README.md"), re.MULTILINE)
    made = recipes(text("Makefile"))
    assert [made["compare"], made["test"]] == [[command] for command in commands]


def test_ci_makefile_and_hooks_run_the_same_checks() -> None:
    made = recipes(text("Makefile"))
    wanted = [f".venv/bin/{check}" for check in CHECKS]
    assert [line for line in text(".ci/run").splitlines() if line.startswith(".venv/")] == wanted
    assert made["slow"] == [".venv/bin/python -m pytest -n 2 -m slow"] and made["slow"][0] in text(".ci/run")
    assert made["slow"][0] in text("README.md") and 'pytest -n 2 -m "not slow"' in text("README.md")
    assert made["lint"] + made["types"] + made["imports"] == wanted
    assert made["docs"] == [".venv/bin/python docs/build_site.py"] and made["docs"][0] in text(".ci/run")
    assert re.search(r"^checks: lint types imports$", text("Makefile"), re.MULTILINE)
    hooks = text(".pre-commit-config.yaml")
    assert re.findall(r"^ +entry: (.*)$", hooks, re.MULTILINE) == wanted
    assert set(re.findall(r"repo: (.*)$", hooks, re.MULTILINE)) == {"local"}, "no network for a commit"
    for check in CHECKS:
        assert f"`{check}`" in text("CONTRIBUTING.md")


# --- the way into the project ------------------------------------------------------------------------------------

MADE_UP = ("governor", "swell", "heights", "fig16", "draw_<what>")
"""What the recipes add."""


def test_recipes_name_files_that_exist_and_code_that_parses() -> None:
    guide = text("CONTRIBUTING.md")
    named = set(re.findall(r"`((?:gyroctl|controllers|studies|tests|docs|benchmarks)/[^` ]*)`", guide))
    missing = [name for name in named if not (ROOT / name).exists() and not any(word in name for word in MADE_UP)]
    assert len(named) > 30 and missing == []
    for block in re.findall(r"^ *```python\n(.*?)^ *```$", guide, re.MULTILINE | re.DOTALL):
        code = textwrap.dedent(block).strip()
        ast.parse(f"{{{code}}}" if code.startswith('"') and '": ' in code else code)


def test_law_of_the_recipe_is_one(tmp_path: Path) -> None:
    blocks = re.findall(r"^```python\n(.*?)^```$", text("CONTRIBUTING.md"), re.MULTILINE | re.DOTALL)
    (tmp_path / "governor.py").write_text(next(block for block in blocks if "class Governor" in block))
    law = gy.law(f"{tmp_path}/governor.py:Governor")
    faster = gy.Measurement(psi=0.0, psi_rate=3.5, omega_rate=70.0, phi1=0.0, phi3=0.0, phi1_rate=0.0, phi3_rate=0.0)
    (cc, cg), _ = law.step(0.0, faster, law.init())
    assert cc == 0.06 and cg > 4e-4


# --- made-up houses ----------------------------------------------------------------------------------------------

LAYERS = """
[[tool.importlinter.contracts]]
type = "layers"
layers = ["studies", "harness | tuning", "plant"]
"""
SOUND = {
    "gyroctl/__init__.py": "",
    "gyroctl/__init__.pyi": "from .harness.run import simulate\n",
    "gyroctl/plant/__init__.py": '"""The plant."""\n',
    "gyroctl/plant/equations.py": "",
    "gyroctl/harness/__init__.py": '"""The loop."""\nfrom gyroctl.harness.run import simulate\n',
    "gyroctl/harness/run.py": "from gyroctl.plant import equations\n",
    "gyroctl/tuning/__init__.py": '"""Tuning."""\n',
    "studies/__init__.py": '"""Studies."""\n',
    "studies/bound.py": "import gyroctl as gy\n\nRUN = gy.simulate\n",
    "gyroctl/studies": "../studies",
}


def house(folder: Path, changes: dict[str, str]) -> Path:
    """Build a small house of four rooms; `changes` are files written on top of the sound ones."""
    (folder / "pyproject.toml").write_text(LAYERS)
    for name, text in {**SOUND, **changes}.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return folder


def test_sound_house_has_no_fault(tmp_path: Path) -> None:
    root = house(tmp_path, {})
    assert faults(root) == []
    assert set(rooms_graph(file_graph(root))) == {("harness", "plant"), ("studies", "harness")}


@pytest.mark.parametrize(
    "back",
    [
        "import gyroctl.harness.run\n",
        "from gyroctl.harness import run\n",
        "def later():\n    from gyroctl.harness.run import simulate\n",
        "from typing import TYPE_CHECKING\n\nif TYPE_CHECKING:\n    from gyroctl.harness.run import Run\n",
        'import importlib\n\nRUN = importlib.import_module("gyroctl.harness.run")\n',
        'import importlib\n\n\ndef later(name):\n    importlib.import_module(f"gyroctl.harness.{name}")\n',
        "from ..harness import run\n",
        "def later():\n    import gyroctl as gy\n\n    return gy.simulate\n",
        "from gyroctl import simulate\n",
    ],
)
def test_circle_and_arrow_upward_are_found_however_the_import_is_written(tmp_path: Path, back: str) -> None:
    found = faults(house(tmp_path, {"gyroctl/plant/equations.py": back}))
    both = {"gyroctl.harness.run", "gyroctl.plant.equations"}
    assert any(both <= set(line.split()) for line in found if line.startswith("circle: "))
    assert "upward: gyroctl.plant.equations -> gyroctl.harness.run" in found
    assert len(found) == 2


def test_circle_within_a_room_is_found(tmp_path: Path) -> None:
    inner = {"gyroctl/plant/a.py": "from . import b\n", "gyroctl/plant/b.py": "def later():\n    from .a import it\n"}
    assert faults(house(tmp_path, inner)) == ["circle: gyroctl.plant.a gyroctl.plant.b"]


def test_file_that_imports_its_own_room_is_a_circle(tmp_path: Path) -> None:
    planted = {"gyroctl/harness/run.py": "from gyroctl.harness import simulate\n"}
    assert faults(house(tmp_path, planted)) == ["circle: gyroctl.harness gyroctl.harness.run"]


def test_arrow_between_rooms_of_one_layer_is_found(tmp_path: Path) -> None:
    planted = {"gyroctl/tuning/tune.py": "from gyroctl.harness import simulate\n"}
    assert faults(house(tmp_path, planted)) == ["upward: gyroctl.tuning.tune -> gyroctl.harness"]


@pytest.mark.parametrize(
    ("planted", "name"),
    [
        ("import os\n\nWHO = os.getuid()\n", "os.getuid"),
        ("from os import fork\n", "fork"),
        ("def later():\n    import fcntl\n", "fcntl"),
        ("from resource import getrusage\n", "resource"),
        ("import signal\n\nEND = signal.SIGKILL\n", "signal.SIGKILL"),
        (f'PLACE = "{TEMPORARY}/gyroctl"\n', f"'{TEMPORARY}/gyroctl'"),
        (f'PLACE = f"{TEMPORARY}/{{__name__}}"\n', f"'{TEMPORARY}/'"),
    ],
)
def test_what_only_posix_has_is_found(tmp_path: Path, planted: str, name: str) -> None:
    assert faults(house(tmp_path, {"studies/bound.py": planted})) == [f"posix: gyroctl.studies.bound: {name}"]


def test_long_files_and_skipped_lines_are_found(tmp_path: Path) -> None:
    long, short = tmp_path / "long.py", tmp_path / "short.py"
    long.write_text("a = 1\n" * (LONGEST + 1))
    short.write_text("a = 1\n" * (LONGEST - 1) + f"b = [1,2]  {SKIP}\n")
    assert longer_than(LONGEST, iter([long, short])) == ["long.py"]
    assert skipped_lines(iter([long, short])) == [f"short.py: b = [1,2]  {SKIP}"]


def test_picture_with_an_arrow_more_is_another(tmp_path: Path) -> None:
    drawn = structure(draw(house(tmp_path, {})))
    assert drawn == (["studies", "harness", "tuning", "plant"], {("harness", "plant"), ("studies", "harness")})
    changed = house(tmp_path, {"gyroctl/tuning/tune.py": "from gyroctl.plant import equations\n"})
    assert structure(draw(changed))[1] - drawn[1] == {("tuning", "plant")}
