"""Synthetic comparisons for the tests of the reports: random but plausible, fixed seed, with the edge cases."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
import xarray as xr

from gyroctl.errors import InputError
from gyroctl.reports import check_layout


class Character(NamedTuple):
    """What a made-up law is like on average."""

    information: str
    power: float
    cv: float
    lock: float
    slips: float
    phi1: float


CHARACTERS = {
    "best_constant": Character("none", 1.95, 0.31, 0.95, 0.4, 0.24),
    "constant": Character("none", 1.70, 0.28, 0.95, 0.3, 0.23),
    "load_angle": Character("sensors", 4.40, 1.25, 0.999, 0.2, 0.31),
    "coupling": Character("sensors", 3.10, 0.34, 0.97, 0.6, 0.29),
    "nmpc": Character("forecast", 7.60, 0.55, 0.9, 4.0, 0.38),
    "preview": Character("oracle", 13.2, 0.18, 0.999, 0.1, 0.33),
}
FOUR = ("best_constant", "constant", "load_angle", "coupling")


def synthetic(
    laws: tuple[str, ...] = FOUR,
    realisations: int = 8,
    duration: float = 600.0,
    *,
    lock: float | None = None,
    examples: bool = True,
    tuning_seeds: tuple[int, ...] = tuple(range(1000, 1008)),
    seed: int = 7,
) -> xr.Dataset:
    """Comparison in the layout of results.nc; `lock` overrides the probability of lock of every law."""
    rng = np.random.default_rng(seed)
    shape = (len(laws), realisations)
    sea = rng.normal(size=realisations)  # what the laws share: some realisations are richer than others

    def column(name: str) -> np.ndarray:
        return np.array([getattr(CHARACTERS[law], name) for law in laws], dtype=float)[:, None]

    locked = rng.uniform(size=shape) < (column("lock") if lock is None else lock)
    loss = np.where(locked, np.nan, rng.uniform(0.2, 0.95, size=shape) * duration)
    share = np.where(locked, 1.0, loss / duration)
    power = column("power") * (1.0 + 0.06 * sea + 0.03 * rng.normal(size=shape)) * share
    wave = (16.7 + 0.8 * sea) * np.ones(shape)
    slip, hinge = 0.12 * power + 0.05, 0.35 + 0.15 * rng.uniform(size=shape)
    stored = 0.02 * rng.normal(size=shape)
    variables = {
        "mean_power": power,
        "power_cv": column("cv") * (1.0 + 0.08 * rng.normal(size=shape)) / share,
        "p98_over_mean": 1.0 + 2.4 * column("cv") * (1.0 + 0.05 * rng.normal(size=shape)),
        "power_cv_1s": 0.7 * column("cv") * np.ones(shape),
        "locked": locked,
        "loss_time": loss,
        "cycle_slips": rng.poisson(column("slips") * 3.0, size=shape) / 3.0,
        "phi1_p98": column("phi1") * (1.0 + 0.08 * rng.normal(size=shape)),
        "phi3_p98": 0.19 + 0.01 * power + 0.01 * rng.normal(size=shape),
        "wave_input_w": wave,
        "radiated_w": wave - power - slip - hinge - stored,
        "hinge_w": hinge,
        "slip_loss_w": slip,
        "stored_w": stored,
        "ledger_residual": 1e-8 * rng.normal(size=shape),
        "capture_width_ratio": power / 22.0,
        "saturations": rng.poisson(3.0, size=shape).astype(float),
        "step_ms_median": np.full(shape, 2e-4),
        "step_ms_p99": np.full(shape, 6e-4),
        "deadline_misses": np.zeros(shape),
        "fallbacks": np.zeros(shape),
        "outside_model": column("phi1") * (1.0 + 0.08 * rng.normal(size=shape)) > 0.3,
    }
    seeds = np.arange(1, realisations + 1)
    digests = [hashlib.sha256(f"realisation {s}".encode()).hexdigest() for s in seeds]
    ds = xr.Dataset(
        {name: (("law", "realisation"), values) for name, values in variables.items()},
        coords={
            "law": list(laws),
            "realisation": seeds,
            "sha256": ("realisation", digests),
            "information": ("law", [CHARACTERS[law].information for law in laws]),
            "label": ("law", [law.replace("_", " ") for law in laws]),
        },
        attrs={
            "experiment": json.dumps(
                {
                    "sea": {"hs": 0.283, "wp": 3.14, "gamma": 5.0, "heading": 0.0},
                    "run": {"duration": duration, "dt": 0.01, "blend": 100.0},
                }
            ),
            "gyroctl_version": "0.1.0",
            "created": "2026-03-02T09:30:00+00:00",
            "tuning_seeds": json.dumps(list(tuning_seeds)),
            "parameters": json.dumps({law: {"cc": 0.052, "cg": 3.5e-4} for law in laws}),
            "command": "gyroctl compare --out results",
        },
    )
    return ds.merge(_examples(laws, duration, rng)) if examples else ds


def save(ds: xr.Dataset, path: Path) -> None:
    """Write NetCDF classic, which needs no library beyond SciPy."""
    ds.to_netcdf(path, engine="scipy", format="NETCDF3_64BIT")


def _examples(laws: tuple[str, ...], duration: float, rng: np.random.Generator) -> xr.Dataset:
    time = np.arange(0.0, duration + 0.05, 0.1)
    phases = rng.uniform(0.0, 2.0 * np.pi, 60)
    omega = rng.normal(3.14, 0.25, 60)
    eta = sum(0.011 * np.cos(w * time + p) for w, p in zip(omega, phases, strict=True))
    envelope = np.convolve(np.abs(eta), np.ones(60) / 60, mode="same") / 0.05
    series: dict[str, list[np.ndarray]] = {
        name: [] for name in ("power", "ring_speed", "phi1", "phi3", "cc", "cg", "load_share")
    }
    for law in laws:
        power, cv = CHARACTERS[law].power, CHARACTERS[law].cv
        series["power"].append(
            np.maximum(power * (1.0 + cv * (0.6 * (envelope - 1.0) + np.cos(2 * 3.14 * time + power))), 0.0)
        )
        series["ring_speed"].append(3.14 + 0.15 * np.cos(1.2 * time + power) + 0.25 * np.sin(6.28 * time))
        series["phi1"].append(
            CHARACTERS[law].phi1 * 0.6 * envelope * np.cos(3.14 * time + 0.3) + 0.04 * np.cos(1.23 * time)
        )
        series["phi3"].append(0.16 * envelope * np.cos(3.14 * time - 1.1))
        series["cc"].append(
            np.where(np.cos(6.28 * time + power) > 0.2, 0.3, 0.0) if law == "coupling" else np.full(time.size, 0.052)
        )
        series["cg"].append(power / 4900.0 * (1.0 + (cv if law == "load_angle" else 0.05) * np.cos(6.28 * time)))
        series["load_share"].append(0.55 + 0.2 * (envelope - 1.0) + 0.02 * rng.standard_t(1.5, size=time.size))
    data = {f"example_{name}": (("law", "time"), np.array(rows)) for name, rows in series.items()}
    return xr.Dataset({**data, "example_elevation": ("time", eta)}, coords={"law": list(laws), "time": time})


def test_synthetic_has_the_layout_and_survives_a_file(tmp_path):
    ds = synthetic()
    assert check_layout(ds, "memory") is ds
    save(ds, tmp_path / "results.nc")
    back = xr.load_dataset(tmp_path / "results.nc", engine="scipy")
    assert back["locked"].dtype == bool
    np.testing.assert_array_equal(back["sha256"].values.astype(str), ds["sha256"].values)


def test_synthetic_without_a_variable_is_refused():
    with pytest.raises(InputError, match="variable loss_time"):
        check_layout(synthetic().drop_vars("loss_time"), "memory")
