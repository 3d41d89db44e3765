"""Results about another point, or with waves referred to another place: moved to the hinge, or refused.

The oracle moves rigid bodies by cross products, motion by motion, and plane waves by their phase.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from foreign_files import CAL, capytaine, is_ours, stored, write_nemoh, write_wamit

from gyroctl.errors import InputError
from gyroctl.hydrodynamics import excitation_table, load, shipped
from gyroctl.hydrodynamics.dispersion import wavenumber
from gyroctl.hydrodynamics.importers import Site, read_nemoh, read_wamit

RNG = np.random.default_rng(7)
COUNT = 9
OMEGA = np.linspace(1.0, 5.0, COUNT)
POINT, HINGE = np.array([0.3, -0.6, -0.2]), np.array([0.0, -1.05, 0.21])
BETA = (0.0, 35.0, 80.0)


def positive() -> np.ndarray:
    """Symmetric positive 6 by 6 matrices."""
    root = RNG.normal(size=(COUNT, 6, 6))
    return root @ np.swapaxes(root, 1, 2)


ADDED, DAMPING, RESTORING = positive(), positive(), positive()[0]
FORCES = RNG.normal(size=(COUNT, 3, 6)) + 1j * RNG.normal(size=(COUNT, 3, 6))


def about_the_hinge(matrix: np.ndarray) -> np.ndarray:
    """(2, 2) of phi1 about -z and phi3 about x, both through the hinge, from 6 by 6 about the point."""
    out = np.empty((2, 2))
    axes = np.array([[0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
    arm = POINT - HINGE
    for k, turning in enumerate(axes):
        force = matrix @ np.concatenate([np.cross(turning, arm), turning])
        for i, measured in enumerate(axes):
            out[i, k] = measured @ (force[3:] + np.cross(arm, force[:3]))
    return out


def moments(n: int, k: int) -> np.ndarray:
    force = FORCES[n, k]
    whole = force[3:] + np.cross(POINT - HINGE, force[:3])
    return np.array([-whole[2], whole[0]])


def check(read: object, depth: float, origin: tuple[float, float] = (0.0, 0.0)) -> None:
    for n in range(COUNT):
        for name, values in (("added_mass", ADDED), ("damping", DAMPING)):
            assert getattr(read, name)[:, n] == pytest.approx(np.diag(about_the_hinge(values[n])), rel=1e-5)
    k = wavenumber(OMEGA, depth)
    for b, beta in enumerate(np.deg2rad(BETA)):
        for n in range(COUNT):
            # a crest passes the origin of the run this much earlier than the float's centre
            lag = k[n] * (np.cos(beta) * -origin[0] + np.sin(beta) * -origin[1])
            assert read.excitation[:, b, n] == pytest.approx(moments(n, b) * np.exp(1j * lag), rel=1e-5)  # type: ignore[attr-defined]


def random_wamit(folder: Path) -> Path:
    first, third = [], []
    for n, w in enumerate(OMEGA):
        for i in range(6):
            first += [
                f"{2 * np.pi / w:.9E} {i + 1} {j + 1} {ADDED[n, i, j] / 1e3:.9E} {DAMPING[n, i, j] / 1e3 / w:.9E}"
                for j in range(6)
            ]
            for b, beta in enumerate(BETA):
                f = FORCES[n, b, i] / 9810.0
                third.append(f"{2 * np.pi / w:.9E} {beta:.4f} {i + 1} {abs(f):.9E} 0.0 {f.real:.9E} {f.imag:.9E}")
    (folder / "body.1").write_text("\n".join(first) + "\n")
    (folder / "body.3").write_text("\n".join(third) + "\n")
    stiffness = [f"{i + 1} {j + 1} {RESTORING[i, j] / 9810.0:.9E}" for i in range(6) for j in range(6)]
    (folder / "body.hst").write_text("\n".join(stiffness) + "\n")
    return folder / "body"


MINE = {"hinge": (HINGE[1], HINGE[2]), "frequency": "period"}
X, Y, Z = map(float, POINT)


def test_wamit_about_a_point_is_moved_to_the_hinge(tmp_path: Path) -> None:
    path = random_wamit(tmp_path)
    site = Site(about=(X, Y, Z), depth=2.0, **MINE)
    read = read_wamit(path, site)
    check(read, 2.0)
    assert read.stiffness == pytest.approx(about_the_hinge(RESTORING)[1, 1], rel=1e-6)
    assert "moved to the hinge" in read.provenance["import"]["point"]
    (tmp_path / "body.cfg").write_text(f"IPERIN = 1\nXBODY(1) = {X} {Y} {Z} 0.0 ! of the body\n")
    check(read_wamit(path, Site(depth=2.0, **MINE)), 2.0)
    with pytest.raises(InputError, match=r"body\.cfg: point.*--hinge"):
        read_wamit(path, Site(depth=2.0, frequency="period"))
    with pytest.raises(InputError, match=r"hydro.about"):
        read_wamit(path, Site(about=(0.0, 0.0, 0.0), **MINE))
    (tmp_path / "body.cfg").unlink()
    (tmp_path / "body.pot").write_text(f"a run\n{X} {Y} {Z} 30.0 XBODY(1-4)\n")
    with pytest.raises(InputError, match=r"body\.pot: XBODY"):
        read_wamit(path, Site(**MINE))


def test_water_of_wamit_is_that_of_its_printed_file(tmp_path: Path) -> None:
    path = write_wamit(tmp_path)
    (tmp_path / "float.out").write_text(
        " Gravity:     9.80665                Length scale:        1.00000\n"
        " Water depth:        infinite        Water density:      1025.0000\n"
    )
    read = read_wamit(path)
    assert (read.rho, read.g, read.depth) == (1025.0, 9.80665, np.inf)
    with pytest.raises(InputError, match=r"hydro\.rho = 1000.*float\.out"):
        read_wamit(path, Site(rho=1000.0))


def test_the_input_files_of_wamit_tell_depth_and_column(tmp_path: Path) -> None:
    path = write_wamit(tmp_path, "rad/s")
    (tmp_path / "float.pot").write_text("a run\n0.7             HBOT\n 0.0 0.0 0.0 0.0 \t\tXBODY(1-4)\n")
    (tmp_path / "float.cfg").write_text("IPERIN=2\nIPEROUT=2 ! rad/s\n")
    read = read_wamit(path)
    assert is_ours(read) and read.depth == 0.7
    (tmp_path / "float.cfg").write_text("IPEROUT=3\n")
    with pytest.raises(InputError, match=r"float\.cfg: IPEROUT"):
        read_wamit(path)


def test_capytaine_about_a_point_is_moved_to_the_hinge(tmp_path: Path) -> None:
    names = ["Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw"]
    force = np.conj(FORCES)
    dims = ("omega", "influenced_dof", "radiating_dof")
    data = xr.Dataset(
        {
            "added_mass": (dims, ADDED),
            "radiation_damping": (dims, DAMPING),
            "excitation_force": (("complex", "omega", "wave_direction", "influenced_dof"), [force.real, force.imag]),
            "hydrostatic_stiffness": (dims[1:], RESTORING),
            "rotation_center": ("xyz", POINT),
        },
        coords={
            "omega": OMEGA,
            "wave_direction": np.deg2rad(BETA),
            "influenced_dof": names,
            "radiating_dof": names,
            "complex": ["re", "im"],
            "water_depth": 2.0,
        },
    )
    path = stored(data, tmp_path / "body.nc")
    read = load(path, Site(hinge=(HINGE[1], HINGE[2])))
    check(read, 2.0)
    assert read.stiffness == pytest.approx(about_the_hinge(RESTORING)[1, 1])
    with pytest.raises(InputError, match=r"rotation|point"):
        load(path)
    lone = data.sel(influenced_dof=["Roll", "Yaw"], radiating_dof=["Roll", "Yaw"])
    with pytest.raises(InputError, match=r"lacks 1 \(surge\), 2 \(sway\), 3 \(heave\)"):
        load(stored(lone, tmp_path / "lone.nc"), Site(hinge=(HINGE[1], HINGE[2])))


BODY = (
    "--- Description of floating bodies ---\n1 ! Number of bodies\n--- Body 1 ---\nfloat.dat ! Name of mesh file\n"
    "540 300 ! Number of points and number of panels\n6 ! Number of degrees of freedom\n"
    "1 1. 0. 0. 0. 0. 0. ! Surge\n1 0. 1. 0. 0. 0. 0. ! Sway\n1 0. 0. 1. 0. 0. 0. ! Heave\n"
    "2 1. 0. 0. {0} {1} {2} ! Roll about a point\n2 0. 1. 0. {0} {1} {2} ! Pitch\n2 0. 0. 1. {0} {1} {2} ! Yaw\n"
    "6 ! Number of resulting generalised forces\n"
)


def test_nemoh_about_a_point_and_with_another_origin_of_waves_is_moved(tmp_path: Path) -> None:
    results = tmp_path / "Results"
    results.mkdir()
    lines = ['VARIABLES="w (rad/s)"']
    for j in range(6):
        lines.append(f'Zone t="Motion of body    1 in DoF   {j + 1}",I={COUNT},F=POINT')
        for n, w in enumerate(OMEGA):
            pairs = np.stack([ADDED[n, :, j], DAMPING[n, :, j]], axis=1).ravel()
            lines.append(" ".join(f"{v:.9E}" for v in (w, *pairs)))
    (results / "RadiationCoefficients.tec").write_text("\n".join(lines) + "\n")
    lines = ['VARIABLES="w (rad/s)"']
    for b, beta in enumerate(BETA):
        lines.append(f'Zone t="Diffraction force - beta = {beta} deg",I={COUNT},F=POINT')
        for n, w in enumerate(OMEGA):
            force = np.conj(FORCES[n, b])
            pairs = np.stack([np.abs(force), np.rad2deg(np.angle(force))], axis=1).ravel()
            lines.append(" ".join(f"{v:.9E}" for v in (w, *pairs)))
    (results / "ExcitationForce.tec").write_text("\n".join(lines) + "\n")
    (tmp_path / "mesh").mkdir()
    (tmp_path / "mesh" / "KH.dat").write_text("\n".join(" ".join(f"{v:.9E}" for v in row) for row in RESTORING) + "\n")
    water = CAL.replace("0.7 !", "2.0 !")
    (tmp_path / "Nemoh.cal").write_text(water.replace("0. 0. ! XEFF", "0.4 -0.9 ! XEFF") + BODY.format(X, Y, Z))
    read = read_nemoh(tmp_path, Site(hinge=(HINGE[1], HINGE[2])))
    check(read, 2.0, (0.4, -0.9))
    assert read.stiffness == pytest.approx(about_the_hinge(RESTORING)[1, 1], rel=1e-6)
    with pytest.raises(InputError, match=r"Nemoh\.cal: point.*--hinge"):
        read_nemoh(tmp_path)
    (tmp_path / "Nemoh.cal").write_text(water + BODY.format(*HINGE))
    plain = read_nemoh(tmp_path, Site(hinge=(HINGE[1], HINGE[2])))
    for n in range(COUNT):
        assert plain.damping[:, n] == pytest.approx(DAMPING[n, [5, 3], [5, 3]], rel=1e-6)


def test_a_wave_referred_to_another_place_turns_the_phase_alone(tmp_path: Path) -> None:
    path = write_wamit(tmp_path, headings=(0, 6))
    plain = read_wamit(path, Site(depth=0.7))
    moved = read_wamit(path, Site(depth=0.7, centre=(0.5, 0.25)))
    k = wavenumber(plain.omega, 0.7)
    ratio = moved.excitation[1] / plain.excitation[1]
    assert ratio[0] == pytest.approx(np.exp(0.5j * k), rel=1e-9) and ratio[1] == pytest.approx(np.exp(0.25j * k))
    assert np.array_equal(moved.damping, plain.damping)


# --- stiffness and modes ------------------------------------------------------------------------------------------


def test_k3_comes_from_the_restoring_files(tmp_path: Path) -> None:
    path = write_wamit(tmp_path)
    assert read_wamit(path).stiffness == 0.0
    (tmp_path / "float.hst").write_text("3 3 1.0\n4 4 3.002E-01\n5 5 9.9\n")
    assert read_wamit(path).stiffness == pytest.approx(0.3002 * 9810.0)
    assert read_wamit(path, Site(length=2.0)).stiffness == pytest.approx(0.3002 * 9810.0 * 16.0)
    assert read_wamit(path, Site(stiffness=7.0)).stiffness == 7.0
    (tmp_path / "float.hst").write_text("4 4 -0.3\n")
    with pytest.raises(InputError, match=r"hydro\.stiffness = -2943.*--stiffness"):
        read_wamit(path)
    folder = write_nemoh(tmp_path / "n")
    rows = np.zeros((6, 6))
    rows[3, 3] = 2945.0
    (folder / "mesh").mkdir()
    np.savetxt(folder / "mesh" / "KH.dat", rows)
    assert read_nemoh(folder).stiffness == 2945.0


def test_a_negative_stiffness_of_capytaine_is_refused_unless_one_is_given(tmp_path: Path) -> None:
    data = capytaine().assign(hydrostatic_stiffness=(("influenced_dof", "radiating_dof"), np.diag([0.0, -500.0])))
    path = stored(data, tmp_path / "neg.nc")
    with pytest.raises(InputError, match=r"-500.*--stiffness"):
        load(path)
    assert load(path, Site(stiffness=2945.0)).stiffness == 2945.0


def test_table_1_lends_no_foreign_float_its_stiffness(tmp_path: Path) -> None:
    import gyroctl as gy
    from gyroctl.hydrodynamics.radiation import PAPER_FIT

    hydro = load(stored(capytaine(), tmp_path / "base.nc"))
    from dataclasses import replace

    hydro = replace(hydro, fits={"accurate": PAPER_FIT})
    with pytest.raises(InputError, match=r"plant\.k3"):
        gy.zhang2017(hydrodynamics=hydro)
    assert gy.zhang2017(hydrodynamics=hydro, k3=2000.0).parameters.k3 == 2000.0


def test_infinite_added_mass_of_nemoh_is_that_of_irf(tmp_path: Path) -> None:
    folder = write_nemoh(tmp_path / "n")
    lines = ['VARIABLES="Time (s)"']
    for motion in range(1, 7):
        lines.append(f'Zone t="Motion of body    1 in DoF   {motion}",I=2,F=POINT')
        pairs = [v for k in range(1, 7) for v in (10.0 * motion + k, 0.5)]
        lines += [" ".join(f"{v:.5E}" for v in (t, *pairs)) for t in (0.0, 0.1)]
    (folder / "Results" / "IRF.tec").write_text("\n".join(lines) + "\n")
    assert read_nemoh(folder).added_mass_inf == pytest.approx([66.0, 44.0])


@pytest.mark.parametrize("modes", [None, ("-yaw", "roll"), ("-Yaw", "ROLL"), (-6, 4), ("-6", "4")])
def test_modes_are_known_by_number_and_name_in_every_format(tmp_path: Path, modes: tuple[str, str] | None) -> None:
    site = Site(modes=modes)
    assert is_ours(load(stored(capytaine(names=("Yaw", "Roll")), tmp_path / "a.nc"), site))
    assert is_ours(load(stored(capytaine(names=("float__Yaw", "float__Roll")), tmp_path / "b.nc"), site))
    assert is_ours(read_wamit(write_wamit(tmp_path), site))
    assert is_ours(read_nemoh(write_nemoh(tmp_path / "n"), site))


def test_modes_that_a_file_lacks_or_has_of_two_bodies_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"lacks 5 \(pitch\)"):
        load(stored(capytaine(names=("Yaw", "Roll")), tmp_path / "a.nc"), Site(modes=("yaw", "pitch")))
    data = capytaine(names=("a__Roll", "b__Roll"))
    with pytest.raises(InputError, match="several bodies"):
        load(stored(data, tmp_path / "b.nc"))
    for modes in (("yaw", "bounce"), ("yaw", "-yaw"), (0, 4)):
        with pytest.raises(InputError, match=r"hydro.modes"):
            Site(modes=modes)


# --- headings of a table ------------------------------------------------------------------------------------------


def test_no_gap_between_headings_is_interpolated_across(tmp_path: Path) -> None:
    hydro = read_wamit(write_wamit(tmp_path, headings=(0, 1, 22, 23)))
    table, whole = excitation_table(hydro), excitation_table(shipped())
    w = np.array([3.14])
    for heading in (-5.0, 355.0, 7.0, 345.0, 15.0, -30.0):
        size = np.max(np.abs(whole(w, heading)))
        assert table(w, heading) == pytest.approx(whole(w, heading), abs=2e-3 * size)
    for heading in (180.0, 16.0, -31.0):
        with pytest.raises(InputError, match="between the tabulated headings 15 and 330 deg, 315 deg apart"):
            table(w, heading)


@pytest.mark.parametrize("positions", [(0, 2, 3, 6, 9, 12, 14, 17, 19, 22), (0, 3, 6, 9, 12, 15, 18, 21)])
def test_an_uneven_circle_of_headings_is_closed(tmp_path: Path, positions: tuple[int, ...]) -> None:
    table = excitation_table(read_wamit(write_wamit(tmp_path, headings=positions)))
    w = np.array([2.0, 3.14])
    for heading in (-22.0, 338.0, 10.0, 200.0):
        right = excitation_table(shipped())(w, heading)
        assert np.max(np.abs(table(w, heading) - right)) < 0.03 * np.max(np.abs(right))


def test_two_stretches_of_headings_are_each_a_table(tmp_path: Path) -> None:
    table = excitation_table(read_wamit(write_wamit(tmp_path, headings=(0, 1, 2, 12, 13))))
    w = np.array([3.14])
    for heading in (10.0, 187.0):
        right = excitation_table(shipped())(w, heading)
        assert np.max(np.abs(table(w, heading) - right)) < 0.02 * np.max(np.abs(right))
    for heading in (100.0, 200.0, -10.0):
        with pytest.raises(InputError, match="apart"):
            table(w, heading)
