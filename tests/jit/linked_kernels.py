"""Kernels that call each other, for `test_linking`: they are cached, so they stand in a file."""

from typing import NamedTuple

import numpy as np

from hydrosim.jit.kernels import kernel, root, root_giving


class Scale(NamedTuple):
    factor: float
    offset: np.ndarray


@kernel
def scaled(x, scale):
    return scale.factor * x + scale.offset[0]


@root_giving(float)
def summed(values, scale):
    total = 0.0
    for i in range(values.size):
        total += scaled(values[i], scale)
    return total


@root_giving(float)
def twice_summed(values, scale):
    return summed(values, scale) + summed(values[1:], scale)


@root
def fill(values, scale):
    for i in range(values.size):
        values[i] = scale.offset[0]


@root
def misspelt(values):
    values.fil(0.0)


@root_giving(float)
def filled(values, scale, correctly):
    if not correctly:
        misspelt(values)
    if scale.factor > 0.0:
        fill(values, scale)
    return values.sum()
