"""What the page of the equations says, computed from its text, is what the code does."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gyroctl as gy

PAGE = (Path(__file__).parents[1] / "docs" / "equations.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^\$\$\n(.*?)^\$\$$", PAGE, re.MULTILINE | re.DOTALL)

WORDS = {
    r"\cos": "cos",
    r"\sin": "sin",
    r"\varphi": "phi",
    r"\psi": "psi",
    r"\omega": "omega",
    r"\left": "",
    r"\right": "",
}
CC, CG = 0.07, 6e-4


def python_of(tex: str) -> str:
    """A formula of the page as Python: factors stand apart by a thin space, rates are primes."""
    text = re.sub(r"\\begin\{aligned\}|\\end\{aligned\}|&", "", tex)
    text = re.sub(r"\\(cos|sin)\^2\\psi", r"\1(psi)**2", text)
    text = re.sub(r"\\(cos|sin)\\psi", r"\1(psi)", text)
    for word, plain in WORDS.items():
        text = text.replace(word, plain)
    text = re.sub(r"_\{?(\w+)\}?", r"\1", text)
    text = re.sub(r"(\w)('+)", lambda m: m[1] + "_" + len(m[2]) * "d", text)
    return " ".join(text.replace(r"\,", "*").split())


def equations(block: str) -> list[tuple[str, str]]:
    """Both sides of each equation of a block; a row that begins with a space goes on with the one above."""
    whole = re.sub(r"\\\\\s*&\s*\\q?quad", " ", block).replace(r"\qquad", "").replace(r"\quad", "")
    sides = [python_of(line).split("=") for line in re.split(r"\\\\", whole)]
    return [(left.strip(), right.strip()) for left, right in sides]


def values(plant: gy.Plant, x: np.ndarray, waves: tuple[float, float]) -> dict[str, Any]:
    """Every symbol of the page in a state of the plant."""
    p, dx = plant.parameters, plant.derivative(x, (CC, CG), waves)
    n = len(plant.radiation[0].q)
    moments = [float(np.dot(f.p[::-1], x[8 + k * n : 8 + k * n + len(f.p)])) for k, f in enumerate(plant.radiation)]
    known = {name: getattr(p, name) for name in ("N", "K", "J2", "J3", "J4", "Jh1", "Jh3", "k1", "k3", "d1", "d3")}
    for i, name in enumerate(("phi1", "phi3", "psi", "omega")):
        known |= {name: x[i], f"{name}_d": x[4 + i], f"{name}_dd": dx[4 + i]}
    known |= {"J1": p.J1, "C2": p.lever_inertia, "cc": CC, "cg": CG, "Mr1": moments[0], "Mr3": moments[1]}
    return {**known, "Me1": waves[0], "Me3": waves[1], "cos": math.cos, "sin": math.sin}


def known_of(plant: gy.Plant, seed: int) -> dict[str, Any]:
    rng = np.random.default_rng(seed)
    x = rng.normal(0.0, 0.2, len(plant.labels)) * np.array(
        [1, 1, 10, 10, 1, 1, 15, 300, *[1] * (len(plant.labels) - 8)]
    )
    known = values(plant, x, tuple(rng.normal(0.0, 100.0, 2)))
    known["J1"] = plant.parameters.J1
    (u1, u3), (torque,) = equations(BLOCKS[0]), equations(BLOCKS[1])
    for name, formula in (u1, u3, torque):
        known[name] = eval(formula, {}, known)
    return known


@pytest.mark.parametrize("line", range(4), ids=["22", "23", "24", "25"])
def test_line_of_the_page_is_that_of_the_code(device: gy.Plant, line: int) -> None:
    left, right = [*equations(BLOCKS[2]), *equations(BLOCKS[3])][line]
    for seed in range(20):
        known = known_of(device, seed)
        assert eval(left, {}, known) == pytest.approx(eval(right, {}, known), rel=1e-9, abs=1e-9)


def test_a_wrong_sign_on_the_page_is_seen(device: gy.Plant) -> None:
    left, right = equations(BLOCKS[3])[0]
    assert "- (K" in right
    known = known_of(device, 1)
    assert eval(left, {}, known) != pytest.approx(eval(right.replace("- (K", "+ (K"), {}, known), rel=1e-3)


def test_every_formula_of_the_pages_can_be_set() -> None:
    site_math = pytest.importorskip("site_math", reason="needs the extra docs")
    for page in sorted((Path(__file__).parents[1] / "docs").glob("*.md")):
        text = page.read_text(encoding="utf-8")
        for tex in re.findall(r"^\$\$\n(.*?)^\$\$$", text, re.MULTILINE | re.DOTALL):
            assert site_math.mathml(tex, block=True).startswith("<math")


def test_a_formula_that_is_none_stops_the_build() -> None:
    site_math = pytest.importorskip("site_math", reason="needs the extra docs")
    with pytest.raises(Exception, match="not understood"):
        site_math.mathml(r"\nothing{x}")
    assert "&prime;" not in site_math.mathml("x") and "′" in site_math.mathml(r"\varphi_1''")
