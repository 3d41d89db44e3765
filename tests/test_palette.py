"""One look of each law in every picture, whoever stands beside it."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from gyroctl.harness.registry import registered
from gyroctl.palette import GREY, OWN, REFERENCE, REGISTERED, base_of, law_styles
from gyroctl.reports import theme

NAMES = st.lists(st.sampled_from([*REGISTERED, REFERENCE, "mine", "yours", "nmpc[information=oracle]"]), unique=True)


def test_every_law_that_ships_has_a_look_and_no_two_share_one() -> None:
    assert {*REGISTERED, REFERENCE} == set(registered())
    looks = [*REGISTERED.values(), *OWN, GREY]
    for part in ("colour", "symbol", "marker"):
        told = [getattr(look, part) for look in looks if look is not GREY or part == "colour"]
        assert len(set(told)) == len(told)


@given(NAMES)
def test_a_law_looks_the_same_in_any_company(names: list[str]) -> None:
    styles = law_styles(names)
    assert list(styles) == names
    for name in names:
        if name in REGISTERED:
            assert styles[name] == REGISTERED[name]
        if name == REFERENCE:
            assert styles[name] == GREY
    assert styles == law_styles(names, None), "grey is the best constant pair, whether others are measured by it or not"


@given(NAMES)
def test_no_two_entries_of_a_picture_look_alike(names: list[str]) -> None:
    styles = law_styles(names)
    assert len({(style.colour, style.marker) for style in styles.values()}) == len(names)


def test_cases_of_a_law_have_its_colour_and_markers_of_their_own() -> None:
    names = [
        "nmpc[information=oracle]",
        "nmpc",
        "nmpc (gamma50)",
        "nmpc[information=oracle] (gamma50)",
        "coupling (gamma1)",
    ]
    styles = law_styles(names)
    assert {base_of(name) for name in names} == {"nmpc", "coupling"}
    planning = [style for name, style in styles.items() if base_of(name) == "nmpc"]
    assert {style.colour for style in planning} == {REGISTERED["nmpc"].colour}
    assert len({style.marker for style in planning}) == len({style.symbol for style in planning}) == len(planning)
    assert styles["nmpc"] == REGISTERED["nmpc"] and styles["coupling (gamma1)"].colour == REGISTERED["coupling"].colour


def test_laws_of_ones_own_take_what_is_free_however_many_they_are() -> None:
    styles = law_styles(["nmpc", *(f"mine {i}" for i in range(40))])
    assert list(styles.values())[1 : 1 + len(OWN)] == list(OWN)
    assert len({style.colour for style in styles.values()}) == len(REGISTERED) + len(OWN)
    others = [style for name, style in styles.items() if name != "nmpc"]
    assert REGISTERED["nmpc"] not in others, "the look of a law that is there is not free"


def test_reports_have_the_same_table() -> None:
    assert theme.law_styles is law_styles
