"""The pages in a real browser without a network, at a desk and on a telephone, light and dark."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from test_reports_pages import evaluation_in, margins_in
from test_reports_synthetic import CHARACTERS, save, synthetic
from test_site_page import site_in
from typer.testing import CliRunner

from gyroctl.cli.app import app

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
BROWSER = next(filter(None, map(shutil.which, NAMES)), None)
SIZES = {"desk": (1280, 900), "telephone": (390, 844)}

OVERLAPS = Path(__file__).with_name("overlaps.js").read_text(encoding="utf-8")
"""Function that returns the pairs of texts that lie on one another, by their boxes as far as they can be seen."""

CONTRAST = Path(__file__).with_name("contrast.js").read_text(encoding="utf-8")
"""Function that returns the number of texts within pictures, and those that are too faint for what they stand on."""

CUT = """() => [...document.querySelectorAll("svg.drawn text")].filter((text) => {
  const [a, b] = [text, text.closest("svg")].map((one) => one.getBoundingClientRect());
  const out = [b.left - a.left, a.right - b.right, b.top - a.top, a.bottom - b.bottom];
  return text.checkVisibility() && Math.max(...out) > 1;
}).map((text) => text.textContent)"""
"""Function that returns the texts that reach out of their picture."""

DECIDE = """async () => {
  const usual = {  // those of axe, which are replaced as a whole
    ignoreUnicode: false, ignorePseudo: false, pseudoSizeThreshold: 0.25, shadowOutlineEmMax: 0.2,
    boldValue: 700, boldTextPt: 14, largeTextPt: 18, textStrokeEmMin: 0.03,
    contrastRatio: { normal: { expected: 4.5 }, large: { expected: 3 } },
  };
  axe.configure({ checks: [{ id: "color-contrast", options: { ...usual, ignoreLength: true } }] });  // "0" is a text
  const unfolded = document.createElement("style");
  unfolded.textContent = ".scroll { overflow: visible !important } .top, nav, main { max-width: none !important }";
  document.head.append(unfolded);
  document.querySelectorAll("details").forEach((part) => (part.open = true));
  const found = await axe.run({ exclude: ["svg.drawn"] }, { runOnly: ["color-contrast"] });
  if (found.passes.length !== 1) throw new Error("contrast was not looked at");
  return [...found.violations, ...found.incomplete].flatMap((one) => one.nodes.map((node) => node.html.slice(0, 120)));
}"""
"""Function that returns the texts of a page whose contrast is too low or could not be told.

Of what is scrolled out of sight it cannot be: it is called in a window as wide as the widest table. Within a picture it
cannot be either: `CONTRAST` decides there.
"""

needs_a_browser = pytest.mark.skipif(BROWSER is None, reason="no chromium or chrome on this machine")
pytestmark = [needs_a_browser, pytest.mark.slow]


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """Folder with a page of each kind, all from `gyroctl report`."""
    folder = tmp_path_factory.mktemp("pages")
    save(synthetic(tuple(CHARACTERS)), folder / "results.nc")
    margins_in(folder / "m")
    evaluation_in(folder / "e")
    site_in(folder / "s")
    for part in (".", "m", "e", "s"):
        assert CliRunner().invoke(app, ["report", str(folder / part)]).exit_code == 0
    return {
        "comparison": folder / "report.html",
        "margins": folder / "m" / "margins.html",
        "evaluation": folder / "e" / "evaluation.html",
        "site": folder / "s" / "site.html",
    }


@pytest.fixture(scope="module")
def browser():
    sync_api = pytest.importorskip("playwright.sync_api")
    with sync_api.sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=BROWSER, args=["--no-sandbox"])
        yield started
        started.close()


def opened(browser, page, size, scheme):
    """Page as it is opened from a file, with all that the console said and all that was asked for."""
    width, height = SIZES[size]
    tab = browser.new_page(viewport={"width": width, "height": height}, color_scheme=scheme)
    said, asked = [], []
    tab.on("console", lambda message: said.append(f"{message.type}: {message.text}"))
    tab.on("pageerror", lambda error: said.append(str(error)))
    tab.on("request", lambda request: asked.append(request.url))
    tab.goto(page.as_uri())
    return tab, said, asked


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("size", list(SIZES))
@pytest.mark.parametrize("kind", ["comparison", "margins", "evaluation", "site"])
def test_page_is_readable(browser, pages, kind, size, scheme):
    import axe_playwright_python

    tab, said, fetched = opened(browser, pages[kind], size, scheme)
    assert tab.evaluate(OVERLAPS) == []
    assert tab.evaluate(CUT) == []
    assert tab.evaluate("document.documentElement.scrollWidth <= innerWidth"), "the page scrolls sideways"
    for figure in tab.query_selector_all("figure"):
        seen = [part for part in figure.query_selector_all("svg, img") if part.is_visible()]
        assert len(seen) == 1, "a figure is drawn once"
        box = seen[0].bounding_box()
        assert box["width"] > 100.0 and box["height"] > 100.0
    tab.evaluate(Path(axe_playwright_python.__file__).with_name("axe.min.js").read_text(encoding="utf-8"))
    found = tab.evaluate("axe.run()")
    assert len(found["passes"]) > 10
    assert [(one["id"], one["nodes"][0]["html"]) for one in found["violations"]] == []
    tab.set_viewport_size({"width": 3600, "height": 900})
    assert tab.evaluate(DECIDE) == []
    tab.set_viewport_size({"width": SIZES[size][0], "height": SIZES[size][1]})
    texts, faint = tab.evaluate(CONTRAST)
    assert faint == [] and (texts > 100) == (kind == "comparison")
    tab.keyboard.press("Tab")
    assert tab.evaluate("document.activeElement.getAttribute('href')") == "#content"
    tab.keyboard.press("Enter")
    assert tab.evaluate("document.activeElement.id") == "content"
    assert said == []
    assert [url for url in fetched if not url.startswith(("file:", "data:"))] == []
    tab.close()


@pytest.mark.parametrize("size", list(SIZES))
def test_closer_look_draws_all_laws_and_the_whole_run(browser, pages, size):
    tab, said, fetched = opened(browser, pages["comparison"], size, "light")
    tab.click("#closer")
    tab.wait_for_selector(".choice input", timeout=120_000)
    assert tab.locator(".choice input").count() == len(CHARACTERS)
    for box in tab.query_selector_all(".choice input"):
        box.check()
    drawn = "document.querySelectorAll('#drawn-closer .scatterlayer .trace').length"
    assert tab.evaluate(drawn) == 1 + 7 * len(CHARACTERS)
    tab.click("text=whole run")
    first, last = tab.evaluate("document.getElementById('drawn-closer').layout.xaxis.range")
    assert (first, last) == (0, pytest.approx(600.0))
    assert tab.evaluate(OVERLAPS) == []
    assert said == []
    assert [url for url in fetched if not url.startswith(("file:", "data:", "blob:"))] == []
    tab.close()


def test_print_shows_the_provenance_and_cuts_nothing(browser, pages):
    tab, _, _ = opened(browser, pages["comparison"], "desk", "dark")
    tab.emulate_media(media="print", color_scheme="dark")
    tab.set_viewport_size({"width": 718, "height": 1000})  # what A4 leaves between its margins
    tab.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert tab.locator("#provenance").is_visible() and tab.get_by_text("Parameters of the laws").is_visible()
    wide = "[...document.querySelectorAll('.scroll, svg, table')]"
    cut = "filter(one => one.getBoundingClientRect().right > innerWidth + 1)"
    assert tab.evaluate(f"{wide}.{cut}.map(one => one.outerHTML.slice(0, 80))") == []
    tab.close()
