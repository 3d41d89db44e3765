"""The prediction model: one step of the plant, cheap enough for millions per second, and its exact derivatives.

The slip is the only fast mode of the device (rate about 683 cc per second) and linear in the coupling. The
implicit-explicit Runge-Kutta method ARS(2,2,2) (Ascher, Ruuth, Spiteri, Appl. Numer. Math. 25 (1997) 151-167) takes the
coupling implicitly, by one division, and all else explicitly. It is L-stable in the slip, of second order, and needs
two evaluations of the equations where classical Runge-Kutta needs twenty.

Everything is derived by casadi from the one text of the equations; the constants of the device enter as an array, so
that one compilation serves every device.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache
from itertools import islice
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyroctl.controllers.nmpc.casadi_to_numba import BESIDE, compiled, compiled_beside, compiled_columns
from gyroctl.controllers.nmpc.design_model import Design, design_of, eased, filled, form_of, numbers_of, signals_at
from gyroctl.plant import Plant
from gyroctl.plant.beyond import BEYOND
from gyroctl.plant.compiled import inlined
from gyroctl.plant.equations import LEDGER, OMEGA, Coefficients, derivative

GAMMA = 1.0 - math.sqrt(0.5)
DELTA = 1.0 - 1.0 / (2.0 * GAMMA)

LINEAR = tuple(name for name in Coefficients._fields if name != "beyond")
"""Constants of the linear model, the radiation filters last."""

Orders = tuple[int, int, int, int]
"""Numbers of coefficients of the radiation filters: p1, q1, p3, q3."""


class Kind(NamedTuple):
    """What compiled functions of the model depend on."""

    orders: Orders
    beyond: Design | None = None  # terms beyond the linear model, without their numbers


STEPS = 2
"""Model steps in a control interval of 0.1 s: with two, 4 s ahead, the states are right to about a hundredth."""


class Chain(NamedTuple):
    """What a step does to a derivative, by the chain rule, stage by stage."""

    stages: list[Any]  # entries of the Jacobians of the stages, as expressions
    matrices: list[Any]  # symbols that stand for them
    so_far: Any  # derivative of the state, and that of the coupling (n + 1,)
    after: Any  # derivative of the state after the step (n,)


class Model(NamedTuple):
    """One step of the prediction model, symbolic: from `x`, held `u` and moments, over `h`."""

    x: Any  # state without omega, which is cyclic (n,)
    u: Any  # coupling [Nms], generator power [W]
    moments: Any  # Me1, Me3 at the start, then at the end of the step [Nm]
    h: Any  # [s]
    k: Any  # constants of the device, see `constants`
    after: Any  # state after the step
    chain: Chain

    @property
    def given(self) -> list[Any]:
        """Inputs in the order of the compiled functions."""
        return [self.x, self.u, self.moments, self.h, self.k]


def constants(plant: Plant, beyond: bool = False, losses: bool = False) -> NDArray[np.float64]:
    """Constants of a device as one array, in the order of `Coefficients`, and those beyond the linear model."""
    linear = plant.rolling.coefficients[: len(LINEAR)]
    more = numbers_of(design_of(plant, losses=losses)) if beyond else []
    return np.array([number for value in (*linear, more) for number in np.atleast_1d(value)])


def linear_kind(plant: Plant) -> Kind:
    """Kind of the model that predicts the linear device."""
    return Kind(orders_of(plant))


def kind_of(plant: Plant, losses: bool = False) -> Kind:
    """Kind of the model that predicts a device with all that its smooth form has, with its losses or without."""
    return Kind(orders_of(plant), form_of(design_of(plant, losses=losses)))


def width_of(kind: Kind) -> int:
    """Numbers of an instant that the model is given: Me1, Me3 [Nm], and beyond the linear model their rates [Nm/s]."""
    return 2 if kind.beyond is None else 4


@lru_cache(maxsize=4)
def model(kind: Kind) -> Model:
    """Build the model of a kind."""
    import casadi

    casadi.GlobalOptions.setNumpyMode(1)
    k, design, symbols = _symbolic_constants(kind)
    orders, width = kind.orders, width_of(kind)
    n = 7 + orders[1] + orders[3]
    x, u, m = casadi.SX.sym("x", n), casadi.SX.sym("u", 2), casadi.SX.sym("moments", 2 * width)
    h = casadi.SX.sym("h", 1)

    def rate(x: Any, cc: Any, power: Any, given: Any, design: Any = design) -> Any:
        """Rate of change where the generator gives `power` whatever the speed."""
        full = casadi.vertcat(x[:3], 0.0, x[3:])
        dx: list[Any] = [0.0] * (n + 1 + len(LEDGER) + len(BEYOND))
        speed = x[6]
        more, signals = (None, None) if design is None else (design.terms, signals_at(design, x[0], given))
        derivative(full, dx, 1, 0, k, cc, power / (speed * speed), given[0], given[1], more, signals)
        return casadi.vertcat(*dx[:OMEGA], *dx[OMEGA + 1 : n + 1])

    cc, power, psi = u[0], u[1], x[2]
    # the coupling's part of the rate is its torque times D(psi); D does not change within the implicit stage
    unit = casadi.jacobian(rate(x, cc, power, (0.0, 0.0), None), cc)
    direction = casadi.substitute(casadi.jacobian(unit, x[6]), x, casadi.vertcat(0, 0, psi, *([0] * (n - 3))))

    def coupled(explicit: Any) -> tuple[Any, Any]:
        """Solve Y = explicit + h GAMMA G(Y) for Y and G(Y)."""
        d = casadi.substitute(direction, psi, explicit[2])
        free = explicit[6] - k.N * explicit[5]
        line = cc if design is None else cc * eased(design.terms, cc, free)
        slip = free / (1.0 - h * GAMMA * line * (d[6] - k.N * d[5]))
        pull = line * slip * d
        return explicit + h * GAMMA * pull, pull

    def moments(part: float) -> tuple[Any, ...]:
        return tuple(m[i] + part * (m[width + i] - m[i]) for i in range(width))

    first = rate(x, 0.0, power, moments(0.0))
    halfway = x + h * GAMMA * first
    second, pull = coupled(halfway)
    third = rate(second, 0.0, power, moments(GAMMA))
    whole = x + h * (DELTA * first + (1.0 - DELTA) * third + (1.0 - GAMMA) * pull)
    after, _ = coupled(whole)

    # the chain rule stage by stage: sparse matrices, which every column meets in turn; their product would be full
    point, me, by = casadi.SX.sym("point", n), casadi.SX.sym("me", width), casadi.jacobian
    free, bound = rate(point, 0.0, power, casadi.vertsplit(me)), coupled(point)[1]
    so_far = casadi.SX.sym("so_far", n + 1)  # derivative of state and coupling
    entries: Any = lambda matrix: casadi.vertcat(*matrix.nonzeros())  # noqa: E731
    stages: list[Any] = []
    matrices: list[Any] = []

    def moved(of: Any, there: Any, stage: Any, share: Any, part: float = 0.0) -> Any:
        """Derivative of `share` times the rate `of` at a stage, where the stage has moved by `there`."""
        place = [stage, casadi.vertcat(*moments(part))]
        whole = casadi.horzcat(*casadi.substitute([by(of, point), by(of, cc)], [point, me], place))
        matrix = casadi.SX.sym(f"stage{len(stages)}", whole.sparsity())
        stages.append(entries(share * whole))
        matrices.append(entries(matrix))
        return matrix @ casadi.vertcat(there, so_far[n])

    start = so_far[:n]
    of_first = moved(free, start, x, h * GAMMA)
    of_pull = moved(bound, start + of_first, halfway, h * GAMMA)
    of_third = moved(free, start + of_first + of_pull, second, h * (1.0 - DELTA), GAMMA)
    of_whole = start + (DELTA / GAMMA) * of_first + of_third + ((1.0 - GAMMA) / GAMMA) * of_pull
    of_after = of_whole + moved(bound, of_whole, whole, h * GAMMA)
    return Model(x, u, m, h, symbols, after, Chain(stages, matrices, so_far, of_after))


@lru_cache(maxsize=4)
def step_of(kind: Kind) -> Any:
    """Compile ``step(x, u, moments, h, k, after)``."""
    found = model(kind)
    return compiled("step", found.given, [found.after])


@lru_cache(maxsize=4)
def beside_of(kind: Kind) -> Any:
    """Compile ``beside(moments, h, k, room)``: one step of BESIDE plans in the same waves, bit for bit that of `step`.

    `room` holds the entries of `x`, then of `u`, those of all plans side by side, see `compiled_beside`.
    """
    found = model(kind)
    return compiled_beside("beside", found.given[:2], found.given[2:], found.after)


@lru_cache(maxsize=4)
def pullback_of(kind: Kind) -> Any:
    """Compile ``pullback(x, u, moments, h, k, weight, by_x, by_u)``: weight' times the Jacobian of the step, exact."""
    import casadi

    found = model(kind)
    weight = casadi.SX.sym("weight", found.x.numel())
    back = casadi.jtimes(found.after, casadi.vertcat(found.x, found.u), weight, True)
    return compiled("pullback", [*found.given, weight], [back[:-2], back[-2:]])


@lru_cache(maxsize=4)
def tangent_of(kind: Kind) -> Any:
    """Compile ``tangent(h, k, room, columns)``: carry derivatives through BESIDE steps, exactly.

    `room`, `tangent_room` long, begins with `x`, `u` and `moments` of the steps side by side, see `compiled_columns`.
    `columns` is an array (BESIDE / STEPS, n + 1, `row_of(n + 1)`), flat: for each interval, in each column the
    derivative of the state, and below it that of the coupling, by whatever the column stands for.
    """
    found = model(kind)
    chain = found.chain
    own, common = found.given[:3], found.given[3:]
    return compiled_columns("tangent", own, common, *chain, STEPS)


@inlined
def tangent_room(m: int, width: int) -> int:
    """Numbers that the `tangent` of `m` states may need: its inputs, and its four stages if they were full.

    `width` is how many numbers of an instant the model is given, see `width_of`.
    """
    return (m + 2 + 2 * width + 4 * m * (m + 1)) * BESIDE


def orders_of(plant: Plant) -> Orders:
    """Orders of the radiation filters of a device."""
    k = plant.coefficients
    return len(k.p1), len(k.q1), len(k.p3), len(k.q3)


def _symbolic_constants(kind: Kind) -> tuple[Coefficients, Design | None, Any]:
    import casadi

    orders, form = kind
    scalars = len(LINEAR) - len(orders)
    symbols = casadi.SX.sym("k", scalars + sum(orders) + len(numbers_of(form)))
    each: Iterator[Any] = iter(casadi.vertsplit(symbols))
    linear = Coefficients(*islice(each, scalars), *(tuple(islice(each, order)) for order in orders))
    return linear, None if form is None else filled(form, each), symbols
