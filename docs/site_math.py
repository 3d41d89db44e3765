"""Equations of the site as MathML, which browsers set by themselves: no script, no font, no request.

Docutils ships the translation from LaTeX; here it is given to Sphinx as one of its ways to write formulas.
"""

from __future__ import annotations

import re
from html import escape
from typing import Any

from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError

PRIMES = re.compile(r"(?P<primes>'+)(?:\^(?P<power>\w))?")
"""Marks of rates, raised in print, with a power behind them."""


def mathml(tex: str, block: bool = False) -> str:
    """Return a formula in LaTeX as MathML.

    Raises
    ------
    ExtensionError
        Where the formula is not understood: the build stops and names it.
    """
    primed = PRIMES.sub(lambda f: "^{" + r"\prime" * len(f["primes"]) + f" {f['power'] or ''}" + "}", tex)
    try:
        found = str(tex2mathml(primed, as_block=block))
    except MathError as error:
        raise ExtensionError(f"a formula is not understood: {tex!r}: {error}") from error
    return found


def inline(translator: Any, node: nodes.math) -> None:
    """Write a formula within a line."""
    translator.body.append(mathml(node.astext()))
    raise nodes.SkipNode


def display(translator: Any, node: nodes.math_block) -> None:
    """Write a formula on lines of its own, wide ones in a box that scrolls."""
    name = f' id="{escape(node["ids"][0])}"' if node.get("ids") else ""
    label = escape("Equation: " + " ".join(node.astext().split()), quote=True)
    translator.body.append(f'<div class="math-block"{name} role="region" tabindex="0" aria-label="{label}">')
    translator.body.append(mathml(node.astext(), block=True))
    translator.body.append("</div>\n")
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the writer of formulas."""
    app.add_html_math_renderer("mathml", (inline, None), (display, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
