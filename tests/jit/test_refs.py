"""References to tuples in kernels: what is read through one is what the tuple holds."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from numba import jit

from hydrosim.jit.linking import OPTIONS
from hydrosim.jit.refs import StructReference

pytestmark = pytest.mark.kernels
bare = jit(**OPTIONS)  # without numba's memory manager, as all kernels


class Inner(NamedTuple):
    x: np.ndarray
    flag: bool


class Outer(NamedTuple):
    inner: Inner
    several: tuple
    number: int


@bare
def leaf(inner, i):
    return inner.x[i] + (10.0 if inner.flag else 0.0)


@bare
def total(outer):
    several = outer.several
    return leaf(outer.inner, 1) + leaf(several[0], 0) + several[1][2] + outer.number


@bare
def fill(inner):
    inner.x[0] = 7.0


@bare
def through(outer):
    fill(outer.inner)
    return total(outer)


@bare
def taken_apart(mixed):
    return mixed.first, mixed.flags[0], mixed.flags[1], mixed.second, mixed.table[1, 2], mixed.last


class Mixed(NamedTuple):
    """Members of one byte and of eight, so that places in memory count."""

    first: bool
    flags: tuple
    nothing: tuple
    second: float
    table: np.ndarray
    last: bool


def test_reads_and_writes() -> None:
    first, second = Inner(np.array([1.0, 2.0]), True), Inner(np.array([5.0]), False)
    outer = Outer(first, (second, np.arange(3.0)), 3)
    expected = (2.0 + 10.0) + 5.0 + 2.0 + 3
    assert through(outer) == expected  # as a tuple of numba's own
    assert through(StructReference(outer)) == expected
    assert outer.inner.x[0] == 7.0


@pytest.mark.parametrize("first", [True, False])
@pytest.mark.parametrize("last", [True, False])
def test_members_of_one_byte_and_of_eight_lie_where_kernels_read_them(
    first: bool, last: bool
) -> None:
    mixed = Mixed(first, (last, first), (), 2.5, np.arange(6.0).reshape(2, 3), last)
    assert taken_apart(StructReference(mixed)) == (first, last, first, 2.5, 5.0, last)


def test_what_kernels_cannot_read_is_refused() -> None:
    with pytest.raises(TypeError, match="kernels take no str in a tuple"):
        StructReference(Inner(np.zeros(1), "no"))  # type: ignore[arg-type]


def test_a_view_is_read_by_its_strides() -> None:
    table = np.arange(12.0).reshape(3, 4)
    mixed = Mixed(True, (True, True), (), 0.0, table[::2, 1:], True)
    assert taken_apart(StructReference(mixed))[4] == 11.0
