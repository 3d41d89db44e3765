"""Readers of files from outside: sound files that the project writes itself, what reads them, and what must hold."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import fuzz_seas
import numpy as np

import gyroctl as gy
from gyroctl import nested
from gyroctl.comparison.compare import Realisations, compare
from gyroctl.comparison.execution import outcome_of
from gyroctl.comparison.experiment import Experiment, read_experiment
from gyroctl.controllers.gain_scheduled.table import law_of, read_table, table_file
from gyroctl.devices.file import new_device, write_device
from gyroctl.devices.identity import changed
from gyroctl.engine import Store
from gyroctl.engine.record import MAGIC
from gyroctl.harness.registry import tuned_sets
from gyroctl.harness.seed_ledger import LEDGER, read_ledger
from gyroctl.harness.tuned_sets import read_sets, seeds_of, write_sets
from gyroctl.hydrodynamics import Hydrodynamics, load, save, shipped
from gyroctl.hydrodynamics.capytaine_layout import to_dataset
from gyroctl.hydrodynamics.importers import Site, read_nemoh, read_wamit
from gyroctl.reports import evaluate, open_results, summarise
from gyroctl.reports.layout import OPTIONAL
from gyroctl.studies.site import read_scatter
from gyroctl.tuning.goal import METRICS, WORST
from gyroctl.tuning.log import TuningLog
from gyroctl.tuning.stages import stored_rows
from gyroctl.tuning.task import read_task
from gyroctl.tuning.tune import BUDGET, check_seeds, planned
from gyroctl.tuning.waters import Circumstances
from gyroctl.waves import read_record, read_spectrum
from gyroctl.writing import write_text


class Reader(NamedTuple):
    """A reader.

    `examples` writes sound files into a folder and returns a path for each example that is read; whatever lies beside
    one of them, in a folder of its own, belongs to it. `read` reads a path and asserts what must hold of a result.
    """

    examples: Callable[[Path], list[Path]]
    read: Callable[[Path], object]


EXPERIMENTS = (
    'sea = {kind = "jonswap", hs = 0.283, wp = 3.14, gamma = 5.0, heading = 0.0}\n'
    "[run]\nduration = 600.0\ndt = 0.01\nblend = 100.0\nseeds = [1, 2, 3]\nmotion_limit = 0.35\n"
    'start = "locked"\ntime_limit = 60.0\n'
    '[plant]\nvariant = "corrected"\nk3 = 2945.0\nd1 = 2.0\nradiation = "accurate"\nexcitation_phase = "complex"\n'
    "[laws.constant]\ncc = 0.05\ncg = 0.0003\n"
    '[laws.mine]\nlaw = "load_angle"\ntuning = "all"\nmargin = 0.7\n'
    "[sensors.psi]\nnoise = 0.001\nquantum = 0.0015\ndelay = 1\n"
    '[sensors.phi1]\nlost_from = 5.0\nlost_for = 2.0\nlost_reads = "last"\n'
    "[actuators]\ncc_max = 0.3\ncg_max = 0.02\nperiod = 0.1\ncc_lag = 0.02\ndelay = 1\n",
    '[sea]\nkind = "two peaks"\n[laws.supervisor]\nwraps = {law = "load_angle", margin = 0.7}\n',
    '[sea]\nkind = "record"\nfile = "waves.csv"\nheading = 10.0\n[run]\nduration = 120.0\nblend = 20.0\n'
    "[laws.constant]\n",
    '[sea]\nkind = "spectrum"\nfile = "spectrum.csv"\n[plant]\nhydrodynamics = "float.nc"\n[laws.tracking]\n'
    '[sensors]\nideal = true\n[run]\nstart = "rest"\n',
    '[sea]\nkind = "bichromatic"\nheights = [0.1, 0.05]\nfrequencies = [3.0, 3.3]\n'
    '[plant]\nvariant = "realistic"\ndrag_area = [0.1, 0.2]\n'
    '[laws.scheduled_lqr]\nload = 0.9\nplant = "realistic"\n',
)


def experiments(folder: Path) -> list[Path]:
    paths = []
    for number, text in enumerate(EXPERIMENTS):
        path = folder / str(number) / "experiment.toml"
        write_text(path, text)
        if "waves.csv" in text:
            elevation(path.with_name("waves.csv"))
        if "spectrum.csv" in text:
            spectrum(path.with_name("spectrum.csv"))
        if "float.nc" in text:
            save(thinned(), path.with_name("float.nc"))
        paths.append(path)
    return paths


def experiment(path: Path) -> Experiment:
    setup = read_experiment(path)
    json.dumps(setup.record(), allow_nan=False)
    assert setup.run.duration > 0.0 and 0 < setup.run.dt <= 0.1 and len(setup.tuning_seeds) < 1e6
    numbers = [number for number in nested.leaves(setup.plant.coefficients) if isinstance(number, float)]
    assert setup.plant.parameters.d1 >= 0.0 and all(map(math.isfinite, numbers))
    return setup


TASK = (
    'law = "load_angle"\nmethod = "evolution"\n[fixed]\nrecall = 1.0\n[knobs]\n'
    'share = {start = 0.43, width = 0.2, scale = "linear", least = 0.0, most = 1.0}\n'
    "cc = {start = 0.0675, width = 0.2}\n"
    "[seas.gamma5]\nhs = 0.283\nwp = 3.14\ngamma = 5.0\nweight = 0.4\npower = 2.1\nruns = 4\n"
    "[goal]\nlocked = 0.99\nmotion = {gamma5 = 0.34}\n[goals.smooth]\npower_cv = 1.2\n"
    "[search]\npopulation = 14\nspread = 0.3\nwindow = 1000.0\nruns = 6\ndt = 0.025\nconfirm = 2000.0\n"
    "confirm_share = 0.3\nseed = 1\n[seeds]\nfirst = 100000\ncount = 64\n[real.goal]\nmotion = 0.46\n"
)


def task(path: Path) -> object:
    found = []
    for water in ("linear", "real"):
        one = read_task(str(path), water)
        point = one.at(np.zeros(len(one.knobs)))
        assert all(math.isfinite(value) for value in point.values() if isinstance(value, float))
        for name in (*one.seas, "all"):
            planned(one, one.served(name), BUDGET)
        assert 0 < one.seeds.count < 1e6 and 0.0 < one.search.window < 1e6 and 0.0 < one.search.dt <= 1.0
        check_seeds(one, Circumstances(device()))
        found.append(one)
    return found


def own_device(path: Path) -> object:
    plant = gy.device(path)
    numbers = [leaf for leaf in nested.leaves(plant.coefficients) if leaf is not None]
    assert all(math.isfinite(number) for number in numbers) and plant.depth > 0.0 and changed(plant) is not None
    return plant


def tuned(path: Path) -> object:
    sets = read_sets(path)
    assert len(seeds_of(sets)) < 1e6
    for name, entry in sets.items():
        assert isinstance(name, str) and {"parameters", "found"} <= set(entry)
        for value in entry["parameters"].values():
            assert isinstance(value, str | bool) or math.isfinite(value)
        assert 0.0 <= entry["found"].get("spent_s", 0.0) < math.inf
        gy.law("load_angle", **entry["parameters"])
    return sets


def table(path: Path) -> object:
    made = law_of(read_table(path))
    for nodes in (made.envelopes, made.frequencies, made.bandwidths):
        assert nodes and all(np.diff(nodes) > 0.0) and all(map(math.isfinite, nodes))
    assert all(math.isfinite(value) for value in made.cells) and max(map(abs, made.cells)) < 1e9
    assert min(made.slow, made.brisk, made.fast, made.memory, made.notch) > 0.0
    return made


def results_nc(engine: str, form: str) -> Callable[[Path], list[Path]]:
    def write(folder: Path) -> list[Path]:
        laws = {
            "constant": gy.law("constant"),
            "load_angle": gy.law("load_angle"),
            "best_constant": gy.law("best_constant"),
        }
        ds = compare(device(), laws, Realisations(gy.SeaState(), (1, 2, 3), 40.0), gy.Settings(blend=10.0), 1)
        whole, older = (folder / name / "results.nc" for name in ("0", "1"))
        for path, content in ((whole, ds), (older, ds.drop_vars([name for name in OPTIONAL if name in ds]))):
            path.parent.mkdir(parents=True)
            content.to_netcdf(path, engine=engine, format=form)
        return [whole] if engine == "scipy" else [whole, *[older] * 7]  # HDF5 takes its time for each variable

    return write


def results(path: Path) -> object:
    ds = open_results(path)
    found = evaluate(ds)
    json.dumps(summarise(ds, found), allow_nan=False)
    assert 0.0 < found.duration < 1e9 and all(seed >= 0 for seed in found.seeds)
    return found


def stored_run(folder: Path) -> list[Path]:
    rng = np.random.default_rng(1)
    store, content = Store(folder / "0"), {"sha256": "b" * 64, "values": {"power": 1.5, "locked": 1.0}}
    store.save("a" * 64, content, {"time": rng.random(30)})
    return [store.path("a" * 64)]


def stored(path: Path) -> object:
    """As it stands there, and under a checksum that fits: whoever changed it could compute one."""
    store = Store(path.parent, lambda _: None)
    store.load(path.stem)
    body = path.read_bytes().partition(b"\n")[2]
    path.write_bytes(MAGIC + hashlib.sha256(body).hexdigest().encode() + b"\n" + body)
    found = outcome_of(store.load(path.stem))
    if found is not None:
        sha256, values, series = found.sha256, found.values, found.series
        assert isinstance(sha256, str) and all(isinstance(value, float) for value in values.values())
        assert all(kept.dtype.kind in "fiub" and kept.nbytes < 1e8 for kept in series.values())
    return found


def tuning_log(folder: Path) -> list[Path]:
    path = folder / "0" / "law.all.jsonl"
    log = TuningLog(path)
    for number in range(4):
        log.add(f"search {number}", [WORST] * 6)
    return [path]


def log(path: Path) -> object:
    steps = TuningLog(path)
    for key in steps.steps:
        rows = stored_rows(steps, key, 6)
        assert np.all(np.isfinite(np.array(rows))) and np.shape(rows) == (6, len(METRICS))
    return steps


def thinned() -> Hydrodynamics:
    """Every fifth frequency of a few headings keeps the files small."""
    hydro = shipped()
    rows, turn = slice(None, None, 5), [0, 4, 12]
    parts = {name: getattr(hydro, name)[:, turn][:, :, rows] for name in ("excitation", "froude_krylov", "diffraction")}
    square = {name: getattr(hydro, name)[:, rows] for name in ("added_mass", "damping")}
    return dataclasses.replace(
        hydro, omega=hydro.omega[rows], headings=hydro.headings[turn], hull=None, **parts, **square
    )


def classic(folder: Path) -> list[Path]:
    whole = save(shipped(), folder / "1" / "float.nc")
    return [save(thinned(), folder / "0" / "float.nc"), whole]


def hdf5(folder: Path) -> list[Path]:
    path = folder / "0" / "float.nc"
    path.parent.mkdir(parents=True)
    to_dataset(thinned()).to_netcdf(path, engine="h5netcdf")
    return [path]


def sound_table(hydro: Hydrodynamics) -> object:
    assert np.all(np.isfinite(hydro.omega)) and np.all(np.diff(hydro.omega) > 0.0) and hydro.omega[0] > 0.0
    assert np.all(np.isfinite(hydro.excitation)) and np.all(np.isfinite(hydro.added_mass_inf))
    low = -0.05 * np.max(np.abs(hydro.damping), axis=1, keepdims=True)
    assert np.all(hydro.damping >= low), "negative damping"
    assert 100.0 < hydro.rho < 5000.0 and 0.1 < hydro.g < 100.0 and hydro.depth > 0.0 and hydro.stiffness >= 0.0
    assert max(np.max(np.abs(hydro.excitation)), np.max(np.abs(hydro.added_mass))) < 1e15
    if hydro.fits:  # those of other solvers are fitted when they are imported
        gy.zhang2017(hydrodynamics=hydro)
    return hydro


def wamit(folder: Path) -> list[Path]:
    hydro, paths = thinned(), []
    for number, apart in enumerate((False, True)):
        path = folder / str(number) / "float.1"
        modes, sign, lines, forces, parts = (6, 4), (-1.0, 1.0), ["  0.0 4 4 0.0332\n  0.0 6 6 0.0146"], [], []
        for n, w in enumerate(hydro.omega):
            period = 2.0 * np.pi / w
            for j in range(2):
                a, b = hydro.added_mass[j, n] / 1000.0, hydro.damping[j, n] / 1000.0 / w
                lines.append(f" {period:.9E} {modes[j]} {modes[j]} {a:.7E} {b:.7E}")
                for k, beta in enumerate(hydro.headings):
                    for rows, values in ((forces, hydro.excitation), (parts, hydro.froude_krylov)):
                        force = sign[j] * values[j, k, n] / 9810.0
                        numbers = (abs(force), np.degrees(np.angle(force)), force.real, force.imag)
                        row = " ".join(f"{v:.7E}" for v in numbers)
                        rows.append(f" {period:.9E} {beta:.4E} {modes[j]} {row}")
        write_text(path, "\n".join(lines) + "\n")
        write_text(path.with_suffix(".3"), "\n".join(forces) + "\n")
        if apart:
            write_text(path.with_suffix(".3fk"), "\n".join(parts) + "\n")
        paths.append(path)
    return paths


def nemoh(folder: Path) -> list[Path]:
    hydro, sign, slot, results = thinned(), (-1.0, 1.0), (5, 3), folder / "0" / "Results"
    head = ['VARIABLES="w (rad/s)"', *(f'"A 1 {k}" "B 1 {k}"' for k in range(1, 7))]

    def row(w: float, pairs: np.ndarray) -> str:
        return " ".join(f"{v:.9E}" for v in (w, *pairs.ravel()))

    lines = list(head)
    for motion in range(6):
        lines.append(f'Zone t="Motion of body  1 in DoF  {motion + 1}",I={len(hydro.omega)},F=POINT')
        for n, w in enumerate(hydro.omega):
            pairs = np.zeros((6, 2))
            if motion in slot:
                j = slot.index(motion)
                pairs[motion] = hydro.added_mass[j, n], hydro.damping[j, n]
            lines.append(row(w, pairs))
    write_text(results / "RadiationCoefficients.tec", "\n".join(lines) + "\n")
    for name, values in (("ExcitationForce", hydro.excitation), ("FKForce", hydro.froude_krylov)):
        lines = list(head)
        for k, beta in enumerate(hydro.headings):
            lines.append(f'Zone t="Diffraction force - beta = {beta:7.3f} deg",I={len(hydro.omega)},F=POINT')
            for n, w in enumerate(hydro.omega):
                pairs = np.zeros((6, 2))
                for j in range(2):
                    moment = sign[j] * np.conj(values[j, k, n])
                    pairs[slot[j]] = abs(moment), np.degrees(np.angle(moment))
                lines.append(row(w, pairs))
        write_text(results / f"{name}.tec", "\n".join(lines) + "\n")
    write_text(folder / "0" / "Nemoh.cal", "--- Environment ---\n1000.0 ! RHO\n9.81 ! G\n0.7 ! DEPTH\n0. 0. ! XEFF\n")
    return [folder / "0"]


def elevation(path: Path) -> Path:
    time = np.arange(0.0, 40.0, 0.25)
    rows = [f"{t:.2f}, {0.1 * math.sin(3.14 * t) + 0.02 * math.sin(2.0 * t):.5f}" for t in time]
    return write_text(path, "time [s], elevation [m]\n" + "\n".join(rows) + "\n")


def spectrum(path: Path) -> Path:
    sea = gy.SeaState()
    rows = [f"{w:.3f};{float(sea.spectrum(w)):.6g}" for w in np.arange(0.5, 12.0, 0.1)]
    return write_text(path, "omega [rad/s]; S [m2 s]\n" + "\n".join(rows) + "\n")


def waves(path: Path) -> object:
    sea = read_record(path)
    assert 0.0 < sea.hs < 100.0 and 0.0 < sea.wp < 1e3 and sea.duration > 0.0
    gy.realise(device(), sea, 1, min(20.0, math.floor(sea.duration)))
    return sea


def spectral(path: Path) -> object:
    sea = read_spectrum(path)
    assert 0.0 < sea.hs < 100.0 and 0.0 < sea.wp <= 100.0
    gy.realise(device(), sea, 1, 20.0)
    return sea


def copied(source: Path) -> Callable[[Path], list[Path]]:
    def write(folder: Path) -> list[Path]:
        return [write_text(folder / "0" / source.name, source.read_text(encoding="utf-8"))]

    return write


def sets_of_load_angle(folder: Path) -> list[Path]:
    sets = tuned_sets("load_angle")
    path = folder / "0" / "load_angle.json"
    write_sets(path, "load_angle", {name: sets[name] for name in ("all", "gamma5") if name in sets})
    return [path]


def device() -> gy.Plant:
    return _device[0] if _device else _device.append(gy.zhang2017()) or _device[0]


_device: list[gy.Plant] = []

SITE = Site(depth=0.7, stiffness=2945.0)

SCATTERS = (
    "# period: Te\n# source: made up\n"
    "Hs [m] \\ Te [s] \\ %,5,7,9,sum\n0.5,10,20,5,35\n1.5,5,30,30,65\nsum,15,50,35,100\n",
    "hs [m];tp [s];hours\n0,5;5;1000\n0,5;7,5;2000\n1,5;7,5;500\n",
    "# bins: lower\n# occurrence: counts\nTz/Hs,0,1,2\n4,1,2,3\n6,3,4,5\n",
)


def scatter_tables(folder: Path) -> list[Path]:
    return [write_text(folder / str(n) / "scatter.csv", text) for n, text in enumerate(SCATTERS)]


def scatter(path: Path) -> object:
    found = read_scatter(path)
    assert found.bins and 0.0 <= found.missing < 1.0
    assert abs(sum(one.share for one in found.bins) + found.missing - 1.0) < 1e-6
    assert all(0.0 <= one.hs <= 30.0 and 0.0 <= one.period <= 40.0 and 0.0 < one.share <= 1.0 for one in found.bins)
    assert len({(one.hs, one.period) for one in found.bins}) == len(found.bins)
    return found


READERS: dict[str, Reader] = {
    "experiment": Reader(experiments, experiment),
    "task": Reader(lambda folder: [write_text(folder / "0" / "law.toml", TASK)], task),
    "device": Reader(lambda folder: [write_device(folder / "0" / "mine.toml", new_device())], own_device),
    "tuned": Reader(sets_of_load_angle, tuned),
    "table": Reader(copied(table_file("scheduled_lqr")), table),
    "ledger": Reader(copied(LEDGER), read_ledger),
    "log": Reader(tuning_log, log),
    "stored": Reader(stored_run, stored),
    "results": Reader(results_nc("scipy", "NETCDF3_64BIT"), results),
    "results-hdf5": Reader(results_nc("h5netcdf", "NETCDF4"), results),
    "capytaine": Reader(classic, lambda path: sound_table(load(path))),
    "capytaine-hdf5": Reader(hdf5, lambda path: sound_table(load(path))),
    "wamit": Reader(wamit, lambda path: sound_table(read_wamit(path, SITE))),
    "nemoh": Reader(nemoh, lambda path: sound_table(read_nemoh(path, SITE))),
    "records": Reader(fuzz_seas.records, fuzz_seas.record),
    "seas": Reader(fuzz_seas.spectra, fuzz_seas.spectral),
    "elevation": Reader(lambda folder: [elevation(folder / "0" / "waves.csv")], waves),
    "scatter": Reader(scatter_tables, scatter),
    "spectrum": Reader(lambda folder: [spectrum(folder / "0" / "spectrum.csv")], spectral),
}
"""By name; those that end in ``-hdf5`` read through a library in C."""
