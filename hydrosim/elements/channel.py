"""Channels that conditions of triggers may refer to: values of a run, known at every time of it.

    position.BODY.DOF, velocity.BODY.DOF    of the centre of gravity; angles
    speed.BODY                              horizontal, of the centre of gravity
    fender_normal_force.NAME                of a contact point, or the sum over an element
    fender_compression.POINT                of a contact point
    spring_tension.NAME                     of a spring
    line_tension.NAME                       of a catenary, at its fairlead
    strut_force.NAME, strut_length.NAME     of a strut or power take-off; tension is positive
    winch_tension.NAME, winch_length.NAME   of a winch; the length off its drum without load
    torsion_angle.NAME                      of a torsion spring or rotary power take-off
    tank_level.TANK of BODY                 above the bottom of a tank that is pumped
    clearance.NAME                          of a named point from another, or from a plane
    relative_speed.POINT to POINT           of two named points, "eye of a to eye of b"

A link has those of its columns that are its load or its place (`hydrosim.elements.link`). The names
are those in the result of a run.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import permutations
from math import hypot, sqrt
from typing import Any

import numpy as np

from hydrosim.dofs import DOFS
from hydrosim.elements.contact import geometry
from hydrosim.elements.contact.fender import normal_load_of
from hydrosim.elements.contact.geometry import EARTH
from hydrosim.elements.kind import Layout, unit_ranges
from hydrosim.elements.line import catenary, winch
from hydrosim.elements.link import table as links
from hydrosim.elements.link.law import LOAD_OUTPUT, PLACE_OUTPUT, Link
from hydrosim.elements.link.laws import LAWS
from hydrosim.errors import InputError
from hydrosim.files.units import is_same_dimension
from hydrosim.jit.kernels import kernel
from hydrosim.multibody.kinematics import attachment, point_velocity
from hydrosim.multibody.vectors import dot, matvec, sub, vector
from hydrosim.scene import Clearance, ForceElement, When
from hydrosim.scene.catenary import Catenary
from hydrosim.scene.contacts import Contact
from hydrosim.scene.links import CoordinateElement
from hydrosim.scene.winch import Winch
from hydrosim.tanks import contents

(
    POSITION,
    VELOCITY,
    HORIZONTAL_SPEED,
    CLEARANCE,
    RELATIVE_SPEED,
    TANK_LEVEL,
    NORMAL_FORCE,
    COMPRESSION,
    LINE_TENSION,
    WINCH_TENSION,
    WINCH_LENGTH,
    LINK_LOAD,
    LINK_PLACE,
) = range(13)
SCENE_CHANNELS = {
    "position": POSITION,
    "velocity": VELOCITY,
    "speed": HORIZONTAL_SPEED,
    "clearance": CLEARANCE,
    "relative_speed": RELATIVE_SPEED,
    "tank_level": TANK_LEVEL,
}
UNIT_CHANNELS: dict[str, tuple[int, type[ForceElement]]] = {
    "fender_normal_force": (NORMAL_FORCE, Contact),
    "fender_compression": (COMPRESSION, Contact),
    "line_tension": (LINE_TENSION, Catenary),
    "winch_tension": (WINCH_TENSION, Winch),
    "winch_length": (WINCH_LENGTH, Winch),
}
"""Channels of units, with the elements among which these units are numbered."""
LINK_CHANNELS = {
    name: LINK_LOAD if column.output == LOAD_OUTPUT else LINK_PLACE
    for _, declared in LAWS.values()
    for name, column in declared.columns.items()
    if column.output in (LOAD_OUTPUT, PLACE_OUTPUT)
}
"""Channels of links, which those links have whose law declares such a column."""
CHANNEL_KINDS = SCENE_CHANNELS | {n: k for n, (k, _) in UNIT_CHANNELS.items()} | LINK_CHANNELS
CHANNEL = np.dtype([("kind", int), ("first", int), ("end", int)])
"""A channel: its kind and its entries, points, links or tanks with ``first`` <= i <
``end``; two named points for a relative speed."""

GAP = np.dtype(
    [
        *(("body", int), ("point", float, 3), ("to", int), ("other", float, 3)),
        *(("plane", bool), ("normal", float, 3)),
    ]
)
"""A clearance: its point on a body; a point of the other body (`EARTH`: of the earth), and the unit
normal there if it is that of a ``plane``."""
NAMED_POINT = np.dtype([("body", int), ("place", float, 3)])
"""A named point of a body."""
TO = " to "  # between two points


def compile_points(layout: Layout) -> np.ndarray:
    """All named points of a scene, (n,) of `NAMED_POINT`."""
    return np.array([*layout.points.values()], dtype=NAMED_POINT)


def compile_clearances(layout: Layout) -> np.ndarray:
    """All clearances of a scene, (n,) of `GAP`."""
    return np.array([_clearance_row(c, layout) for c in layout.clearances.values()], dtype=GAP)


def _clearance_row(c: Clearance, layout: Layout) -> tuple[Any, ...]:
    body, point = layout.points[c.of]
    if c.to is not None:
        other, place = layout.points[c.to]
        return body, point, other, place, False, (0.0, 0.0, 0.0)
    assert c.plane is not None
    normal = np.array(c.plane.normal, float) / np.linalg.norm(c.plane.normal)
    other = EARTH if c.plane.body is None else layout.body[c.plane.body]
    return body, point, other, c.plane.point, True, normal


@kernel
def clearance(gap, bodies, motion):
    """Present value of a clearance [m]."""
    d, _ = attachment(gap.body, vector(gap.point, 0), bodies, motion)
    normal = vector(gap.normal, 0)
    other = vector(gap.other, 0)
    if gap.to != EARTH:
        other, _ = attachment(gap.to, other, bodies, motion)
        normal = matvec(motion.rotation[gap.to], normal)
    d = sub(d, other)
    return dot(d, normal) if gap.plane else sqrt(dot(d, d))


@kernel
def relative_speed(first, second, bodies, motion):
    """Present relative speed of two named points [m/s]."""
    _, arm = attachment(first.body, vector(first.place, 0), bodies, motion)
    v = point_velocity(first.body, arm, motion)
    _, arm = attachment(second.body, vector(second.place, 0), bodies, motion)
    v = sub(v, point_velocity(second.body, arm, motion))
    return sqrt(dot(v, v))


def compile_channel(
    name: str, elements: Mapping[str, ForceElement], layout: Layout
) -> tuple[int, int, int]:
    """Values of `CHANNEL`; raises InputError if there is no such channel."""
    kind, _, of = name.partition(".")
    channel_range = _channel_range(kind, elements, layout)
    if of not in channel_range:
        there = ", ".join(channel_range) or "nothing in this scene"
        expected = (
            f"one of {', '.join(CHANNEL_KINDS)}"
            if kind not in CHANNEL_KINDS
            else f"{kind}. and {there}"
        )
        raise InputError(f"channel: found {name}; expected {expected}.")
    return CHANNEL_KINDS[kind], *channel_range[of]


def check_unit(when: When, elements: Mapping[str, ForceElement], layout: Layout) -> None:
    """Raises InputError for a value in the unit of a line if its link acts about an axis, or the
    other way."""
    kind, _, of = (when.channel or "").partition(".")
    link = elements.get(of)
    if when.unit is None or not isinstance(link, CoordinateElement):
        return
    turns = link.turns(layout.joints)
    units = ("N*m" if turns else "N") if kind.endswith("_load") else ("rad" if turns else "m")
    if not is_same_dimension(when.unit, "1", units):
        reason = "about an axis" if turns else "along a line"
        raise InputError(
            f"{when.channel}: found a value in {when.unit}; expected one in {units}, as {of} acts"
            f" {reason}."
        )


def _channel_range(
    kind: str, elements: Mapping[str, ForceElement], layout: Layout
) -> dict[str, tuple[int, int]]:
    """Names that a channel of a kind may have, with their entries."""
    body = layout.body
    if kind == "clearance":
        return {name: (k, k + 1) for k, name in enumerate(layout.clearances)}
    if kind == "relative_speed":
        names = enumerate(layout.points)
        return {f"{a}{TO}{b}": (i, j) for (i, a), (j, b) in permutations(names, 2)}
    if kind == "tank_level":
        return {name: (k, k + 1) for k, name in enumerate(layout.tank_names)}
    if kind in ("position", "velocity"):
        pairs = (
            (f"{name}.{dof}", 6 * b + j) for name, b in body.items() for j, dof in enumerate(DOFS)
        )
        return {name: (k, k + 1) for name, k in pairs}
    if kind == "speed":
        return {name: (6 * b, 6 * b + 2) for name, b in body.items()}
    if kind not in UNIT_CHANNELS and kind not in LINK_CHANNELS:
        return {}
    among = UNIT_CHANNELS[kind][1] if kind in UNIT_CHANNELS else Link
    every = unit_ranges(order_units(elements), among)
    units = {name: place for name, place in every.items() if _has_channel(elements[name], kind)}
    unit_indices = {
        unit: (k, k + 1)
        for name, (first, _) in units.items()
        for k, unit in enumerate(elements[name].unit_names(name), first)
    }
    return unit_indices | (units if kind == "fender_normal_force" else {})


def _has_channel(element: ForceElement, kind: str) -> bool:
    """True if an ``element`` has a channel of this ``kind``."""
    return kind in UNIT_CHANNELS or (
        isinstance(element, Link) and kind in LAWS[type(element)][1].columns
    )


def order_units(elements: Mapping[str, ForceElement]) -> dict[str, ForceElement]:
    """The elements in the order in which units are numbered: links as in their table."""
    others = {name: e for name, e in elements.items() if not isinstance(e, Link)}
    return {**others, **links.order_links(elements)}


@kernel
def channel_value(channel, t, y, modes, motion, bodies, elements, tanks):
    """Present value of a channel."""
    k = channel.first
    fenders = elements.fenders
    if channel.kind == POSITION:
        return motion.coordinates[k]
    if channel.kind == VELOCITY:
        return motion.velocity[k]
    if channel.kind == HORIZONTAL_SPEED:
        return hypot(motion.velocity[k], motion.velocity[k + 1])
    if channel.kind == LINE_TENSION:
        return catenary.tension_of(k, t, y, modes, motion, bodies, elements.catenaries)
    if channel.kind == WINCH_TENSION:
        return winch.kinematics(k, t, y, modes, motion, bodies, elements.winches).tension
    if channel.kind == WINCH_LENGTH:
        return winch.kinematics(k, t, y, modes, motion, bodies, elements.winches).length
    if channel.kind == LINK_LOAD:
        return links.find_load(k, t, y, modes, motion, bodies, elements.link_table)
    if channel.kind == LINK_PLACE:
        return links.find_place(k, t, y, modes, motion, bodies, elements.link_table)
    if channel.kind == COMPRESSION:
        return geometry.contact_kinematics(fenders.points[k], bodies, motion).compression
    if channel.kind == CLEARANCE:
        return clearance(elements.triggers.gaps[k], bodies, motion)
    if channel.kind == RELATIVE_SPEED:
        points = elements.triggers.points
        return relative_speed(points[k], points[channel.end], bodies, motion)
    if channel.kind == TANK_LEVEL:
        return contents.level(k, y, tanks) if tanks.each.size > 0 else 0.0
    total = 0.0
    for i in range(k, channel.end):
        contact = geometry.contact_kinematics(fenders.points[i], bodies, motion)
        total += normal_load_of(i, t, y, modes, contact, fenders).N
    return total
