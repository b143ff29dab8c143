"""Segments of lines that are chain, by their weight and stiffness."""

from __future__ import annotations

from collections.abc import Iterator
from math import sqrt
from typing import TYPE_CHECKING

from hydrosim.scene.chain import CHAIN, STEEL

if TYPE_CHECKING:
    from hydrosim.forces.line.catenary import Catenary
    from hydrosim.scene import Environment

SAME_CHAIN = 0.03  # relative difference of EA


def bar_diameters(line: Catenary, water: Environment) -> Iterator[float]:
    """Bar diameters [m] of those segments of a line whose weight and EA are those of chain."""
    buoyant = water.gravity * (1.0 - water.water_density / STEEL)
    for weight, stiffness in zip(line.weight, line.stiffness, strict=True):
        for mass_factor, stiffness_factor in CHAIN.values():
            usual = stiffness_factor * weight / (buoyant * mass_factor)
            if abs(usual - stiffness) < SAME_CHAIN * stiffness:
                yield sqrt(stiffness / stiffness_factor)
                break
