"""Make tables and write them: markdown, JSON and a figure each."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from gyroctl.engine.cluster import connected
from gyroctl.errors import InputError, in_words
from gyroctl.provenance import made
from gyroctl.reports.wording import seed_ranges
from gyroctl.studies.evaluation import gauge, information, price, real
from gyroctl.studies.evaluation.offdesign import offdesign_table
from gyroctl.studies.evaluation.page import write_page
from gyroctl.studies.evaluation.physics import DURATION, LAWS, SEEDS, physics_table
from gyroctl.studies.evaluation.request import Request
from gyroctl.studies.evaluation.robustness import faults_table, robustness_table
from gyroctl.studies.evaluation.seas import seas_table
from gyroctl.studies.evaluation.seeds import states_in_words
from gyroctl.studies.evaluation.titles import TITLES
from gyroctl.studies.style import save
from gyroctl.writing import write_json, write_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Table = Callable[[Request], tuple[dict[str, Any], str, "Figure"]]

TABLES: dict[str, Table] = {
    "seas": seas_table,
    "offdesign": offdesign_table,
    "information": information.information_table,
    "information_real": partial(information.information_table, water=information.REALISTIC),
    "robustness": robustness_table,
    "physics": physics_table,
    "price": price.price_table,
    "faults": faults_table,
    "gauge": gauge.gauge_table,
    "real": real.real_table,
}
"""Tables by name."""

IN_SEAS = ("seas", "real")
"""Tables of which single cases, seas, may be asked for."""

ALL_OF_IT = "the whole table"
"""What failed, where no case of it could be run."""

USUAL = {
    "physics": (LAWS, SEEDS, DURATION),
    "information_real": ("nmpc", information.SEEDS, information.DURATION),
    "price": ("nmpc", price.SEEDS, price.DURATION),
    "faults": ("nmpc[plant=realistic],coupling,load_angle", ("1:8",), 400.0),
    "gauge": ("nmpc", gauge.SEEDS, gauge.DURATION),
    "real": (real.LAWS, real.SEEDS, real.DURATION),
}
"""Laws, seeds and length [s] of a table that has its own, where they are not asked for."""


def evaluate_tables(names: Sequence[str], ask: Request) -> dict[str, dict[str, Any]]:
    """Make the tables and write each as soon as it is finished.

    Parameters
    ----------
    names : sequence of str
        Of `TABLES`; all where there are none.
    ask : Request
        Laws, seeds, length, folder.

    Returns
    -------
    dict
        What the JSON files hold, by table.

    Raises
    ------
    InputError
        For an unknown table, a scheduler that does not answer, or where every table failed, the last reason. A table
        that fails among others is written as such, and the others are made.
    ConnectionError
        Where the scheduler is lost.
    """
    for name in names:
        if name not in TABLES:
            raise InputError("table", name, "there is no such table", f"Choose of {', '.join(TABLES)}")
    for name in names or TABLES:
        if ask.only and name not in IN_SEAS:
            problem, mend = f"names cases, and {name} is always whole", f"It goes with {' and '.join(IN_SEAS)}"
            raise InputError("only", ", ".join(ask.only), problem, mend)
    wanted, found, broken = list(dict.fromkeys(names or TABLES)), {}, 0
    with connected(ask.scheduler) if ask.scheduler is not None else nullcontext() as client:
        ask = replace(ask, scheduler=client)
        for name in wanted:
            try:
                found[name] = _one(name, ask)
            except ConnectionError:  # every other table would meet it
                raise
            except Exception as error:  # the other tables do not depend on it
                broken += 1
                found[name] = _not_made(name, ask, in_words(error))
                if broken == len(wanted):
                    raise
    try:
        write_page(ask.out, tuple(TITLES))
    except InputError as error:  # a file of an earlier call: what is made now stands in its own files
        ask.say(f"No page was written: {error}")
    return found


def _not_made(name: str, ask: Request, why: str) -> dict[str, Any]:
    """Write that a table could not be made, in the place of one that an earlier call may have left."""
    ask.say(f"{name} failed: {why}")
    failed = {ALL_OF_IT: why}
    head = {"table": name, "title": TITLES[name], **made()}
    content = {**head, "request": ask.record(), "failed": failed}
    write_json(ask.out / f"{name}.json", content)
    write_text(ask.out / f"{name}.md", f"# {TITLES[name]}\n\n## Not run\n\n- {ALL_OF_IT}: {why}\n")
    return content


def _one(name: str, ask: Request) -> dict[str, Any]:
    from gyroctl.studies.style import styled

    begin = time.monotonic()
    ask = ask.usually(*USUAL[name]) if name in USUAL else ask
    with styled(formulas=False):
        found, text, figure = TABLES[name](ask)
        ask.out.mkdir(parents=True, exist_ok=True)
        save(figure, ask.out / f"{name}.png")
    content = {
        "table": name,
        "title": TITLES[name],
        **made(),
        "request": ask.record(),
        **found,
        "seconds": round(time.monotonic() - begin, 1),
    }
    write_json(ask.out / f"{name}.json", content)
    write_text(ask.out / f"{name}.md", _page(name, ask, text, found.get("failed", {})))
    return content


def _page(name: str, ask: Request, text: str, failed: dict[str, str]) -> str:
    own = "".join(f"; {law}: {seed_ranges(seeds)}" for law, seeds in ask.plan.own.items())
    head = (
        f"# {TITLES[name]}\n\nRealisations {seed_ranges(ask.plan.common)}{own}. {states_in_words(ask.plan.all)}. "
        f"Runs of {ask.duration:g} s. Intervals in brackets are 95 %: bootstrap over realisations, Wilson for lock. "
        "Means are over all runs, lost ones included; ratios and differences over the realisations that both "
        "have. Power is what was generated and the "
        "change of what flywheel and float store. In step: at least 0.98 of the turns of the best constant pair on "
        "the same realisation, and cycle slips within its 95 % upper limit. Beyond 0.3 rad, given as a share of the "
        "time, the model no longer holds.\n\n"
        f"![{TITLES[name]}]({name}.png)\n\n"
    )
    tail = "".join(f"\n- {what}: {why}" for what, why in failed.items())
    return head + text + (f"\n\n## Not run\n{tail}" if failed else "") + "\n"
