"""Bodies that are all free, held together by multipliers: a model with too many coordinates.

    M a = F + sum of J_k^T l_k,   J_k a = -J_k' v

a: accelerations (6 nb,) of centres of gravity and angular accelerations, earth frame. Each row of J
is the second derivative of a condition: two points coincide, or two directions, one of each body,
stay at right angles (Haug 1989, chapter 9). Nothing here comes from hydrosim.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

EARTH = -1
RIGHT_ANGLES: Mapping[str, Sequence[tuple[int, int]]] = {
    "ball": (),
    "universal": ((0, 1),),
    "hinge": ((1, 0), (2, 0)),
    "cylindrical": ((1, 0), (2, 0)),
    "planar": ((1, 0), (2, 0)),
    "slider": ((1, 0), (2, 0), (1, 2)),
    "fixed": ((1, 0), (2, 0), (1, 2)),
}
"""Axes of `to` and of `body`, by number, that stay at right angles. For the slider and the fixed
joint the last pair stops the turn about the first axis."""

SLIDES: Mapping[str, Sequence[int]] = {"slider": (0,), "cylindrical": (0,), "planar": (1, 2)}
"""Axes of `to` along which the points may part."""


class Rigid(NamedTuple):
    """A body at an instant: mass, inertia about its centre in the earth frame, place of the centre,
    rotation, velocity and angular velocity; ``load`` (6,) is the wrench about its centre."""

    mass: float
    inertia: np.ndarray
    place: np.ndarray
    rotation: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray
    load: np.ndarray


class Link(NamedTuple):
    """A joint: its kind, numbers of the bodies, points and axes by rows in the frames of both."""

    kind: str
    body: int
    to: int
    point: np.ndarray
    to_point: np.ndarray
    axes: np.ndarray
    to_axes: np.ndarray


STILL = Rigid(1.0, np.eye(3), np.zeros(3), np.eye(3), np.zeros(3), np.zeros(3), np.zeros(6))


class Rows(NamedTuple):
    """J (r, 6 nb), J' v (r,), and wrenches (r, 6) on the body about the joint's point on it."""

    J: np.ndarray
    bias: np.ndarray
    wrench: np.ndarray


def joint_wrenches(bodies: Sequence[Rigid], links: Sequence[Link]) -> list[np.ndarray]:
    """Wrench (6,) of each joint on its body, about the joint's point on the body."""
    n = 6 * len(bodies)
    M, F = np.zeros((n, n)), np.zeros(n)
    for b, body in enumerate(bodies):
        k = 6 * b
        M[k : k + 3, k : k + 3] = body.mass * np.eye(3)
        M[k + 3 : k + 6, k + 3 : k + 6] = body.inertia
        F[k : k + 6] = body.load
        F[k + 3 : k + 6] -= np.cross(body.spin, body.inertia @ body.spin)
    each = [_rows(bodies, link) for link in links]
    J = np.vstack([rows.J for rows in each])
    whole = np.block([[M, -J.T], [J, np.zeros((len(J), len(J)))]])
    solution = np.linalg.solve(whole, np.concatenate([F, *(-rows.bias for rows in each)]))
    loads = np.split(solution[n:], np.cumsum([len(rows.J) for rows in each])[:-1])
    return [load @ rows.wrench for load, rows in zip(loads, each, strict=True)]


def openings(bodies: Sequence[Rigid], link: Link) -> list[float]:
    """How far a joint is open: lengths along axes that are no slides, cosines of right angles."""
    one, other = _body(bodies, link.body), _body(bodies, link.to)
    gap = one.place + one.rotation @ link.point - other.place - other.rotation @ link.to_point
    held = [axis for axis in range(3) if axis not in SLIDES.get(link.kind, ())]
    lengths = [float(gap @ other.rotation @ link.to_axes[axis]) for axis in held]
    ours, theirs = (one.rotation @ link.axes.T).T, (other.rotation @ link.to_axes.T).T
    cosines = [float(theirs[i] @ ours[j]) for i, j in RIGHT_ANGLES[link.kind]]
    return [*lengths, *cosines]


def _rows(bodies: Sequence[Rigid], link: Link) -> Rows:
    rows = [*_points(bodies, link), *_angles(bodies, link)]
    return Rows(*(np.array(column) for column in zip(*rows, strict=True)))


def _points(bodies: Sequence[Rigid], link: Link) -> list[tuple[np.ndarray, float, np.ndarray]]:
    """e . (p - q) is constant: p on the body, q and e, an axis that is no slide, on the other."""
    one, other = _body(bodies, link.body), _body(bodies, link.to)
    arm, to_arm = one.rotation @ link.point, other.rotation @ link.to_point
    gap = one.place + arm - other.place - to_arm
    rate = one.velocity + np.cross(one.spin, arm) - other.velocity - np.cross(other.spin, to_arm)
    whirl = np.cross(one.spin, np.cross(one.spin, arm))
    to_whirl = np.cross(other.spin, np.cross(other.spin, to_arm))
    found = []
    for axis in range(3):
        if axis in SLIDES.get(link.kind, ()):
            continue
        e = other.rotation @ link.to_axes[axis]
        e_rate = np.cross(other.spin, e)
        row = np.zeros(6 * len(bodies))
        _add(row, link.body, e, np.cross(arm, e))
        _add(row, link.to, -e, -np.cross(to_arm, e) + np.cross(e, gap))
        bias = e @ (whirl - to_whirl) + 2.0 * e_rate @ rate
        bias += np.cross(other.spin, e_rate) @ gap
        found.append((row, bias, np.concatenate([e, np.zeros(3)])))
    return found


def _angles(bodies: Sequence[Rigid], link: Link) -> list[tuple[np.ndarray, float, np.ndarray]]:
    """u . w = 0, u fixed in the other, w fixed in the body:

    (u . w)'' = (alpha_other - alpha_body) . (u x w) + (omega_other - omega_body) . (u x w)'
    """
    one, other = _body(bodies, link.body), _body(bodies, link.to)
    found = []
    for i, j in RIGHT_ANGLES[link.kind]:
        u, w = other.rotation @ link.to_axes[i], one.rotation @ link.axes[j]
        normal = np.cross(u, w)
        change = np.cross(np.cross(other.spin, u), w) + np.cross(u, np.cross(one.spin, w))
        row = np.zeros(6 * len(bodies))
        _add(row, link.body, np.zeros(3), -normal)
        _add(row, link.to, np.zeros(3), normal)
        wrench = np.concatenate([np.zeros(3), -normal])
        found.append((row, (other.spin - one.spin) @ change, wrench))
    return found


def _body(bodies: Sequence[Rigid], number: int) -> Rigid:
    return STILL if number == EARTH else bodies[number]


def _add(row: np.ndarray, number: int, force: np.ndarray, moment: np.ndarray) -> None:
    if number != EARTH:
        row[6 * number : 6 * number + 3] += force
        row[6 * number + 3 : 6 * number + 6] += moment
