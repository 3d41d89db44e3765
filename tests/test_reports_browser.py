"""The report in a real browser without a network: are the figures drawn, and does nothing ask for the outside?"""

from __future__ import annotations

import os
import re
import shutil
import subprocess

import pytest
from test_reports_synthetic import synthetic

from gyroctl.reports import write_report

BROWSER = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable"))), None
)


def rendered(path, profile, *options: str) -> tuple[str, str]:
    """DOM after the scripts have run, and what the browser logged."""
    command = [BROWSER, "--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking"]
    command += [
        f"--user-data-dir={profile}",
        "--host-resolver-rules=MAP * ~NOTFOUND",
        "--enable-logging=stderr",
        "--v=0",
    ]
    command += ["--virtual-time-budget=30000", *options, "--dump-dom", path.as_uri()]
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=120, check=True, env={**os.environ, "LANG": "C.UTF-8"}
    )
    return done.stdout, done.stderr


@pytest.mark.skipif(BROWSER is None, reason="no chromium or chrome on this machine")
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_figures_are_drawn_without_a_network(tmp_path, scheme):
    page = write_report(synthetic(), tmp_path / "report.html")
    options = ["--blink-settings=preferredColorScheme=0"] if scheme == "dark" else []
    dom, log = rendered(page, tmp_path / "profile", *options)
    figures = re.findall(r'data-figure="(\w+)"', dom)
    assert sorted(figures) == ["differences", "energy", "motion", "pareto", "power", "series", "survival"]
    pieces = re.split(r'data-figure="', dom)[1:]
    for name, piece in zip(figures, pieces, strict=True):
        assert 'class="main-svg"' in piece, f"{name} was not drawn"
        assert re.search(r'class="(trace|bars|points|js-line|point)', piece), f"{name} is empty"
    assert "Content Security Policy" not in log
    assert "Uncaught" not in log
    visible = re.sub(r"<script.*?</script>", "", dom, flags=re.S)
    assert not re.search(r"""(?:src|href)\s*=\s*["']?(?:https?:)?//""", visible)
