"""What all foreign text formats share: how scattered rows become a table, and what is said about it."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from gyroctl.errors import InputError
from gyroctl.hydrodynamics.directions import repeated
from gyroctl.hydrodynamics.fortran_numbers import MEND, lines_of
from gyroctl.hydrodynamics.kramers_kronig import added_mass_inf
from gyroctl.hydrodynamics.moving import Frame, named
from gyroctl.hydrodynamics.site import SAME, Site
from gyroctl.hydrodynamics.table import DOFS, FEWEST, Complexes, Floats, Hydrodynamics, coupling, diagonal
from gyroctl.reading import existing as existing_file

__all__ = ["TABLE_MAX", "Reading", "Site", "assembled", "existing", "lines_of", "mode_of", "unlike"]

TABLE_MAX = 1_000_000
"""Most pairs of frequency and heading: scattered rows of each would fill the memory."""

SHOWN = 6
"""Frequencies or places that a note lists."""

NOTES = 20
"""Notes on single rows that are kept."""

SHARE = 0.5
"""Part of the frequencies that may be left out as unreadable."""


def existing(path: Path) -> Path:
    """Return the path of a file that exists."""
    return existing_file("path", path, MEND)


def mode_of(value: float) -> int:
    """Number of a mode as a row of results has it, 0 for what is no whole number."""
    return int(value) if abs(value) < 1e6 and value == int(value) else 0


def unlike(a: complex, b: complex) -> bool:
    """Whether a value that is given twice differs."""
    return bool(abs(a - b) > SAME * max(abs(a), abs(b)))


Matrices = dict[float, Floats]
"""Added mass and damping (2, n, n) at each frequency. [rad/s]"""

Forces = dict[tuple[float, float], Complexes]
"""Forces and moments (n,) at each frequency [rad/s] and heading [deg]."""


@dataclass
class Reading:
    """What a reader has found, in the modes and coordinates of the run; nan where it found nothing.

    Parameters
    ----------
    site : Site
        What was given by hand.
    frame : Frame
        How the modes of the run make up ours.
    source : str
        Names the files.
    """

    site: Site
    frame: Frame
    source: str
    matrices: Matrices = field(default_factory=dict)
    forces: Forces = field(default_factory=dict)
    undisturbed: Forces | None = None
    infinite: Floats = field(default_factory=lambda: np.full((0, 0), np.nan))
    zero: Floats = field(default_factory=lambda: np.full((0, 0), np.nan))
    restoring: Floats | None = None
    spoiled: dict[float, list[str]] = field(default_factory=dict)
    """Places of what cannot be read, by frequency. [rad/s]"""
    told: dict[str, str] = field(default_factory=dict)
    """What was read how: units, point, origin of single numbers."""
    notes: list[str] = field(default_factory=list)
    rho: float = 1000.0
    g: float = 9.81
    depth: float = float("inf")

    def __post_init__(self) -> None:
        """Nothing is known of the limits yet."""
        n = len(self.frame.wanted)
        self.infinite, self.zero = np.full((2, n, n), np.nan)

    def note(self, text: str) -> None:
        """Keep a note, of many alike the first ones."""
        if len(self.notes) < NOTES:
            self.notes.append(text)


def assembled(reading: Reading) -> Hydrodynamics:
    """Put rows in any order onto one frequency axis, which all kinds of results must share.

    Raises
    ------
    InputError
        Where values are missing, or too few frequencies are left.
    """
    source, site = reading.source, reading.site
    every = np.array(sorted(reading.matrices))
    omega = _without_spoiled(reading, every)
    headings = np.array(sorted({beta for _, beta in reading.forces}))
    if len(every) * max(len(headings), 1) > TABLE_MAX:
        problem, mend = f"has more than {TABLE_MAX} pairs of frequency and heading", "Leave some of them out"
        raise InputError(source, f"{len(every)} and {len(headings)}", problem, mend)
    if len(omega) < FEWEST or omega[0] <= 0.0 or not np.isfinite(omega[-1]):
        problem = f"must have at least {FEWEST} positive frequencies"
        raise InputError(source, len(omega), problem, "Compute more of them")
    _unmatched(reading, every)
    table = np.array([reading.matrices[w] for w in omega])
    excitation = _tabled(reading.forces, omega, headings, len(reading.frame.wanted))
    part = reading.undisturbed
    fraction = None if part is None else _tabled(part, omega, headings, len(reading.frame.wanted))
    _check_complete(reading, omega, headings, table, [excitation] + ([] if fraction is None else [fraction]))
    headings, excitation, fraction = _once_around(source, headings, excitation, fraction)
    table = np.nan_to_num(table)  # an absent coupling term is zero
    frame, depth, g = reading.frame, reading.depth, reading.g
    added, damping = frame.matrix(table[:, 0]), frame.matrix(table[:, 1])
    excitation = frame.moments(excitation, omega, headings, depth, g)
    fraction = None if fraction is None else frame.moments(fraction, omega, headings, depth, g)
    told = dict(reading.told)
    at_infinity = infinite_of(limit(frame, reading.infinite), omega, added, damping, told)
    at_zero = limit(frame, reading.zero)
    told["coupling"] = dropped(added, damping)
    told["point"] = frame.words
    stiffness = stiffness_of(site, frame, reading.restoring, told)
    return Hydrodynamics(
        omega=omega,
        added_mass=diagonal(added),
        damping=diagonal(damping),
        added_mass_inf=at_infinity,
        excitation=excitation,
        headings=headings,
        stiffness=stiffness,
        depth=depth,
        rho=reading.rho,
        g=g,
        coupling=coupling(added, damping),
        provenance={"source": source, "import": {**told, "notes": list(reading.notes)}},
        froude_krylov=fraction,
        diffraction=None if fraction is None else excitation - fraction,
        added_mass_zero=None if np.isnan(at_zero).all() else at_zero,
    )


def limit(frame: Frame, values: Floats) -> Floats:
    """Added mass (2,) of our rotations in a limit of the frequency, nan where a mode lacks it."""
    known = np.where(np.isnan(values) & ~np.eye(len(values), dtype=bool), 0.0, values)
    out = np.empty(2)
    for j, row in enumerate(frame.turn):
        used = np.flatnonzero(row)
        out[j] = row[used] @ known[np.ix_(used, used)] @ row[used]
    return out


def infinite_of(rows: Floats, omega: Floats, added: Floats, damping: Floats, told: dict[str, str]) -> Floats:
    """Added mass at infinite frequency (2,): from the rows of it, else by Kramers-Kronig; `told` says which."""
    out = np.array(rows, dtype=np.float64)
    for j, name in enumerate(DOFS):
        key = f"added_mass_inf of {name}"
        if np.isfinite(out[j]):
            told.setdefault(key, "row of infinite frequency")
            continue
        out[j], spread = added_mass_inf(omega, added[:, j, j], damping[:, j, j])
        told[key] = f"Kramers-Kronig; its estimates over the band depart by {100.0 * spread:.3g} %"
    return out


def dropped(added: Floats, damping: Floats) -> str:
    """Tell what of the full matrices (n, 2, 2) a pair of single rotations leaves out."""
    skew = 0.0
    for values in (added, damping):
        size = float(np.max(np.abs(values)))
        gap = float(np.max(np.abs(values[:, 0, 1] - values[:, 1, 0])))
        skew = max(skew, gap / size if size > 0.0 else 0.0)
    return f"coupling {coupling(added, damping):.2g} of the own values dropped, asymmetry {skew:.2g}"


def stiffness_of(site: Site, frame: Frame, restoring: Floats | None, told: dict[str, str]) -> float:
    """k3 of phi3: as given, else from the restoring matrix (6, 6), else 0, which stands for unknown.

    Raises
    ------
    InputError
        Where the matrix has a negative one.
    """
    if site.stiffness is not None:
        told["stiffness"] = "--stiffness"
        return site.stiffness
    if restoring is None:
        told["stiffness"] = "unknown: give --stiffness, or k3 of the device"
        return 0.0
    used = [m - 1 for m in frame.wanted]
    if max(used) > 5:
        told["stiffness"] = "unknown: the restoring matrix has rigid modes alone"
        return 0.0
    row = frame.turn[1]
    value = float(row @ restoring[np.ix_(used, used)] @ row)
    if value < 0.0:
        problem = "is negative: it must be that of buoyancy alone, without the weight"
        raise InputError("hydro.stiffness", value, problem, "Give it with --stiffness")
    moved = ", moved to the hinge as of a body in balance" if frame.moved else ""
    told["stiffness"] = f"{told.pop('restoring', 'restoring matrix of the file')}{moved}"
    return value


def _without_spoiled(reading: Reading, every: Floats) -> Floats:
    """Frequencies whose values can all be read; the others are noted."""
    bad = {w: places for w, places in reading.spoiled.items() if places}
    gone = _near(every, np.array(sorted(bad)))
    if not gone.any():
        return every
    where = list(dict.fromkeys(place for places in bad.values() for place in places))
    named_ = ", ".join(f"{w:.4g}" for w in every[gone][:SHOWN]) + (", .." if gone.sum() > SHOWN else "")
    text = f"left out {named_} rad/s: no number in {', '.join(where[:SHOWN])}" + (", .." if len(where) > SHOWN else "")
    if gone.sum() > SHARE * len(every) or len(every) - gone.sum() < FEWEST:
        problem = f"cannot be read at {named_} rad/s ({', '.join(where[:SHOWN])})"
        raise InputError(reading.source, int(gone.sum()), problem, "Compute those frequencies again")
    reading.notes.append(text)
    return np.asarray(every[~gone], dtype=np.float64)


def _near(values: Floats, others: Floats) -> np.ndarray:
    """Whether each of rising values is among other rising ones, (n,) bool."""
    low, high = (others.searchsorted(values * (1.0 + sign * SAME)) for sign in (-1.0, 1.0))
    return np.asarray(low < high)


def _unmatched(reading: Reading, every: Floats) -> None:
    """Note frequencies of the excitation that the radiation lacks."""
    own = np.array(sorted({w for w, _ in reading.forces}))
    rest = own[~_near(own, every)]
    if len(rest):
        named_ = ", ".join(f"{w:.4g}" for w in rest[:SHOWN]) + (", .." if len(rest) > SHOWN else "")
        reading.notes.append(f"excitation at {named_} rad/s is not used: no radiation there")


def _check_complete(reading: Reading, omega: Floats, headings: Floats, table: Floats, forces: list[Complexes]) -> None:
    """Refuse a table with holes, by name."""
    mend = "Compute radiation and excitation at the same frequencies, or set the two modes"
    modes = reading.site.chosen
    lack = "lacks values of these modes at some frequency or heading"
    if not len(headings):
        raise InputError(reading.source, modes, lack, mend)
    own = np.arange(table.shape[-1])
    radiation = np.isfinite(table[:, :, own, own]).all(axis=1)
    where = f"modes {named(reading.frame.wanted)}"
    if not radiation.all():
        n, m = np.argwhere(~radiation)[0]
        mode = named((reading.frame.wanted[m],))
        problem = f"{lack}: radiation of mode {mode} at {omega[n]:.4g} rad/s"
        raise InputError(reading.source, modes, problem, mend)
    for force in forces:
        holes = np.argwhere(~np.isfinite(force))
        if len(holes):
            m, h, n = holes[0]
            problem = f"{lack}: excitation at {omega[n]:.4g} rad/s, heading {headings[h]:g} deg, of {where}"
            raise InputError(reading.source, modes, problem, mend)


def _once_around(
    source: str, headings: Floats, excitation: Complexes, part: Complexes | None
) -> tuple[Floats, Complexes, Complexes | None]:
    """Headings without those that repeat a direction, as 360 does 0; what they hold must be the same."""
    twice = repeated(headings)
    for kept, again in twice:
        size = float(np.max(np.abs(excitation)))
        if float(np.max(np.abs(excitation[:, kept] - excitation[:, again]))) > 1e-4 * size:
            problem = f"is the direction of {headings[kept]:g} deg, with other moments"
            raise InputError(f"{source}: heading", float(headings[again]), problem, "Leave one of them out")
    left = [k for k in range(len(headings)) if k not in {again for _, again in twice}]
    return headings[left], excitation[:, left], None if part is None else part[:, left]


def _tabled(forces: Forces, omega: Floats, headings: Floats, modes: int) -> Complexes:
    """Forces (n, heading, omega), nan where the results have none."""
    out = np.full((modes, len(headings), len(omega)), np.nan + 0j)
    for (w, beta), moment in forces.items():
        near = omega.searchsorted([w * (1.0 - SAME), w * (1.0 + SAME)])
        at = np.searchsorted(headings, beta)
        if near[0] < near[1] and at < len(headings) and headings[at] == beta:
            out[:, at, near[0]] = moment
    return out
