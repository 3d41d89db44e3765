"""Files of other solvers, written from the shipped table by their formats' descriptions: each test puts its trap in."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from gyroctl.hydrodynamics import Hydrodynamics, shipped

ROWS = slice(1, None, 3)
"""Frequencies of the files, 0.35 to 16 rad/s."""

COLUMN: dict[str, Callable[[float], float]] = {
    "period": lambda w: 2.0 * np.pi / w,
    "rad/s": lambda w: w,
    "Hz": lambda w: w / (2.0 * np.pi),
}
SIGN = (-1.0, 1.0)
"""phi1 is minus yaw, phi3 roll."""


def omega() -> np.ndarray:
    return shipped().omega[ROWS]


def truth(name: str, headings: Sequence[int] = (0,)) -> np.ndarray:
    """A table of the shipped float at the frequencies of the files."""
    values = getattr(shipped(), name)
    return values[:, list(headings)][:, :, ROWS] if values.ndim == 3 else values[:, ROWS]


def write_wamit(
    folder: Path, unit: str = "period", headings: Sequence[int] = (0,), limits: Sequence[str] = (), yaw: float = 1.0
) -> Path:
    """NAME.1 and NAME.3; `limits` are rows that come first in NAME.1."""
    first, third = list(limits), []
    for n, w in enumerate(omega()):
        value = COLUMN[unit](w)
        for j, mode in ((1, 4), (0, 6)):
            size = yaw if mode == 6 else 1.0
            a, b = size * truth("added_mass")[j, n] / 1e3, size * truth("damping")[j, n] / 1e3 / w
            first.append(f" {value:.6E} {mode:5d} {mode:5d} {a: .6E} {b: .6E}")
        for k, position in enumerate(headings):
            for j, mode in ((1, 4), (0, 6)):
                force = SIGN[j] * (yaw if mode == 6 else 1.0) * truth("excitation", headings)[j, k, n] / 9810.0
                parts = abs(force), np.degrees(np.angle(force)), force.real, force.imag
                row = " ".join(f"{v: .6E}" for v in parts)
                third.append(f" {value:.6E} {shipped().headings[position]:.6E} {mode:5d} {row}")
    (folder / "float.1").write_text("\n".join(first) + "\n")
    (folder / "float.3").write_text("\n".join(third) + "\n")
    return folder / "float"


def write_nemoh(
    folder: Path, unit: str = "rad/s", head: str = "w (rad/s)", cal: str = "", turn: float = 0.0, order: str = "123456"
) -> Path:
    """Results of NEMOH; all phases above 0 where `turn` is 2 pi; zones of motions in any order."""
    results = folder / "Results"
    results.mkdir(parents=True)
    lines = [f'VARIABLES="{head}"', *(f'"A 1 {k}" "B 1 {k}"' for k in range(1, 7))]
    for motion in map(int, order):
        lines.append(f'Zone t="Motion of body    1 in DoF   {motion}",I={len(omega()):6d},F=POINT')
        for n, w in enumerate(omega()):
            pairs = np.full((6, 2), 7.0)
            for j, own in enumerate((6, 4)):
                if motion == own:
                    pairs[[5, 3]] = 0.0
                    pairs[own - 1] = truth("added_mass")[j, n], truth("damping")[j, n]
            lines.append(" ".join(f"{v:14.7E}" for v in (COLUMN[unit](w), *pairs.ravel())))
    (results / "RadiationCoefficients.tec").write_text("\n".join(lines) + "\n")
    lines = [f'VARIABLES="{head}"', 'Zone t="Diffraction force - beta =   0.000 deg",I=  25,F=POINT']
    lines[1] = lines[1].replace("  25", f"{len(omega()):4d}")
    for n, w in enumerate(omega()):
        pairs = np.zeros((6, 2))
        for j, own in enumerate((6, 4)):
            force = np.conj(SIGN[j] * truth("excitation")[j, 0, n])
            angle = float(np.angle(force))
            pairs[own - 1] = abs(force), angle % turn if turn else angle
        lines.append(" ".join(f"{v:14.7E}" for v in (COLUMN[unit](w), *pairs.ravel())))
    (results / "ExcitationForce.tec").write_text("\n".join(lines) + "\n")
    if cal:
        (folder / "Nemoh.cal").write_text(cal)
    return folder


CAL = "--- Environment ---\n1000.0 ! RHO\n9.81 ! G\n0.7 ! DEPTH\n0. 0. ! XEFF YEFF\n"


def capytaine(headings: Sequence[int] = (0,), names: Sequence[str] = ("phi1", "phi3")) -> xr.Dataset:
    """Results as Capytaine's dataset has them; standard names have yaw turn against phi1."""
    w = omega()
    square = np.zeros((2, len(w), 2, 2))
    for k, name in enumerate(("added_mass", "damping")):
        square[k][:, [0, 1], [0, 1]] = truth(name).T
    sign = np.array([-1.0, 1.0]) if "phi1" not in names else np.ones(2)
    force = np.conj(np.transpose(truth("excitation", headings), (2, 1, 0))) * sign
    dims = ("omega", "influenced_dof", "radiating_dof")
    return xr.Dataset(
        {
            "added_mass": (dims, square[0]),
            "radiation_damping": (dims, square[1]),
            "excitation_force": (("complex", "omega", *("wave_direction", "influenced_dof")), [force.real, force.imag]),
        },
        coords={
            "omega": w,
            "wave_direction": np.deg2rad(shipped().headings[list(headings)]),
            "influenced_dof": list(names),
            "radiating_dof": list(names),
            "complex": ["re", "im"],
            "rho": 1000.0,
            "g": 9.81,
            "water_depth": 0.7,
        },
    )


def stored(dataset: xr.Dataset, path: Path) -> Path:
    dataset.to_netcdf(path, engine="scipy", format="NETCDF3_64BIT")
    return path


def is_ours(read: Hydrodynamics, headings: Sequence[int] = (0,), left_out: Sequence[int] = ()) -> bool:
    """Whether a table is the shipped one at the frequencies of the files, to the digits that the files have."""
    kept = [n for n in range(len(omega())) if n not in left_out]
    pairs = [(read.omega, omega()[kept])]
    pairs += [(getattr(read, name), truth(name)[:, kept]) for name in ("added_mass", "damping")]
    pairs.append((read.excitation, truth("excitation", headings)[:, :, kept]))
    return all(a.shape == b.shape and bool(np.max(np.abs(a - b)) < 2e-6 * np.max(np.abs(b))) for a, b in pairs)
