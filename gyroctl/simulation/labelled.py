"""The dataset of a run: an `xarray.Dataset` that tells itself in a few lines and draws itself."""

from __future__ import annotations

import xarray

from gyroctl.faces.runs import trajectory_face
from gyroctl.faces.show import as_html, as_text
from gyroctl.plots.of_dataset import Drawn, plain
from gyroctl.plots.run import run_figure


class Trajectory(xarray.Dataset):  # type: ignore[no-untyped-call]
    """A run over time, see `gyroctl.simulation.trajectory`: an `xarray.Dataset` with all its methods.

    ``run.plot(begin, end)`` draws waves, ring, float, controls and power over these times [s]. What is left of it by a
    choice of variables shows itself as xarray does; ``run.dataset`` does so with all of them.
    """

    __slots__ = ()

    def __repr__(self) -> str:
        face = trajectory_face(self)
        return as_text(face) if face is not None else repr(self.dataset)

    def _repr_html_(self) -> str:
        face = trajectory_face(self)
        return as_html(face) if face is not None else self.dataset._repr_html_()

    @property
    def dataset(self) -> xarray.Dataset:
        """The same as a plain `xarray.Dataset`."""
        return plain(self)

    @property
    def plot(self) -> Drawn:  # type: ignore[override]
        """Draw the run when it is called; its attributes are the plots of xarray."""
        return Drawn(self, run_figure)
