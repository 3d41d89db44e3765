"""Blocks of the page on margins: those of constant controls and of a law, in one wave."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from gyroctl.reports.wording import number
from result_blocks.source import caption, result, states, table

UNITS = {"cg": "Nms", "height": "m", "frequency_down": "rad/s", "frequency_up": "rad/s"}
NAMES = {
    "cg": "cg headroom",
    "height": "height headroom",
    "frequency_down": "frequency, lower end",
    "frequency_up": "frequency, upper end",
}
ANGLES = ("phi1", "phi3", "psi")


def orbit() -> str:
    """The orbit of the constant controls and its slow modes, and the one at a small coupling."""
    found, loose = result("margins"), result("margins_loose")
    told = []
    for one in (found, loose):
        controls, shape = one["request"]["controls"], one["orbit"]
        modes = ", ".join(_mode(mode) for mode in shape["modes"][:2])
        share = f"; the load takes {100.0 * shape['lock_share']:.1f} % of what the wave can pull, "
        share += f"load angle {math.degrees(shape['load_angle_rad']):.1f}°"
        told.append(
            f"cc = {controls['cc_nms']:g}, cg = {controls['cg_nms']:g} Nms: {shape['status']}; {modes}"
            + (share if shape["status"] == "stable" else "; no margin, however small the load")
        )
    wave = found["request"]["wave"]
    head = f"In a wave of {wave['height_m']:g} m at {wave['wp_rad_s']:g} rad/s:\n\n"
    return head + "\n".join(f"- {line}." for line in told) + f"\n\n{caption('margins', 'margins_loose')}"


def _mode(mode: Mapping[str, Any]) -> str:
    time, period = mode["decay_time_s"], mode["period_s"]
    cycle = f" with a period of {number(period, 2)} s" if period else ""
    return f"the {mode['name']} mode{cycle} {'falls' if time > 0 else 'grows'} by e in {number(abs(time))} s"


def sizes() -> str:
    """Headroom, basin and smallest shocks of the constant controls and of the law."""
    found = result("margins")
    both = found["constant_controls"], found["law"]
    lines = [["power"] + [f"{number(one['power_w'])} W" for one in both]]
    lines += [[name, *(_room(one["headroom"][key], UNITS[key]) for one in both)] for key, name in NAMES.items()]
    for i, basin in enumerate(both[0]["basin_stability"]):
        name = f"basin, disturbances of {100.0 * basin['size']:g} %"
        lines.append([name, *(_basin(one["basin_stability"][i]) for one in both)])
    for i, shock in enumerate(both[0]["smallest_shocks"]):
        sizes = [one["smallest_shocks"][i] for one in both]
        if any(size["size"] is not None for size in sizes):
            sign = "+" if shock["sign"] > 0 else "−"
            lines.append([f"smallest shock of {shock['state']}, {sign}", *(_shock(size) for size in sizes)])
    quiet = [
        f"{shock['state']} {'+' if shock['sign'] > 0 else '−'}{number(shock['tried_up_to'], 2)}"
        for i, shock in enumerate(both[0]["smallest_shocks"])
        if all(one["smallest_shocks"][i]["size"] is None for one in both)
    ]
    heads = ("margin", "constant controls", f"law `{found['request']['law']['name']}`")
    rest = f"No shock breaks either lock along {', '.join(quiet)} [rad, rad/s], the largest that were tried."
    return "\n\n".join([table(heads, lines, 3), rest, caption("margins")])


def _room(room: Mapping[str, Any], unit: str) -> str:
    if room["limit"] is None:
        return "none found in range"
    factor = unit == "Nms" and room["value"] == 1.0
    to = f"to {number(room['limit'])} times" if factor else f"{number(room['value'])} to {number(room['limit'])} {unit}"
    far = f"{room['decibel']:.1f} dB" if unit != "rad/s" else f"{100.0 * (room['limit'] / room['value'] - 1.0):+.1f} %"
    return f"{to} ({far}), {room['ending']}"


def _basin(basin: Mapping[str, Any]) -> str:
    low, high = (100.0 * end for end in basin["ci95"])
    return f"{100.0 * basin['share']:.1f} % ({low:.1f} to {high:.1f} %) of {basin['runs']} lock again"


def _shock(shock: Mapping[str, Any]) -> str:
    unit = "rad" if shock["state"] in ANGLES else "rad/s"
    if shock["size"] is None:
        return f"none up to {number(shock['tried_up_to'], 2)} {unit}"
    return f"{number(shock['size'])} {unit}"


def channels() -> str:
    """Gain, phase, delay and disk margin of the law at each control and sensor."""
    found = result("margins")
    lines = []
    for name, one in found["law"]["linear"]["channels"].items():
        low, high = (("∞" if end is None else number(end)) for end in one["gain"])
        sure = " to ".join("∞" if end is None else number(end, 2) for end in one["guaranteed_gain"])
        delay = "none found" if one["delay_s"] is None else f"{number(one['delay_s'], 2)} s"
        phase = f"{one['phase_deg']:.0f}°"
        disk = number(one["disk_alpha"])
        lines.append(
            [f"`{name}`", f"{low} to {high}", phase, delay, disk, f"{sure}, or {one['guaranteed_phase_deg']:.0f}°"]
        )
    heads = ("at", "gain", "phase", "delay", "disk margin α", "what α guarantees")
    return f"{table(heads, lines)}\n\n{caption('margins')}"


def water() -> str:
    """What each choice beyond the linear model moves."""
    found = result("margins_water")["water"]
    linear, lines = found["choices"]["linear"], []
    for name, one in found["choices"].items():
        ends = "" if one["cg_ending"] == "fold" else f", stable to {number(one['cg_end'])}"
        least = "none met" if one["cc_border"] is None else number(one["cc_border"])
        lines.append(
            [
                name,
                f"{one['multiplier']:.4f}",
                f"{number(one['rate'])} ({100.0 * one['damping_ratio']:.2g} %)",
                f"{number(one['fold'], 4)} ({100.0 * (one['fold'] / linear['fold'] - 1.0):+.1f} %){ends}",
                number(one["d1_border"]),
                least,
                "none met" if one["wp_end"] is None else f"{number(one['wp_end'])}, {one['wp_ending']}",
            ]
        )
    heads = ("choice", "largest multiplier", "rate of φ1 [1/s] (of critical)", "fold in cg [Nms] (shift)")
    heads += ("d1 that lock needs [Nms/rad]", "least cc [Nms]", "lowest wp [rad/s]")
    return "\n\n".join([table(heads, lines), found["words"], caption("margins_water")])


def drag() -> str:
    """The drag that takes the place of the hinge damping, counted in a sea."""
    found = result("margins_water")["water"]
    sea, lock = found["sea"], found["drag_that_locks"]
    lines = [
        [
            number(run["drag"]),
            f"{run['locked']} of {run['runs']} ({run['ci95'][0]:.2f} to {run['ci95'][1]:.2f})",
            f"{round(run['in_step'] * run['runs'])} of {run['runs']}",
            number(run["phi1_p98"], 2),
        ]
        for run in sea["runs"]
    ]
    told = (
        f"By the multipliers in the regular wave: Cd = {number(lock['drag'])}. In seas of gamma {sea['gamma']:g}, "
        f"Hs {number(sea['hs_m'])} m, {sea['duration_s']:g} s, seeds {states(sea['seed_states'])}, with the same pair:"
    )
    heads = ("Cd", "locked (95 %)", "in step", "98 % of φ1, median [rad]")
    return "\n\n".join([told, table(heads, lines, 0), caption("margins_water")])


BLOCKS: Mapping[str, Callable[[], str]] = {
    "margins-orbit": orbit,
    "margins-sizes": sizes,
    "margins-channels": channels,
    "margins-water": water,
    "margins-drag": drag,
}
"""Blocks of the pages: each a function from committed results to markdown."""
