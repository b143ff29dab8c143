"""Pendulums against Lagrange's equations in coordinates of their own, by DOP853."""

from math import cos, pi, sin, sqrt
from typing import NamedTuple

import numpy as np
import pytest
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
    swivelled,
)
from scenes import central_force
from solutions import about, skew, solved

from hydrosim.elements import Harmonic
from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import Body, Scene

WITHIN = 1e-9  # of the range
ORDER = 3.8
Y = (0.0, 1.0, 0.0)
DURATION = 10.0
TIME = np.linspace(0.0, DURATION, 101)


class Rod(NamedTuple):
    """Mass, inertia across and along, distance from the upper joint to the centre and the lower."""

    mass: float
    across: float
    along: float
    centre: float
    length: float

    @property
    def about_joint(self) -> float:
        """Inertia across the rod about its upper joint."""
        return self.across + self.mass * self.centre**2

    def hanging(self, name: str, top: float = 0.0) -> Body:
        """The body, hanging from a joint at the height ``top``."""
        inertia = (self.across, self.across, self.along)
        return carried(name, self.mass, inertia, (0.0, 0.0, top - self.centre))


UPPER = Rod(mass=3.0, across=9.0, along=0.4, centre=2.5, length=5.0)
LOWER = Rod(mass=2.0, across=3.0, along=0.3, centre=2.0, length=4.0)


def hung(angle: np.ndarray, distance: float) -> np.ndarray:
    """Point (nt, 3) at a ``distance`` down a rod that has turned about y by ``angle`` (nt,)."""
    return -distance * np.stack([np.sin(angle), np.zeros_like(angle), np.cos(angle)], axis=1)


ANGLES, RATES = (0.7, -0.35), (0.2, -0.3)  # of both rods, from the vertical


def double_pendulum() -> Scene:
    """Two rods on hinges about y. It swings, and is not chaotic yet."""
    upper, lower = UPPER.hanging("upper"), LOWER.hanging("lower", -UPPER.length)
    turn, speed = ANGLES[1] - ANGLES[0], RATES[1] - RATES[0]
    top, knee = {"point": (0.0, 0.0, UPPER.centre)}, {"point": (0.0, 0.0, LOWER.centre)}
    joints = {
        "top": joint("hinge", "upper", None, moved(ANGLES[0], RATES[0]), **top, axis=Y),
        "knee": joint("hinge", "lower", "upper", moved(turn, speed), **knee, axis=Y),
    }
    return scene([upper, lower], joints, DURATION)


def double_pendulum_by_lagrange() -> tuple[np.ndarray, np.ndarray]:
    """Centres of both rods (nt, 3), with angles a, b of the rods from the vertical:

    T = J_a a'^2 / 2 + J_b b'^2 / 2 + m L c a' b' cos(a - b)
    V = -(M C + m L) g cos a - m c g cos b

    M, C, L: mass, centre, length of the upper rod; m, c of the lower one; J_a: inertia of the upper
    rod about its joint and m L^2; J_b: of the lower one about its joint.
    """
    coupling = LOWER.mass * UPPER.length * LOWER.centre
    first = UPPER.about_joint + LOWER.mass * UPPER.length**2
    weight = (UPPER.mass * UPPER.centre + LOWER.mass * UPPER.length) * G

    def equations(t: float, y: np.ndarray) -> np.ndarray:
        a, b, da, db = y
        cross = coupling * cos(a - b)
        M = np.array([[first, cross], [cross, LOWER.about_joint]])
        whirl = coupling * sin(a - b)
        below = whirl * da**2 - LOWER.mass * LOWER.centre * G * sin(b)
        Q = [-whirl * db**2 - weight * sin(a), below]
        return np.array([da, db, *np.linalg.solve(M, Q)])

    a, b, *_ = solved(equations, [*ANGLES, *RATES], TIME)
    return hung(a, UPPER.centre), hung(a, UPPER.length) + hung(b, LOWER.centre)


def test_a_double_pendulum(validated, figure) -> None:
    whole, (upper, lower) = double_pendulum(), double_pendulum_by_lagrange()
    run = completed(whole)
    error = max(apart(places(run, "upper"), upper), apart(places(run, "lower"), lower))
    claim, against = "double pendulum, 10 s", "Lagrange's equations by DOP853"
    validated(Kind.INDEPENDENT, claim, against, error, WITHIN, Feature.JOINTS)
    assert run.attrs["energy_residual_relative"] <= WITHIN
    assert_order(whole, "lower", lower, 0.05, figure)


TILT, PRECESSION = 0.8, 1.3  # of the spherical pendulum [rad, rad/s]


def spherical_pendulum() -> Scene:
    """A rod on a ball joint that circles about the vertical, without spin about itself."""
    out = np.array([sin(TILT), 0.0, -cos(TILT)])
    speed = np.array([0.0, PRECESSION * sin(TILT), 0.0])
    start = swivelled((0.0, -TILT, 0.0), np.cross(out, speed))
    joints = {"pin": joint("ball", "rod", None, *start, point=(0.0, 0.0, UPPER.centre))}
    return scene([UPPER.hanging("rod")], joints, DURATION)


def spherical_pendulum_by_lagrange() -> np.ndarray:
    """Centre (nt, 3), with the tilt a from below and the azimuth b. A rod keeps its spin about
    itself, which is zero, so that

    T = J (a'^2 + b'^2 sin(a)^2) / 2,   V = -m g c cos a,   J b' sin(a)^2 = const
    """
    weight = UPPER.mass * G * UPPER.centre / UPPER.about_joint
    momentum = PRECESSION * sin(TILT) ** 2

    def equations(t: float, y: np.ndarray) -> np.ndarray:
        a, da, _ = y
        db = momentum / sin(a) ** 2
        return np.array([da, db**2 * sin(a) * cos(a) - weight * sin(a), db])

    a, _, b = solved(equations, [TILT, 0.0, 0.0], TIME)
    return UPPER.centre * np.stack([np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), -np.cos(a)], 1)


def test_a_spherical_pendulum(validated, figure) -> None:
    whole, exact = spherical_pendulum(), spherical_pendulum_by_lagrange()
    run = completed(whole)
    error = apart(places(run, "rod"), exact)
    claim, against = "spherical pendulum on a ball joint, 10 s", "Lagrange's equations by DOP853"
    validated(Kind.INDEPENDENT, claim, against, error, WITHIN, Feature.JOINTS)
    assert_order(whole, "rod", exact, 0.05, figure)


CARRIAGE = 40.0  # mass of the pivot [kg]
NATURAL = sqrt(UPPER.mass * G * UPPER.centre / UPPER.about_joint)  # of the pendulum [rad/s]
SPRING = 600.0  # of the pivot [N/m]
SMALL = 0.01  # first angle of the pendulum [rad]
LONG = np.linspace(0.0, 40.0, 201)


class Shaking(NamedTuple):
    """A force on the pivot that alone would shake it by ``heave`` [m] at ``frequency``."""

    frequency: float
    heave: float = 0.5

    @property
    def force(self) -> float:
        """Its amplitude."""
        inertia = (CARRIAGE + UPPER.mass) * self.frequency**2
        return abs(self.heave * (SPRING - inertia))


def moving_pivot(shaking: Shaking) -> Scene:
    """A rod that hangs from a carriage, which slides up and down on a spring and is shaken."""
    total = (CARRIAGE + UPPER.mass) * G
    carriage = carried("carriage", CARRIAGE, (1.0, 1.0, 1.0), (0.0, 0.0, 0.0))
    held = moved(stiffness=SPRING, neutral=total / SPRING)
    rail = joint("slider", "carriage", None, held, axis=(0.0, 0.0, 1.0))
    at = {"point": (0.0, 0.0, UPPER.centre), "axis": Y}
    joints = {"rail": rail, "pin": joint("hinge", "rod", "carriage", moved(SMALL), **at)}
    signal = Harmonic(shaking.force, 2.0 * pi / shaking.frequency)
    push = central_force("carriage", heave=signal)
    bodies = [carriage, UPPER.hanging("rod")]
    return scene(bodies, joints, LONG[-1], {"push": push}, output_step=0.2)


def moving_pivot_by_lagrange(shaking: Shaking) -> tuple[np.ndarray, np.ndarray]:
    """Heights z of the pivot (nt,) and angles a of the rod (nt,):

    T = (M + m) z'^2 / 2 + J a'^2 / 2 + m c z' a' sin a
    V = (M + m) g z - m g c cos a + k (z - z_0)^2 / 2,   k z_0 = (M + m) g
    """
    mass, arm = CARRIAGE + UPPER.mass, UPPER.mass * UPPER.centre

    def equations(t: float, y: np.ndarray) -> np.ndarray:
        z, a, dz, da = y
        coupling = arm * sin(a)
        M = np.array([[mass, coupling], [coupling, UPPER.about_joint]])
        push = shaking.force * sin(shaking.frequency * t)
        Q = [push - SPRING * z - arm * da**2 * cos(a), -arm * G * sin(a)]
        return np.array([dz, da, *np.linalg.solve(M, Q)])

    z, a, *_ = solved(equations, [0.0, SMALL, 0.0, 0.0], LONG)
    return z, a


@pytest.mark.parametrize(("ratio", "unstable"), [(2.0, True), (1.4, False)])
def test_a_moving_pivot_makes_a_pendulum_unstable_at_twice_its_frequency(
    ratio: float, unstable: bool, validated, figure
) -> None:
    shaking = Shaking(ratio * NATURAL)
    whole = moving_pivot(shaking)
    z, a = moving_pivot_by_lagrange(shaking)
    assert (np.abs(a).max() > 20.0 * SMALL) == unstable
    run = completed(whole)
    exact = hung(a, UPPER.centre)
    exact[:, 2] += z
    error = apart(places(run, "rod"), exact)
    claim = "pendulum on a moving pivot, at twice its frequency too"
    against = "Lagrange's equations by DOP853"
    validated(Kind.INDEPENDENT, claim, against, error, WITHIN, Feature.JOINTS)
    if unstable:
        assert_order(whole, "rod", exact, 0.05, figure)


SPIN = 30.0  # of the gyroscope about itself [rad/s]
TOP = Rod(mass=2.0, across=0.3, along=0.5, centre=0.8, length=0.0)
LEAN = 0.5
SPINNING = np.linspace(0.0, 6.0, 121)


def gyroscope() -> Scene:
    """A heavy top on a ball joint, let go while it spins: it nutates and precesses."""
    inertia = (TOP.across, TOP.across, TOP.along)
    body = carried("top", TOP.mass, inertia, (0.0, 0.0, TOP.centre))
    axis = np.array([sin(LEAN), 0.0, cos(LEAN)])
    start = swivelled((0.0, LEAN, 0.0), SPIN * axis)
    joints = {"foot": joint("ball", "top", None, *start, point=(0.0, 0.0, -TOP.centre))}
    return scene([body], joints, SPINNING[-1], output_step=0.05)


def gyroscope_by_lagrange() -> np.ndarray:
    """Rotations Rz(b) Ry(a) Rz(c) (nt, 3, 3). Spin n = c' + b' cos a and the momentum p about the
    vertical are kept:

    T = J (a'^2 + b'^2 sin(a)^2) / 2 + C n^2 / 2,   V = m g l cos a
    J a'' = J b'^2 sin a cos a - C n b' sin a + m g l sin a,   b' = (p - C n cos a) / (J sin(a)^2)
    """
    J, spin = TOP.about_joint, TOP.along * SPIN
    momentum = spin * cos(LEAN)

    def equations(t: float, y: np.ndarray) -> np.ndarray:
        a, da, _, _ = y
        db = (momentum - spin * cos(a)) / (J * sin(a) ** 2)
        moment = TOP.mass * G * TOP.centre - spin * db
        dda = (db**2 * cos(a) + moment / J) * sin(a)
        return np.array([da, dda, db, SPIN - db * cos(a)])

    a, _, b, c = solved(equations, [LEAN, 0.0, 0.0, 0.0], SPINNING)
    return about(2, b) @ about(1, a) @ about(2, c)


def test_a_gyroscope(validated, figure) -> None:
    """Its axis traces cusps, its frame turns 29 times."""
    whole, exact = gyroscope(), gyroscope_by_lagrange()
    tip = TOP.centre * exact[:, :, 2]
    nods = np.diff(np.sign(np.diff(tip[:, 2])))
    assert np.count_nonzero(nods) >= 8
    run = completed(whole)
    error = max(apart(places(run, "top"), tip), apart(rotations(run, "top"), exact))
    claim, against = "gyroscope that nutates, 29 turns", "Lagrange's equations by DOP853"
    validated(Kind.INDEPENDENT, claim, against, error, WITHIN, Feature.JOINTS)
    assert_order(whole, "top", tip, 0.005, figure)


INERTIA = np.array([[3.0, -0.4, 0.2], [-0.4, 4.0, 0.3], [0.2, 0.3, 6.0]])
MASS, ARM = 2.0, np.array([0.1, -0.2, 0.25])  # from the joint to the centre of gravity
TUMBLE = np.linspace(0.0, 12.0, 121)
SPINS = {
    "about x": (3.0, 0.1, 0.0),
    "about y": (0.1, 3.0, 0.0),
    "about z": (0.0, -0.1, 3.0),
    "backwards": (-2.0, -2.2, -1.5),
    "askew": (1.5, 2.5, -2.0),
}


def tumbler(spin: tuple[float, float, float]) -> Scene:
    """A body without symmetry on a ball joint near its centre, thrown into a tumble."""
    body = carried("body", MASS, INERTIA, ARM.tolist())
    start = swivelled((0.0, 0.0, 0.0), spin)
    joints = {"pin": joint("ball", "body", None, *start, point=tuple(-ARM))}
    return scene([body], joints, TUMBLE[-1])


def tumbler_by_euler(spin: tuple[float, float, float]) -> np.ndarray:
    """Rotations R (nt, 3, 3), by Euler's equations about the joint in the body's frame,

    J w' + w x J w = r x R^T m g,   R' = R (w x),   J = I + m (r^2 - r r^T)
    """
    J = INERTIA - MASS * skew(ARM) @ skew(ARM)
    inverse = np.linalg.inv(J)

    def equations(t: float, y: np.ndarray) -> np.ndarray:
        R, w = y[:9].reshape(3, 3), y[9:]
        weight = R.T @ [0.0, 0.0, -MASS * G]
        spun = inverse @ (np.cross(ARM, weight) - np.cross(w, J @ w))
        return np.concatenate([(R @ skew(w)).ravel(), spun])

    y = solved(equations, np.concatenate([np.eye(3).ravel(), spin]), TUMBLE)
    return y[:9].T.reshape(-1, 3, 3)


@pytest.mark.parametrize("spin", SPINS.values(), ids=list(SPINS))
def test_a_ball_joint_turns_through_every_attitude(spin, validated, figure):
    """Several turns, so that any three coordinates of a rotation must be changed on the way."""
    exact = tumbler_by_euler(spin)
    angles = np.arccos(np.clip((np.trace(exact, axis1=1, axis2=2) - 1.0) / 2.0, -1.0, 1.0))
    assert np.count_nonzero(np.diff(np.sign(np.diff(angles)))) >= 4  # half turns
    whole = tumbler(spin)
    run = completed(whole)
    error = apart(rotations(run, "body"), exact)
    claim, against = "body on a ball joint through every attitude", "Euler's equations by DOP853"
    validated(Kind.INDEPENDENT, claim, against, error, WITHIN, Feature.JOINTS)
    assert_order(whole, "body", exact @ ARM, 0.005, figure)
