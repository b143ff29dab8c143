"""Current over the depth: a table of velocities, linear between its depths; its mean on bodies.

    U(d) = U_k + (d - d_k) / (d_k+1 - d_k) (U_k+1 - U_k),   d_k <= d <= d_k+1

d: depth below the still water. Above the first and below the last depth U is constant. A table with
a single depth is a uniform current. The velocity of a body is compared with the mean of U over its
draught at rest.

Limits: the table does not change with time, with waves or with place.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from math import cos, sin
from typing import NamedTuple

import numpy as np

from hydrosim.errors import InputError
from hydrosim.jit.kernels import kernel
from hydrosim.scene import Body, CurrentPower, Environment, Scene

PROFILE_PARTS = 100  # of the table of a power law


class TabulatedCurrent(NamedTuple):
    """Velocity (n, 2) [m/s] in the earth's x and y at each ``depth`` (n,) [m], which rises."""

    depth: np.ndarray
    velocity: np.ndarray


def velocity_along(speed: float, heading: float) -> tuple[float, float]:
    """Velocity [m/s] of a stream in the earth's x and y."""
    return speed * cos(heading), speed * sin(heading)


def current_table(environment: Environment) -> TabulatedCurrent:
    """The current of an environment over the depth."""
    current = environment.current
    speed, heading = current.top_speed, current.direction
    table = current.table
    depths: Sequence[float] = (0.0,)
    factors: Sequence[float] = (1.0,)
    turns: Sequence[float] = (0.0,)
    if table is not None:
        depths = table.depth
        factors = [x / speed if speed else 1.0 for x in table.speed]
        turns = [x - heading for x in table.heading or [heading] * len(depths)]
    elif isinstance(current.profile, CurrentPower):
        depth = current.profile.depth or environment.water_depth
        depths, factors = power_profile(current.profile.exponent, depth)
        turns = [0.0] * len(depths)
    rows = [velocity_along(speed * f, heading + t) for f, t in zip(factors, turns, strict=True)]
    return TabulatedCurrent(np.array(depths, dtype=float), np.array(rows))


def is_sheared(table: TabulatedCurrent) -> bool:
    """True if the current differs between depths."""
    return bool(np.any(table.velocity != table.velocity[0]))


def current_at(table: TabulatedCurrent, depth: np.ndarray | float) -> np.ndarray:
    """Velocity (..., 2) [m/s] of the current at ``depth`` (...) [m] below the still water."""
    components = [np.interp(depth, table.depth, table.velocity[:, i]) for i in range(2)]
    return np.stack(components, axis=-1)


def mean_current(table: TabulatedCurrent, top: float, bottom: float) -> tuple[float, float]:
    """Mean velocity [m/s] of the current between two depths [m]. It is exact for the table; a
    uniform current has its own velocity to the bit."""
    first = table.velocity[0]
    if not is_sheared(table):
        return float(first[0]), float(first[1])
    inside = table.depth[(table.depth > top) & (table.depth < bottom)]
    nodes = np.array([top, *inside, bottom])
    change = current_at(table, nodes) - first
    area = np.trapezoid(change, nodes, axis=0)
    mean = first + area / (bottom - top)
    return float(mean[0]), float(mean[1])


def current_on_hull(
    table: TabulatedCurrent, draught: float | None, body: str
) -> tuple[float, float]:
    """Velocity [m/s] of the current on a body: the mean over its ``draught`` [m]. Raises InputError
    if the current varies and the draught is unknown."""
    if not is_sheared(table):
        return mean_current(table, 0.0, 1.0)
    if draught is None:
        raise InputError(
            f"bodies.{body}.draught: found none, and a current that varies over the depth;"
            f" expected the draught of {body}. The current on it is the mean over the draught."
        )
    return mean_current(table, 0.0, draught)


def power_profile(exponent: float, depth: float) -> tuple[list[float], list[float]]:
    """Depths d [m] and factors ((D - d) / D)^a of the speed, with an ``exponent`` a and a ``depth``
    D [m] (DNV-RP-C205, 4.1.4). Raises InputError if the depth is infinite.

    The depths of the table are closer near D, where the law is steep. Its error is below
    0.1 % of the speed at the surface for exponents of 0.1 or more.
    """
    if not np.isfinite(depth):
        raise InputError(
            "environment.current.profile: found a power law in water of infinite depth; expected"
            " the depth at which the current ends. Give depth there."
        )
    part = np.linspace(1.0, 0.0, PROFILE_PARTS + 1)
    steepness = max(2.0 / exponent, 1.0)
    above = part**steepness
    return [float(depth * (1.0 - s)) for s in above], [float(x) for x in above**exponent]


@kernel
def current_velocity(depth, p):
    """Velocity (2,) of the current at a ``depth`` [m] below the still water, as a tuple."""
    last = p.depth.size - 1
    if depth <= p.depth[0]:
        return p.velocity[0, 0], p.velocity[0, 1]
    if depth >= p.depth[last]:
        return p.velocity[last, 0], p.velocity[last, 1]
    k = 0
    while p.depth[k + 1] < depth:
        k += 1
    part = (depth - p.depth[k]) / (p.depth[k + 1] - p.depth[k])
    return (
        p.velocity[k, 0] + part * (p.velocity[k + 1, 0] - p.velocity[k, 0]),
        p.velocity[k, 1] + part * (p.velocity[k + 1, 1] - p.velocity[k, 1]),
    )


# Current on each body: the mean over its draught at rest.


def draught_of(body: Body) -> float | None:
    """Draught [m] of a body at rest: its own, or that of its hull; None if unknown."""
    if body.draught is not None or body.hydrostatics is None:
        return body.draught
    lowest = -float(body.hydrostatics.corners[..., 2].min())
    return lowest if lowest > 0.0 else None


def currents_on(scene: Scene, wet: Collection[str]) -> np.ndarray:
    """Velocity (nb, 2) [m/s] of the current on the bodies that are ``wet``, which move water; 0 for
    others. Raises InputError if it varies and the draught of one of them is unknown."""
    table = current_table(scene.environment)
    currents = np.zeros((len(scene.bodies), 2))
    for b, body in enumerate(scene.bodies):
        if body.name in wet:
            currents[b] = current_on_hull(table, draught_of(body), body.name)
    return currents
