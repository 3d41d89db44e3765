"""The plant's parameters: numbers of the device, variants, and what is refused."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import gyroctl as gy

POSITIVE = ("a", "b", "d", "r1", "r2", "m1", "m2", "m3", "m4", "J11", "J22", "J13", "J14", "k1", "k3")
NOT_NEGATIVE = ("c", "Jh1", "Jh3", "d1", "d3")


# --- numbers of the device ---------------------------------------------------------------------------------------


def test_derived_constants_of_table_1(device: gy.Plant) -> None:
    """(16) with the numbers of Table 1, typed here by hand."""
    p = device.parameters
    assert p.N == pytest.approx(0.203 / 0.009, rel=1e-15)
    assert p.J2 == pytest.approx(0.0952 + (508.7530864 + 0.5) * 0.0009208 + 0.3671 / 2, rel=1e-9)
    assert p.J3 == pytest.approx(0.0004604, rel=1e-12)
    assert p.J4 == 0.3671
    assert p.K == pytest.approx(0.0004604 + 0.18355, rel=1e-12)
    assert p.lever_inertia == pytest.approx(0.279, abs=5e-4)
    assert math.sqrt(146.7 / (p.J1 + 14.39)) == pytest.approx(1.29, abs=5e-3)
    lever = 21.68 + 0.0476 + 0.0004604 + 0.18355
    assert p.J1 == pytest.approx(lever + 20.27 * 0.9891**2 + 27.983 * 1.0652**2, rel=1e-9)


def test_slip_decays_at_683_times_cc(device: gy.Plant) -> None:
    """The slip alone, in the ring's frame: its rate is cc (N^2/J2 + 1/J4)."""
    from gyroctl.plant.kernel import slip_rate

    p, x = device.parameters, np.zeros(14)
    x[7] = 1.0
    dx = device.derivative(x, (0.052, 0.0), (0.0, 0.0))
    free = dx[7] - p.N * dx[6]
    assert free == pytest.approx(-0.052 * 683.2, rel=2e-2)  # the float is a little free to move with it
    assert slip_rate(device.coefficients, 1.0) == pytest.approx(p.N**2 / p.J2 + 1 / p.J4, rel=1e-12)
    assert slip_rate(device.coefficients, 1.0) == pytest.approx(683.0, abs=0.5)
    assert slip_rate(gy.zhang2017(connection="rigid").coefficients, 1.0) == pytest.approx(0.0, abs=1e-9)


def test_labels_are_those_of_the_contract(device: gy.Plant) -> None:
    assert device.labels == (
        "phi1",
        "phi3",
        "psi",
        "omega",
        "phi1_rate",
        "phi3_rate",
        "psi_rate",
        "omega_rate",
        "z1_1",
        "z1_2",
        "z1_3",
        "z3_1",
        "z3_2",
        "z3_3",
    )
    assert len(gy.zhang2017(radiation="fine").labels) == 16


def test_power_is_cg_times_the_square_of_the_speed(device: gy.Plant) -> None:
    """Trap 2, with the paper's own figures: cg 3.5e-4 at 71 rad/s gives 1.76 W."""
    x = np.zeros((14, 2))
    x[7] = 71.0, 35.5
    np.testing.assert_allclose(device.power(x, (0.052, 3.5e-4)), [1.764, 1.764 / 4], rtol=1e-3)


# --- variants ----------------------------------------------------------------------------------------------------


def test_paper_is_the_corrected_plant_with_every_erratum_put_back_by_name(printed: gy.Plant) -> None:
    choices: dict[str, Any] = {
        "generator_reaction": True,
        "lever_gyroscopic": False,
        "d1": 0.0,
        "radiation": "paper",
        "excitation_phase": "magnitude",
    }
    built = gy.zhang2017("corrected", **choices)
    assert built.parameters == printed.parameters
    assert built.radiation == printed.radiation
    assert built.excitation.sha256 == printed.excitation.sha256
    for left_out in choices:
        partial = gy.zhang2017(**{name: value for name, value in choices.items() if name != left_out})
        assert (partial.parameters, partial.radiation, partial.excitation.sha256) != (
            printed.parameters,
            printed.radiation,
            printed.excitation.sha256,
        )


def test_presets_hold_what_the_design_says(device: gy.Plant, printed: gy.Plant) -> None:
    assert (device.parameters.d1, device.parameters.d3) == (2.0, 0.0)
    assert (printed.parameters.d1, printed.parameters.d3) == (0.0, 0.0)
    np.testing.assert_allclose(printed.radiation[0].p, [1396.494, 4584.783, 724.177], rtol=1e-3)
    np.testing.assert_allclose(printed.radiation[1].q, [11.6028, 83.0018, 134.1893], rtol=1e-3)
    low = [plant.radiation[0].response(1.2).real for plant in (device, printed)]
    assert low[0] == pytest.approx(0.27, abs=0.08)  # what the BEM has
    assert low[1] == pytest.approx(1.24, abs=0.02)  # trap 5: the unweighted fit over-damps 4.5 times


def test_printed_excitation_has_one_phase_and_the_true_one_two(device: gy.Plant, printed: gy.Plant) -> None:
    """Trap 4: about 82 degrees between the two moments near the peak."""
    w = np.array([2.5, 3.1, 4.0])
    true, one = device.excitation(w), printed.excitation(w)
    np.testing.assert_allclose(np.abs(one), np.abs(true), rtol=5e-3)
    np.testing.assert_allclose(np.angle(one), 0.0, atol=1e-12)
    apart = np.rad2deg(np.angle(true[0, 1] / true[1, 1]))
    assert apart == pytest.approx(82.0, abs=2.0)


def test_replace_changes_one_choice_and_nothing_else(device: gy.Plant) -> None:
    changed = device.replace(d1=1.0)
    assert changed.parameters.d1 == 1.0
    assert dataclasses.replace(changed.parameters, d1=2.0) == device.parameters
    assert changed.radiation is device.radiation and device.parameters.d1 == 2.0
    assert device.replace(name="mine", d3=0.5).name == "mine"
    assert device.replace(name="mine", d3=0.5).parameters.d3 == 0.5


def test_derived_numbers_follow_a_replaced_parameter(device: gy.Plant) -> None:
    """The constants are cached: a plant made by `replace` must not inherit the old ones."""
    assert device.coefficients.d1 == 2.0
    assert device.replace(d1=0.5).coefficients.d1 == 0.5
    assert len(device.replace(radiation=gy.zhang2017(radiation="fine").radiation).labels) == 16


# --- refusals ----------------------------------------------------------------------------------------------------


def parameters_with(name: str, value: Any) -> gy.Parameters:
    changes: dict[str, Any] = {name: value}
    return gy.Parameters(**changes)


@pytest.mark.parametrize("name", POSITIVE + NOT_NEGATIVE)
@given(value=st.floats(max_value=0.0, exclude_max=True) | st.sampled_from([math.nan, math.inf, -math.inf]))
@settings(max_examples=10, deadline=None)
def test_parameter_out_of_range_is_named(name: str, value: float) -> None:
    with pytest.raises(gy.InputError) as caught:
        parameters_with(name, value)
    assert caught.value.field == f"plant.{name}"
    assert repr(caught.value.value) == repr(value)
    assert caught.value.mend and name in str(caught.value) and repr(value) in str(caught.value)


@pytest.mark.parametrize("name", POSITIVE)
def test_zero_is_refused_where_it_has_no_meaning(name: str) -> None:
    with pytest.raises(gy.InputError, match=rf"plant\.{name} = 0\.0: must be positive"):
        parameters_with(name, 0.0)


@pytest.mark.parametrize("name", NOT_NEGATIVE)
def test_zero_is_allowed_where_it_has_a_meaning(name: str) -> None:
    assert getattr(parameters_with(name, 0.0), name) == 0.0


@pytest.mark.parametrize("value", ["2.0", None, True, [1.0], 1j])
def test_parameter_of_another_type_is_refused(value: Any) -> None:
    with pytest.raises(gy.InputError, match=r"plant\.d1"):
        gy.Parameters(d1=value)


@pytest.mark.parametrize(
    ("field", "changes"),
    [
        ("plant.connection", {"connection": "elastic"}),
        ("plant.generator_reaction", {"generator_reaction": 1}),
        ("plant.lever_gyroscopic", {"lever_gyroscopic": "yes"}),
        ("plant.r2", {"r2": 0.005}),
        ("plant.r2", {"r1": 0.203}),
        ("plant.J22", {"J22": 1e-5}),
        ("plant.springs", {"springs": 3}),
        ("plant.J11", {"J11": -21.68}),
        ("plant.variant", {"variant": "improved"}),
        ("plant.radiation", {"radiation": "best"}),
        ("plant.radiation", {"radiation": 3}),
        ("plant.radiation", {"radiation": (gy.Radiation((1.0,), (1.0,)),)}),
        ("plant.excitation_phase", {"excitation_phase": "none"}),
    ],
)
def test_bad_choice_is_named(field: str, changes: dict[str, Any]) -> None:
    with pytest.raises(gy.InputError) as caught:
        gy.zhang2017(**changes)
    assert caught.value.field == field
    assert caught.value.mend


def test_replace_names_an_unknown_parameter_and_the_known_ones(device: gy.Plant) -> None:
    with pytest.raises(gy.InputError, match=r"plant\.dl = 2\.0: unknown parameter.*d1") as caught:
        device.replace(dl=2.0)
    assert caught.value.field == "plant.dl"


@pytest.mark.parametrize("shape", [(13,), (15,), (), (13, 14), (2, 14, 3)])
def test_state_of_another_shape_is_refused(device: gy.Plant, shape: tuple[int, ...]) -> None:
    with pytest.raises(gy.InputError, match="the state has 14 rows"):
        device.derivative(np.zeros(shape), (0.05, 1e-3), (0.0, 0.0))
