"""Applied force: a table in time on a point of a body, earth-fixed or body-fixed.

    F = f(t)  or  R f(t),   M = m(t) + arm x F  (m turned as F is)

f, m: force and moment between the table's points on straight lines, constant before the first and
after the last; arm: from the centre of gravity to the point. Work is F v. The corners of the table
are breakpoints of the integration. A deballasting ramp is an earth-fixed force; fixed to the body
it would push sideways through pitch and roll.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from hydrosim.forces.layout import Layout
from hydrosim.kernels import kernel
from hydrosim.rigid import add_wrench, attachment, point_velocity
from hydrosim.rigid.vectors import add, cross, dot, matvec, scale, vector
from hydrosim.scene import ForceElement


@dataclass(frozen=True)
class AppliedForce(ForceElement):
    """``force`` (n, 6) [N, N m] at ``time`` (n,) [s] on ``point`` of the body frame."""

    supplies: ClassVar[bool] = True
    point: tuple[float, ...]
    time: np.ndarray
    force: np.ndarray
    body_fixed: bool = False


APPLIED = np.dtype(
    [
        *(("body", int), ("row", int), ("point", float, 3), ("body_fixed", bool)),
        *(("first", int), ("last", int)),
    ]
)


class Params(NamedTuple):
    """``each`` (ne,) of `APPLIED`; the table of one is ``time`` and ``force`` (nt, 6) from its row
    ``first`` to before its row ``last``."""

    each: np.ndarray
    time: np.ndarray
    force: np.ndarray


def compile_elements(elements: Mapping[str, ForceElement], layout: Layout) -> Params:
    """Constants of the applied forces among ``elements``."""
    rows, time, force, last = [], [np.zeros(0)], [np.zeros((0, 6))], 0
    for name, e in elements.items():
        if isinstance(e, AppliedForce):
            first, last = last, last + len(e.time)
            place = (layout.body[e.body], layout.row[name], e.point, e.body_fixed)
            rows.append((*place, first, last))
            time.append(e.time)
            force.append(e.force)
    return Params(np.array(rows, dtype=APPLIED), np.concatenate(time), np.concatenate(force))


@kernel
def add_force(t, y, modes, motion, bodies, p, wrench, rate, dy):
    """Every applied force into its row of ``wrench``, its power into ``rate``."""
    for e in p.each:
        b, row = e.body, e.row
        force, moment = table_value(t, p.time, p.force, e.first, e.last)
        if e.body_fixed:
            force, moment = matvec(motion.rotation[b], force), matvec(motion.rotation[b], moment)
        _, arm = attachment(b, vector(e.point, 0), bodies, motion)
        add_wrench(b, force, add(moment, cross(arm, force)), wrench[row])
        omega = vector(motion.velocity, 6 * b + 3)
        rate[row] += dot(force, point_velocity(b, arm, motion)) + dot(moment, omega)


@kernel
def table_value(t, time, force, first, last):
    """Force and moment at ``t`` from rows ``first`` to ``last`` of a table, linear between."""
    k = first + np.searchsorted(time[first:last], t)
    if not first < k < last:
        k = min(k, last - 1)
        return vector(force[k], 0), vector(force[k], 3)
    x = (t - time[k - 1]) / (time[k] - time[k - 1])
    before, after = force[k - 1], force[k]
    return (
        add(scale(1.0 - x, vector(before, 0)), scale(x, vector(after, 0))),
        add(scale(1.0 - x, vector(before, 3)), scale(x, vector(after, 3))),
    )


@kernel
def add_energy(t, y, modes, motion, bodies, p, stored):
    """An applied force stores nothing."""
