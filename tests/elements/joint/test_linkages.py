"""Loops of hinges and sliders against their equation in one coordinate.

A planar mechanism with one degree of freedom, the angle a of its crank, has T = I(a) a'^2 / 2 and

    I a'' + I_a a'^2 / 2 = -V_a,
    I(a) = sum of m |x_a|^2 + J b_a^2,   V(a) = sum of m g z

x(a), b(a): centre and angle of each link; index a: derivative. They follow from geometry alone, in
closed form and without `arctan`, so that the complex step gives I_a to rounding.
"""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
import pytest
import xarray as xr
from jointed import (
    G,
    apart,
    assert_order,
    carried,
    completed,
    joint,
    moved,
    places,
    rotations,
    scene,
)
from solutions import solved

from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import Body, Joint, Scene

Vector = np.ndarray
WITHIN, CLOSED, ORDER = 1e-9, 1e-12, 3.8
TIME = np.linspace(0.0, 6.0, 121)
COUNTER = (0.0, -1.0, 0.0)  # axis of turns from x to z
TINY = 1e-30  # complex step


class Link(NamedTuple):
    """A uniform rod in the plane."""

    mass: float
    length: float

    @property
    def inertia(self) -> float:
        """Inertia about its centre [kg m^2]."""
        return self.mass * self.length**2 / 12.0


class Pose(NamedTuple):
    """Centre of a link, its derivative, and that of its angle, by the angle of the crank."""

    centre: Vector
    slope: Vector
    turn: complex


class Mechanism(NamedTuple):
    """The ``links`` by name and their ``poses`` at an angle of the crank."""

    links: Mapping[str, Link]
    poses: Callable[[complex], Mapping[str, Pose]]

    def inertia(self, a: complex) -> complex:
        """I(a)."""
        poses = self.poses(a)
        links = [(link, poses[name]) for name, link in self.links.items()]
        return sum(k.mass * (p.slope @ p.slope) + k.inertia * p.turn**2 for k, p in links)

    def potential(self, a: complex) -> complex:
        """V(a)."""
        poses = self.poses(a)
        return sum(link.mass * G * poses[name].centre[1] for name, link in self.links.items())

    def acceleration(self, a: float, rate: float) -> float:
        """a''."""
        inertia = self.inertia(a + 1j * TINY)
        slope = self.potential(a + 1j * TINY).imag / TINY
        return -(0.5 * inertia.imag / TINY * rate**2 + slope) / inertia.real

    def centres(self, start: float, rate: float) -> dict[str, np.ndarray]:
        """Centres of the links (nt, 3) over time."""

        def equations(t: float, y: Vector) -> Vector:
            return np.array([y[1], self.acceleration(*y)])

        a = solved(equations, [start, rate], TIME)[0]
        poses = [self.poses(complex(angle)) for angle in a]
        return {
            name: np.array([[x.real, 0.0, z.real] for x, z in (p[name].centre for p in poses)])
            for name in self.links
        }


def cross(u: Vector, v: Vector) -> complex:
    """The turn from u to v, for complex vectors too."""
    return u[0] * v[1] - u[1] * v[0]


CRANK, COUPLER, ROCKER, GROUND = Link(2.0, 1.0), Link(3.0, 2.6), Link(2.5, 2.0), 2.8


def four_bar_poses(a: complex) -> dict[str, Pose]:
    """Crank from A = 0 to B, coupler from B to C, rocker from D = (GROUND, 0) to C.

    C is where circles about B and D meet, above. Its derivative follows from both lengths,
    (C - B) . (C_a - B_a) = 0 and (C - D) . C_a = 0.
    """
    B = CRANK.length * np.array([np.cos(a), np.sin(a)])
    B_a = CRANK.length * np.array([-np.sin(a), np.cos(a)])
    D = np.array([GROUND, 0.0])
    e = D - B
    s2 = e @ e
    along = (COUPLER.length**2 - ROCKER.length**2 + s2) / (2.0 * s2)
    up = np.sqrt(COUPLER.length**2 / s2 - along**2)
    C = B + along * e + up * np.array([-e[1], e[0]])
    u, v = C - B, C - D
    C_a = (u @ B_a) / cross(u, v) * np.array([v[1], -v[0]])
    coupler = Pose((B + C) / 2, (B_a + C_a) / 2, cross(u, C_a - B_a) / COUPLER.length**2)
    rocker = Pose((C + D) / 2, C_a / 2, cross(v, C_a) / ROCKER.length**2)
    return {"crank": Pose(B / 2, B_a / 2, 1.0), "coupler": coupler, "rocker": rocker}


FOUR_BAR = Mechanism({"crank": CRANK, "coupler": COUPLER, "rocker": ROCKER}, four_bar_poses)
ROD, BLOCK = Link(1.5, 3.0), Link(4.0, 0.0)


def slider_crank_poses(a: complex) -> dict[str, Pose]:
    """Crank from A = 0 to B, rod from B to C, which slides along x:

    C = r cos a + sqrt(l^2 - (r sin a)^2),  sin b = -r sin a / l,  b_a = -r cos a / (l cos b)
    """
    r, length = CRANK.length, ROD.length
    B, B_a = r * np.array([np.cos(a), np.sin(a)]), r * np.array([-np.sin(a), np.cos(a)])
    base = np.sqrt(length**2 - (r * np.sin(a)) ** 2)  # l cos b
    C = np.array([r * np.cos(a) + base, 0.0 * a])
    C_a = np.array([-r * np.sin(a) - r**2 * np.sin(a) * np.cos(a) / base, 0.0 * a])
    rod = Pose((B + C) / 2, (B_a + C_a) / 2, -r * np.cos(a) / base)
    return {"crank": Pose(B / 2, B_a / 2, 1.0), "rod": rod, "block": Pose(C, C_a, 0.0)}


SLIDER_CRANK = Mechanism({"crank": CRANK, "rod": ROD, "block": BLOCK}, slider_crank_poses)
START, RATE = 1.1, 4.0  # of the cranks: they go round


def ends(mechanism: Mechanism) -> dict[str, Vector]:
    """Points of the plane where links meet, at the start."""
    poses = mechanism.poses(complex(START))
    B = 2.0 * poses["crank"].centre.real
    second = next(poses[name] for name in ("coupler", "rod") if name in poses)
    return {"A": np.zeros(2), "B": B, "C": 2.0 * second.centre.real - B}


def body_of(mechanism: Mechanism, name: str) -> Body:
    """The link as a body: at rest it is where the crank starts."""
    x, z = mechanism.poses(complex(START))[name].centre.real
    link = mechanism.links[name]
    across = link.inertia or 1.0
    return carried(name, link.mass, (across, across, 0.2 * across), (x, 0.0, z))


def hinged(
    mechanism: Mechanism, body: str, to: str | None, place: Vector, rate: float = 0.0
) -> Joint:
    """A hinge at a ``place`` of the plane."""
    x, z = place - mechanism.poses(complex(START))[body].centre.real
    return joint("hinge", body, to, moved(0.0, rate), point=(x, 0.0, z), axis=COUNTER)


def turns(mechanism: Mechanism) -> dict[str, float]:
    """Rates of all links at the start."""
    poses = mechanism.poses(complex(START))
    return {name: RATE * float(np.real(pose.turn)) for name, pose in poses.items()}


def four_bar() -> Scene:
    """A crank that goes round and a rocker: four hinges, of which one closes the loop."""
    m, at, turn = FOUR_BAR, ends(FOUR_BAR), turns(FOUR_BAR)
    joints = {
        "A": hinged(m, "crank", None, at["A"], turn["crank"]),
        "B": hinged(m, "coupler", "crank", at["B"], turn["coupler"] - turn["crank"]),
        "D": hinged(m, "rocker", None, np.array([GROUND, 0.0]), turn["rocker"]),
        "C": hinged(m, "rocker", "coupler", at["C"]),
    }
    bodies = [body_of(m, name) for name in m.links]
    return scene(bodies, joints, TIME[-1], output_step=0.05)


def slider_crank() -> Scene:
    """A crank that goes round, a rod, and a block on a rail."""
    m, at, turn = SLIDER_CRANK, ends(SLIDER_CRANK), turns(SLIDER_CRANK)
    speed = RATE * float(m.poses(complex(START))["block"].slope[0].real)
    joints = {
        "A": hinged(m, "crank", None, at["A"], turn["crank"]),
        "B": hinged(m, "rod", "crank", at["B"], turn["rod"] - turn["crank"]),
        "rail": joint("slider", "block", None, moved(0.0, speed), axis=(1.0, 0.0, 0.0)),
        "C": hinged(m, "block", "rod", at["C"]),
    }
    bodies = [body_of(m, name) for name in m.links]
    return scene(bodies, joints, TIME[-1], output_step=0.05)


def gap(run: xr.Dataset, mechanism: Mechanism, one: str, other: str) -> float:
    """Largest distance between the points of two links that meet in C."""
    C = ends(mechanism)["C"]
    found = []
    for name in (one, other):
        x, z = C - mechanism.poses(complex(START))[name].centre.real
        found.append(places(run, name) + rotations(run, name) @ np.array([x, 0.0, z]))
    return float(np.linalg.norm(found[0] - found[1], axis=1).max())


CASES = {
    "four-bar": (FOUR_BAR, four_bar, ("coupler", "rocker")),
    "slider-crank": (SLIDER_CRANK, slider_crank, ("rod", "block")),
}


@pytest.mark.parametrize(("mechanism", "build", "closing"), CASES.values(), ids=list(CASES))
def test_a_loop(mechanism, build, closing, validated, figure):
    whole, exact = build(), mechanism.centres(START, RATE)
    run = completed(whole)
    error = max(apart(places(run, name), centre) for name, centre in exact.items())
    claim, against = "four-bar and slider-crank that go round", "one coordinate by DOP853"
    validated(Kind.INDEPENDENT, claim, against, error, WITHIN, Feature.JOINTS)
    open_by = gap(run, mechanism, *closing)
    claim, against = "loops of joints, the gap where they close [m]", "0"
    validated(Kind.CLOSED_FORM, claim, against, open_by, CLOSED, Feature.JOINTS)
    assert run.attrs["energy_residual_relative"] <= WITHIN
    assert_order(whole, closing[0], exact[closing[0]], 0.00125, figure)


@pytest.mark.parametrize("mechanism", [FOUR_BAR, SLIDER_CRANK], ids=["four-bar", "slider-crank"])
def test_derivatives_of_the_geometry(mechanism: Mechanism) -> None:
    """The velocities that the equations use are the derivatives of the places."""
    for a in (0.3, 2.0, 4.0):
        for pose in mechanism.poses(a + 1j * TINY).values():
            slope = np.imag(pose.centre) / TINY
            assert np.allclose(slope, np.real(pose.slope), rtol=0.0, atol=1e-13)
