"""`ds.plot` of a run and of a comparison: called it draws the whole, its attributes are those that xarray has."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import xarray

from gyroctl.errors import InputError
from gyroctl.plots.laws import NEEDED as OF_LAWS
from gyroctl.plots.laws import comparison_figure
from gyroctl.plots.run import NEEDED as OF_RUNS
from gyroctl.plots.run import run_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def plain(ds: xarray.Dataset) -> xarray.Dataset:
    """The same variables and attributes, of no class but that of xarray."""
    return xarray.Dataset(ds.data_vars, ds.coords, ds.attrs)


class Drawn:
    """The picture of a dataset, and the single plots of xarray.

    Parameters
    ----------
    ds : xarray.Dataset
        What is drawn.
    draw : callable
        How it is drawn as a whole.
    """

    def __init__(self, ds: xarray.Dataset, draw: Callable[..., Figure]) -> None:
        self._ds, self._draw = ds, draw

    def __call__(self, *arguments: Any, **choices: Any) -> Figure:
        """Draw it; arguments are those of `plots.run.run_figure` or `plots.laws.comparison_figure`."""
        return self._draw(self._ds, *arguments, **choices)

    def __getattr__(self, name: str) -> Any:
        """Return what xarray has: scatter, quiver, streamplot."""
        return getattr(plain(self._ds).plot, name)


@xarray.register_dataset_accessor("gyroctl")  # type: ignore[no-untyped-call]
class Accessor:
    """``ds.gyroctl`` of a dataset that was read from a file: it draws a run or a comparison.

    Parameters
    ----------
    ds : xarray.Dataset
        From `gyroctl.simulate` or `gyroctl.compare`, or read from what they wrote.
    """

    def __init__(self, ds: xarray.Dataset) -> None:
        self._ds = ds

    def plot(self, *arguments: Any, **choices: Any) -> Figure:
        """Draw it.

        Raises
        ------
        InputError
            For a dataset that is neither.
        """
        for needed, draw in ((OF_LAWS, comparison_figure), (OF_RUNS, run_figure)):
            if all(name in self._ds.variables for name in needed):
                return draw(self._ds, *arguments, **choices)
        mend = "Give what gyroctl.simulate or gyroctl.compare returned or wrote"
        raise InputError("dataset", list(self._ds.variables)[:8], "is neither a run nor a comparison", mend)
