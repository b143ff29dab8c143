"""Bushing: spring and damper of six components between frames on a body and on another one or the
earth.

    U = x^T K x / 2,   x = (d, theta),   theta = log Q

At rest both frames are at one place and parallel to the axes of the body. R is the rotation of the
frame on the body, F that of the other frame; p and a are their places. d = F^T (p - a) is the
displacement, theta the rotation vector of Q = F^T R, both in the axes of the other frame. With s =
K x the body receives at p, in these axes,

    force  -s_d - (C u)_d,   moment  -J^-T s_theta - (C u)_theta

and the other side the opposite force and moment at the same place p. u = (d', omega) are the
relative velocity of the frames and their relative angular velocity. omega = J theta' with the left
Jacobian J of the rotation group (Chirikjian 2012, Stochastic Models, vol. 2, sec. 10.6),

    J^-T s = s + theta x s / 2 + c theta x (theta x s),
    c = (1 - |theta|/2 cot(|theta|/2)) / |theta|^2

so the load is the gradient of U at any rotation. Dissipation u^T C u.

Limits: theta is not defined at half a turn: a run ends there. With small angles the axes of the
other frame and the lever arms stay as at rest, J is the identity, and the bushing is linear.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import atan2, nan, sqrt, tan
from typing import Any, ClassVar, NamedTuple

import numpy as np

from hydrosim.dofs import about_z
from hydrosim.elements import kind
from hydrosim.elements.contact.geometry import EARTH
from hydrosim.elements.pair import relative_small_turn, relative_turn_rate
from hydrosim.jit.kernels import kernel, root
from hydrosim.modes import ACTING, CONTACT_MARGIN, INACTIVE, MARGINS, MODE, UNDEFINED
from hydrosim.multibody.kinematics import add_wrench, attachment, point_velocity
from hydrosim.multibody.vectors import add, cross, dot, matvec, product, scale, sub, vector
from hydrosim.scene import ForceElement
from hydrosim.scene.restraints import Bushing

BUSHING_OUTPUTS = 12  # see `write_outputs`
MIN_TURN_COSINE = 1e-3  # least 1 + cosine of the relative rotation: 177 deg
SERIES_ANGLE = 0.03  # rad: below, c is a series to 1e-15


BUSHING = np.dtype(
    [
        *(("body", int), ("row", int), ("other", int), ("ends", float, 6), ("axes", float, (3, 3))),
        *(("stiffness", float, (6, 6)), ("damping", float, (6, 6))),
    ]
)
"""Constants of a bushing: the places of both frames, each in the frame of its side; the rotation
from the axes of the body at rest to those of the other side."""


class BushingConstants(NamedTuple):
    """The bushings ``each`` (n,) of `BUSHING` and the first of their rows of modes."""

    each: np.ndarray
    mode: int


class BushingKinematics(NamedTuple):
    """State of a bushing: lever ``arm`` and ``other_arm`` of the place p, in the earth frame; the
    ``axes`` of the other frame; x and u in these axes; the cosine of the relative rotation."""

    arm: tuple[float, float, float]
    other_arm: tuple[float, float, float]
    axes: tuple[tuple[float, float, float], ...]
    x: tuple[float, float, float, float, float, float]
    u: tuple[float, float, float, float, float, float]
    cosine: float


def compile_elements(elements: Mapping[str, ForceElement], layout: kind.Layout) -> BushingConstants:
    """Constants of the bushings among ``elements``, in their order."""
    rows = []
    for name, e in elements.items():
        if isinstance(e, Bushing):
            axes = layout.axes_from(e.body, e.to)
            which = (layout.body[e.body], layout.row[name])
            other = EARTH if e.to is None else layout.body[e.to]
            ends = np.concatenate([e.point, _place_on_other(e, layout)])
            rows.append((*which, other, ends, axes, e.stiffness, e.damping))
    return BushingConstants(np.array(rows, dtype=BUSHING), 0)


def _place_on_other(bushing: Bushing, layout: kind.Layout) -> np.ndarray:
    """Place (3,) of the bushing at rest in the frame of the other side."""
    place = layout.place_at_rest(bushing.body, bushing.point)
    if bushing.to is None:
        return place
    b = layout.body[bushing.to]
    return np.asarray((place - layout.origin[b]) @ about_z(layout.heading[b]))


@kernel
def components_along(axes, v):
    """Components of a vector along three axes."""
    return (dot(axes[0], v), dot(axes[1], v), dot(axes[2], v))


@kernel
def vector_from_components(axes, v):
    """The vector with these components along three axes."""
    return add(add(scale(v[0], axes[0]), scale(v[1], axes[1])), scale(v[2], axes[2]))


@kernel
def column_of(A, k):
    return (A[0, k], A[1, k], A[2, k])


@kernel
def other_axes(bushing, bodies, motion):
    """Axes of the other frame of a bushing, in the earth frame."""
    x = column_of(bushing.axes, 0)
    y = column_of(bushing.axes, 1)
    z = column_of(bushing.axes, 2)
    if bushing.other == EARTH or not bodies.exact:
        return (x, y, z)
    R = motion.rotation[bushing.other]
    return (matvec(R, x), matvec(R, y), matvec(R, z))


@kernel
def kinematics(bushing, bodies, motion):
    """State of a bushing, as an `BushingKinematics`."""
    p, arm = attachment(bushing.body, vector(bushing.ends, 0), bodies, motion)
    v = point_velocity(bushing.body, arm, motion)
    a = vector(bushing.ends, 3)
    other_arm = (0.0, 0.0, 0.0)
    if bushing.other != EARTH:
        a, other_arm = attachment(bushing.other, a, bodies, motion)
        if bodies.exact:
            other_arm = add(other_arm, sub(p, a))
        v = sub(v, point_velocity(bushing.other, other_arm, motion))
    axes = other_axes(bushing, bodies, motion)
    d = components_along(axes, sub(p, a))
    v = components_along(axes, v)
    w = components_along(axes, relative_turn_rate(bushing.body, bushing.other, motion))
    theta, cosine = relative_rotation(bushing, axes, bodies, motion)
    x = (d[0], d[1], d[2], theta[0], theta[1], theta[2])
    u = (v[0], v[1], v[2], w[0], w[1], w[2])
    return BushingKinematics(arm, other_arm, axes, x, u, cosine)


@kernel
def relative_rotation(bushing, axes, bodies, motion):
    """Rotation vector of the body relative to the other frame, in its axes, and the cosine of the
    angle."""
    if not bodies.exact:
        return components_along(axes, relative_small_turn(bushing.body, bushing.other, motion)), 1.0
    R = motion.rotation[bushing.body]
    X = components_along(axes, column_of(R, 0))
    Y = components_along(axes, column_of(R, 1))
    Z = components_along(axes, column_of(R, 2))
    k = scale(0.5, (Y[2] - Z[1], Z[0] - X[2], X[1] - Y[0]))
    sine = sqrt(dot(k, k))
    cosine = 0.5 * (X[0] + Y[1] + Z[2] - 1.0)
    return scale(atan2(sine, cosine) / sine if sine > 0.0 else 1.0, k), cosine


@kernel
def moment_of(theta, s):
    """J^-T s."""
    angle = sqrt(dot(theta, theta))
    if angle < SERIES_ANGLE:
        c = 1.0 / 12.0 + angle * angle / 720.0
    else:
        c = (1.0 - 0.5 * angle / tan(0.5 * angle)) / (angle * angle)
    once = cross(theta, s)
    return add(s, add(scale(0.5, once), scale(c, cross(theta, once))))


@kernel
def load_and_power(bushing, mode, o, bodies):
    """Load (6,) of a bushing on its body, in the axes of the other frame, and the power that it
    dissipates. The load is not a number where theta is not defined, so that the run ends."""
    s = product(bushing.stiffness, o.x, 0)
    f = product(bushing.damping, o.u, 0)
    m = (s[3], s[4], s[5])
    if bodies.exact:
        m = moment_of((o.x[3], o.x[4], o.x[5]), m)
    lost = 0.0
    for i in range(6):
        lost += o.u[i] * f[i]
    z = nan if mode[MODE] == UNDEFINED else 0.0
    force = (z - s[0] - f[0], z - s[1] - f[1], z - s[2] - f[2])
    return force, (z - m[0] - f[3], z - m[1] - f[4], z - m[2] - f[5]), lost


@root
def add_force(t, y, modes, motion, bodies, p, loads):
    """Add the force [N, N m] of every bushing to its row of ``wrench``, and the power [W] that it
    dissipates to ``rate``, in place."""
    for i in range(p.each.size):
        bushing = p.each[i]
        mode = modes[p.mode + i]
        if mode[MODE] == INACTIVE:
            continue
        o = kinematics(bushing, bodies, motion)
        force, moment, lost = load_and_power(bushing, mode, o, bodies)
        loads.rate[bushing.row] += lost
        F = vector_from_components(o.axes, force)
        M = vector_from_components(o.axes, moment)
        add_wrench(bushing.body, F, add(M, cross(o.arm, F)), loads.wrench[bushing.row])
        if bushing.other != EARTH:
            M = scale(-1.0, add(M, cross(o.other_arm, F)))
            add_wrench(bushing.other, scale(-1.0, F), M, loads.wrench[bushing.row])


@root
def add_energy(t, y, modes, motion, bodies, p, stored):
    """Add the energy stored in every bushing to its row of ``stored``."""
    for i in range(p.each.size):
        bushing = p.each[i]
        if modes[p.mode + i, MODE] == ACTING:
            o = kinematics(bushing, bodies, motion)
            s = product(bushing.stiffness, o.x, 0)
            for k in range(6):
                stored[bushing.row] += 0.5 * o.x[k] * s[k]


@root
def write_outputs(modes, motion, bodies, p, out):
    """Write rows of `BUSHING_OUTPUTS` of all bushings to ``out``: x, and the load on the body."""
    for i in range(p.each.size):
        bushing = p.each[i]
        o = kinematics(bushing, bodies, motion)
        force, moment, _ = load_and_power(bushing, modes[p.mode + i], o, bodies)
        acting = modes[p.mode + i, MODE] != INACTIVE
        for k in range(6):
            out[BUSHING_OUTPUTS * i + k] = o.x[k]
        for k in range(3):
            out[BUSHING_OUTPUTS * i + 6 + k] = force[k] if acting else 0.0
            out[BUSHING_OUTPUTS * i + 9 + k] = moment[k] if acting else 0.0


@root
def find_margins(modes, motion, bodies, p, out):
    """Margins of all bushings into ``out`` (4 to a row of modes): room before half a turn."""
    for i in range(p.each.size):
        m = MARGINS * (p.mode + i)
        for k in range(MARGINS):
            out[m + k] = 1.0
        if modes[p.mode + i, MODE] == ACTING:
            out[m + CONTACT_MARGIN] = turn_room(p.each[i], bodies, motion)


@kernel
def turn_room(bushing, bodies, motion):
    """Positive while the relative rotation is less than half a turn."""
    axes = other_axes(bushing, bodies, motion)
    _, cosine = relative_rotation(bushing, axes, bodies, motion)
    return 1.0 + cosine - MIN_TURN_COSINE


@kernel
def transition(i, modes, p):
    """End the action of bushing ``i``, whose rotation has reached half a turn."""
    modes[p.mode + i, MODE] = UNDEFINED


@root
def set_initial_modes(modes, motion, bodies, p):
    """Modes of all bushings for a start."""
    for i in range(p.each.size):
        activate(i, modes, motion, bodies, p)


@kernel
def activate(i, modes, motion, bodies, p):
    """Mode of bushing ``i`` when it becomes active."""
    modes[p.mode + i, MODE] = ACTING if turn_room(p.each[i], bodies, motion) > 0.0 else UNDEFINED


@kernel
def deactivate(i, modes, p):
    """Deactivate bushing ``i``."""
    modes[p.mode + i, MODE] = INACTIVE


def _velocity_map(arm: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Velocity and angular velocity along the ``axes`` (3, 3) at a lever arm, from those of the
    centre of gravity."""
    J = np.kron(np.eye(2), axes.T)
    J[:3, 3:] = -axes.T @ np.cross(arm, np.eye(3)).T
    return J


class BushingKind(kind.ElementKind):
    unit = "bushing"
    variables: ClassVar = {
        "bushing_displacement": kind.Variable(
            "displacement; rotation vector", "m or rad", "axes of the body at rest, moved by `to`"
        ),
        "bushing_load": kind.Variable(
            "force; moment on the body", "N or N m", "axes of the body at rest, moved by `to`"
        ),
        "bushing_mode": kind.Variable("whether the bushing acts", "1", flags="acting absent"),
    }

    def modes(self, p: BushingConstants) -> kind.ModeRows:
        return kind.ModeRows(p.each.size)

    def resistances(self, p: BushingConstants) -> Iterator[kind.LinearResistance]:
        """Damping of each bushing with small angles: u is J times the velocities of its sides."""
        for bushing in p.each:
            J = _velocity_map(bushing["ends"][:3], bushing["axes"])
            if bushing["other"] != EARTH:
                J = np.hstack([J, -_velocity_map(bushing["ends"][3:], bushing["axes"])])
            B = J.T @ bushing["damping"] @ J
            yield kind.LinearResistance(
                bushing["row"], bushing["body"], B, np.zeros(len(B)), other=bushing["other"]
            )

    def undefined_units(self, p: BushingConstants, modes: np.ndarray) -> Iterator[tuple[int, str]]:
        for i in np.flatnonzero(modes[:, MODE] == UNDEFINED).tolist():
            yield i, "it has turned by half a turn, where its rotation vector is not defined"

    def record(
        self, p: BushingConstants, bodies: Any, unit_record: kind.UnitRecord
    ) -> kind.Columns:
        dims = ("time", "bushing", "dof")
        return {
            "bushing_displacement": (dims, unit_record.observed[:, :, :6]),
            "bushing_load": (dims, unit_record.observed[:, :, 6:]),
            "bushing_mode": (dims[:2], unit_record.modes[:, :, MODE].astype(np.int8)),
        }


BUSHING_KIND = BushingKind("bushings", (Bushing,), compile_elements)
