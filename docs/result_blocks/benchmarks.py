"""Blocks from the benchmarks and from the tuned sets that ship."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from gyroctl.reports.wording import number
from result_blocks.source import ROOT, of_file, read, table

TUNED = "controllers/nmpc/tuned/nmpc.json"


def speed() -> str:
    """Time of a run, beside others'."""
    found, others = read("benchmarks/speed.json"), read("benchmarks/integrators.json")["peers"]
    one, many = found["single run, dt .01 [s]"], found["1000 runs of 2000 s at dt .01 on all cores, wall [s]"]
    times = {row["name"]: row["times_of_one_run"] for row in others}
    best = min(value for name, value in times.items() if not name.startswith("gyroctl"))
    numpy = times["SciPy DOP853, right-hand side in NumPy"]
    planner = read("benchmarks/nmpc.json")["horizon_4_s"]["median_ms"]
    return (
        f"A run of 2000 s takes {1000 * one:.0f} ms, a thousand of them {many:.1f} s ({found['machine']}). Of other "
        f"integrators as accurate on the same plant and waves the quickest takes {number(best, 2)} times as long "
        f"as one run, SciPy's DOP853 {number(numpy, 2)} times. A sample of the planning law takes "
        f"{number(planner, 2)} ms: [benchmarks](docs/benchmarks.md).\n\n"
        f"{of_file('benchmarks/speed.json', 'python benchmarks/speed.py')}"
    )


def nmpc_time() -> str:
    """Time of a plan by the length of the horizon, and what the timed runs did."""
    found = read("benchmarks/nmpc.json")
    lines = []
    for name in ("horizon_4_s", "horizon_8_s"):
        one = found[name]
        title = name.removeprefix("horizon_").replace("_", " ")
        counts = [str(one[key]) for key in ("deadline_misses", "fallbacks", "failed_plans")]
        lines.append([title, f"{one['median_ms']:.2f} ms", f"{one['p99_ms']:.1f} ms", *counts, f"{one['samples']}"])
    command = f"python benchmarks/nmpc.py --runs {len(found['runs'])}"
    heads = ("horizon", "median of a sample", "99 %", "late", "fallbacks", "failed plans", "samples")
    return f"{table(heads, lines)}\n\n{of_file('benchmarks/nmpc.json', command, found['machine'])}"


def nmpc_solvers() -> str:
    """Solvers of the quadratic program on the same programs, and of the whole problem in a closed loop."""
    found = read("benchmarks/nmpc_qp.json")
    lines = [
        [
            f"{one['horizon_s']:g} s",
            f"`{one['solver']}`",
            f"{number(one['ms_median'], 2)}, {number(one['ms_p99'], 2)}",
            "–" if one["error_max_nms"] is None else number(one["error_max_nms"], 2),
            str(one["not_solved"]),
            str(one["count"]),
        ]
        for one in found["programs"]
        if one["solver"] != "linearise"
    ]
    heads = ("horizon", "solver, and its tolerance", "time: median, 99 % [ms]", "largest error [Nms]")
    heads += ("not solved", "programs")
    seeds = f"seeds {', '.join(str(seed) for seed in found['seeds'])}"
    command = f"python benchmarks/nmpc_qp.py --seeds {len(found['seeds'])} --duration {found['duration_s']:g}"
    made = of_file("benchmarks/nmpc_qp.json", command, seeds)
    return f"{table(heads, lines, 2)}\n\n{made}"


def tuned_nmpc() -> str:
    """The tuned sets of the planning law on the seeds that chose them."""
    lines = []
    seeds: list[str] = []
    for name, entry in read(TUNED)["sets"].items():
        span = entry["found"]["seeds"]
        seeds.append(f"`{name}`: {span['first']} to {span['last']}, {entry['found']['date']}")
        for sea, found in entry["result"].items():
            lines.append([f"`{name}`", sea.replace("gamma", "gamma "), *_tuned(found)])
    heads = ("set", "sea", "power [W]", "CV", "locked", "slips per 1000 waves", "98 % of φ1, φ3 [rad]")
    told = (
        f"Mean power on the tuning seeds among which the sets were chosen ({'; '.join(seeds)}): they flatter, and "
        "judge nothing; in step is not judged there."
    )
    command = "gyroctl tune nmpc --budget 5e5 --ship, gyroctl tune nmpc --for gamma50 --from all --budget 4e5 --ship"
    return "\n\n".join([table(heads, lines, 2), told, of_file(TUNED, command)])


def _tuned(found: Mapping[str, Any]) -> list[str]:
    return [
        number(found["mean_power"]),
        number(found["power_cv"], 2),
        f"{round(found['locked'] * found['runs'])} of {found['runs']}",
        number(found["cycle_slips"], 2) if "cycle_slips" in found else "–",
        f"{number(found['phi1_p98'], 2)}, {number(found['phi3_p98'], 2)}",
    ]


def spent() -> str:
    """Simulated time that went into every set that ships."""
    lines = []
    for path in sorted(ROOT.glob("controllers/*/tuned/*.json")):
        for name, entry in read(path.relative_to(ROOT).as_posix())["sets"].items():
            found = entry["found"]
            before, seeds = found.get("spent_before_s") or 0.0, found["seeds"]
            span = f"{seeds['first']} to {seeds['last']}"
            lines.append(
                [f"`{path.stem}`", f"`{name}`", f"{found['spent_s']:.3g}", f"{before:.3g}", span, found["date"]]
            )
    heads = ("law", "set", "simulated [s]", "before, for the set it began at or by hand [s]", "seeds", "found on")
    made = "*`controllers/*/tuned/*.json`: `gyroctl tune LAW --ship`, with the budgets in the files.*"
    return f"{table(heads, lines, 2)}\n\n{made}"


def water_cost() -> str:
    """Cost of the choices beyond the linear model."""
    found = read("benchmarks/water.json")
    lines = [
        [name, number(one["relative to linear"], 2), number(1000.0 * one["a run [s]"], 2)]
        for name, one in found.items()
        if isinstance(one, Mapping) and "relative to linear" in one
    ]
    told = (
        f"Processor time of 600 s of `load_angle` in one process, relative to the linear plant "
        f"({1000.0 * found['linear, one run [s]']:.1f} ms, {found['machine']})."
    )
    made = of_file("benchmarks/water.json", "python -P benchmarks/water.py")
    return "\n\n".join([table(("choice", "relative to linear", "a run [ms]"), lines), told, made])


def reduced_truth() -> str:
    """Polynomials of the wetted surface against the panels."""
    found = read("benchmarks/real_water.json")
    lines = []
    for position, laws in found["wetted"].items():
        for law, one in laws.items():
            panels, fit = one["surface"], one["reduced"]
            lines.append(
                [
                    position,
                    f"`{law}`",
                    *(f"{number(each['mean_power'])}, {number(each['phi1_p98'], 3)}" for each in (panels, fit)),
                    *(f"{100.0 * (fit[key] / panels[key] - 1.0):+.1f} %" for key in ("mean_power", "phi1_p98")),
                    *(f"{each['locked']} of {each['runs']}" for each in (panels, fit)),
                ]
            )
    heads = ("position", "law", "panels: power [W], 98 % of φ1 [rad]", "polynomials", "power", "98 % of φ1")
    pairs = ", ".join(f"{position}: ({cc:g}, {cg:g}) Nms" for position, (cc, cg) in found["pairs_nms"].items())
    runs = f"{len(found['seeds'])} realisations of {found['duration_s']:g} s"
    told = f"Cd {found['drag']:g}, {runs}; constant pairs {pairs}."
    made = of_file("benchmarks/real_water.json", "python -P benchmarks/real_water.py")
    return "\n\n".join([table((*heads, "lock kept on the panels", "on the polynomials"), lines, 2), told, made])


def friction_truth() -> str:
    """Smoothed friction against dry friction."""
    found = read("benchmarks/real_water.json")
    lines = []
    for traction, one in found["friction"].items():
        creep = one["creep_w"]
        crept = "–" if creep is None else f"{number(creep[0], 2)} to {number(creep[1], 2)}"
        lines.append([traction, f"{one['agreed']} of {one['runs']}", f"{one['reversed']} of {one['runs']}", crept])
    heads = ("μ", "same verdict: does the run reverse?", "runs that do", "creep loss where none does [W]")
    made = of_file("benchmarks/real_water.json", "python -P benchmarks/real_water.py", "a constant pair, runs of 300 s")
    return f"{table(heads, lines)}\n\n{made}"


BLOCKS: Mapping[str, Callable[[], str]] = {
    "speed": speed,
    "water-cost": water_cost,
    "reduced-truth": reduced_truth,
    "friction-truth": friction_truth,
    "nmpc-time": nmpc_time,
    "nmpc-solvers": nmpc_solvers,
    "nmpc-tuned": tuned_nmpc,
    "tuning-spent": spent,
}
