"""Loads and damping by the waves that motions make far away.

By Haskind's relation the loads X of waves follow from the Kochin functions H of the motions, and
the damping B from the loads (Newman 1977, Marine Hydrodynamics, 6.18), in deep water

    X_i(b) = -4 pi i rho g / w H_i(b + pi),   B_ij = w^3 / (4 pi rho g^3) Re int X_i X_j* db.

Loads by pressures on the hull and these differ by the error of the panels, and in resonances of the
water between bodies, where pressures can make the damping negative, their mean is nearer to what
finer panels give than either. In long waves H of surge, sway and roll is a small difference.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hydrosim.database.build.bem import Solution
from hydrosim.database.build.drift import DIRECTIONS, STEP, Complex, Real
from hydrosim.database.build.recipe import FarField
from hydrosim.database.build.water import Water


def by_far_field(
    solutions: Sequence[Solution], headings: Real, wanted: FarField, water: Water
) -> list[Solution]:
    """The ``solutions`` with loads that are in part by Haskind's relation, and the damping of these
    loads: symmetric, and without negative eigenvalues, as energy demands. The ``headings`` are
    evenly spaced round the circle; the water is deep."""
    return [_mixed(solution, headings, wanted, water) for solution in solutions]


def _mixed(solution: Solution, headings: Real, wanted: FarField, water: Water) -> Solution:
    w = solution.frequency
    share = np.interp(w, wanted.rising, [0.0, wanted.share])
    far = haskind(solution.kochin_radiation, w, headings, water)
    loads = (1 - share) * solution.excitation + share * far
    flux = np.real(loads.T @ loads.conj()) * (2 * np.pi / headings.size)
    factor = w**3 / (4 * np.pi * water.density * water.gravity**3)
    return solution._replace(excitation=loads, damping=factor * flux)


def haskind(kochin: Complex, frequency: float, headings: Real, water: Water) -> Complex:
    """Loads (headings, n) for exp(+i w t) of Kochin functions (n, directions) in Capytaine's
    normalisation and time factor; headings are multiples of half a degree."""
    behind = np.rint((headings + np.pi) / STEP).astype(int) % DIRECTIONS.size
    factor = -4j * np.pi * water.density * water.gravity / frequency
    return np.conj(factor * kochin[:, behind].T)
