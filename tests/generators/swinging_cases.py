"""Random bodies on joints without damping: pendulums of one to three links, carts, tops, four-bars.

A case is drawn from its seed alone and lasts 60 to 120 s. Some swing so far that their motion is
chaotic.
"""

from math import cos, hypot, pi, sin, sqrt
from typing import NamedTuple

import numpy as np

from tests.generators.long_cases import long_case, long_duration
from tests.generators.random_cases import GRAVITY, Case, Draw, rounded

TURNS = {"hinge": 70.0, "ball": 15.0, "universal": 15.0}
REGULAR = {1: 3.1, 2: 0.9, 3: 0.5}
"""Largest angle from below [rad] by the number of links, at which few motions are chaotic."""
FAR = 0.25  # of the chains: they begin at any angle
COUNTER = [0, -1, 0]
"""Axis of turns from x to z."""


def swinging_case(seed: int) -> Case:
    """The case of a seed, as a case file holds it."""
    d = Draw(seed)
    make = d.one((_chain, _four_bar, _top), 75, 15, 10)
    return make(d, seed)


def _chain(d: Draw, seed: int) -> Case:
    """Links below each other, perhaps on a cart."""
    count = d.one((1, 2, 3), 50, 35, 15)
    most = 3.1 if d.chance(FAR) else REGULAR[count]
    mass = d.order(10.0, 1e5)
    size = d.order(0.3, 10.0)
    bodies: Case = {}
    joints: Case = {}
    z = 0.0
    if d.chance(0.2):
        joints["rail"] = _rail(d, mass)
        bodies["cart"] = _body(d, mass, size, 0.0)
    above = next(iter(bodies), None)
    for k in range(count):
        half = rounded(size * d.between(0.5, 1.5))
        z -= half
        name = f"link{k + 1}"
        bodies[name] = _body(d, mass * d.order(0.3, 3.0), half, z)
        z -= half
        joint: Case = {"body": name, "point": [0.0, 0.0, half], **_turn(d, most)}
        joints[f"pin{k + 1}"] = joint | ({"to": above} if above else {})
        above = name
    rate = 2.0 * sqrt(GRAVITY / size)
    return long_case(d, seed, rate, long_duration(d), bodies=bodies, joints=joints)


def _rail(d: Draw, mass: float) -> Case:
    stiffness = rounded(mass * d.order(0.5, 4.0) ** 2)
    return {"type": "slider", "body": "cart", "axis": [1, 0, 0], "stiffness": stiffness}


def _body(d: Draw, mass: float, size: float, z: float) -> Case:
    extent = [size * d.between(0.1, 0.5) for _ in range(3)]
    radii = [rounded(hypot(extent[i - 1], extent[i - 2])) for i in range(3)]
    body = {"mass": rounded(mass), "centre_of_gravity": [0.0, 0.0, rounded(z)]}
    return {**body, "radii_of_gyration": radii, "weight": "carried"}


def _turn(d: Draw, most: float) -> Case:
    """A joint that begins at an angle of at most ``most`` [rad]."""
    kind = d.one(tuple(TURNS), *TURNS.values())
    angle, aside = d.between(0.1 * most, most), d.between(-0.3, 0.3)
    if kind == "ball":
        return {"type": kind, "initial": {"rotation": [aside, min(angle, 2.8), 0.0]}}
    if kind == "hinge":
        return {"type": kind, "axis": [0, 1, 0], "initial": {"angle": angle}}
    first, second = {"initial": {"angle": angle}}, {"initial": {"angle": aside}}
    axes: Case = {"axis": [0, 1, 0], "second_axis": [1, 0, 0]}
    return {"type": kind, **axes, "first": first, "second": second}


def _top(d: Draw, seed: int) -> Case:
    """A body that spins on a ball joint below or above its centre."""
    size = d.order(0.3, 3.0)
    up = rounded(size * d.between(-0.5, 0.5))
    body = _body(d, d.order(1.0, 1e3), size, up)
    spin = d.between(2.0, 12.0)
    start = {"rotation": [d.between(0.1, 0.6), 0.0, 0.0], "rate": [0.0, 0.0, spin]}
    pin = {"type": "ball", "body": "top", "point": [0.0, 0.0, -up], "initial": start}
    parts: Case = {"bodies": {"top": body}, "joints": {"pin": pin}}
    return long_case(d, seed, max(spin, 2.0 * sqrt(GRAVITY / size)), long_duration(d), **parts)


class _Linkage(NamedTuple):
    """Corners A, B, C, D (2,) in the plane x, z; crank A-B, coupler B-C, rocker C-D."""

    corners: tuple[np.ndarray, ...]

    def rates(self, crank: float) -> tuple[float, float, float]:
        """Rates [rad/s] of crank, coupler and rocker."""
        A, B, C, D = self.corners
        M = np.column_stack([_across(C - B), -_across(C - D)])
        coupler, rocker = np.linalg.solve(M, -crank * _across(B - A))
        return crank, float(coupler), float(rocker)


def _across(r: np.ndarray) -> np.ndarray:
    """r turned by a right angle."""
    return np.array([-r[1], r[0]])


def _linkage(size: float, angle: float) -> _Linkage:
    """A crank of 1, a coupler of 3.5 and a rocker of 3 on a ground of 4, times ``size``."""
    A, D = np.zeros(2), np.array([4.0, 0.0])
    B = np.array([cos(angle), sin(angle)])
    far = np.linalg.norm(D - B)
    along = (far**2 + 3.5**2 - 3.0**2) / (2.0 * far)
    e = (D - B) / far
    C = B + along * e + sqrt(3.5**2 - along**2) * _across(e)
    return _Linkage(tuple(size * x for x in (A, B, C, D)))


def _four_bar(d: Draw, seed: int) -> Case:
    """A crank, a coupler and a rocker under their weight, at rest or turning."""
    size = d.order(0.3, 3.0)
    linkage = _linkage(size, d.between(-pi, pi))
    A, B, C, D = linkage.corners
    crank, coupler, rocker = linkage.rates(d.one((0.0, d.between(-3.0, 3.0))))
    ends = {"crank": (A, B), "coupler": (B, C), "rocker": (C, D)}
    bodies = {name: _bar(d, size, *both) for name, both in ends.items()}
    joints = {
        "a": _pin("crank", ends, A, rate=crank),
        "b": _pin("coupler", ends, B, to="crank", rate=coupler - crank),
        "d": _pin("rocker", ends, D, rate=rocker),
        "c": _pin("coupler", ends, C, to="rocker"),
    }
    rate = max(2.0 * sqrt(GRAVITY / size), abs(crank), abs(coupler))
    return long_case(d, seed, rate, long_duration(d), bodies=bodies, joints=joints)


def _bar(d: Draw, size: float, one: np.ndarray, other: np.ndarray) -> Case:
    x, z = (one + other) / 2
    body = _body(d, 100.0 * d.order(0.5, 2.0) * size**3, float(np.linalg.norm(other - one)) / 2, z)
    return {**body, "centre_of_gravity": [0.0, 0.0, float(z)], "location": [float(x), 0.0]}


def _pin(
    body: str, ends: dict[str, tuple[np.ndarray, np.ndarray]], at: np.ndarray, **keys: object
) -> Case:
    """A hinge of a bar at a corner; it keeps the corner to rounding, for the loop closes there."""
    x, z = at - sum(ends[body]) / 2
    joint: Case = {"type": "hinge", "body": body, "point": [float(x), 0.0, float(z)]}
    rate = keys.pop("rate", 0.0)
    return {**joint, "axis": COUNTER, **keys} | ({"initial": {"rate": rate}} if rate else {})
