"""What the public functions take: a plant, laws by name, waves; what is mixed up is refused by the argument's name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from gyroctl.errors import InputError, check_kind
from gyroctl.harness.laws import law as registered_law
from gyroctl.harness.protocol import Law
from gyroctl.harness.registry import registered
from gyroctl.names import check_apart, text_of
from gyroctl.plant import Plant, given

LAW = 'Give a law, for example gyroctl.law("load_angle"), or its registered name'


def check_plant(plant: Plant) -> None:
    """Refuse what is no plant."""
    given.check_plant(plant)
    text_of("plant.name", plant.name)


def law_of(value: Law | str, field: str = "law") -> Law:
    """Return the law, or the registered one of that name.

    Raises
    ------
    InputError
        Field `field`, for what is neither.
    """
    if isinstance(value, str):
        return registered_law(value)
    if isinstance(value, type):
        raise InputError(field, value.__name__, "is a class and not a law made of it", f"Give {value.__name__}()")
    check_kind(field, value, Law, "a law: it has no period, information, init() and step(t, y, state)", LAW)
    return value


def laws_by_name(laws: Mapping[str, Law | str] | Sequence[str]) -> dict[str, Law]:
    """Return the laws by name; a list of registered names stands for those laws.

    Raises
    ------
    InputError
        Field ``laws``, for a list of laws, which have no names, and for what is no law.
    """
    if isinstance(laws, str) or not isinstance(laws, Mapping | Sequence) or isinstance(laws, Law):
        given = laws if isinstance(laws, str) else type(laws).__name__
        mend = 'Give a mapping from names to laws, for example {"mine": law}'
        raise InputError("laws", given, "is no mapping from names to laws", mend)
    if isinstance(laws, Mapping):
        check_apart("laws", map(str, laws), registered())
        return {text_of("laws", str(name)): law_of(value, f"laws.{name}") for name, value in laws.items()}
    for each in laws:
        if not isinstance(each, str):
            mend = 'Give them with names, for example {"mine": law}'
            raise InputError("laws", f"[{type(each).__name__}]", "is a list of laws without names", mend)
    return {name: registered_law(name) for name in laws}
