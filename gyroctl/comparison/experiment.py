"""An experiment: what is compared on which sea, from a TOML file whose every table is optional."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from gyroctl.comparison.compare import check_length, check_motion_limit
from gyroctl.comparison.items import check_different
from gyroctl.comparison.sea_table import build_sea
from gyroctl.devices import VARIANTS, device, zhang2017
from gyroctl.errors import InputError
from gyroctl.froude import growth
from gyroctl.harness.actuation import Actuators
from gyroctl.harness.code_files import Trust, asked_for, is_file
from gyroctl.harness.device_sets import foreign, foreign_note, own_choice, own_seeds
from gyroctl.harness.plausibility import check_lags, check_parts, remarks
from gyroctl.harness.protocol import Law
from gyroctl.harness.registry import build, registered
from gyroctl.harness.run import Settings
from gyroctl.harness.run_size import DT, run_size
from gyroctl.harness.seed_ledger import refused_for
from gyroctl.harness.sensing import Channel, Sensors
from gyroctl.harness.start import STARTS
from gyroctl.harness.yardstick import BASELINE
from gyroctl.names import check_apart, name_of
from gyroctl.plant import Parameters, Plant
from gyroctl.plant.measurement import CHANNELS
from gyroctl.tables import check_known, checked_table, names_of, number, read_tables, table_of
from gyroctl.waves import Bichromatic, DirectionalSpectrum, ElevationRecord, Regular, Sea, SeaState, SpreadSea
from gyroctl.waves.checks import DURATION_MAX, positive, seed_number, within
from gyroctl.waves.physical import check_headings

TABLES = ("sea", "run", "plant", "laws", "sensors", "actuators")

SEEDS_MAX = 100_000
"""Most realisations of a comparison."""


@dataclass(frozen=True)
class RunTable:
    """The table [run].

    Parameters
    ----------
    duration : float
        Length of each run, blend included. [s]
    dt : float
        Longest Runge-Kutta step. [s]
    blend : float
        Blend from the regular wave at the start; scoring begins after it. [s]
    seeds : tuple of int
        One realisation each.
    motion_limit : float
        Limit of the 98 % motion. [rad]
    start : str
        "locked": on the locked orbit of the regular wave, with the blend; "rest": at rest, scored from the beginning.
    time_limit : float
        Time that a run of a law from elsewhere may take; 0 for as long as what it simulates, a minute at least. [s]
    """

    duration: float = 2000.0
    dt: float = 0.01
    blend: float = 100.0
    seeds: tuple[int, ...] = tuple(range(1, 9))
    motion_limit: float = 0.35
    start: str = "locked"
    time_limit: float = 0.0

    def __post_init__(self) -> None:
        mend = "Give seconds, for example 2000"
        positive("run.duration", within("run.duration", self.duration, 0.0, DURATION_MAX, mend), mend)
        within("run.dt", self.dt, *DT, "Give the longest step in seconds, for example 0.01")
        within("run.blend", self.blend, 0.0, DURATION_MAX, "Give its length in seconds, 0 for none")
        check_motion_limit(self.motion_limit)
        if len(self.seeds) > SEEDS_MAX:
            problem, mend = f"are more than {SEEDS_MAX} realisations", "Give fewer; 64 judge a law"
            raise InputError("run.seeds", len(self.seeds), problem, mend)
        for seed in self.seeds:
            seed_number(seed)


@dataclass(frozen=True)
class Experiment:
    """What is compared on which sea; the defaults are the default experiment.

    Parameters
    ----------
    sea : Sea
        The waves.
    run : RunTable
        Length, step, seeds.
    plant : Plant
        The device.
    laws : mapping of str to Law
        Laws by name.
    sensors, actuators
        Between law and plant.
    source : mapping
        The tables as they were given, for the record.
    """

    sea: Sea
    run: RunTable
    plant: Plant
    laws: Mapping[str, Law]
    sensors: Sensors
    actuators: Actuators
    source: Mapping[str, Any] = field(default_factory=dict)
    kinds: Mapping[str, str] = field(default_factory=dict)
    device_file: Path | None = None

    @property
    def tuning_seeds(self) -> tuple[int, ...]:
        """Seeds on which these laws may not be judged, those of tuned sets beside a user's law or device among them."""
        refused = refused_for(self.laws.values(), self.kinds.values())
        if self.device_file is None:
            return refused
        return tuple(sorted({*refused, *own_seeds(self.device_file, self.kinds.values(), self.plant)}))

    @property
    def foreign(self) -> list[str]:
        """Laws that run with a set of another device, the yardstick aside."""
        kinds = {name: kind for name, kind in self.kinds.items() if name != BASELINE}
        tables = self.source.get("laws", {})
        tunings = {name: tables.get(name, {}).get("tuning") for name in kinds}
        return foreign(kinds, self.plant, self.device_file, tunings)

    @property
    def foreign_note(self) -> str:
        """Sentence on these laws; empty where there are none."""
        strange = self.foreign
        return foreign_note(strange, self.kinds, self.plant, self.device_file) if strange else ""

    @property
    def remarks(self) -> list[str]:
        """What of its numbers is odd, see `gyroctl.harness.plausibility`."""
        return remarks(self.plant, self.sea, self.laws, self.actuators)

    @property
    def settings(self) -> Settings:
        """What is common to all runs."""
        return Settings(self.run.dt, self.run.blend, self.sensors, self.actuators, self.run.start)

    def record(self) -> dict[str, Any]:
        """Tables with every default filled in, safe for JSON."""
        still = self.sea.sea if isinstance(self.sea, SpreadSea) else self.sea
        sea = _plain(dataclasses.asdict(still)) | _plain(dataclasses.asdict(self.sea))
        kinds = {SeaState: "jonswap", Regular: "regular", Bichromatic: "bichromatic"}
        given, limits = self.source.get("sea", {}), dataclasses.asdict(self.actuators)
        notes = list(getattr(self.sea, "notes", ()))
        sea |= {"notes": notes} if notes else {}
        return {
            "sea": {"kind": kinds.get(type(still), given.get("kind", "")), **sea, **_plain(given)},
            "run": {**dataclasses.asdict(self.run), "seeds": list(self.run.seeds)},
            "plant": {"name": self.plant.name, **dataclasses.asdict(self.plant.parameters)},
            "laws": {name: _plain(table) for name, table in self.source.get("laws", {}).items()},
            "sensors": dataclasses.asdict(self.sensors),
            "actuators": {key: value for key, value in limits.items() if key != "length"},
        }


def read_experiment(path: Path | None, quick: bool = False, allow_code: Sequence[str | Path] = ()) -> Experiment:
    """Read an experiment.

    Parameters
    ----------
    path : Path or None
        TOML file; None for the default experiment.
    quick : bool
        Four realisations of 600 s instead of what the file says.
    allow_code : sequence of str or Path
        Files outside the experiment's folder that may run, see `gyroctl.harness.code_files`.

    Raises
    ------
    InputError
        For a missing or unreadable file, an unknown table or key, a value out of range, a law in a file outside the
        experiment's folder that was not asked for; the field is named as in the file.
    """
    if path is None:
        return build_experiment({}, quick)
    return build_experiment(read_tables(path, "experiment"), quick, path.parent, allow_code)


def build_experiment(
    tables: Mapping[str, Any], quick: bool = False, folder: Path = Path(), allow_code: Sequence[str | Path] = ()
) -> Experiment:
    """Build an experiment from tables as read from TOML; paths are relative to `folder`, from where laws may run."""
    check_known("", tables, TABLES)
    table = {name: table_of(tables, name) for name in TABLES}
    file = device_file(table["plant"], folder)
    plant = _plant(table["plant"], folder)
    length = plant.parameters.length_scale
    sea, run = build_sea(table["sea"], folder, length), _run(table["run"], length)
    if isinstance(sea, Regular | ElevationRecord):  # such a sea is the same for every seed
        if "seeds" not in table["run"]:
            run = dataclasses.replace(run, seeds=(1,))
        check_different([""] * len(run.seeds))
    if quick:
        run = dataclasses.replace(run, seeds=run.seeds[:4], duration=max(600.0 * growth("s", length), run.blend))
    if run.start == "locked":
        check_length(run.duration, run.blend, growth("s", length))
    if plant.parameters.wetted == "surface" and isinstance(sea, SpreadSea | DirectionalSpectrum):
        check_headings(sea)
    check_known("actuators", table["actuators"], [name for name in names_of(Actuators) if name != "length"])
    trust = Trust(folder, asked_for(allow_code))
    for name in table["laws"]:
        name_of("laws", name)
    check_apart("laws", table["laws"], registered())
    entries = {name: trust.names(f"laws.{name}", entry) for name, entry in table["laws"].items()}
    kinds = _kinds(entries)
    actuators = Actuators(**(dataclasses.asdict(Actuators().at(length)) if length != 1.0 else {}) | table["actuators"])
    actuators.fit(length)
    check_lags(actuators, sea)
    run_size(run.duration, run.dt, actuators.period, plant.parameters.time_scale)
    return Experiment(
        sea=sea,
        run=run,
        plant=plant,
        laws=_laws(entries, kinds, sea, allow_code, None if file is None else (plant, file)),
        sensors=_sensors(table["sensors"], length),
        actuators=actuators,
        source=tables,
        kinds=kinds,
        device_file=file,
    )


def device_file(table: Mapping[str, Any], folder: Path) -> Path | None:
    """Device file that the table [plant] names, None where it names none."""
    file = table.get("device")
    return folder / file if isinstance(file, str) else None


def _run(table: dict[str, Any], length: float = 1.0) -> RunTable:
    check_known("run", table, names_of(RunTable))
    for name in ("duration", "dt", "blend", "motion_limit", "time_limit"):
        if name in table:
            table[name] = number(f"run.{name}", table[name])
            if table[name] < 0.0 or (table[name] == 0.0 and name not in ("blend", "time_limit")):
                raise InputError(f"run.{name}", table[name], "must be positive", "Leave it out for the default")
    if table.get("start", "locked") not in STARTS:
        raise InputError("run.start", table["start"], "unknown start", f"Choose one of {', '.join(STARTS)}")
    if "seeds" in table:
        seeds = table["seeds"]
        if not isinstance(seeds, list) or not seeds or not all(type(s) is int and s >= 0 for s in seeds):
            problem = "must be a list of whole numbers, zero or positive"
            raise InputError("run.seeds", seeds, problem, "For example seeds = [1, 2, 3]")
        table["seeds"] = tuple(seeds)
    own = {name: getattr(RunTable, name) * growth("s", length) for name in ("duration", "dt", "blend")}
    return RunTable(**(own if length != 1.0 else {}) | table)


def _plant(table: dict[str, Any], folder: Path) -> Plant:
    choices = ("variant", "hydrodynamics", "radiation", "excitation_phase", "device")
    check_known("plant", table, (*choices, *names_of(Parameters)))
    if "device" in table:
        return _own_device(table, choices, folder)
    if "hydrodynamics" in table:
        table["hydrodynamics"] = folder / str(table["hydrodynamics"])
    variant = table.pop("variant", "corrected")
    if not isinstance(variant, str) or variant not in VARIANTS:
        raise InputError("plant.variant", variant, "unknown variant", f"Choose one of {', '.join(VARIANTS)}")
    return zhang2017(variant, **table)


def _own_device(table: dict[str, Any], choices: Sequence[str], folder: Path) -> Plant:
    """Device of a file, with some of its parameters changed; what else it is, its file says."""
    file = table.pop("device")
    if not isinstance(file, str):
        raise InputError(
            "plant.device", file, "must be a path", 'Give the path of a device file, for example "mine.toml"'
        )
    for name in choices:
        if name in table:
            raise InputError(f"plant.{name}", table[name], "is said by the device file", f"Write it into {file}")
    built = device(folder / file)
    return built.replace(**table) if table else built


def _kinds(table: dict[str, Any]) -> dict[str, str]:
    """What each law is built from: a registered name, or "file.py:Name" with its path; all registered ones by default.

    Every law is also told relative to the best constant pair, so that this always takes part.
    """
    if not table:
        return {name: name for name in registered()}
    kinds = {}
    for name, entry in table.items():
        kind = checked_table(f"laws.{name}", entry).get("law", name)
        if not isinstance(kind, str):
            raise InputError(f"laws.{name}.law", kind, "is no name of a law", 'Give a name, or "file.py:Name"')
        if kind == name and is_file(kind):  # a key would not have been looked at as a name of code
            raise InputError(f"laws.{name}", name, "is a file", 'Give the law a name, and law = "file.py:Name" in it')
        kinds[name] = kind
    if table.get(BASELINE):
        problem = "the yardstick is searched for the sea and the device and takes no entries"
        raise InputError(f"laws.{BASELINE}", table[BASELINE], problem, "Give a pair of your own another name")
    return {**kinds, BASELINE: kinds.get(BASELINE, BASELINE)}


OwnDevice = tuple[Plant, Path]
"""A device of one's own and its file."""


def _laws(
    table: dict[str, Any],
    kinds: Mapping[str, str],
    sea: Sea,
    allow_code: Sequence[str | Path],
    own: OwnDevice | None = None,
) -> dict[str, Law]:
    built = {}
    for name, kind in kinds.items():
        parameters = {key: value for key, value in table.get(name, {}).items() if key != "law"}
        built[name] = _law(name, kind, parameters, sea, allow_code, own)
    return built


def _law(
    name: str,
    kind: str,
    parameters: dict[str, Any],
    sea: Sea,
    allow_code: Sequence[str | Path],
    own: OwnDevice | None = None,
) -> Law:
    still = sea.sea if isinstance(sea, SpreadSea) else sea
    if kind == BASELINE and "gamma" not in parameters and isinstance(still, SeaState):
        parameters = {**parameters, "gamma": still.gamma}
    check_parts(kind, parameters, name)
    try:
        if own is not None and kind != BASELINE:
            parameters = own_choice(own[1], kind, own[0], parameters)
        plant = None if own is None else own[0]
        return build(kind, parameters, None, allow_code, plant)  # what data may run is not for data to say
    except InputError as error:
        known = error.field.replace(f"laws.{kind}", f"laws.{name}") if error.field != "law" else f"laws.{name}.law"
        raise InputError(known, error.value, error.problem, error.mend) from None


def _sensors(table: dict[str, Any], length: float = 1.0) -> Sensors:
    ideal = table.pop("ideal", False)
    if not isinstance(ideal, bool):
        raise InputError("sensors.ideal", ideal, "must be true or false", "Leave it out for sensors with noise")
    check_known("sensors", table, CHANNELS)
    sensors = Sensors.ideal() if ideal else Sensors()
    sensors = sensors if length == 1.0 else sensors.at(length)
    changes = {}
    for name, entry in table.items():
        channel = checked_table(f"sensors.{name}", entry)
        check_known(f"sensors.{name}", channel, names_of(Channel))
        changes[name] = dataclasses.replace(getattr(sensors, name), **channel)
    return dataclasses.replace(sensors, **changes)


def _plain(table: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in table.items() if isinstance(value, str | int | float | bool | list)}
