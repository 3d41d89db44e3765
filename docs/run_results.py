"""Make the results that the pages show: each by one command of the project, kept as docs/results/NAME.json.

``python docs/run_results.py NAME ...`` runs the commands and keeps what they wrote; ``--short`` runs the short form of
each, on seeds that are spent, to try the way from the command to the page; ``--keep`` keeps what was run before;
``--list`` prints the table of docs/results/README.md. Finished runs are stored, so that what was stopped goes on.
Afterwards ``python docs/write_results.py`` writes the pages.
"""

from __future__ import annotations

import argparse
import json
import shlex
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from kept_results import kept, write_kept

ROOT = Path(__file__).resolve().parents[1]
WORK = Path("results") / "docs"
"""Folder of the reports, from the root of the checkout."""


class Run(NamedTuple):
    """How a result is made."""

    command: str  # as it is typed, without where it writes
    short: str  # what to put in its place to try things out; empty where the command is quick itself
    report: str  # file that it writes
    takes: str  # on two cores


PLANNER = '--seeds nmpc=1:8 --seeds "nmpc[information=oracle]=1:8"'
BOUND = (
    'gyroctl bound --gamma {0} --seeds 1-8 --law "nmpc information=oracle" --law nmpc --law coupling --law load_angle'
)
QUICK = "gyroctl bound --gamma {0} --seeds 1 --duration 30 --quick --law coupling --law load_angle"
REAL = (
    "gyroctl bound --variant realistic --gamma 5 --seeds {0} --duration 100{1} "
    '--law "nmpc information=oracle plant=realistic"'
)
OWN_SET = ' --law "nmpc information=oracle tuning=gamma50" --law "nmpc tuning=gamma50"'
SIMPLE = "coupling,load_angle,scheduled_lqr,scheduled_lmi,tracking,stabiliser,threshold"
POINT = "gyroctl margins --cg 3.5e-4 --height 0.2 --wp 3.14 --no-maps"

RUNS = {
    "seas": Run(
        'gyroctl evaluate seas --seeds 2001:2064 --seeds "@gamma 5=1001:1400" --seeds nmpc=1:16 '
        '--seeds "nmpc[information=oracle]=1:8"',
        f"gyroctl evaluate seas --laws {SIMPLE} --seeds 1:8",
        "seas.json",
        "3 h",
    ),
    "offdesign": Run(
        "gyroctl evaluate offdesign --seeds 1:64 --seeds nmpc=1:8",
        "gyroctl evaluate offdesign --laws coupling,load_angle --seeds 1:4 --duration 300 --budget 3e6",
        "offdesign.json",
        "12 min",
    ),
    "robustness": Run(
        "gyroctl evaluate robustness --seeds 1:64 --seeds nmpc=1:8",
        f"gyroctl evaluate robustness --laws {SIMPLE} --seeds 1:4 --duration 500",
        "robustness.json",
        "2 h",
    ),
    "faults": Run(
        'gyroctl evaluate faults --laws "nmpc[plant=realistic]" --seeds 4793:4800 --seeds "@friction 0.45=4793:4856"',
        "gyroctl evaluate faults --laws coupling,load_angle --seeds 1:2 --duration 300",
        "faults.json",
        "30 min",
    ),
    "faults_coupling": Run(
        'gyroctl evaluate faults --laws "coupling[tuning=real]" --seeds 3465:3472 --seeds "@friction 0.45=3465:3528"',
        "gyroctl evaluate faults --laws coupling --seeds 1:2 --duration 300",
        "faults.json",
        "1 h",
    ),
    "information": Run(
        "gyroctl evaluate information --seeds 1:8",
        "gyroctl evaluate information --seeds 1:2 --duration 300",
        "information.json",
        "1 h",
    ),
    "information_real": Run(
        "gyroctl evaluate information_real --seeds 3529:3536",
        "gyroctl evaluate information_real --seeds 100000:100001 --duration 260 --allow-tuning-seeds",
        "information_real.json",
        "not measured",
    ),
    "physics": Run(
        "gyroctl evaluate physics",
        "gyroctl evaluate physics --laws coupling,load_angle --seeds 1:4 --duration 300",
        "physics.json",
        "55 min",
    ),
    "price": Run(
        "gyroctl evaluate price --seeds 1:8",
        "gyroctl evaluate price --seeds 100000:100001 --duration 260 --allow-tuning-seeds",
        "price.json",
        "8 min",
    ),
    "gauge": Run(
        "gyroctl evaluate gauge --seeds 4785:4792",
        "gyroctl evaluate gauge --seeds 100000:100001 --duration 260 --allow-tuning-seeds",
        "gauge.json",
        "25 min",
    ),
    "real": Run(
        'gyroctl evaluate real --seeds 3401:3416 --seeds "@gamma 5=3001:3016" '
        "--seeds nmpc=3401:3464 --seeds coupling=3401:3464 "
        '--seeds "nmpc@gamma 5=3001:3400" --seeds "coupling@gamma 5=3001:3400"',
        "gyroctl evaluate real --laws nmpc,coupling,load_angle --seeds 100000:100001 --duration 260 "
        "--allow-tuning-seeds",
        "real.json",
        "2 h",
    ),
    "real_coupling": Run(
        'gyroctl evaluate real --laws coupling --seeds 3953:4016 --seeds "@gamma 5=3553:3952"',
        "gyroctl evaluate real --laws coupling --seeds 100000:100001 --duration 260 --allow-tuning-seeds",
        "real.json",
        "40 min",
    ),
    "real_nmpc": Run(
        'gyroctl evaluate real --laws nmpc --seeds 4721:4784 --seeds "@gamma 5=4321:4720"',
        "gyroctl evaluate real --laws nmpc --seeds 100000:100001 --duration 260 --allow-tuning-seeds",
        "real.json",
        "110 min",
    ),
    "real_lmi": Run(
        'gyroctl evaluate real --laws scheduled_lmi --seeds 4033:4048 --seeds "@gamma 5=4049:4064"',
        "gyroctl evaluate real --laws scheduled_lmi --seeds 100000:100001 --duration 260 --allow-tuning-seeds",
        "real.json",
        "15 min",
    ),
    "bound_gamma1": Run(BOUND.format(1), QUICK.format(1), "bound.json", "30 min"),
    "bound_gamma5": Run(BOUND.format(5), QUICK.format(5), "bound.json", "30 min"),
    "bound_gamma50": Run(BOUND.format(50) + OWN_SET, QUICK.format(50), "bound.json", "35 min"),
    "bound_realistic": Run(
        REAL.format("3549-3552", ""), REAL.format("100001,100000", " --quick"), "bound.json", "45 min"
    ),
    "margins": Run(f"{POINT} --cc 0.052 --law load_angle", "", "margins.json", "30 s"),
    "margins_loose": Run(f"{POINT} --cc 0.02", "", "margins.json", "10 s"),
    "margins_water": Run(f"{POINT} --cc 0.052 --water", "", "margins.json", "2 min"),
    "statements": Run("gyroctl reproduce statements", "", "statements.json", "3 min"),
    "hydro": Run("gyroctl hydro check", "", "hydro.json", "5 s"),
    "startup": Run("python -m gyroctl.studies.startup --seeds 1:101", "", "startup.json", "3 min"),
    "connection": Run(
        "python -m gyroctl.studies.connection --seeds 1:65 --budget 2e6",
        "python -m gyroctl.studies.connection --seeds 1:9 --gammas 5 --heights 0.283 --duration 600 --budget 1e6",
        "connection.json",
        "2 min",
    ),
    "forecast": Run(
        "python -m gyroctl.studies.forecast --seeds 4065:4081",
        "python -m gyroctl.studies.forecast --seeds 100000:100002 --duration 260",
        "forecast.json",
        "10 min",
    ),
}
"""The results by name. Seeds of `seas` and `real` are in reserve until the run; a commit after it tells the ledger."""


def typed(name: str, short: bool) -> tuple[list[str], Path]:
    """Words of the command of a result, and the report that it writes, from the root."""
    run, out = RUNS[name], WORK / name
    words = shlex.split(run.short if short and run.short else run.command)
    out = out / run.report if name == "hydro" else out
    return [*words, "--out", out.as_posix()], WORK / name / run.report


def made(name: str, short: bool) -> None:
    """Run the command of a result, from the root of the checkout."""
    words, report = typed(name, short)
    (ROOT / report).parent.mkdir(parents=True, exist_ok=True)
    print(shlex.join(words), file=sys.stderr)
    module = words[2:] if words[0] == "python" else ["gyroctl", *words[1:]]
    subprocess.run([sys.executable, "-m", *module], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)


def keep(name: str) -> Path:
    """Keep of the report of a result what the pages show."""
    report = json.loads((ROOT / WORK / name / RUNS[name].report).read_text(encoding="utf-8"))
    return write_kept(name, kept(name, report))


def main(arguments: Sequence[str] | None = None) -> None:
    """Read the arguments; run and keep."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(RUNS)}; all without any")
    parser.add_argument("--short", action="store_true", help="the short form of each, to try things out")
    parser.add_argument("--keep", action="store_true", help="run nothing, keep what was run before")
    parser.add_argument("--list", action="store_true", help="print the commands and how long they take")
    given = parser.parse_args(arguments)
    unknown = [name for name in given.names if name not in RUNS]
    if unknown:
        parser.error(f"there is no result {unknown[0]}: choose of {', '.join(RUNS)}")
    for name in given.names or RUNS:
        if given.list:
            print(f"{name} ({RUNS[name].takes}): {shlex.join(typed(name, given.short)[0])}")
            continue
        if not given.keep:
            made(name, given.short)
        print(f"kept in {keep(name).relative_to(ROOT)}")


if __name__ == "__main__":
    main()
