"""Every command on every page runs: as it stands, or reduced as a table beside this says, with the reason.

The commands are found by `page_commands`, so that a new page cannot escape. What takes long runs with fewer seeds,
a shorter time or a smaller task; what takes hours whatever one does is checked and led to its work, which is not done.
"""

from __future__ import annotations

import importlib
import re
import shlex
import shutil
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
import typer
from command_line import SHORT, Run
from foreign_files import write_wamit
from page_commands import ROOT, Typed, all_commands, all_spans, commands, is_ours, spans
from test_device_tutorial import TASK

from gyroctl.cli.app import app

EXPERIMENT = SHORT + '\n[laws.mine]\nlaw = "{law}"\n'
RUN = "[run]\nduration = {duration}\nblend = 50\nseeds = [1]\n[laws.constant]\n"
SEA = '[sea]\nkind = "regular"\nheight = 0.2\nwp = 3.14\n' + RUN.format(duration=150)
SCATTER = "Hs [m] \\ Tp [s] \\ %,7,9\n2.5,60,40\n"


# --- what lies in the folder -------------------------------------------------------------------------------------


def laws(folder: Path) -> None:
    """The example law, and the law of the guide."""
    shutil.copy(ROOT / "docs" / "examples" / "my_law.py", folder)
    guide = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    blocks = re.findall(r"^```python\n(.*?)^```$", guide, re.MULTILINE | re.DOTALL)
    (folder / "governor.py").write_text(next(block for block in blocks if "class Governor" in block))


def experiment(folder: Path) -> None:
    """An experiment of two short runs with the example law."""
    laws(folder)
    (folder / "mine.toml").write_text(EXPERIMENT.format(law="my_law.py:MyLaw"))
    (folder / "half-study.toml").write_text('[plant]\ndevice = "half.toml"\n' + RUN.format(duration=340))


def sea(folder: Path) -> None:
    (folder / "sea.toml").write_text(SEA)


def device(folder: Path) -> None:
    """Two devices: the paper's, and the one of the tutorial."""
    from gyroctl.devices.file import new_device, write_device

    write_device(folder / "mine.toml", new_device("mine", "corrected"), ())
    scaled: dict[str, Any] = {"length_scale": 2.0, "hydrodynamics_length": 2.0, "J14": 5.8736}
    write_device(folder / "half.toml", new_device("half", "corrected", **scaled), ())


def large(folder: Path) -> None:
    """The paper's device, and the same twenty times as long."""
    from gyroctl.devices.file import new_device, scaled_device, write_device

    mine = write_device(folder / "mine.toml", new_device("mine", "corrected"), ())
    write_device(folder / "mine-x20.toml", scaled_device(mine, 20.0), ())


def scatter(folder: Path) -> None:
    shutil.copytree(ROOT / "docs" / "examples", folder / "docs" / "examples")
    for name in ("scatter.csv", "SCATTER.csv"):
        (folder / name).write_text(SCATTER)


def task(folder: Path) -> None:
    """Two small tasks: of a registered law, and of the example law with the same two places for knobs."""
    laws(folder)
    (folder / "load_angle.toml").write_text(TASK)
    knobs = "[knobs]\ncg = { start = 4e-4, width = 0.5 }\ngain = { start = 3e-4, width = 1.0 }\n"
    own = re.sub(
        r"\[knobs\]\n.*?\n\n", f"{knobs}\n", TASK.replace('"load_angle"', '"my_law.py:MyLaw"'), flags=re.DOTALL
    )
    (folder / "my_task.toml").write_text(own)


def database(folder: Path) -> None:
    from gyroctl.hydrodynamics import save, shipped

    save(shipped(), folder / "mine.nc")


def wamit(folder: Path) -> None:
    """Results of the shipped float as another solver writes them."""
    stem = write_wamit(folder)
    for ending in (".1", ".3"):
        stem.with_suffix(ending).rename(folder / f"RESULTS{ending}")


def results(folder: Path) -> None:
    """A comparison of two short runs, where the pages have results; made once, beside the folders of all tests."""
    from typer.testing import CliRunner

    made = folder.parent / "compared"
    if not made.is_dir():
        (folder.parent / "EXPERIMENT.toml").write_text(SHORT)
        words = ["compare", str(folder.parent / "EXPERIMENT.toml"), "--out", str(made), "--workers", "1"]
        assert CliRunner().invoke(app, words).exit_code == 0
    shutil.copy(folder.parent / "EXPERIMENT.toml", folder)
    for name in ("DIR", "results/north_sea"):
        shutil.copytree(made, folder / name)


READY: dict[str, Callable[[Path], None]] = {
    make.__name__: make for make in (laws, experiment, sea, device, large, scatter, task, database, wamit, results)
}

# --- what is reduced, and why ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Reduced:
    """How a command runs here.

    Parameters
    ----------
    why : str
        Why it does not run as it stands.
    more : str
        Options behind it.
    instead : str
        What is typed instead.
    work : str
        The function to which it must lead, and which is not done.
    ready : tuple of callable
        What makes the files that it names.
    """

    why: str = ""
    more: str = ""
    instead: str = ""
    work: str = ""
    ready: tuple[Callable[[Path], None], ...] = ()


def reductions() -> dict[str, Reduced]:
    """The table by the command as it stands on the page; what is not in it runs so."""
    table = tomllib.loads(Path(__file__).with_name("page_commands.toml").read_text(encoding="utf-8"))["reduced"]
    found = {each.pop("command"): each for each in table}
    assert len(found) == len(table), "a command twice"
    return {
        text: Reduced(**{**each, "ready": tuple(READY[name] for name in each.get("ready", ()))})
        for text, each in found.items()
    }


REDUCED = reductions()

OTHER = re.compile(r"^(?:python3 -m venv \.venv|git |kubectl |dask )")
"""Commands of other programs that no test runs: the environment is made by CI, clusters by tests of their own."""

OURS = list(dict.fromkeys((each.text.replace(".venv/bin/", ""), each.page) for each in all_commands() if is_ours(each)))
"""Commands of ours, each once for a page."""

TYPED = sorted({text for text, _ in OURS})


class Reached(Exception):
    """The work of a command was about to begin."""


def param(text: str) -> Any:
    quick = text in REDUCED and REDUCED[text].work
    return pytest.param(text, id=text, marks=[] if quick else pytest.mark.slow)


@pytest.mark.parametrize("text", [param(text) for text in TYPED])
def test_command_of_a_page_runs(text: str, tmp_path: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    reduced = REDUCED.get(text, Reduced())
    monkeypatch.chdir(tmp_path)
    for make in reduced.ready:
        make(tmp_path)
    words = shlex.split(reduced.instead or f"{text.removeprefix('gyroctl ')} {reduced.more}")
    if not reduced.work:
        code, said, why = run(*words)
        assert code == 0, said + why
        return

    def work(*_: object, **__: object) -> None:
        raise Reached

    module, _, name = reduced.work.rpartition(".")
    assert callable(getattr(importlib.import_module(module), name))
    monkeypatch.setattr(reduced.work, work)
    with pytest.raises(Reached):
        run(*words)


def test_every_reduction_is_of_a_command_on_a_page_and_says_why() -> None:
    assert [text for text in REDUCED if text not in TYPED] == []
    for text, reduced in REDUCED.items():
        assert reduced.why or not (reduced.more or reduced.instead or reduced.work), text
        if reduced.instead:  # the same command, with other arguments
            assert reduced.instead.split()[0] == text.split()[1], text


def test_pages_have_commands() -> None:
    assert len(TYPED) > 60
    assert {page for _, page in OURS} >= {"README.md", "docs/index.md", "docs/bound.md", "docs/stored.md"}


# --- commands within sentences -----------------------------------------------------------------------------------


def refused(words: tuple[str, ...]) -> str:
    """Why the command line would not know what is typed, or an empty text. What is left out is no fault."""
    command: Any = typer.main.get_command(app)
    rest = list(words[1:])
    while hasattr(command, "commands") and rest and not rest[0].startswith("-"):
        if rest[0] not in command.commands:
            return f"no command {rest[0]}"
        command = command.commands[rest.pop(0)]
    known = {name: option for option in command.params for name in (*option.opts, *option.secondary_opts)}
    values = 0
    for word in rest:
        if values:
            values -= 1
            continue
        if word.startswith("-") and not re.fullmatch(r"-?[\d.]+", word):
            name, given, _ = word.partition("=")
            if name not in known and name != "--help":
                return f"no option {name}"
            plain = getattr(known.get(name), "is_flag", True)
            values = 0 if plain or given else getattr(known[name], "nargs", 1)
        elif not any(option.param_type_name == "argument" for option in command.params):
            return f"takes no argument {word}"
    return ""


@pytest.mark.parametrize("typed", list({each.words: each for each in all_spans()}.values()), ids=lambda each: each.text)
def test_command_in_a_sentence_is_known(typed: Typed) -> None:
    assert refused(typed.words) == "", f"{typed.page}:{typed.line}"


def test_what_is_not_known_is_found() -> None:
    assert refused(("gyroctl", "comparison")) == "no command comparison"
    assert refused(("gyroctl", "hydro", "imprt")) == "no command imprt"
    assert refused(("gyroctl", "compare", "--quik")) == "no option --quik"
    assert refused(("gyroctl", "lockmap", "cc,cg")) == "takes no argument cc,cg"
    assert refused(("gyroctl", "margins", "--cc", "-0.052", "--no-maps")) == ""


# --- commands of other programs ----------------------------------------------------------------------------------


def unknown(typed: Typed) -> str:
    """What a command of another program names that there is not, or an empty text."""
    words = [word.rpartition("/")[2] if i == 0 else word for i, word in enumerate(typed.words)]
    named = [word for word in words[1:] if re.match(r"(?:tests|docs|benchmarks|studies)/", word)]
    missing = [word for word in named if not (ROOT / word.partition("::")[0]).exists()]
    if words[0] == "make":
        targets = re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
        missing += [word for word in words[1:] if "=" not in word and word not in targets]
    for extras in re.findall(r"(?:\.|gyroctl)\[([\w,]+)\]", typed.text):
        have = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
        missing += [extra for extra in extras.split(",") if extra not in have]
    if words[0].startswith("python") and words[1:2] == ["-m"] and words[2].startswith("gyroctl"):
        missing += [] if importlib.util.find_spec(words[2]) else [words[2]]
    return " ".join(missing)


def test_commands_of_other_programs_name_what_exists() -> None:
    others = [each for each in all_commands() if not is_ours(each) and not OTHER.match(each.text)]
    assert len(others) > 6
    assert {each.text: unknown(each) for each in others if unknown(each)} == {}


def test_what_does_not_exist_is_found() -> None:
    for line, what in (
        ("pytest tests/test_nothing.py", "tests/test_nothing.py"),
        ("make nothing", "nothing"),
        ('pip install "gyroctl[nothing]"', "nothing"),
        ("python -m gyroctl.nothing", "gyroctl.nothing"),
    ):
        assert unknown(commands(f"```sh\n{line}\n```")[0]) == what


# --- the parser --------------------------------------------------------------------------------------------------

PAGE = """# A page

Text with `gyroctl laws` and `gyroctl tune a, gyroctl tune b`.

~~~bash
$ gyroctl compare one.toml \\
    --workers 2   # two of them
export A=1
cd x && gyroctl laws; gyroctl status DIR &
~~~

    gyroctl bound "--law" "nmpc a=b"     # indented
    plain text

1. An item

    gyroctl within an item is text

```python
gyroctl = 3
```

| `gyroctl report DIR` | again |
"""


def test_parser_finds_what_is_typed_and_nothing_else() -> None:
    found = [(each.line, each.text) for each in commands(PAGE)]
    assert found == [(6, "gyroctl compare one.toml --workers 2"), (12, "gyroctl bound --law 'nmpc a=b'")]
    told = ["gyroctl laws", "gyroctl tune a", "gyroctl tune b", "gyroctl report DIR"]
    assert [each.text for each in spans(PAGE)] == told
