"""The package as it is shipped: what the wheel holds, that public names resolve, and that they are documented."""

from __future__ import annotations

import importlib
import importlib.util
import inspect
import pkgutil
import re
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from collections.abc import Iterator
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import gyroctl as gy

ROOT = Path(gy.__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text()) if (ROOT / "pyproject.toml").exists() else {}

NEEDED = (
    "gyroctl/__init__.py",
    "gyroctl/plant/equations.py",
    "gyroctl/data/hydrodynamics.nc",
    "gyroctl/controllers/__init__.py",
    "gyroctl/controllers/rule_based/__init__.py",
    "gyroctl/controllers/rule_based/constant.py",
    "gyroctl/controllers/rule_based/load_angle.py",
    "gyroctl/controllers/rule_based/coupling.py",
    "gyroctl/controllers/rule_based/tuned/constant.json",
    "gyroctl/controllers/rule_based/tuning/coupling.toml",
    "gyroctl/studies/__init__.py",
    "gyroctl/studies/paper/__init__.py",
    "gyroctl/reports/templates/report.html.j2",
    "gyroctl/reports/templates/page.html.j2",
    "gyroctl/reports/templates/margins.html.j2",
    "gyroctl/reports/templates/report.css",
    "gyroctl/reports/templates/report.js",
)


# --- wheel and sdist ---------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a wheel and an sdist, built by the project's own backend."""
    if importlib.util.find_spec("hatchling") is None:
        pytest.skip("hatchling, the build backend, is not installed here (the CI builds in isolation)")
    if not PROJECT:
        pytest.skip("the tests run outside a clone: there is nothing to build from")
    out = tmp_path_factory.mktemp("dist")
    command = [sys.executable, "-m", "hatchling", "build", "-d", str(out)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return out


def test_wheel_holds_laws_studies_data_and_templates(built: Path) -> None:
    """`controllers` and `studies` lie beside the package and come in under the one import name."""
    (wheel,) = built.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
        points = archive.read(next(name for name in names if name.endswith("entry_points.txt"))).decode()
    assert set(NEEDED) <= names
    for folder, inside in (("controllers", "gyroctl/controllers"), ("studies", "gyroctl/studies")):
        modules = {f"{inside}/{p.relative_to(ROOT / folder)}" for p in (ROOT / folder).rglob("*.py")}
        assert modules and modules <= names
    top = {name.split("/")[0] for name in names}
    assert len(top) == 2 and "gyroctl" in top, "one import name beside the metadata"
    assert not [name for name in names if "__pycache__" in name or name.endswith((".nbi", ".nbc", ".pyc"))]
    assert "gyroctl = gyroctl.cli:main" in points and "[gyroctl.controllers]" in points


def test_source_distribution_does_not_drop_the_laws(built: Path) -> None:
    (sdist,) = built.glob("*.tar.gz")
    with tarfile.open(sdist) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    laid = {re.sub(r"^gyroctl/(controllers|studies)/", r"\1/", name) for name in NEEDED}
    assert laid <= names
    assert {"pyproject.toml", "README.md", "LICENSE", "tests/test_package.py"} <= names


def test_wheel_works_without_the_clone(built: Path, tmp_path: Path) -> None:
    """Unpacked elsewhere: plant, law and report template come from the wheel itself."""
    (wheel,) = built.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path)
    code = (
        "import gyroctl as gy, sys; from pathlib import Path\n"
        "assert Path(gy.__file__).is_relative_to(sys.argv[1]), gy.__file__\n"
        "plant = gy.zhang2017(); law = gy.law('load_angle')\n"
        "assert plant.parameters.d1 == 2.0 and type(law).__module__.startswith('gyroctl.controllers')\n"
        "assert Path(sys.modules[type(law).__module__].__file__).is_relative_to(sys.argv[1])\n"
        "import gyroctl.studies.paper, gyroctl.reports\n"
    )
    done = subprocess.run(
        [sys.executable, "-P", "-c", f"import sys; sys.path.insert(0, sys.argv[1])\n{code}", str(tmp_path)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr


def test_version_and_name_agree() -> None:
    assert PROJECT["project"]["version"] == gy.__version__
    assert PROJECT["project"]["name"] == "gyroctl"


def test_symlinks_are_relative_and_lead_to_the_top() -> None:
    """Committed as links: an absolute one would be dead in any other clone."""
    for name in ("controllers", "studies"):
        link = ROOT / "gyroctl" / name
        assert link.is_symlink() and str(link.readlink()) == f"../{name}"
        assert (link / "__init__.py").is_file()


# --- public names ------------------------------------------------------------------------------------------------


def modules() -> Iterator[ModuleType]:
    """Every module of the package that can be imported here."""
    for info in pkgutil.walk_packages([str(ROOT / "gyroctl")], "gyroctl."):
        if info.name != "gyroctl.__main__":
            yield importlib.import_module(info.name)


def test_every_public_name_resolves() -> None:
    assert sorted(gy.__all__) == sorted(gy.__dir__())
    for name in gy.__all__:
        assert getattr(gy, name) is not None
    with pytest.raises(AttributeError, match="nothing"):
        _ = gy.nothing


def test_every_exported_name_of_every_package_resolves() -> None:
    for module in modules():
        for name in getattr(module, "__all__", ()):
            assert hasattr(module, name), f"{module.__name__}.{name}"


def test_names_of_the_contract_are_public() -> None:
    """DESIGN section 6: checks from outside rely on these."""
    for name in ("zhang2017", "law", "SeaState", "Regular", "realise", "simulate", "compare", "lock_orbit"):
        assert name in gy.__all__
    assert {p.name for p in entry_points(group="gyroctl.controllers")} >= {
        "constant",
        "best_constant",
        "load_angle",
        "coupling",
    }
    assert {"zhang2017", "realise", "simulate"} <= set(dir(gy))


def section(text: str, title: str) -> str:
    """A section of a numpy docstring."""
    found = re.search(rf"^{title}\n-{{3,}}\n(.*?)(?=^\w[\w ]*\n-{{3,}}$|\Z)", text, re.MULTILINE | re.DOTALL)
    return found.group(1) if found else ""


def documented(text: str) -> set[str]:
    """Parameters named in a numpy docstring: `a, b : float`, also stars, also `Attributes`."""
    names: set[str] = set()
    for title in ("Parameters", "Attributes"):
        for line in re.findall(r"^(\S[^:\n]*?)(?: ?:.*)?$", section(text, title), re.MULTILINE):
            names |= {name.strip().lstrip("*") for name in line.split(",")}
    return names


def parameters_of(thing: Any) -> list[str]:
    return [name for name in inspect.signature(thing).parameters if name not in ("self", "cls")]


PUBLIC = [name for name in gy.__all__ if callable(getattr(gy, name)) and name not in ("InputError", "LawError", "Law")]


@pytest.mark.parametrize("name", PUBLIC)
def test_every_public_parameter_is_documented(name: str) -> None:
    """numpy style, with the exceptions that refer to the function they pass to or comment each field in place."""
    thing = getattr(gy, name)
    text = inspect.getdoc(thing) or ""
    assert text and text.splitlines()[0].rstrip().endswith((".", "]")), name
    if name == "scan":
        assert "run_ensemble" in text
        from gyroctl.simulation import run_ensemble

        text += "\n\n" + (inspect.getdoc(run_ensemble) or "")
        assert "pairs" in documented(text)
    if name == "Measurement":  # a NamedTuple whose fields carry their units beside them
        source = inspect.getsource(thing)
        assert all(re.search(rf"{field}: float  # .*\[", source) for field in thing._fields)
        return
    known = documented(text)
    if inspect.isclass(thing) and not section(text, "Parameters") and hasattr(thing, "__dataclass_fields__"):
        lines = inspect.getsource(thing)
        known |= {f for f in thing.__dataclass_fields__ if re.search(rf"\b{f}\b", text + lines)}
    missing = [p for p in parameters_of(thing) if p not in known]
    assert not missing, f"{name}: {missing}"


@pytest.mark.parametrize("name", ["Plant", "WaveRealisation", "PeriodicOrbit"])
def test_public_methods_are_documented(name: str) -> None:
    thing = getattr(gy, name)
    for method, function in inspect.getmembers(thing, inspect.isfunction):
        if method.startswith("_") or function.__module__.partition(".")[0] != "gyroctl":
            continue
        text = inspect.getdoc(function) or ""
        assert text, f"{name}.{method}"
        mentioned = documented(text) | set(re.findall(r"`(\w+)`", text)) | set(re.findall(r"\w+", text))
        missing = [p for p in parameters_of(function) if p not in mentioned]
        assert not missing, f"{name}.{method}: {missing}"


def test_every_module_says_what_it_holds() -> None:
    for module in modules():
        assert (module.__doc__ or "").strip(), module.__name__


def test_numbers_with_a_dimension_have_a_unit_in_the_docstring() -> None:
    """STYLE: units in every docstring. Checked where a float is documented in the public functions and settings."""
    dimensionless = ("gamma", "power_cv", "bias", "noise", "quantum", "dropout", "error", "residual", "lock_share")
    for name in ("Settings", "Actuators", "SeaState", "Regular", "Parameters", "realise", "lock_orbit", "compare"):
        text = inspect.getdoc(getattr(gy, name)) or ""
        for field, description in re.findall(
            r"^(\w[\w, ]*) : (?:tuple of two )?floats?.*\n((?:[ \t]+.*\n?)+)", text, re.MULTILINE
        ):
            if field not in dimensionless:
                assert re.search(r"\[[^\]]+\]", description), f"{name}.{field}"


# --- the clone ---------------------------------------------------------------------------------------------------

TEXT = (".py", ".md", ".toml", ".json", ".txt", ".css", ".js", ".j2", ".ipynb", ".yml", ".yaml", ".cfg", "")
# split, so that this file does not hold what it looks for
MACHINES = ["/" + "home/", "/" + "root/", "/" + "Users/", "C:" + "\\", "/" + "work/", "/" + "tmp/"]


def tracked() -> list[Path]:
    done = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True)
    if done.returncode != 0:
        pytest.skip("the tests run outside a clone")
    return [ROOT / name for name in done.stdout.split("\0") if name]


def test_no_file_mentions_a_path_of_one_machine() -> None:
    found = []
    for path in tracked():
        if path.suffix in TEXT and path.is_file():
            text = path.read_text(encoding="utf-8", errors="replace")
            found += [f"{path.relative_to(ROOT)}: {machine}" for machine in MACHINES if machine in text]
    assert not found


def test_nothing_generated_is_committed() -> None:
    bad = [p for p in tracked() if p.suffix in (".pyc", ".nbi", ".nbc", ".part") or "__pycache__" in p.parts]
    assert not bad


def test_layers_are_declared_for_every_folder_of_the_package() -> None:
    """A folder that is not in the contract of import-linter escapes it silently."""
    (layers,) = (c["layers"] for c in PROJECT["tool"]["importlinter"]["contracts"] if c["type"] == "layers")
    named = {part.strip() for layer in layers for part in layer.split("|")}
    folders = {p.name for p in (ROOT / "gyroctl").iterdir() if (p / "__init__.py").is_file()}
    assert folders <= named


def test_floor_imports_nothing_from_above() -> None:
    """`import gyroctl.plant` loads numpy and numba only: no labels, settings or pictures."""
    heavy = ("xarray", "pydantic", "plotly", "matplotlib", "pandas", "casadi", "scipy.optimize", "control", "cvxpy")
    code = f"import sys, gyroctl.plant; print([m for m in {heavy!r} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
