"""Margins: which have ended, in which units they are compared, how a zero is closed in."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hydrosim.integrate.methods import guard_defect, linear_value, next_trial
from hydrosim.jit.kernels import any_negative

BEFORE = np.array([4.0, 1.0, -0.5, 2.0])
AFTER = np.array([-1.0, 3.0, -2.0, -8.0])


def test_a_mode_has_ended_where_a_margin_is_negative() -> None:
    assert any_negative(AFTER)
    assert not any_negative(np.array([0.0, 1.0]))
    assert not any_negative(np.zeros(0))


def test_margins_are_compared_in_units_of_their_larger_end() -> None:
    now = np.array([2.0, -5.0, 0.6, 1.0])
    assert [linear_value(i, now, BEFORE, AFTER) for i in range(4)] == [0.5, -5 / 3, 0.3, 0.125]


def test_phi_is_the_smallest_of_the_margins_that_end_negative() -> None:
    """The second margin is negative in between, but positive at the end: it is not watched."""
    assert guard_defect(np.array([2.0, -5.0, 0.6, 1.0]), BEFORE, AFTER) == 0.125
    assert guard_defect(AFTER, BEFORE, AFTER) == -1.0
    assert guard_defect(np.array([2.0, 3.0]), np.ones(2), np.ones(2)) == 1.0


@given(scale=st.floats(1e-6, 1e6), value=st.floats(-1.0, 1.0))
def test_phi_does_not_depend_on_the_units_of_a_margin(scale: float, value: float) -> None:
    ends = np.array([1.0, 0.5]), np.array([-0.5, -1.0])
    now = np.array([value, 0.3])
    units = np.array([scale, 1.0])
    scaled = guard_defect(now * units, *(e * units for e in ends))
    assert scaled == pytest.approx(guard_defect(now, *ends))


@given(
    lo=st.floats(-10.0, 10.0),
    width=st.floats(1e-3, 10.0),
    f_lo=st.floats(0.0, 1e6),
    f_hi=st.floats(-1e6, -1e-6),
)
def test_the_next_guess_is_inside_the_bracket(
    lo: float, width: float, f_lo: float, f_hi: float
) -> None:
    x = next_trial(lo, f_lo, lo + width, f_hi)
    assert lo + 0.009 * width <= x <= lo + 0.991 * width


def test_the_next_guess_is_where_the_chord_crosses() -> None:
    assert next_trial(1.0, 3.0, 5.0, -1.0) == pytest.approx(4.0)


@pytest.mark.parametrize("power", [1, 3, 9])
def test_the_bracket_closes_on_the_zero(power: int) -> None:
    """Even where the function is as flat as (x - 0.3)^9; every guess takes at least 1 % off."""
    lo, hi = 0.0, 1.0
    for _ in range(2500):
        x = next_trial(lo, (0.3 - lo) ** power, hi, (0.3 - hi) ** power)
        lo, hi = (x, hi) if x <= 0.3 else (lo, x)
        if hi - lo < 1e-10:
            break
    assert lo <= 0.3 <= hi < lo + 1e-10
