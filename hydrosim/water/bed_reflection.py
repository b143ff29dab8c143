"""Sum of interpolated functions over pairs of points: what the sea bed adds to pulsating sources.

`hydrosim.database.build.green` makes the tables. They hold smooth functions of the horizontal
distance R, and of the sum or the difference of the heights of two points.
"""

from __future__ import annotations

from math import sqrt

from hydrosim.jit.kernels import kernel, root

VALUE, BY_R, BY_W, BY_BOTH = range(4)


@kernel
def interpolate(table, r, w):
    """Value and derivatives by ``r`` and ``w`` of a function, all in steps of the ``table`` (nr,
    nw, 4), by bicubic Hermite polynomials."""
    i = min(int(r), table.shape[0] - 2)
    j = min(int(w), table.shape[1] - 2)
    a = r - i
    b = w - j
    value = 0.0j
    by_r = 0.0j
    by_w = 0.0j
    for p in range(2):
        x = a if p == 1 else 1.0 - a
        sign_r = 1.0 if p == 1 else -1.0
        place = x * x * (3.0 - 2.0 * x)
        slope = sign_r * x * x * (x - 1.0)
        place_by_r = sign_r * 6.0 * x * (1.0 - x)
        slope_by_r = x * (3.0 * x - 2.0)
        for q in range(2):
            y = b if q == 1 else 1.0 - b
            sign_w = 1.0 if q == 1 else -1.0
            height = y * y * (3.0 - 2.0 * y)
            tilt = sign_w * y * y * (y - 1.0)
            height_by_w = sign_w * 6.0 * y * (1.0 - y)
            tilt_by_w = y * (3.0 * y - 2.0)
            at = table[i + p, j + q]
            along = place * at[VALUE] + slope * at[BY_R]
            turned = place * at[BY_W] + slope * at[BY_BOTH]
            value += height * along + tilt * turned
            by_w += height_by_w * along + tilt_by_w * turned
            along = place_by_r * at[VALUE] + slope_by_r * at[BY_R]
            turned = place_by_r * at[BY_W] + slope_by_r * at[BY_BOTH]
            by_r += height * along + tilt * turned
    return value, by_r, by_w


@root
def add_reflection(
    points, centres, areas, normals, of_field, of_sum, of_difference, step_r, step_w, S, K
):
    """Add the potentials at ``points`` (n, 3) of sources on panels with ``centres`` (m, 3) and
    ``areas`` (m,) to ``S`` (n, m). Add their slopes along ``normals`` to ``K`` (n, m): along those
    of the points (n, 3) if ``of_field``, else along those of the panels (m, 3).

    The potential of a unit source is the sum of two tables: ``of_sum`` over R and -(z + zeta),
    and ``of_difference`` over R and |z - zeta|.
    """
    for m in range(areas.size):
        for n in range(points.shape[0]):
            dx = points[n, 0] - centres[m, 0]
            dy = points[n, 1] - centres[m, 1]
            dz = points[n, 2] - centres[m, 2]
            R = sqrt(dx * dx + dy * dy)
            down = -(points[n, 2] + centres[m, 2])
            first, first_r, first_w = interpolate(of_sum, R / step_r, down / step_w)
            second, second_r, second_w = interpolate(of_difference, R / step_r, abs(dz) / step_w)
            S[n, m] += areas[m] * (first + second)
            k = n if of_field else m
            away = 1.0 if of_field else -1.0
            level = dx * normals[k, 0] + dy * normals[k, 1]
            along = away * level / R if R > 0.0 else 0.0
            upward = away if dz >= 0.0 else -away
            steep = (upward * second_w - first_w) * normals[k, 2] / step_w
            K[n, m] += areas[m] * (along * (first_r + second_r) / step_r + steep)
