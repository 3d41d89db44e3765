"""Exact derivatives of a law's step by numbers that carry a gradient.

A law is written with `math`, `min`, `max` and comparisons, which complex numbers refuse. A `Dual` is a value with its
gradient (forward differentiation): comparisons look at the value, so that the branch taken is the one differentiated.
A law that forces its inputs into plain floats (a solver, compiled code) is not differentiable in this way and says so.
"""

from __future__ import annotations

import builtins
import math
from collections.abc import Callable
from types import FunctionType, MethodType, SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import without_addresses
from gyroctl.nested import leaves, like


class NotDifferentiable(TypeError):
    """A law whose step does not pass gradients on."""


class Dual:
    """A value and its gradient (m,)."""

    __array_priority__ = 100.0
    __slots__ = ("gradient", "value")

    def __init__(self, value: float, gradient: NDArray[np.float64]) -> None:
        self.value, self.gradient = value, gradient

    def _chain(self, value: float, slope: float) -> Dual:
        return Dual(value, slope * self.gradient)

    def __add__(self, other: Any) -> Dual:
        if isinstance(other, Dual):
            return Dual(self.value + other.value, self.gradient + other.gradient)
        return Dual(self.value + float(other), self.gradient)

    __radd__ = __add__

    def __neg__(self) -> Dual:
        return Dual(-self.value, -self.gradient)

    def __pos__(self) -> Dual:
        return self

    def __sub__(self, other: Any) -> Dual:
        return self.__add__(-other)

    def __rsub__(self, other: Any) -> Dual:
        return (-self).__add__(other)

    def __mul__(self, other: Any) -> Dual:
        if isinstance(other, Dual):
            return Dual(self.value * other.value, self.value * other.gradient + other.value * self.gradient)
        return self._chain(self.value * float(other), float(other))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Dual:
        if isinstance(other, Dual):
            return self.__mul__(other._chain(1.0 / other.value, -1.0 / other.value**2))
        return self.__mul__(1.0 / float(other))

    def __rtruediv__(self, other: Any) -> Dual:
        return self._chain(1.0 / self.value, -1.0 / self.value**2).__mul__(other)

    def __pow__(self, other: Any) -> Dual:
        if isinstance(other, Dual):
            power: Dual = exp(other * log(self))
            return power
        slope = other * self.value ** (other - 1) if other != 0 else 0.0
        return self._chain(self.value**other, slope)

    def __rpow__(self, other: Any) -> Dual:
        return self._chain(other**self.value, other**self.value * math.log(other))

    def __mod__(self, other: float) -> Dual:
        return Dual(self.value % other, self.gradient)

    def __abs__(self) -> Dual:
        return -self if self.value < 0.0 else self

    def __bool__(self) -> bool:
        return self.value != 0.0

    def __lt__(self, other: Any) -> bool:
        return bool(self.value < _value(other))

    def __le__(self, other: Any) -> bool:
        return bool(self.value <= _value(other))

    def __gt__(self, other: Any) -> bool:
        return bool(self.value > _value(other))

    def __ge__(self, other: Any) -> bool:
        return bool(self.value >= _value(other))

    def __eq__(self, other: object) -> bool:
        return bool(self.value == _value(other))

    __hash__ = None  # type: ignore[assignment]

    def __float__(self) -> float:
        raise NotDifferentiable("the law turns its inputs into plain floats")


def _value(number: Any) -> Any:
    return number.value if isinstance(number, Dual) else number


def _unary(function: Callable[[float], float], slope: Callable[[float], float]) -> Callable[[Any], Any]:
    def apply(x: Any) -> Any:
        return x._chain(function(x.value), slope(x.value)) if isinstance(x, Dual) else function(x)

    return apply


exp = _unary(math.exp, math.exp)
log = _unary(math.log, lambda v: 1.0 / v)
_UNARY = {
    "exp": exp,
    "log": log,
    "sin": _unary(math.sin, math.cos),
    "cos": _unary(math.cos, lambda v: -math.sin(v)),
    "tan": _unary(math.tan, lambda v: 1.0 + math.tan(v) ** 2),
    "tanh": _unary(math.tanh, lambda v: 1.0 - math.tanh(v) ** 2),
    "sinh": _unary(math.sinh, math.cosh),
    "cosh": _unary(math.cosh, math.sinh),
    "sqrt": _unary(math.sqrt, lambda v: 0.5 / math.sqrt(v) if v > 0.0 else 0.0),
    "asin": _unary(math.asin, lambda v: 1.0 / math.sqrt(1.0 - v * v)),
    "acos": _unary(math.acos, lambda v: -1.0 / math.sqrt(1.0 - v * v)),
    "atan": _unary(math.atan, lambda v: 1.0 / (1.0 + v * v)),
    "fabs": _unary(abs, lambda v: math.copysign(1.0, v)),
    "floor": _unary(math.floor, lambda v: 0.0),
    "ceil": _unary(math.ceil, lambda v: 0.0),
}


for _name, _function in _UNARY.items():  # where a law writes np.cos(x), numpy asks x for its method `cos`
    setattr(Dual, _name, _function)


def _atan2(y: Any, x: Any) -> Any:
    if not (isinstance(y, Dual) or isinstance(x, Dual)):
        return math.atan2(y, x)
    a, b = _value(y), _value(x)
    total = (y * b - x * a) * (1.0 / (a * a + b * b))
    return Dual(math.atan2(a, b), total.gradient)


def _hypot(*numbers: Any) -> Any:
    return _UNARY["sqrt"](sum(n * n for n in numbers))


def _modulo(function: Callable[[float, float], float]) -> Callable[[Any, float], Any]:
    return lambda x, y: Dual(function(x.value, y), x.gradient) if isinstance(x, Dual) else function(x, y)


def _to_float(number: Any = 0.0) -> Any:
    return number if isinstance(number, Dual) else builtins.float(number)


_MATH = SimpleNamespace(
    **{
        **vars(math),
        **_UNARY,
        "atan2": _atan2,
        "hypot": _hypot,
        "remainder": _modulo(math.remainder),
        "fmod": _modulo(math.fmod),
        "pow": lambda x, y: x**y,
        "isfinite": lambda x: math.isfinite(_value(x)),
        "isnan": lambda x: math.isnan(_value(x)),
        "copysign": lambda x, y: abs(x) if math.copysign(1.0, _value(y)) > 0.0 else -abs(x),
    }
)


class _Rebound:
    """Looks like the law, but runs its methods, and those of a law within it, with functions that know `Dual`."""

    def __init__(self, law: Any) -> None:
        self._law = law

    def __getattr__(self, name: str) -> Any:
        value = getattr(self._law, name)
        if isinstance(value, MethodType) and isinstance(value.__func__, FunctionType):
            return MethodType(_rebind(value.__func__, {}), self)
        return _Rebound(value) if name == "law" and callable(getattr(value, "step", None)) else value


def _rebind(function: FunctionType, done: dict[int, FunctionType]) -> FunctionType:
    """Copy of a plain function in which `math` and `float` know `Dual`, and so do the functions it calls."""
    if id(function) in done:
        return done[id(function)]
    scope = dict(function.__globals__)
    copy = FunctionType(function.__code__, scope, function.__name__, function.__defaults__, function.__closure__)
    copy.__kwdefaults__ = function.__kwdefaults__
    done[id(function)] = copy
    for name in function.__code__.co_names:
        value = scope.get(name)
        if value is math or name == "float":
            scope[name] = _MATH if value is math else _to_float
        elif isinstance(value, FunctionType) and _home(value) == _home(function):
            scope[name] = _rebind(value, done)
        elif getattr(math, name, None) is value and name in vars(_MATH) and value is not None:
            scope[name] = getattr(_MATH, name)  # from math import cos
    return copy


def _home(function: FunctionType) -> str:
    """Package of a function: what laws of one folder share is rebound too, what they use of others is not."""
    return str(function.__module__).rpartition(".")[0] or str(function.__module__)


def step_jacobian(
    law: Any, t: float, y: Any, state: Any
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Differentiate one step of a law.

    Parameters
    ----------
    law : Law
        With `step(t, y, state)`.
    t : float
        Time. [s]
    y : tuple of floats
        Measurement (a NamedTuple).
    state : float or nested tuple of floats
        State of the law.

    Returns
    -------
    values : (2 + ns,) array
        Command, then new state.
    by_measurement : (2 + ns, ny) array
        Derivative with respect to the measurement.
    by_state : (2 + ns, ns) array
        Derivative with respect to the state.

    Raises
    ------
    NotDifferentiable
        Where the step does not pass gradients on, or the state holds something else than numbers.
    """
    if not all(isinstance(value, int | float) for value in leaves(state)):
        kinds = sorted({type(value).__name__ for value in leaves(state) if not isinstance(value, int | float)})
        raise NotDifferentiable(f"the law's state holds {' and '.join(kinds)}, give it as a NamedTuple of floats")
    ny, ns = len(y), len(leaves(state))
    unit = np.eye(ny + ns)
    measured = type(y)(*(Dual(float(value), unit[i]) for i, value in enumerate(y)))
    known = [Dual(float(value), unit[ny + i]) for i, value in enumerate(leaves(state))]
    carried = like(state, known)
    try:
        (cc, cg), new = _Rebound(law).step(t, measured, carried)
        flat = [cc, cg, *leaves(new)]
        values = np.array([float(_value(value)) for value in flat])
    except (TypeError, ValueError, AttributeError) as error:
        raise NotDifferentiable(without_addresses(str(error))) from error
    gradient = np.array([v.gradient if isinstance(v, Dual) else np.zeros(ny + ns) for v in flat])
    return values, gradient[:, :ny], gradient[:, ny:]
