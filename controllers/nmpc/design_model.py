"""What the prediction model knows of a plant beyond the linear one: its terms, and how the waves reach them.

The terms are those of the one text of the equations. What they ask of the waves beside the two moments at rest is
guessed from these and their rates, as the estimator does it: the water's velocity and the Froude-Krylov moments by
least squares over the spectrum, and all of it at the float's own place by the phase that waves of the peak frequency
lose on the way there. So a plan sees smooth functions of its own motion.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gyroctl.nested import leaves, like
from gyroctl.plant import Plant
from gyroctl.plant.beyond import Beyond, cubic_rows
from gyroctl.plant.trigonometry import cos_sin
from gyroctl.waves import SeaState
from gyroctl.waves.estimation.wave_signals import phase_along, regression


class Reach(NamedTuple):
    """How the waves at rest tell what acts on the float."""

    along: float  # phase that the waves lose along the reach of the lever [rad]
    wp: float  # frequency that they are taken to have [rad/s]
    u: tuple[float, float]  # of the water's velocity along phi1, from Me1 and its rate
    w: tuple[float, float]  # of that along phi3, from Me3 and its rate
    f1: tuple[float, float]  # of the Froude-Krylov moments, in the same way
    f3: tuple[float, float]


class Design(NamedTuple):
    """Numbers of a design model beyond the linear one."""

    terms: Beyond
    reach: Reach


def design_of(plant: Plant, sea: SeaState | None = None, losses: bool = False) -> Design | None:
    """Terms that the prediction has beyond the linear model, None without any.

    Parameters
    ----------
    plant : Plant
        The design model; of a contact with friction and a wetted surface the smooth forms are predicted.
    sea : SeaState, optional
        Weighs the frequencies; the default sea.
    losses : bool
        Predict what bearing, windage and rolling take, too. It hardly depends on the plan; a promise has to count it.
    """
    smooth, sea = plant.rolling.smooth, sea or SeaState()
    terms = smooth.coefficients.beyond
    if terms is None:
        return None
    if not losses:
        terms = terms._replace(losses=None)
    if all(term is None for term in terms):
        return None
    rows = dict(zip(smooth.channels, regression(smooth, sea), strict=True))

    def of(name: str) -> tuple[float, float]:
        row = rows.get(name, rows.get(f"{name}^0", np.zeros(4)))
        first = 0 if name in ("u", "F1") else 2
        return float(row[first]), float(row[first + 1])

    reach = Reach(phase_along(smooth, sea), sea.wp, of("u"), of("w"), of("F1"), of("F3"))
    return Design(terms, reach)


def form_of(design: Design | None) -> Design | None:
    """The same with its numbers left out: what a compiled model depends on."""
    if design is None:
        return None
    blank: Design = like(design, [0.0 if _is_number(leaf) else leaf for leaf in leaves(design)])
    return blank


def numbers_of(design: Design | None) -> list[float]:
    """Numbers of a design, in their order."""
    return [] if design is None else [float(leaf) for leaf in leaves(design) if _is_number(leaf)]


def filled(form: Design, numbers: Any) -> Design:
    """A design with these numbers, or symbols, in the order of `numbers_of`."""
    values = iter(numbers)
    whole: Design = like(form, [next(values) if _is_number(leaf) else leaf for leaf in leaves(form)])
    return whole


def signals_at(design: Design, phi1: Any, known: Any) -> list[Any]:
    """Signals as the equations see them, with the float's own place as the place of the cubics.

    `known` holds Me1, Me3 [Nm] and their rates [Nm/s].
    """
    terms, reach = design
    m1, m3, r1, r3 = (known[i] for i in range(4))
    _, along = cos_sin(phi1)
    c, s = cos_sin(reach.along * along)

    def here(value: Any, rate: Any) -> Any:
        return c * value - s * rate / reach.wp

    def guessed(row: tuple[Any, Any], value: Any, rate: Any) -> tuple[Any, Any]:
        """Value and rate of what follows a moment: it swings at the peak frequency."""
        return row[0] * value + row[1] * rate, row[0] * rate - row[1] * reach.wp**2 * value

    found = [m1, m3]
    if terms.drag is not None:
        found += [guessed(reach.u, m1, r1)[0], guessed(reach.w, m3, r3)[0]]
    undisturbed = [guessed(reach.f1, m1, r1), guessed(reach.f3, m3, r3)]
    if terms.position is None:
        return found + [value for value, _ in undisturbed if terms.reduced is not None]
    moved = [(m1, r1), (m3, r3), *(undisturbed if terms.reduced is not None else [])]
    for pair in moved:
        found += [here(*pair), 0.0, 0.0, 0.0]
    assert len(moved) * 4 == cubic_rows(terms)
    return [*found, phi1]


def eased(terms: Beyond, cc: Any, slip: Any) -> Any:
    """Part of the straight line's torque that the coupling gives at a slip. [-]"""
    part = 1.0
    if terms.curve is not None:
        over = slip / terms.curve.slip
        part = 1.0 / (1.0 + over * over)
    if terms.cap is not None:
        part = part * saturated((part * cc * slip / terms.cap.torque) ** 2)
    return part


def saturated(square: Any) -> Any:
    """``tanh(x) / x`` by the square of x: the Pade approximant (7, 6), right to 1e-6 at 2.5 and to 2e-4 at 4."""
    over = 135135.0 + square * (17325.0 + square * (378.0 + square))
    under = 135135.0 + square * (62370.0 + square * (3150.0 + 28.0 * square))
    return over / under


def _is_number(leaf: Any) -> bool:
    return isinstance(leaf, float | int) and not isinstance(leaf, bool)
