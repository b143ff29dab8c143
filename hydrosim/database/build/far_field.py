"""Loads and damping from the waves that motions radiate into the far field.

By Haskind's relation the wave loads X follow from the Kochin functions H of the motions, and the
damping B from the loads (Newman 1977, Marine Hydrodynamics, 6.18). In deep water

    X_i(b) = -4 pi i rho g / w H_i(b + pi),   B_ij = w^3 / (4 pi rho g^3) Re int X_i X_j* db.

These loads differ from loads by pressures on the hull by the error of the panels. In resonances of
the water between bodies, pressures can make the damping negative. There, the mean of both is closer
to the result of finer panels than either. In long waves, H of surge, sway and roll is a small
difference of large numbers.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hydrosim.database.build.bem import Solution
from hydrosim.database.build.drift import DIRECTION_STEP, DIRECTIONS, Complex, Real
from hydrosim.database.build.recipe import FarField
from hydrosim.database.build.water import Water


def by_far_field(
    solutions: Sequence[Solution], headings: Real, wanted: FarField, water: Water
) -> list[Solution]:
    """``solutions`` with loads that come partly from Haskind's relation, and with the damping of
    these loads. The damping is symmetric and has no negative eigenvalues, as energy conservation
    requires. The ``headings`` are evenly spaced around the circle; the water is deep."""
    return [_blend_far_field(solution, headings, wanted, water) for solution in solutions]


def _blend_far_field(
    solution: Solution, headings: Real, wanted: FarField, water: Water
) -> Solution:
    w = solution.frequency
    share = np.interp(w, wanted.rising, [0.0, wanted.share])
    far = haskind(solution.kochin_radiation, w, headings, water)
    loads = (1 - share) * solution.excitation + share * far
    flux = np.real(loads.T @ loads.conj()) * (2 * np.pi / headings.size)
    factor = w**3 / (4 * np.pi * water.density * water.gravity**3)
    return solution._replace(excitation=loads, damping=factor * flux)


def haskind(kochin: Complex, frequency: float, headings: Real, water: Water) -> Complex:
    """Loads (headings, n) for exp(+i w t) from Kochin functions (n, directions) in Capytaine's
    normalisation and time factor. Headings are multiples of half a degree."""
    behind = np.rint((headings + np.pi) / DIRECTION_STEP).astype(int) % DIRECTIONS.size
    factor = -4j * np.pi * water.density * water.gravity / frequency
    return np.conj(factor * kochin[:, behind].T)
