"""Load of a stream by coefficients over its heading: current on a hull, wind on the part above the
water.

    w = U - v_p,   X = c_x(a) |w|^2,   Y = c_y(a) |w|^2,   N = c_n(a) |w|^2

U: velocity of the stream, horizontal, with the gusts of the wind; v_p: velocity of the point on
which the load acts. Further w: horizontal part of the difference; a: the direction of w,
counter-clockwise from the body's x axis (0 from astern, 180 deg from ahead). X and Y act along and
across the body's heading in the horizontal plane, N about the vertical. There is no heave force.
Roll and pitch moments come from the height of the point. The coefficients are forces and moments
per squared speed, 1/2 rho A C in terms of dimensionless ones (such as those of OCIMF 1994,
Prediction of Wind and Current Loads on VLCCs).

Between the given headings c is a periodic cubic spline, exact at them. The body's heading is its
yaw, as for the hydrodynamics (`multibody.heading`). Booked as work.

The current is the mean over the ``depth`` of the load, or over the draught of its body, or that at
the depth of the point (`hydrosim.water.current`). The wind is that at the ``height`` of the load,
or of the point at rest, with the gusts there (`hydrosim.water.wind`).

Limits: a load feels one velocity at a time: no shear over its area, and gusts act on all of it at
the same instant. Its depth and height are those at rest. The only resistance to yawing comes from
the point's own velocity. Measured yaw coefficients include Munk's moment of a steady stream. A body
with hydrodynamics also receives this moment from its added mass (`multibody.heading`).
"""

from __future__ import annotations

from collections.abc import Mapping
from math import atan2
from typing import NamedTuple

import numpy as np

from hydrosim.elements.kind import ElementKind, Layout
from hydrosim.elements.pair import current_on
from hydrosim.errors import InputError
from hydrosim.jit.kernels import kernel, root
from hydrosim.multibody.heading import heading
from hydrosim.multibody.kinematics import add_wrench, attachment, point_velocity
from hydrosim.multibody.tree import FULL_TURN
from hydrosim.multibody.vectors import add, cross, dot, vector
from hydrosim.scene import ForceElement
from hydrosim.scene.loads import CurrentLoad, StreamLoad, WindLoad
from hydrosim.water import wind
from hydrosim.water.current import current_at, is_sheared, mean_current

STREAM_LOAD = np.dtype(
    [
        *(("body", int), ("row", int), ("point", float, 3), ("stream", float, 2)),
        *(("first", int), ("last", int), ("gusts", int), ("direction", float, 2)),
    ]
)
"""A load: ``stream`` is the mean velocity that it feels; ``gusts`` is the column of its gusts along
``direction``, negative for a current."""
SPLINE_PIECE = np.dtype([("start", float), ("powers", float, (4, 3))])
"""A piece of the splines of X, Y and N: its first heading, and the factors of 1, x, x^2, x^3."""


class StreamLoadConstants(NamedTuple):
    """``each`` (ne,) of `STREAM_LOAD`; each has the ``pieces`` with ``first`` <= i < ``last``, of
    which the first has a heading in the first turn. The first column of ``gusts`` is at 10 m, the
    others at the ``heights`` (nh - 1,) [m]."""

    each: np.ndarray
    pieces: np.ndarray
    heights: np.ndarray
    gusts: wind.GustTable


def compile_elements(elements: Mapping[str, ForceElement], layout: Layout) -> StreamLoadConstants:
    """Constants of the loads of streams among ``elements``."""
    rows = []
    pieces = [np.zeros(0, dtype=SPLINE_PIECE)]
    heights = [wind.REFERENCE_HEIGHT]
    first = 0
    for name, e in elements.items():
        if isinstance(e, StreamLoad):
            stream = stream_felt(name, e, layout)
            gusts = -1
            if isinstance(e, WindLoad):
                height = layout.wind.height_felt(height_of(name, e, layout))
                heights += [] if height in heights else [height]
                gusts = heights.index(height)
            pieces.append(_coefficient_splines(e))
            last = first + pieces[-1].size
            place = (layout.body[e.body], layout.row[name], e.point, stream)
            rows.append((*place, first, last, gusts, layout.wind.direction))
            first = last
    constants = np.array(rows, dtype=STREAM_LOAD)
    return StreamLoadConstants(
        constants, np.concatenate(pieces), np.array(heights[1:]), wind.NO_GUSTS
    )


def stream_felt(name: str, load: StreamLoad, layout: Layout) -> tuple[float, float]:
    """Mean velocity [m/s] of the stream that a load feels. Raises InputError if it is unknown."""
    if isinstance(load, WindLoad):
        return layout.wind.velocity_at(height_of(name, load, layout))
    if isinstance(load, CurrentLoad) and load.depth is not None:
        return mean_current(layout.current_profile, *load.depth)
    if layout.draught_of(load.body) is not None or not is_sheared(layout.current_profile):
        return current_on(load.body, layout)
    depth = -float(layout.place_at_rest(load.body, load.point)[2])
    if depth < 0.0:
        raise InputError(
            f"forces.{name}.depth: found none, a point {-depth:.3g} m above the water, and a"
            " current that varies over the depth; expected depth: [top, bottom],"
            f" bodies.{load.body}.draught, or a point below the water"
        )
    x, y = current_at(layout.current_profile, depth)
    return float(x), float(y)


def height_of(name: str, load: WindLoad, layout: Layout) -> float:
    """Height [m] above the still water of the wind that a load feels. Raises InputError if it is
    too low for the profile of the wind."""
    height = load.height
    if height is None:
        height = float(layout.place_at_rest(load.body, load.point)[2])
    if layout.wind.has_profile and height < wind.MIN_HEIGHT:
        raise InputError(
            f"forces.{name}.height: found a height of {height:.3g} m above the water, that of the"
            f" point unless the key is given; expected {wind.MIN_HEIGHT:g} m or more for the"
            f" profile of"
            " the wind. Give height, that of the centre of the area."
        )
    return height


def with_gusts(p: StreamLoadConstants, gusts: wind.GustTable) -> StreamLoadConstants:
    """The same loads in these gusts."""
    return p if gusts is p.gusts else p._replace(gusts=gusts)


def _coefficient_splines(load: StreamLoad) -> np.ndarray:
    """Pieces (n,) of the periodic splines, from the least heading in the first turn on."""
    from scipy.interpolate import CubicSpline  # slow to load, and few scenes have such a load

    headings = np.mod(load.headings, FULL_TURN)
    order = np.argsort(headings)
    values = np.stack([load.surge, load.sway, load.yaw], axis=1)[order]
    nodes = np.append(headings[order], headings[order[0]] + FULL_TURN)
    spline = CubicSpline(nodes, np.vstack([values, values[:1]]), bc_type="periodic")
    pieces = np.zeros(len(values), dtype=SPLINE_PIECE)
    pieces["start"] = nodes[:-1]
    pieces["powers"] = np.moveaxis(spline.c[::-1], 1, 0)
    return pieces


@root
def add_force(t, y, modes, motion, bodies, p, loads):
    """Add the force and moment [N, N m] of every wind or current load to its row of ``wrench``,
    and its power [W] to ``rate``."""
    for e in p.each:
        b = e.body
        _, arm = attachment(b, vector(e.point, 0), bodies, motion)
        v = point_velocity(b, arm, motion)
        along, aside = heading(b, bodies, motion)
        w = (e.stream[0] - v[0], e.stream[1] - v[1])
        if e.gusts >= 0 and wind.has_gusts(p.gusts):
            u = wind.gust_at(t, e.gusts, p.gusts)
            w = (w[0] + u * e.direction[0], w[1] + u * e.direction[1])
        angle = atan2(along * w[1] - aside * w[0], along * w[0] + aside * w[1])
        c = coefficients(angle, e.first, e.last, p.pieces)
        square = w[0] * w[0] + w[1] * w[1]
        X = square * c[0]
        Y = square * c[1]
        force = (along * X - aside * Y, aside * X + along * Y, 0.0)
        moment = (0.0, 0.0, square * c[2])
        add_wrench(b, force, add(moment, cross(arm, force)), loads.wrench[e.row])
        loads.rate[e.row] += dot(force, v) + moment[2] * motion.velocity[6 * b + 5]


@kernel
def coefficients(angle, first, last, pieces):
    """The splines at ``angle``, which is brought into the turn of the pieces."""
    x = (angle - pieces[first].start) % FULL_TURN
    k = first
    while k + 1 < last and pieces[k + 1].start - pieces[first].start <= x:
        k += 1
    x -= pieces[k].start - pieces[first].start
    a = pieces[k].powers
    return (
        a[0, 0] + x * (a[1, 0] + x * (a[2, 0] + x * a[3, 0])),
        a[0, 1] + x * (a[1, 1] + x * (a[2, 1] + x * a[3, 1])),
        a[0, 2] + x * (a[1, 2] + x * (a[2, 2] + x * a[3, 2])),
    )


STREAM_LOAD_KIND = ElementKind("stream_loads", (StreamLoad,), compile_elements)
