"""From a table, as xarray labels it or as an array with its nodes, to the law of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyroctl.errors import NOT_GIVEN, InputError
from gyroctl.harness.law_forms.signals import SIGNALS
from gyroctl.harness.law_forms.table import TableLaw

SOURCE = "law_from.source"
CONTROLS = ("cc", "cg")
AXES_MAX, NODES_MAX = 3, 20_000
"""Most quantities of a table, and most of its entries."""


def is_table(source: Any) -> bool:
    """Whether it is an array, a list of numbers, or what xarray has; xarray is not loaded to find that out."""
    return isinstance(source, np.ndarray | list | tuple) or any(
        kind.__module__.partition(".")[0] == "xarray" for kind in type(source).__mro__
    )


def table_law(
    source: Any,
    over: Mapping[str, Sequence[float]] | None,
    sets: tuple[str, ...] | None,
    pair: Mapping[str, float],
    smooth: float,
    most: tuple[float, float],
    N: float,
    period: float,
) -> TableLaw:
    """Make the law of a table.

    Raises
    ------
    InputError
        Fields ``law_from.source``, ``law_from.over``, ``law_from.sets``, ``law_from.cc``, ``law_from.cg``: what is no
        table over known quantities, or leaves a control open.
    """
    tables, nodes = _labelled(source, sets) if over is None else _plain(source, over, sets)
    _check_nodes(nodes)
    shape = tuple(len(values) for values in nodes.values())
    commands = []
    for name in CONTROLS:
        if name in tables and name in pair:
            raise InputError(f"law_from.{name}", pair[name], f"the table holds {name} already", "Leave it out")
        if name not in tables and name not in pair:
            raise InputError(f"law_from.{name}", NOT_GIVEN, f"the table holds no {name}", f"Give {name}= in Nms")
        values = tables.get(name)
        values = np.full(shape, pair[name]) if values is None else values
        if values.shape != shape:
            mend = f"Give it the shape {shape} of its nodes"
            raise InputError(SOURCE, values.shape, f"{name} has another shape than its nodes", mend)
        if not (np.all(np.isfinite(values)) and np.all(values >= 0.0)):
            raise InputError(SOURCE, name, "has entries that are no controls", "Give finite numbers >= 0 in Nms")
        commands.append(tuple(float(value) for value in values.ravel()))
    flat = tuple(float(value) for values in nodes.values() for value in values)
    counts = tuple(float(count) for count in shape)
    reads = tuple(float(SIGNALS.index(name)) for name in nodes)
    cc, cg = commands
    return TableLaw(cc, cg, flat, counts, reads, float(smooth), most, N, period)


Tables = tuple[dict[str, NDArray[np.float64]], dict[str, NDArray[np.float64]]]
"""Commands by control, and nodes by quantity."""


def _labelled(source: Any, sets: tuple[str, ...] | None) -> Tables:
    """Take apart what xarray has labelled."""
    if isinstance(source, np.ndarray | list | tuple):
        mend = 'Give over= its quantities and nodes, for example {"psi_rate": [2.5, 3.1, 3.7]}'
        raise InputError("law_from.over", NOT_GIVEN, "an array has no names of its own", mend)
    if hasattr(source, "data_vars"):
        found = {str(name): values for name, values in source.data_vars.items()}
    else:
        found = {_only(sets) if sets is not None else str(source.name or "cg"): source}
    strange = [name for name in found if name not in CONTROLS]
    if strange or not found:
        name = strange[0] if strange else None
        raise InputError(SOURCE, name, "is neither cc nor cg", "Name the variables of the table cc and cg")
    dims = max((values.dims for values in found.values()), key=len)
    nodes = {}
    for name in dims:
        if name not in source.coords:
            raise InputError("law_from.over", name, "has no nodes", "Give the table a coordinate for each dimension")
        nodes[str(name)] = np.atleast_1d(_numbers("law_from.over", source.coords[name].values))
    tables = {}
    for name, values in found.items():
        missing = [each for each in values.dims if each not in dims]
        if missing:
            raise InputError(SOURCE, missing[0], "is a dimension of one control alone", "Give both the same dimensions")
        whole = values.broadcast_like(next(v for v in found.values() if v.dims == dims)).transpose(*dims)
        tables[name] = _numbers(SOURCE, whole.values)
    return tables, nodes


def _plain(source: Any, over: Mapping[str, Sequence[float]], sets: tuple[str, ...] | None) -> Tables:
    """Take an array with its quantities and nodes."""
    if not isinstance(over, Mapping):
        mend = 'Give quantities and nodes, for example {"psi_rate": [2.5, 3.1, 3.7]}'
        raise InputError("law_from.over", type(over).__name__, "is no mapping", mend)
    name = _only(sets) if sets is not None else "cg"
    nodes = {str(key): np.atleast_1d(_numbers("law_from.over", values)) for key, values in over.items()}
    return {name: np.atleast_1d(_numbers(SOURCE, source))}, nodes


def _only(sets: tuple[str, ...]) -> str:
    if len(sets) != 1:
        raise InputError("law_from.sets", sets, "an array holds one control", "Give a Dataset with both")
    return sets[0]


def _numbers(field: str, values: Any) -> NDArray[np.float64]:
    try:
        return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(field, type(values).__name__, "is no table of numbers", "Give numbers") from error


def _check_nodes(nodes: Mapping[str, NDArray[np.float64]]) -> None:
    if not 1 <= len(nodes) <= AXES_MAX:
        raise InputError("law_from.over", list(nodes), "is no table of one to three quantities", "Give one to three")
    for name, values in nodes.items():
        if name not in SIGNALS or name == "psi":
            known = ", ".join(each for each in SIGNALS if each != "psi")
            raise InputError("law_from.over", name, "is no quantity to look up by", f"Choose from {known}")
        if values.ndim != 1 or not np.all(np.isfinite(values)) or np.any(np.diff(values) <= 0.0):
            mend = "Give finite nodes that rise"
            raise InputError(f"law_from.over.{name}", values.tolist(), "does not rise from node to node", mend)
    if np.prod([values.size for values in nodes.values()]) > NODES_MAX:
        raise InputError("law_from.over", list(nodes), f"has more than {NODES_MAX} entries", "Give a coarser table")
