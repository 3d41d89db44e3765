"""Blocks from the studies of start-up and forecast, of the paper's statements and of the hydrodynamic database."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from gyroctl.reports.wording import number, watts
from result_blocks.source import caption, ranged, result, states, table

SHOWN = ("true moments", "sensors")
"""What the table of the forecast shows of what one may be made from; the picture shows all."""


SHOWN_IN = {
    "Hydrodynamics": " (figure 8)",
    "Irregular sea, γ = 5": " (figures 10 to 12 and 15)",
    "Irregular sea, γ = 50": " (figures 13 and 15)",
    "Irregular sea, γ = 1": " (figures 14 and 15)",
}
"""Figures that show what a group of statements is about."""


def _spread(spread: Mapping[str, Any], digits: int = 0) -> str:
    return ", ".join("never" if spread[key] is None else f"{spread[key]:.{digits}f}" for key in ("median", "q95"))


def _share(case: Mapping[str, Any], of: str) -> str:
    low, high = case["ci95"]
    return f"{case['locked']} of {case[of]} ({low:.3f} to {high:.3f})"


def _motion(case: Mapping[str, Any]) -> list[str]:
    return [
        _spread(case["phi1_p98_rad"], 2),
        f"{number(case['phi1_max_rad']['worst'], 2)}, {number(case['phi3_max_rad']['worst'], 2)}",
        f"{100.0 * case['outside_share']:.1f} %",
    ]


MOTION = ("98 % of φ1 locked [rad]", "largest φ1, φ3 [rad]", "beyond 0.3 rad")


def startup_rest() -> str:
    """From rest."""
    found = result("startup")
    lines = [
        [
            f"`{law}`",
            _share(case, "runs"),
            f"{number(case['turns_kept'])}, {number(case['cycle_slips'], 2)}",
            _spread(case["locked_after_s"]),
            _spread(case["motor_j"]),
            _spread(case["payback_s"]),
            f"{number(case['mean_power_w'])} ({number(case['net_power_w'])}, {watts(case['stored_w'])})",
            f"{100.0 * case['availability']:.1f} %",
            *_motion(case),
        ]
        for law, case in found["rest"].items()
    ]
    heads = ("wrapped law", "locked within 200 s and to the end (95 %)", "turns kept, slips per 1000 waves")
    heads += ("lock after [s]", "motor [J]", "net energy positive after [s]", "power [W] (generated net, stored)")
    told = f"From rest, {found['durations_s'][0]:g} s, gamma {found['sea']['gamma']:g}, Hs {found['sea']['hs_m']:g} m"
    return "\n\n".join([f"{told}; {_runs(found)}", table((*heads, "availability", *MOTION), lines), caption("startup")])


def startup_loss() -> str:
    """Through a forced loss."""
    found = result("startup")
    lines = [
        [
            f"`{law}`",
            f"{case['lost']} of {case['runs']}",
            _share(case, "lost"),
            f"{number(case['turns_kept'])}, {number(case['cycle_slips'], 2)}",
            *(_spread(case[key]) for key in ("locked_after_s", "fault_s", "motor_j")),
            f"{number(case['mean_power_w'])} ({watts(case['stored_w'])})",
            *_motion(case),
        ]
        for law, case in found["loss"].items()
    ]
    heads = (
        "wrapped law",
        "lost",
        "locked again within 120 s and to the end (95 %)",
        "turns kept, slips per 1000 waves",
    )
    heads += ("lock after [s]", "fault [s]", "motor [J]", "power [W] (stored)")
    told = (
        "Forced loss: the generator is stuck at its limit from 400 s on, for 20 s at least and until the ring stalls; "
        f"{found['durations_s'][1]:g} s, times from the end of the fault"
    )
    return "\n\n".join([f"{told}; {_runs(found)}", table((*heads, *MOTION), lines), caption("startup")])


def _runs(found: Mapping[str, Any]) -> str:
    return (
        f"seeds {states(found['seed_states'])}. Median and 95 % quantile over the runs, of the motion the largest of "
        "any run. In step is not judged here, since no constant pair starts the device: turns kept and slips say it."
    )


def forecast() -> str:
    """Error of the forecast against the lead, and at the sample."""
    found = result("forecast")
    lines = []
    for sea, sources in found["error"].items():
        for source in SHOWN:
            for moment, errors in zip(("Me1", "Me3"), sources[source], strict=True):
                lines.append([sea, source, moment, *(number(error, 2) for error in errors)])
    for case, sources in found["error_in_real_water"].items():
        for moment, errors in zip(("Me1", "Me3"), sources["sensors"], strict=True):
            lines.append([case, "sensors", moment, *(number(error, 2) for error in errors)])
    heads = ("sea", "from", "moment", *(f"{lead:g} s" for lead in found["leads_s"]))
    told = (
        f"{len(found['seeds'])} realisations of {found['duration_s']:g} s, seeds {states(found['seed_states'])}, moved "
        f"by the law `{found['law']}`. At the sample itself the estimator's error is {_now(found, 'estimator')} of the "
        f"variance, that of `memory.now` {_now(found, 'smoothed')}. {_known(found)}"
    )
    return "\n\n".join([table(heads, lines, 3), told, _in_real_water(found), caption("forecast")])


def _in_real_water(found: Mapping[str, Any]) -> str:
    """The error with the device's own model, with its interval over the realisations."""
    case = "gamma 5, realistic device, realistic design"
    leads, sources = found["leads_s"], found["error_in_real_water"][case]
    told = []
    for lead in (1.0, 2.0):
        at = leads.index(lead)
        errors = [
            f"{source[at]:.3f} ± {half[at]:.3f}"
            for source, half in zip(sources["sensors"], found["half_width"][case], strict=True)
        ]
        known = [f"{source[at]:.3f}" for source in sources["sensors, sea known"]]
        told.append(
            f"at {lead:g} s {errors[0]} (Me1) and {errors[1]} (Me3), with the spectrum known {known[0]} and {known[1]}"
        )
    return f"In real water, from the sensors, mean over the realisations and its 95 % interval: {'; '.join(told)}."


def forecast_spread() -> str:
    """Share of the errors within the deviations that the forecast says of itself."""
    found = result("forecast")
    lines = [
        [
            case,
            f"Me{moment}",
            *(" / ".join(f"{share:.2f}" for share in shares) for shares in zip(one, two, strict=True)),
        ]
        for case, within in found["within_its_deviations"].items()
        for moment, one, two in zip((1, 3), within["one"], within["two"], strict=True)
    ]
    heads = ("sea, from sensors", "moment", *(f"{lead:g} s" for lead in found["leads_s"]))
    return "\n\n".join([table(heads, lines, 2), caption("forecast")])


def _now(found: Mapping[str, Any], which: str) -> str:
    each = [seas[which] for seas in found["error_at_the_sample"].values()]
    told = []
    for j, name in enumerate(("Me1", "Me3")):
        values: Sequence[float] = [100.0 * one[j] for one in each]
        told.append(f"{number(min(values), 2)} to {number(max(values), 2)} % ({name})")
    return " and ".join(told)


def _known(found: Mapping[str, Any]) -> str:
    gains = []
    for sources in found["error"].values():
        learnt, known = sources["sensors"], sources["sensors, sea known"]
        gains += [
            100.0 * (1.0 - k / e)
            for learnt_row, known_row in zip(learnt, known, strict=True)
            for e, k in zip(learnt_row, known_row, strict=True)
            if e is not None and k is not None
        ]
    return (
        f"Knowing the spectrum instead of learning it changes the error from the sensors by {-max(gains):+.1f} to "
        f"{-min(gains):+.1f} %."
    )


def statements() -> str:
    """How many of the paper's statements agree."""
    found = result("statements")
    forms = {"corrected": "the corrected model", "paper": "the model as printed"}
    told = "; ".join(
        f"with {forms[form]} {', '.join(f'{count} {verdict}' for verdict, count in verdicts.items())}"
        for form, verdicts in found["tally"].items()
    )
    seeds = f"{len(found['seeds'])} realisations of {found['duration_s']:g} s, seeds {states(found['seed_states'])}"
    return f"Of {len(found['statements'])} statements of the paper: {told} ({seeds}).\n\n{caption('statements')}"


def statements_table() -> str:
    """What the paper states beside what is found, one by one, by what the figures show."""
    found = result("statements")
    forms = {"corrected": "corrected", "paper": "as printed"}
    parts = []
    for group in dict.fromkeys(one["group"] for one in found["statements"]):
        members = [one for one in found["statements"] if one["group"] == group]
        lines = [
            [one["paper"], one["measure"], *(part for form in forms for part in _stated(one["results"][form]))]
            for one in members
        ]
        heads = ("the paper", "measured", *(part for word in forms.values() for part in (word, "")))
        parts.append(f"**{group}**{SHOWN_IN.get(group, '')}\n\n{table(heads, lines)}")
    return "\n\n".join([*parts, caption("statements")])


def _stated(found: Mapping[str, Any]) -> list[str]:
    """A number with interval and unit, and the verdict."""
    unit = f" {found['unit']}" if found["unit"] else ""
    if found["value"] is None:
        return ["–", found["verdict"]]
    spread = "" if found["low"] is None else f" ({number(found['low'])} to {number(found['high'])})"
    return [f"{number(found['value'], 3 if spread else 4)}{spread}{unit}", found["verdict"]]


def hydro() -> str:
    """The database against the paper and against itself."""
    found = result("hydro")
    lines = [
        [
            row["name"],
            f"{number(row['value'], 4)} {row['unit']}".removesuffix(" 1"),
            number(row["reference"], 4),
            number(row["tolerance"], 2),
            "yes" if abs(row["value"] - row["reference"]) <= row["tolerance"] else "no",
        ]
        for row in found["rows"]
    ]
    return f"{table(('check', 'value', 'reference', 'tolerance', 'holds'), lines)}\n\n{caption('hydro')}"


def connection() -> str:
    """Each device at its best, sea by sea, and the answer in words."""
    found = result("connection")
    lines = [
        [
            f"{case['gamma']:g}",
            f"{case['hs']:g}",
            *_controls(case["magnetic"], True),
            *_controls(case["rigid"], False),
            ranged(case["gain"]),
            number(case["p_holm"], 2),
            case["words"],
        ]
        for case in found["at_best"]
    ]
    with_it = ("with the coupling: cc, cg [Nms]", "held lock; turns kept", "power [W]")
    without = ("rigid: cg [Nms]", "held lock; turns kept", "power [W]")
    heads = ("gamma", "Hs [m]", *with_it, *without, "with less without [W]", "p (Holm)", "power is")
    told = (
        f"Runs of {found['duration_s']:g} s, seeds {states(found['seed_states'])}, the same waves for both devices. "
        f"Controls by a search of {found['budget_s']:g} s for each device and sea, on tuning seeds. "
        "In step is not judged here, where each pair is the yardstick itself: the turns kept tell."
    )
    return "\n\n".join([*found["sentences"], table(heads, lines, 2), told, caption("connection")])


def _controls(one: Mapping[str, Any], coupled: bool) -> list[str]:
    controls = f"{one['cc']:.3g}, {one['cg']:.3g}" if coupled else f"{one['cg']:.3g}"
    held = f"{round(one['lock']['value'] * one['lock']['runs'])} of {one['lock']['runs']}"
    return [controls, f"{held}; {number(one['turns_kept'])}", ranged(one["power"])]


BLOCKS: Mapping[str, Callable[[], str]] = {
    "connection": connection,
    "startup-rest": startup_rest,
    "startup-loss": startup_loss,
    "forecast": forecast,
    "statements": statements,
    "statements-table": statements_table,
    "hydro": hydro,
}
