"""What is given for a plant: refused by the argument's name, a path with how it is read."""

from __future__ import annotations

from pathlib import Path

from gyroctl.errors import InputError, check_kind
from gyroctl.plant.plant import Plant


def check_plant(plant: object, field: str = "plant", kind: type = Plant) -> None:
    """Refuse what is no plant.

    Parameters
    ----------
    plant : object
        What was given.
    field : str
        The argument.
    kind : type
        What it must be, `Plant` or a protocol that plants fulfil.

    Raises
    ------
    InputError
        Field `field`; of a path the mend says how it is read.
    """
    if isinstance(plant, str | Path) and str(plant).endswith(".toml"):
        mend = f'Read it first, gyroctl.device("{plant}"), and give what that returns'
        raise InputError(field, str(plant), "is the path of a device file and not a plant", mend)
    check_kind(field, plant, kind, "a plant", "Give one, for example gyroctl.zhang2017()")
