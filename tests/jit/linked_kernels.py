"""Kernels that call each other, for `test_linking`: they are cached, so they stand in a file."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrosim.jit.kernels import kernel, root


class Scale(NamedTuple):
    factor: float
    offset: np.ndarray


@kernel
def scaled(x, scale):
    return scale.factor * x + scale.offset[0]


@root
def summed(values, scale):
    total = 0.0
    for i in range(values.size):
        total += scaled(values[i], scale)
    return total


@root
def twice_summed(values, scale):
    return summed(values, scale) + summed(values[1:], scale)
