"""All measures of one operating point, stage by stage: of the constant controls, of a law, of the law's linear loop."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future

from gyroctl.engine.steps import Steps
from gyroctl.errors import InputError, in_words
from gyroctl.harness.law_fingerprint import law_fingerprint
from gyroctl.linearisation import PeriodicOrbit
from gyroctl.robustness.regime import Regime
from gyroctl.studies.margins import measures
from gyroctl.studies.margins.measures import DIRECTIONS, SIZES, LoopAnswer, Margins, Tick
from gyroctl.studies.margins.request import Request
from gyroctl.waves.checks import whole
from gyroctl.writing import Kept

SAMPLES_MAX = 100_000
"""Most random disturbances per size."""

Measured = tuple[Margins | None, Margins | None, LoopAnswer | None]
"""Margins of the constant controls, of the law, and its linear ones; None where there are none."""


def check_samples(samples: int) -> None:
    """Refuse a number of disturbances that is none, or more than any basin needs."""
    whole("samples", samples, 1, SAMPLES_MAX, "Give the number of disturbances, for example 128")


def steps_of(asked: Request) -> int:
    """How often `measured` tells that it goes on, about."""
    return (len(DIRECTIONS) + len(SIZES) + 1) * (2 if asked.law else 1)


def of_constant(samples: int) -> str:
    """Name of the step that measures the constant controls."""
    return f"constant controls, {samples} samples"


def of_a_law(known: str, samples: int) -> str:
    """Name of the step that measures a law, which is known by its content."""
    return f"law {known}, {samples} samples"


def measured(
    asked: Request,
    orbit: PeriodicOrbit,
    samples: int,
    kept: Kept,
    tick: Tick,
    alone_done: Callable[[], None] = lambda: None,
    step: Steps | None = None,
) -> Measured:
    """Measure, and keep what is finished under ``constant_controls`` and ``law``.

    The linear margins come first, and then `alone_done` is called: they are made of singular values, for which the
    threads of the linear algebra want all cores to themselves, and wait for each other a hundred times where they are
    not given them.

    Raises
    ------
    InputError
        Where the law does not keep the lock: before anything takes time.
    """
    content, regime = kept.content, None
    step = step or Steps(None, "", (), ())
    constant: Margins | None = None
    of_law: Margins | None = None
    answer: LoopAnswer | None = None
    linear: Future[LoopAnswer] = Future()
    if asked.law is not None:
        regime = _regime(asked, orbit, kept)
        try:
            linear.set_result(measures.linear_margins(orbit, asked))
        except Exception as error:  # told where it is asked for
            linear.set_exception(error)
    alone_done()
    if orbit.status == "stable":
        with kept.stage("constant_controls"):
            constant = step(of_constant(samples), lambda: measures.constant_margins(orbit, asked, samples, tick))
            content["constant_controls"] = constant.record()
    if regime is not None:
        with kept.stage("law"):
            known, begun = law_fingerprint(asked.law), regime
            own = step if known else Steps(None, "", (), ())
            of_law = own(of_a_law(known, samples), lambda: measures.law_margins(begun, samples, tick))
            content["law"] = of_law.record()
    if asked.law is not None:
        with kept.stage("law.linear"):
            answer = linear.result()
            content["law"] = {**content.get("law", {}), "linear": answer.record()}
            tick()
    return constant, of_law, answer


def _regime(asked: Request, orbit: PeriodicOrbit, kept: Kept) -> Regime | None:
    """Regime of the law; a law that does not keep the lock is refused, one that fails in it is named."""
    try:
        return measures.law_regime(orbit, asked)
    except InputError:
        raise
    except Exception as error:  # whatever a user's law can raise: the constant controls have their margins all the same
        kept.failed["law"] = in_words(error)
        return None
