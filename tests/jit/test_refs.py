"""References to tuples in kernels: what is read through one is what the tuple holds."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from numba import jit

from hydrosim.jit.linking import OPTIONS
from hydrosim.jit.refs import ref

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
    here = ref(outer)
    fill(here.inner)
    return total(here), total(ref(here)), total(outer)


def test_reads_and_writes() -> None:
    outer = Outer(
        Inner(np.array([1.0, 2.0]), True), (Inner(np.array([5.0]), False), np.arange(3.0)), 3
    )
    expected = (2.0 + 10.0) + 5.0 + 2.0 + 3
    assert through(outer) == (expected, expected, expected)
    assert outer.inner.x[0] == 7.0
