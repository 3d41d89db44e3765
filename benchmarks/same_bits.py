"""Hashes of a fixed experiment, to show that a move changed no bit: run it before and after, and compare.

    python benchmarks/same_bits.py --out before.json             # in the one checkout
    python benchmarks/same_bits.py --out after.json --against before.json    # in the other

It uses the command line and the public names alone, so that the same file serves checkouts whose rooms differ. What a
clock measured is left out; everything else counts, to the last bit.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

EXPERIMENT = """
[sea]
gamma = 5.0
[run]
duration = 300.0
seeds = [1, 2, 3, 4, 5]
"""
CLOCKED = ("step_ms_median", "step_ms_p99", "deadline_misses")
CARD = (
    *("traction_p99", "traction_p999", "traction_over_03", "traction_over_06", "reversals", "beyond_validity"),
    *("coupling_torque_max", "slip_max", "coupling_loss_max", "kx_max"),
    *("immersion_max", "immersion_min", "dry_share", "submerged_share"),
)
"""What is said of a run beside its metrics: left out, so that checkouts without it compare."""
TASK = """
law = "load_angle"
[knobs]
share = { start = 0.4328, width = 0.2, scale = "linear", least = 0.0 }
damping = { start = 0.8, width = 0.4 }
cc = { start = 0.0675, width = 0.2 }
[search]
population = 5
window = 300.0
runs = 2
confirm = 400.0
[seeds]
count = 4
"""
BUDGET = 1.5e4  # s: four generations of five points, and what confirming takes


def digest(value: object) -> str:
    """SHA-256 of an array, or of a value as JSON."""
    raw = value.tobytes() if isinstance(value, np.ndarray) else json.dumps(value, sort_keys=True).encode()
    return hashlib.sha256(raw).hexdigest()[:16]


def gyroctl(*arguments: str, folder: Path) -> None:
    """Run the command line."""
    subprocess.run([sys.executable, "-m", "gyroctl", *arguments], check=True, cwd=folder, stdout=subprocess.DEVNULL)


def comparison(folder: Path) -> dict[str, str]:
    """All laws on three seeds: every variable of each law."""
    import xarray as xr

    (folder / "experiment.toml").write_text(EXPERIMENT)
    gyroctl("compare", "experiment.toml", "--out", "compared", folder=folder)
    found = {}
    with xr.open_dataset(folder / "compared" / "results.nc", engine="h5netcdf") as ds:
        for law in ds.law.values:
            for name in sorted(set(ds.data_vars) - {*CLOCKED, *CARD}):
                if "law" in ds[name].dims and ds[name].dtype.kind in "fiub":
                    values = np.ascontiguousarray(ds[name].sel(law=law).values)
                    found.setdefault(str(law), []).append((name, digest(values)))
        found = {law: digest(rows) for law, rows in found.items()}
        found["waves"] = digest([str(value) for value in np.ravel(ds.sha256.values)])
    return found


def orbit() -> dict[str, str]:
    """One locked orbit with its multipliers and modes."""
    import gyroctl as gy

    found = gy.lock_orbit(gy.zhang2017(), gy.Regular(height=0.2, wp=3.14), cc=0.052, cg=3.5e-4)
    return {"state": digest(found.x), "multipliers": digest(found.multipliers), "states": digest(found.states(8))}


def margins(folder: Path) -> dict[str, str]:
    """Numbers of a margin report."""
    gyroctl("margins", "--no-maps", "--samples", "32", "--out", "margins", folder=folder)
    found = json.loads((folder / "margins" / "margins.json").read_text())
    return {"numbers": digest({key: value for key, value in found.items() if key not in ("seconds", "commit")})}


def tuning(folder: Path) -> dict[str, str]:
    """What a short tuning finds."""
    (folder / "load_angle.toml").write_text(TASK)
    gyroctl("tune", "load_angle.toml", "--for", "gamma5", "--budget", str(BUDGET), "--out", "tuned", folder=folder)
    sets = json.loads((folder / "tuned" / "load_angle.json").read_text())["sets"]
    return {name: digest([entry["parameters"], entry["result"]]) for name, entry in sets.items()}


def main() -> None:
    """Print hashes as JSON; with `--against`, what differs."""
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("--out", type=Path)
    asked.add_argument("--against", type=Path)
    options = asked.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        found = {"orbit": orbit(), "margins": margins(folder), "tuning": tuning(folder), "laws": comparison(folder)}
    found["all"] = {"hash": digest(found)}
    print(json.dumps(found, indent=1))
    if options.out:
        options.out.write_text(json.dumps(found, indent=1) + "\n")
    if options.against:
        before = json.loads(options.against.read_text())
        parts = [(part, key) for part in found for key in {**before.get(part, {}), **found[part]}]
        differ = [f"{p}.{k}" for p, k in parts if before.get(p, {}).get(k) != found[p].get(k)]
        print("equal" if not differ else f"differ: {', '.join(differ)}")
        sys.exit(bool(differ))


if __name__ == "__main__":
    main()
