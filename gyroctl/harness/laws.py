"""Laws by name, for whoever writes Python: `gyroctl.law`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from gyroctl.harness.device_sets import on_file
from gyroctl.harness.protocol import Law
from gyroctl.harness.registry import build
from gyroctl.plant import Plant


def law(
    name: str,
    tuning: str | None = None,
    *,
    device: Plant | str | Path | None = None,
    allow_code: Sequence[str | Path] = (),
    **parameters: Any,
) -> Law:
    """Build a law.

    Parameters
    ----------
    name : str
        A registered name, or "file.py:Name" for a law in a user's file.
    tuning : str, optional
        A set of its tuned parameters: "all", or one for a sea alone, as "gamma1", "gamma5", "gamma50"; "real" for all
        seas in real water, or that of `gyroctl.harness.registry.real_set`. A law whose design model goes beyond the
        linear one takes "real" unless told otherwise; one without a design model cannot know of the water, and is told.
    device : Plant, str or Path, optional
        The device that the law is to serve, where it is not that of the paper: gear ratio, inertia of the flywheel and
        design model are then those of the device, and one of another length is controlled as its model at the size of
        Table 1, see `gyroctl.harness.for_device`: all parameters but the pair of a constant law are the model's. Given
        its file, sets that were tuned on it are found beside that, and come before those that ship.
    allow_code : sequence of str or Path, optional
        Files that may run where a tuned set names a law in a file outside the folder of this one.
    **parameters
        Parameters of the law; the defaults are its shipped tuning for all seas. The design model `plant` of a law that
        has one may be a variant, "realistic", or a table of choices as `gyroctl.zhang2017` takes them.

    Returns
    -------
    Law

    Raises
    ------
    InputError
        For an unknown name, set or parameter, a missing file, a value that is not a finite number, or an object that
        is no law.
    """
    if isinstance(device, str | Path):
        device, parameters = on_file(device, name, {**parameters, **({} if tuning is None else {"tuning": tuning})})
        tuning = None
    return build(name, parameters, tuning, allow_code, device)
