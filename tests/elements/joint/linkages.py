"""Linkages in planes, and their motions in minimal coordinates by independent equations."""

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jointed import FRAME, joint, moved
from scenes import scene, steady
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from hydrosim.scene import Body, Joint, Method, Scene

GRAVITY = 9.81
TIGHT = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-13}
IN_PLANE = Rotation.identity()
TILTED = Rotation.from_euler("yx", [0.3, 0.4])


class Bar(NamedTuple):
    """A bar from ``a`` to ``b`` in the plane x, y; its centre of gravity is half way."""

    name: str
    mass: float
    inertia: float
    a: np.ndarray
    b: np.ndarray


class Rates(NamedTuple):
    """Of each bar: velocity of its centre (n, 2) and angular velocity (n,)."""

    v: np.ndarray
    w: np.ndarray


def across(r: np.ndarray) -> np.ndarray:
    """r turned by a right angle: the velocity of a point at r for unit angular velocity."""
    return np.array([-r[1], r[0]])


def body(bar: Bar, turn: Rotation) -> Body:
    """The bar as a body, in a plane that is turned out of x, y."""
    centre = turn.apply([*(bar.a + bar.b) / 2.0, 0.0])
    R = turn.as_matrix()
    inertia = R @ np.diag([0.3 * bar.inertia, 0.9 * bar.inertia, bar.inertia]) @ R.T
    return Body(bar.name, bar.mass, inertia, centre_of_gravity=tuple(centre), points=FRAME)


def at(bar: Bar, place: np.ndarray, turn: Rotation) -> tuple[float, ...]:
    """A place of the plane in the frame of a bar."""
    return tuple(turn.apply([*(place - (bar.a + bar.b) / 2.0), 0.0]))


def hung(bars: list[Bar], turn: Rotation) -> tuple[list[Body], Mapping]:
    """The bars, and their weights along -y of the plane."""
    bodies = [body(bar, turn) for bar in bars]
    weights = {}
    for bar in bars:
        force = turn.apply([0.0, -GRAVITY * bar.mass, 0.0])
        along = dict(zip(("surge", "sway", "heave"), force, strict=True))
        weights[f"weight_{bar.name}"] = steady(bar.name, **along)
    return bodies, weights


class FourBar:
    """Crank A-B, coupler B-C and rocker C-D on the earth, by the angle of the crank."""

    A, D = np.zeros(2), np.array([4.0, 0.0])
    lengths = (1.0, 3.5, 3.0)
    masses = (2.0, 3.0, 4.0)
    inertias = (3.0, 4.5, 6.0)

    def corners(self, angle: float) -> tuple[np.ndarray, np.ndarray]:
        """B and C."""
        crank, coupler, rocker = self.lengths
        B = self.A + crank * np.array([np.cos(angle), np.sin(angle)])
        d = np.linalg.norm(self.D - B)
        e = (self.D - B) / d
        a = (d * d + coupler**2 - rocker**2) / (2.0 * d)
        return B, B + a * e + np.sqrt(coupler**2 - a * a) * across(e)

    def bars(self, angle: float) -> list[Bar]:
        """All three."""
        B, C = self.corners(angle)
        ends = ((self.A, B), (B, C), (C, self.D))
        names = ("crank", "coupler", "rocker")
        each = zip(names, self.masses, self.inertias, ends, strict=True)
        return [Bar(name, m, inertia, *end) for name, m, inertia, end in each]

    def rates(self, angle: float, w: float) -> Rates:
        """For an angular velocity of the crank."""
        B, C = self.corners(angle)
        vB = w * across(B - self.A)
        M = np.column_stack([across(C - B), -across(C - self.D)])
        w2, w3 = np.linalg.solve(M, -vB)
        v = [vB / 2.0, vB + w2 * across(C - B) / 2.0, w3 * across(C - self.D) / 2.0]
        return Rates(np.array(v), np.array([w, w2, w3]))

    def joints(self, angle: float, w: float, turn: Rotation) -> dict[str, Joint]:
        """Four hinges; `c` closes the loop."""
        crank, coupler, rocker = self.rates(angle, w).w
        B, C = self.corners(angle)
        bars = {bar.name: bar for bar in self.bars(angle)}
        ends = {
            "a": ("crank", None, self.A),
            "b": ("coupler", "crank", B),
            "c": ("coupler", "rocker", C),
            "d": ("rocker", None, self.D),
        }
        starts = {"a": crank, "b": coupler - crank, "d": rocker}
        return hinges(bars, ends, starts, turn)

    def acceleration(self, angle: float, w: float) -> float:
        """Of the crank, by Lagrange's equation of its angle."""
        one = self.rates(angle, 1.0)
        h = 1e-5  # derivatives of the rates by the angle, of fourth order
        near = [self.rates(angle + k * h, 1.0) for k in (-2, -1, 1, 2)]
        weights = np.array([1.0, -8.0, 8.0, -1.0]) / (12.0 * h)
        dv = sum(c * r.v for c, r in zip(weights, near, strict=True))
        dw = sum(c * r.w for c, r in zip(weights, near, strict=True))
        m, inertia = np.array(self.masses), np.array(self.inertias)
        mass = m @ (one.v**2).sum(axis=1) + inertia @ one.w**2
        bias = m @ (one.v * dv).sum(axis=1) + inertia @ (one.w * dw)
        return float((-GRAVITY * m @ one.v[:, 1] - bias * w * w) / mass)

    def scene(self, angle: float, w: float, end: float, step: float, turn: Rotation) -> Scene:
        """The linkage under its weight."""
        bodies, weights = hung(self.bars(angle), turn)
        found = scene(bodies, weights, end, step, method=Method.RK4)
        return replace(found, joints=self.joints(angle, w, turn))

    def angles(self, angle: float, w: float, times: np.ndarray) -> np.ndarray:
        """Angle (nt,) of the crank."""

        def rhs(_: float, y: np.ndarray) -> list[float]:
            return [y[1], self.acceleration(*y)]

        return np.asarray(solve_ivp(rhs, (0.0, times[-1]), [angle, w], t_eval=times, **TIGHT).y[0])


class SliderCrank(FourBar):
    """Crank A-B, rod B-C, and a block C that slides along x."""

    lengths = (1.0, 3.0, 0.0)
    masses = (2.0, 3.0, 1.5)
    inertias = (3.0, 4.5, 0.7)

    def corners(self, angle: float) -> tuple[np.ndarray, np.ndarray]:
        crank, rod, _ = self.lengths
        B = crank * np.array([np.cos(angle), np.sin(angle)])
        return B, np.array([B[0] + np.sqrt(rod**2 - B[1] ** 2), 0.0])

    def bars(self, angle: float) -> list[Bar]:
        B, C = self.corners(angle)
        ends = ((self.A, B), (B, C), (C, C))
        each = zip(("crank", "rod", "block"), self.masses, self.inertias, ends, strict=True)
        return [Bar(name, m, inertia, *end) for name, m, inertia, end in each]

    def rates(self, angle: float, w: float) -> Rates:
        B, C = self.corners(angle)
        vB = w * across(B)
        rod = -vB[1] / (C - B)[0]
        vC = vB + rod * across(C - B)
        return Rates(np.array([vB / 2.0, (vB + vC) / 2.0, vC]), np.array([w, rod, 0.0]))

    def joints(self, angle: float, w: float, turn: Rotation) -> dict[str, Joint]:
        rates = self.rates(angle, w)
        crank, rod, _ = rates.w
        B, C = self.corners(angle)
        bars = {bar.name: bar for bar in self.bars(angle)}
        ends = {"a": ("crank", None, self.A), "b": ("rod", "crank", B), "c": ("rod", "block", C)}
        along = tuple(turn.apply([1.0, 0.0, 0.0]))
        slide = joint("slider", "block", None, moved(velocity=rates.v[2, 0]), axis=along)
        return {**hinges(bars, ends, {"a": crank, "b": rod - crank}, turn), "slide": slide}


def hinges(
    bars: Mapping[str, Bar], ends: Mapping, starts: Mapping[str, float], turn: Rotation
) -> dict[str, Joint]:
    """Hinges about the plane's normal: name, bodies, place; rates at the tree's ``starts``."""
    normal = tuple(turn.apply([0.0, 0.0, 1.0]))
    joints = {}
    for name, (one, other, place) in ends.items():
        rate, at_one = moved(velocity=starts.get(name, 0.0)), at(bars[one], place, turn)
        joints[name] = joint("hinge", one, other, rate, point=at_one, axis=normal)
    return joints
