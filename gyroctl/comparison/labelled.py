"""The dataset of a comparison: an `xarray.Dataset` that tells itself in a few lines and draws itself."""

from __future__ import annotations

import xarray

from gyroctl.faces.runs import comparison_face
from gyroctl.faces.show import as_html, as_text
from gyroctl.plots.laws import comparison_figure
from gyroctl.plots.of_dataset import Drawn, plain


class Comparison(xarray.Dataset):  # type: ignore[no-untyped-call]
    """Laws on identical realisations, see `gyroctl.compare`: an `xarray.Dataset` with all its methods.

    ``found.plot()`` draws power, smoothness, motion and lock of each law, run by run. What is left of it by a choice of
    variables shows itself as xarray does; ``found.dataset`` does so with all of them.
    """

    __slots__ = ()

    def __repr__(self) -> str:
        face = comparison_face(self)
        return as_text(face) if face is not None else repr(self.dataset)

    def _repr_html_(self) -> str:
        face = comparison_face(self)
        return as_html(face) if face is not None else self.dataset._repr_html_()

    @property
    def dataset(self) -> xarray.Dataset:
        """The same as a plain `xarray.Dataset`."""
        return plain(self)

    @property
    def plot(self) -> Drawn:  # type: ignore[override]
        """Draw the comparison when it is called; its attributes are the plots of xarray."""
        return Drawn(self, comparison_figure)
