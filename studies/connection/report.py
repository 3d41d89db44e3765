"""Table, data and figure of the study."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from gyroctl.harness.seed_ledger import ledger
from gyroctl.provenance import made
from gyroctl.statistics import Estimate, Share
from gyroctl.studies.connection.draw import draw
from gyroctl.studies.connection.runs import Answer, AtBest, OneDevice, SameGain, compare_connections
from gyroctl.studies.style import save, styled
from gyroctl.tuning.yardstick import BUDGET
from gyroctl.writing import plain, write_json, write_text


def connection_report(
    out: Path,
    seeds: Sequence[int] = range(1, 65),
    gammas: Sequence[float] = (1.0, 5.0, 50.0),
    heights: Sequence[float] = (0.2, 0.283, 0.36),
    duration: float = 2000.0,
    budget: float = BUDGET,
    workers: int | None = None,
    quiet: bool = False,
) -> dict[str, Any]:
    """Run the study; write ``connection.json``, ``.md``, ``.png``, ``.svg`` and ``.pdf`` into `out`.

    Parameters
    ----------
    out : Path
        Folder, made where it is missing.
    seeds, gammas, heights, duration, budget, workers, quiet
        As in `compare_connections`.

    Returns
    -------
    dict
        What connection.json holds.

    Raises
    ------
    InputError
        As `compare_connections` does.
    """
    answer = compare_connections(gammas, heights, seeds, duration, budget=budget, workers=workers, quiet=quiet)
    result = {
        **made(),
        "seeds": list(answer.seeds),
        "seed_states": ledger().states(answer.seeds),
        "duration_s": duration,
        "budget_s": budget,
        "sentences": answer.sentences,
        "same_gain": [flat(case) for case in answer.same_gain],
        "at_best": [flat(case) for case in answer.at_best],
    }
    content = dict(plain(result))
    write_json(out / "connection.json", content)
    write_text(out / "connection.md", table(answer))
    with styled():
        save(draw(answer), out / "connection.png")
    return content


def answer_of(content: Mapping[str, Any]) -> Answer:
    """Read an answer back from what connection.json holds.

    Parameters
    ----------
    content : mapping
        The JSON, or what is kept of it.

    Returns
    -------
    Answer
    """
    same = [
        SameGain(
            **{
                **case,
                "magnetic": _share(case["magnetic"]),
                "rigid": _share(case["rigid"]),
                "longer": _estimate(case["longer"]),
            }
        )
        for case in content["same_gain"]
    ]
    best = [
        AtBest(
            **{
                **case,
                "magnetic": _one(case["magnetic"]),
                "rigid": _one(case["rigid"]),
                "gain": _estimate(case["gain"]),
            }
        )
        for case in content["at_best"]
    ]
    gammas, heights = (tuple(dict.fromkeys(getattr(case, name) for case in best)) for name in ("gamma", "hs"))
    return Answer(gammas, heights, tuple(content["seeds"]), content["duration_s"], tuple(same), tuple(best))


def _one(device: Mapping[str, Any]) -> OneDevice:
    return OneDevice(**{**device, "lock": _share(device["lock"]), "power": _estimate(device["power"])})


def _share(share: Mapping[str, Any]) -> Share:
    return Share(**share)


def _estimate(found: Mapping[str, Any]) -> Estimate:
    value, low, high = (math.nan if found[name] is None else found[name] for name in ("value", "low", "high"))
    return Estimate(value, low, high, found["note"])


def table(answer: Answer) -> str:
    """Each device at its best, sea by sea, as Markdown, with the answer in words below.

    Parameters
    ----------
    answer : Answer
        From `compare_connections`.

    Returns
    -------
    str
    """
    lines = [
        "| gamma | Hs [m] | with the coupling: cc, cg [Nms] | held lock | power [W] | CV "
        "| rigid: cg [Nms] | held lock | power [W] | CV | with less without [W] | power is |",
        "|---|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for case in answer.at_best:
        m, r = case.magnetic, case.rigid
        gain = f"{case.gain.value:+.2f} ({case.gain.low:+.2f} to {case.gain.high:+.2f})"
        cells = [f"{case.gamma:g}", f"{case.hs:g}", f"{m.cc:.3g}, {m.cg:.3g}", *_told(m), f"{r.cg:.3g}", *_told(r)]
        lines.append(f"| {' | '.join([*cells, gain, case.words])} |")
    return "\n".join([*lines, "", *answer.sentences, ""])


def _told(one: OneDevice) -> list[str]:
    held = f"{round(one.lock.value * one.lock.runs)} of {one.lock.runs}"
    return [held, f"{one.power.value:.2f} ({one.power.low:.2f} to {one.power.high:.2f})", f"{one.cv:.2f}"]


def flat(value: Any) -> Any:
    """Named values all the way down, as JSON keeps them."""
    if hasattr(value, "_asdict"):
        return {name: flat(entry) for name, entry in value._asdict().items()}
    return value
