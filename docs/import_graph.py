"""Who imports whom, read from the sources alone: no module of the package is imported for it.

Every import counts, wherever it stands: at the top of a file, inside a function, under ``TYPE_CHECKING``, as
``import_module("...")`` with a literal, in the ``.pyi`` stub of a lazy face, or through a name of such a face (``import
gyroctl as gy`` and then ``gy.lock_orbit``). What the harness finds by an entry point is no import: laws are looked up
by name.

`docs/draw_rooms.py` draws the graph, `tests/test_house.py` holds it to the layers that ``pyproject.toml`` declares.
"""

from __future__ import annotations

import ast
import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path

PACKAGE = "gyroctl"

BESIDE = ("controllers", "studies")
"""Rooms that lie beside the package's folder in a checkout, and are imported as its own."""

Files = dict[str, Path]
"""Files by the name under which they are imported."""

Graph = dict[str, set[str]]
"""What each file imports, both by the name under which it is imported."""


def shipped_files(root: Path) -> Files:
    """Python files of the package by module name, sorted."""
    found = {}
    for folder in (PACKAGE, *BESIDE):
        for path in sorted((root / folder).rglob("*.py")):
            parts = path.relative_to(root).with_suffix("").parts
            if parts[0] == PACKAGE and parts[1] in BESIDE:
                continue  # the link in the package's folder: the room itself is read
            parts = parts if parts[0] == PACKAGE else (PACKAGE, *parts)
            found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return dict(sorted(found.items()))


def file_graph(root: Path) -> Graph:
    """Read the imports between the files of the package below `root`."""
    files = shipped_files(root)
    face = {
        name: home for module, path in files.items() for name, home in _names_of_the_face(module, path, files).items()
    }
    return {
        module: {target for target in _targets(module, path, files, face) if target in files and target != module}
        for module, path in files.items()
    }


def layers(root: Path) -> list[list[str]]:
    """Layers of rooms from above to below, as the contract of import-linter declares them."""
    contracts = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]
    (declared,) = (c["layers"] for c in contracts["contracts"] if c["type"] == "layers")
    return [[room.strip() for room in layer.split("|")] for layer in declared]


def room(module: str) -> str:
    """Room of a file: the part of its name after the package's; "" for the package's own face."""
    return module.split(".")[1] if "." in module else ""


def rooms_graph(graph: Mapping[str, set[str]]) -> Counter[tuple[str, str]]:
    """Count imports from room to room, each pair of files once; the package's face and `__main__` are no rooms."""
    pairs = ((room(module), room(target)) for module, targets in graph.items() for target in targets)
    return Counter(pair for pair in pairs if pair[0] != pair[1] and not {"", "__main__"} & set(pair))


def upward(graph: Mapping[str, set[str]], declared: list[list[str]]) -> list[str]:
    """Name imports that lead upward, or sideways between rooms of one layer: "from -> to"."""
    level = {name: depth for depth, layer in enumerate(declared) for name in layer}
    return [
        f"{module} -> {target}"
        for module, targets in sorted(graph.items())
        for target in sorted(targets)
        if (here := room(module)) in level
        and (there := room(target)) in level
        and here != there
        and level[here] >= level[there]
    ]


def circles(graph: Mapping[str, set[str]]) -> list[list[str]]:
    """Find sets of files of which each reaches each other by imports (Tarjan's strongly connected components)."""
    order: dict[str, int] = {}
    lowest: dict[str, int] = {}
    open_files: list[str] = []
    found: list[list[str]] = []

    def visit(module: str) -> None:
        order[module] = lowest[module] = len(order)
        open_files.append(module)
        for target in sorted(graph[module]):
            if target not in order:
                visit(target)
                lowest[module] = min(lowest[module], lowest[target])
            elif target in open_files:
                lowest[module] = min(lowest[module], order[target])
        if lowest[module] == order[module]:
            start = open_files.index(module)
            component = open_files[start:]
            del open_files[start:]
            if len(component) > 1:
                found.append(sorted(component))

    for module in sorted(graph):
        if module not in order:
            visit(module)
    return found


def _targets(module: str, path: Path, files: Files, face: Mapping[str, str]) -> Iterator[str]:
    """Names of what a file imports; those outside the package too."""
    nodes = list(ast.walk(ast.parse(path.read_text(encoding="utf-8"), str(path))))
    package = module if path.name == "__init__.py" else module.rpartition(".")[0]
    own = _names_of_the_package(nodes)
    yield from (home for name, home in face.items() if name.rpartition(".")[0] == module)  # of its own face
    for node in nodes:
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom):
            source = _absolute(node, package)
            for name in node.names:
                inside = f"{source}.{name.name}"
                yield inside if inside in files else face.get(inside, source)
        elif isinstance(node, ast.Call):
            yield from _imported_by_name(node, files)
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in own:
            yield face.get(f"{PACKAGE}.{node.attr}", PACKAGE)  # gy.lock_orbit: the file that defines it


def _absolute(node: ast.ImportFrom, package: str) -> str:
    """Module of ``from module import ...``, also where it is relative to the package of the file."""
    if node.level == 0:
        return str(node.module)
    above = package.split(".")[: len(package.split(".")) - node.level + 1]
    return ".".join([*above, *([node.module] if node.module else [])])


def _imported_by_name(call: ast.Call, files: Files) -> Iterator[str]:
    """``import_module`` of a literal; of an f-string that begins with a literal, every module that it may name."""
    called = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")
    if called != "import_module" or not call.args:
        return
    name = call.args[0]
    if isinstance(name, ast.Constant):
        yield str(name.value)
    elif isinstance(name, ast.JoinedStr) and isinstance(name.values[0], ast.Constant):
        begin = str(name.values[0].value)
        yield from (module for module in files if module.startswith(begin) and "." not in module[len(begin) :])


def _names_of_the_package(nodes: list[ast.AST]) -> set[str]:
    """What the file calls the package: ``import gyroctl as gy`` gives gy."""
    imported = (name for node in nodes if isinstance(node, ast.Import) for name in node.names)
    return {name.asname or PACKAGE for name in imported if name.name == PACKAGE}


def _names_of_the_face(module: str, path: Path, files: Files) -> dict[str, str]:
    """Files that define the names of a lazy face, by ``package.name``, from the stub beside its ``__init__.py``."""
    stub = path.with_suffix(".pyi")
    if not stub.is_file():
        return {}
    found = {}
    for node in ast.parse(stub.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.ImportFrom):
            source = _absolute(node, module)
            homes = {name.name: f"{source}.{name.name}" for name in node.names}
            found |= {f"{module}.{name}": home if home in files else source for name, home in homes.items()}
    return found
