"""Linear models in the forms of other tools: python-control and MATLAB."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

NAMES = ("states", "inputs", "outputs")


def control_system(model: Any, name: str, *period: float) -> Any:
    """Return a `control.StateSpace` with named signals, in discrete time where there is a sampling period [s]."""
    import control

    names = {kind: list(getattr(model, kind)) for kind in NAMES}
    return control.ss(model.A, model.B, model.C, model.D, *period, **names, name=name)


def save_matlab(path: str | Path, model: Any, **more: Any) -> None:
    """Write matrices, names as cell arrays, and more; the sample of a periodic model is the last index there."""
    from scipy.io import savemat

    matrices = {name: getattr(model, name) for name in "ABCD"}
    turned = {name: np.moveaxis(m, 0, -1) if m.ndim == 3 else m for name, m in matrices.items()}
    names = {kind: np.array(getattr(model, kind), dtype=object)[:, None] for kind in NAMES}
    savemat(path, {**turned, **names, **more})
