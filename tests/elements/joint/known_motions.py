"""Motions without damping that are known: a pendulum, a double one, a four-bar, a bouncing ball.

Pendulums are known by elliptic functions, balls by parabolas and half sines. The others are solved
by DOP853 in coordinates of their own.
"""

from collections.abc import Callable
from math import atan2, ceil, cos, pi, sin, sqrt
from typing import NamedTuple

import numpy as np
from jointed import carried, joint, moved, scene
from linkages import IN_PLANE, FourBar
from scenes import block, moving, on_floor, steady
from scenes import scene as dry_scene
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from scipy.special import ellipj, ellipkm1
from solutions import about

from hydrosim.elements import Frictionless
from hydrosim.scene import Scene

G = 9.81
PERIODS = 18
OUTPUT_STEP = 0.1  # s
LONGEST = 2.0  # s: durations are whole multiples
Y = (0.0, 1.0, 0.0)
ARM = 1.0  # m, of all rods: from the joint to the centre of gravity
MASS, RADIUS = 1000.0, 0.5  # kg, m


class Known(NamedTuple):
    """A scene, and its positions (nt, nb, 6) at its output times, as they are recorded."""

    scene: Scene
    exact: np.ndarray


def known(scene: Scene, exact: Callable[[np.ndarray], np.ndarray]) -> Known:
    """The scene with its positions by a function of time, every `OUTPUT_STEP`."""
    time = OUTPUT_STEP * np.arange(round(scene.duration / OUTPUT_STEP) + 1)
    return Known(scene.with_output(step=OUTPUT_STEP), exact(time))


def positions(places: np.ndarray, rotations: np.ndarray) -> np.ndarray:
    """Positions (nt, nb, 6) of displacements (nt, nb, 3) and attitudes (nt, nb, 3, 3)."""
    count = places.shape[:2]
    angles = Rotation.from_matrix(rotations.reshape(-1, 3, 3)).as_euler("ZYX")[:, ::-1]
    return np.concatenate([places, angles.reshape(*count, 3)], axis=2)


def whole(duration: float) -> float:
    """The duration, up to a multiple of `LONGEST`."""
    return LONGEST * ceil(duration / LONGEST)


def pendulum(start: float) -> Known:
    """A rod on a hinge, let go at an angle from below."""
    inertia = MASS * RADIUS**2
    about_joint = inertia + MASS * ARM**2
    slow = sqrt(MASS * G * ARM / about_joint)
    quarter = ellipkm1(cos(start / 2) ** 2) / slow
    rod = carried("rod", MASS, (inertia,) * 3, (0.0, 0.0, -ARM))
    pin = joint("hinge", "rod", None, moved(start), point=(0.0, 0.0, ARM), axis=Y)

    def exact(time: np.ndarray) -> np.ndarray:
        """sin(a / 2) = k cd(w t), k = sin(start / 2)."""
        k = sin(start / 2)
        _, cn, dn, _ = ellipj(slow * np.remainder(time, 4 * quarter), k * k)
        return rod_positions(2.0 * np.arcsin(k * cn / dn)[:, None])

    return known(scene([rod], {"pin": pin}, whole(PERIODS * 4 * quarter)), exact)


def rod_positions(angles: np.ndarray) -> np.ndarray:
    """Positions of rods below each other that have turned about y by ``angles`` (nt, nb)."""
    halves = ARM * np.stack([-np.sin(angles), 0.0 * angles, 1.0 - np.cos(angles)], axis=2)
    before = np.cumsum(halves, axis=1) - halves
    return positions(2.0 * before + halves, about(1, angles))


def double_pendulum(first: float, second: float, duration: float) -> Known:
    """Two rods on hinges, let go at angles; the second one is from the first."""
    inertia = MASS * RADIUS**2
    upper = carried("upper", MASS, (inertia,) * 3, (0.0, 0.0, -ARM))
    lower = carried("lower", MASS, (inertia,) * 3, (0.0, 0.0, -3.0 * ARM))
    at = {"point": (0.0, 0.0, ARM), "axis": Y}
    top = joint("hinge", "upper", None, moved(first), **at)
    joints = {"top": top, "knee": joint("hinge", "lower", "upper", moved(second), **at)}

    def equations(_: float, y: np.ndarray) -> np.ndarray:
        """Lagrange's equations of the angles a, b from below, with the length 2 l of both rods:

        (J + 4 m l^2) a'' + 2 m l^2 cos(a - b) b'' = -2 m l^2 sin(a - b) b'^2 - 3 m g l sin a
        2 m l^2 cos(a - b) a'' + J b'' = 2 m l^2 sin(a - b) a'^2 - m g l sin b
        """
        a, b, da, db = y
        about_joint = inertia + MASS * ARM**2
        cross = 2.0 * MASS * ARM**2
        turning = cross * cos(a - b)
        M = np.array([[about_joint + 4.0 * MASS * ARM**2, turning], [turning, about_joint]])
        whirl = cross * sin(a - b)
        weight = MASS * G * ARM
        Q = [-whirl * db**2 - 3.0 * weight * sin(a), whirl * da**2 - weight * sin(b)]
        return np.array([da, db, *np.linalg.solve(M, Q)])

    def exact(time: np.ndarray) -> np.ndarray:
        start = [first, first + second, 0.0, 0.0]
        tight = {"rtol": 2.3e-14, "atol": 1e-15}
        found = solve_ivp(equations, (0.0, time[-1]), start, "DOP853", time, **tight)
        return rod_positions(found.y[:2].T)

    return known(scene([upper, lower], joints, duration), exact)


def four_bar() -> Known:
    """The linkage of `linkages`, whose crank swings from the side, 18 times."""
    bars = FourBar()
    start, period = 0.3, 3.1
    made = bars.scene(start, 0.0, whole(PERIODS * period), 0.01, IN_PLANE)

    def exact(time: np.ndarray) -> np.ndarray:
        angles = bars.angles(start, 0.0, time)
        each = [bars.bars(angle) for angle in angles]
        centres = np.array([[(bar.a + bar.b) / 2.0 for bar in row] for row in each])
        along = np.array([[bar.b - bar.a for bar in row] for row in each])
        # the rocker goes from C to D, and no bar turns as far as half a turn from its start
        turned = np.unwrap(np.arctan2(along[..., 1], along[..., 0]), axis=0)
        places = np.concatenate([centres - centres[0], 0.0 * centres[..., :1]], axis=2)
        return positions(places, about(2, turned - turned[0]))

    return known(made, exact)


def ball(drop: float) -> Known:
    """A ball of 19 rad/s on an elastic floor, let go at a height [m]."""
    omega = 19.0
    speed = sqrt(2.0 * G * drop)
    fall = speed / G
    touching = 2.0 * (pi - atan2(speed * omega, G)) / omega
    body = block(MASS, ("heave",), position=moving(heave=drop))
    floor = on_floor(MASS * omega**2, Frictionless())
    forces = {"floor": floor, "gravity": steady(heave=-MASS * G)}

    def exact(time: np.ndarray) -> np.ndarray:
        """Parabolas, and half sines about the place of rest -g / w^2."""
        since = np.remainder(time + fall, 2.0 * fall + touching)  # since it left the floor
        below = since - 2.0 * fall
        sag = G / omega**2
        deep = sag * (np.cos(omega * below) - 1.0) - speed / omega * np.sin(omega * below)
        heave = np.where(below < 0.0, speed * since - 0.5 * G * since**2, deep)
        found = np.zeros((time.size, 1, 6))
        found[:, 0, 2] = heave
        return found

    duration = whole(PERIODS * (2.0 * fall + touching))
    return known(dry_scene(body, forces, duration, OUTPUT_STEP), exact)


KNOWN: dict[str, Callable[[], Known]] = {
    "pendulum from 1 rad": lambda: pendulum(1.0),
    "pendulum from 2.5 rad": lambda: pendulum(2.5),
    "pendulum from 3.1 rad": lambda: pendulum(3.1),
    "double pendulum": lambda: double_pendulum(0.7, -1.0, whole(PERIODS * 4.1)),
    "four-bar": four_bar,
    "ball from 0.05 m": lambda: ball(0.05),
    "ball from 1 m": lambda: ball(1.0),
    "ball from 20 m": lambda: ball(20.0),
}
"""Motions whose errors grow as time does, over 18 periods."""
CHAOTIC: dict[str, Callable[[], Known]] = {
    "double pendulum from 1.2 rad": lambda: double_pendulum(1.2, 0.5, 28.0),
    "double pendulum from 2 rad": lambda: double_pendulum(2.0, 0.0, 20.0),
}
"""Motions whose errors grow by a factor in every second."""
