"""The check of a device: findings, what they mean, a picture, written to a folder."""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

from gyroctl.devices.file import device
from gyroctl.devices.identity import changes_in_words, device_record
from gyroctl.errors import InputError
from gyroctl.plant import Plant
from gyroctl.provenance import made
from gyroctl.studies.device.assumed import assumed
from gyroctl.studies.device.bodies import Finding, bodies
from gyroctl.studies.device.draw import draw
from gyroctl.studies.device.motion import Lock, Oscillation, Slip, lock, oscillations, slip
from gyroctl.studies.style import save, styled
from gyroctl.waves.checks import positive
from gyroctl.waves.excitation import band
from gyroctl.writing import write_json


class DeviceReport(NamedTuple):
    """What was found."""

    plant: Plant
    findings: list[Finding]
    lines: list[str]

    @property
    def plausible(self) -> bool:
        """Whether nothing was found that no device can be."""
        return all(finding.passed for finding in self.findings)


def device_report(
    file: Path, out: Path | None = None, height: float | None = None, wp: float | None = None
) -> DeviceReport:
    """Check a device file.

    Parameters
    ----------
    file : Path
        See ``gyroctl device new``.
    out : Path, optional
        Folder for ``device.json``, ``geometry.png``, ``.svg`` and ``.pdf``.
    height, wp : float, optional
        Regular wave of the lock [m, rad/s]; by default 0.2 m at 3.14 rad/s at the size of Table 1.

    Raises
    ------
    InputError
        What the file refuses; fields ``height``, ``wp`` for no wave.
    """
    if out is not None and out.exists() and not out.is_dir():
        raise InputError("out", str(out), "is a file, not a folder", "Give another folder")
    plant = device(file)
    if height is not None:
        positive("height", height, "Give the wave height in metres, for example 0.2")
    if wp is not None:
        low, high = band(plant.excitation)
        if not low <= positive("wp", wp, "Give the frequency in rad/s") <= high:
            mend = f"Give a frequency from {low:g} to {high:g} rad/s"
            raise InputError("wp", wp, "the excitation is not known at this frequency", mend)
    moves, held, slips = oscillations(plant), lock(plant, height, wp), slip(plant)
    findings = [*bodies(plant), *_motions(plant, moves, held, slips), *assumed(plant)]
    lines = [f"Device: {plant.name}", *_changed(plant)]
    for finding in findings:
        mark = "ok  " if finding.passed else "FAIL"
        lines.append(f"{mark}  {finding.name}: {finding.found}{'' if finding.passed else f'. {finding.mend}.'}")
    report = DeviceReport(plant, findings, lines)
    if out is not None:
        _write(report, out, moves, held, slips)
    return report


def _changed(plant: Plant) -> list[str]:
    words = changes_in_words(plant, most=100)
    return [f"Against Table 1: {', '.join(words)}" if words else "Against Table 1: nothing changed"]


def _motions(plant: Plant, moves: dict[str, Oscillation | None], held: Lock | None, slips: Slip) -> list[Finding]:
    found = []
    low, high = band(plant.excitation)
    for name, one in moves.items():
        if one is None:
            found.append(Finding(f"natural frequency of {name}", "overdamped: it creeps back"))
            continue
        words = (
            f"{one.frequency:.3g} rad/s ({2.0 * math.pi / one.frequency:.3g} s), {one.damping:.2%} of critical damping"
        )
        mend = "Its damping is negative: the radiation fit or a stiffness feeds the motion"
        inside = "" if low <= one.frequency <= high else f"; the table of moments knows {low:.3g} to {high:.3g} rad/s"
        found.append(Finding(f"natural frequency of {name}", words + inside, one.damping > 0.0, mend))
    if held is None:
        mend = "Give another wave with --height and --wp, or correct the moments of the database"
        found.append(Finding("lock", "the wave pulls the ring in neither sense", False, mend))
    else:
        words = f"up to cg = {held.capacity:.3g} Nms, {held.power:.3g} W, in a regular wave of {held.height:.3g} m at "
        sense = "" if held.sense == 1 else "; it turns in the negative sense"
        found.append(Finding("lock capacity", f"{words}{held.wp:.3g} rad/s, by harmonic balance{sense}"))
    words = f"{slips.rate:.3g}/s at cc = {slips.coupling:.3g} Nms; steps of {plant.step:.3g} s allow cc up to "
    found.append(Finding("slip rate", f"{words}{slips.largest:.3g} Nms"))
    return found


def _write(
    report: DeviceReport, out: Path, moves: dict[str, Oscillation | None], held: Lock | None, slips: Slip
) -> None:
    out.mkdir(parents=True, exist_ok=True)
    content = {
        **made(),
        "device": device_record(report.plant),
        "plausible": report.plausible,
        "findings": [finding._asdict() for finding in report.findings],
        "natural_frequencies": {name: None if one is None else one._asdict() for name, one in moves.items()},
        "lock": None if held is None else held._asdict(),
        "slip": slips._asdict(),
    }
    with styled(formulas=False):
        save(draw(report.plant), out / "geometry.png")
    write_json(out / "device.json", content)
