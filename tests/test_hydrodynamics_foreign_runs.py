"""A real run of another program, about another point: moved to the hinge it is the run about the hinge."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gyroctl.hydrodynamics import Site, load
from gyroctl.hydrodynamics.importers import read_wamit

cpt: Any = pytest.importorskip("capytaine")

PERIODS = (1.2, 1.5, 1.8, 2.1, 2.5, 3.0, 3.5, 4.2)
HEADINGS = np.deg2rad([0.0, 50.0])
HINGE, POINT = (0.0, -1.0, 0.3), (0.1, -0.2, -0.4)


def run(about: tuple[float, float, float], periods: tuple[float, ...]) -> Any:
    mesh = cpt.mesh_sphere(radius=0.5, center=(0.0, 0.1, -0.05), resolution=(8, 10)).immersed_part()
    body = cpt.FloatingBody(mesh=mesh, dofs=cpt.rigid_body_dofs(rotation_center=about), name="float")
    common = {"body": body, "water_depth": np.inf, "rho": 1020.0}
    problems = [cpt.RadiationProblem(**common, period=t, radiating_dof=dof) for t in periods for dof in body.dofs]
    waves = [t for t in periods if t > 0.0]
    problems += [cpt.DiffractionProblem(**common, period=t, wave_direction=b) for t in waves for b in HEADINGS]
    results = cpt.BEMSolver().solve_all(problems, progress_bar=False)
    return cpt.assemble_dataset(results, wavenumber=True, hydrostatics=False)


@pytest.mark.slow
def test_a_run_about_another_point_is_the_run_about_the_hinge(tmp_path: Path) -> None:
    exporter = pytest.importorskip("capytaine.io.wamit")
    there, here = run(POINT, PERIODS), run(HINGE, PERIODS)
    cpt.export_dataset(tmp_path / "there.nc", there, format="netcdf")
    cpt.export_dataset(tmp_path / "here.nc", here, format="netcdf")
    hinge = (HINGE[1], HINGE[2])
    moved, direct = (load(tmp_path / name, Site(hinge=hinge)) for name in ("there.nc", "here.nc"))
    exporter.export_wamit_1(there, str(tmp_path / "there.1"))
    exporter.export_wamit_3(there, str(tmp_path / "there.3"))
    text = read_wamit(tmp_path / "there", Site(rho=1020.0, about=POINT, hinge=hinge, frequency="period"))
    # by numbers of the dataset itself, in the order of the file
    roll = here["added_mass"].sel(influenced_dof="Roll", radiating_dof="Roll").values[::-1]
    yaw = here["excitation_force"].sel(influenced_dof="Yaw").values[::-1]
    assert direct.omega == pytest.approx(2.0 * np.pi / np.array(PERIODS[::-1]))
    assert direct.added_mass[1] == pytest.approx(roll) and direct.rho == 1020.0
    assert np.allclose(direct.excitation[0], -np.conj(yaw).T)
    for read, digits in ((moved, 1e-9), (text, 3e-5)):
        for name in ("added_mass", "damping", "excitation"):
            ours, theirs = getattr(read, name), getattr(direct, name)
            assert np.max(np.abs(ours - theirs)) < digits * np.max(np.abs(theirs)), name
