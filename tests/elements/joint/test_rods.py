"""Rods, which keep the distance of two points."""

from collections.abc import Callable
from dataclasses import replace
from math import cos, sin
from typing import Any

import numpy as np
import pytest
import xarray as xr
from jointed import G, apart, assert_order, by_rk4, carried, completed, places, rotations, scene
from scenes import assert_continues, joint_of
from solutions import solved

import hydrosim as hs
from hydrosim.elements import Drive, Harmonic
from hydrosim.errors import InputError
from hydrosim.report.evidence import Feature, Kind
from hydrosim.report.sentences.check import describe_joints
from hydrosim.scene import Active, Body, Joint, Kinematics, Scene, Weight, When

WITHIN = 1e-9
DURATION = 10.0
TIME = np.linspace(0.0, DURATION, 101)
MASS, ABOUT, LENGTH, EYE = 20.0, 15.0, 4.0, 1.5  # kg, kg m^2, m: of the rod, and above the centre
SHAKE = Harmonic(0.4, 2.3, 0.0, 0.5)
ORIGIN, Z = (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)
PLANE = ("surge", "heave", "pitch")


def rod(body: str, to: str | None = None, **place: Any) -> Joint:
    return joint_of("rod", body, to, **place)


def hung_block(out: float = 0.5, **changes: Any) -> tuple[Body, Joint]:
    """A block on a rod from the origin, which at rest slopes by ``out``; the block is upright."""
    place = (-LENGTH * sin(out), 0.0, -LENGTH * cos(out) - EYE)
    block = carried("block", MASS, (12.0, ABOUT, 11.0), place, **changes)
    return block, rod("block", None, point=(0.0, 0.0, EYE), to_point=(0.0, 0.0, 0.0))


def swinging(
    a: float, start: tuple[float, ...], of: Callable[[float], tuple[float, float, float]]
) -> tuple[np.ndarray, np.ndarray]:
    """Angles of the rod and of the block (2, nt) by Lagrange's equations, and the tension (nt,);
    the upper end moves by s(t) along x:

    x = s - L sin a - e sin b,  z = -L cos a - e cos b
    """

    def parts(t: float, y: np.ndarray) -> tuple[np.ndarray, float]:
        a, b, da, db = y
        _, _, dds = of(t)
        cross = MASS * LENGTH * EYE * cos(a - b)
        whirl = MASS * LENGTH * EYE * sin(a - b)
        M = np.array([[MASS * LENGTH**2, cross], [cross, ABOUT + MASS * EYE**2]])
        along = -whirl * db**2 + MASS * LENGTH * (dds * cos(a) - G * sin(a))
        Q = np.array([along, whirl * da**2 + MASS * EYE * (dds * cos(b) - G * sin(b))])
        return np.linalg.solve(M, Q), dds

    def equations(t: float, y: np.ndarray) -> np.ndarray:
        return np.array([y[2], y[3], *parts(t, y)[0]])

    y = solved(equations, [a, *start], TIME)
    tension = []
    for t, (a, b, da, db) in zip(TIME, y.T, strict=True):
        (dda, ddb), dds = parts(t, np.array([a, b, da, db]))
        ddx = dds - LENGTH * (dda * cos(a) - da**2 * sin(a)) - EYE * (ddb * cos(b) - db**2 * sin(b))
        ddz = LENGTH * (dda * sin(a) + da**2 * cos(a)) + EYE * (ddb * sin(b) + db**2 * cos(b))
        tension.append(MASS * (ddx * sin(a) + (ddz + G) * cos(a)))
    return y[:2], np.array(tension)


def centre(angles: np.ndarray, s: np.ndarray | float = 0.0) -> np.ndarray:
    a, b = angles
    x = s - LENGTH * np.sin(a) - EYE * np.sin(b)
    return np.stack([x, 0.0 * x, -LENGTH * np.cos(a) - EYE * np.cos(b)], axis=1)


def still(t: float) -> tuple[float, float, float]:
    return 0.0, 0.0, 0.0


def shaken(t: float) -> tuple[float, float, float]:
    w = 2.0 * np.pi / SHAKE.period
    phase = w * t + SHAKE.phase
    A = SHAKE.amplitude
    return A * sin(phase), w * A * cos(phase), -w * w * A * sin(phase)


def test_a_block_that_hangs_from_a_rod(validated, figure) -> None:
    block, line = hung_block()
    whole = scene([block], {"line": line}, DURATION)
    run = completed(whole)
    angles, tension = swinging(0.5, (0.0, 0.0, 0.0), still)
    exact = centre(angles)
    error = apart(places(run, "block"), exact)
    claim, against = "block on a rod, 10 s", "Lagrange's equations by DOP853"
    validated(Kind.INDEPENDENT, claim, against, error, WITHIN, Feature.JOINTS)
    load = np.linalg.norm(run.joint_force.values[:, 0, :3], axis=1)
    np.testing.assert_allclose(load, tension, rtol=0.0, atol=1e-8 * np.ptp(tension))
    arm = np.stack([np.sin(angles[1]), 0.0 * angles[1], np.cos(angles[1])], axis=1)
    eye = places(run, "block") + EYE * arm
    np.testing.assert_allclose(np.linalg.norm(eye, axis=1), LENGTH, rtol=0.0, atol=1e-8)
    assert run.attrs["energy_residual_relative"] < WITHIN
    assert_order(whole, "block", exact, 0.1, figure)


def test_a_rod_pendulum_with_a_driven_pivot(validated) -> None:
    """The other end is on a cart, which a drive moves."""
    block, _ = hung_block()
    cart = carried("cart", 7.0, (1.0, 1.0, 1.0), (0.0, 0.0, 0.0), dofs=("surge",))
    start, speed, _ = shaken(0.0)
    # the drive starts beside the place at rest: the block moves along
    block = replace(block, position=(start, 0, 0, 0, 0, 0), velocity=(speed, 0, 0, 0, 0, 0))
    line = rod("block", "cart", point=(0.0, 0.0, EYE), to_point=(0.0, 0.0, 0.0))
    drive = Drive("cart", dof="surge", offset=SHAKE)
    run = completed(scene([block, cart], {"line": line}, DURATION, {"shake": drive}))
    angles, _ = swinging(0.5, (0.0, 0.0, 0.0), shaken)
    exact = centre(angles, SHAKE.amplitude * np.sin(2 * np.pi / SHAKE.period * TIME + SHAKE.phase))
    error = apart(places(run, "block"), exact)
    claim, against = "rod pendulum with a driven pivot, 10 s", "Lagrange's equations by DOP853"
    validated(Kind.INDEPENDENT, claim, against, error, WITHIN, Feature.JOINTS, Feature.DRIVES)
    assert run.attrs["energy_residual_relative"] < WITHIN


def test_two_bodies_on_a_rod_keep_momentum_and_distance() -> None:
    """Thrown and turning, without gravity: the rod does no work."""
    free = {"weight": Weight.BALANCED}
    ends = {"point": (0.4, 0.3, 0.0), "to_point": (-0.5, 0.0, 0.2)}
    rest = np.array([4.0 - 0.5 - 0.4, 0.5 - 0.3, 1.2])  # from end to end
    across = 0.3 * np.cross(rest, Z) / np.linalg.norm(rest)
    left = carried("left", 3.0, (1.0, 2.0, 1.5), ORIGIN, velocity=(*across, 0, 0, 0), **free)
    away = {"velocity": (*-across, 0, 0, 0), **free}
    right = carried("right", 5.0, (2.0, 1.0, 2.5), (4.0, 0.5, 1.0), **away)
    bar = {"bar": rod("left", "right", **ends)}
    run = completed(scene([left, right], bar, DURATION, gravity=0.0))
    mass = np.array([3.0, 5.0])
    momentum = (run.velocity.values[:, :, :3] * mass[:, None]).sum(axis=1)
    np.testing.assert_allclose(momentum, np.broadcast_to(momentum[0], momentum.shape), atol=1e-10)
    kinetic = run.energy_kinetic.values
    np.testing.assert_allclose(kinetic, kinetic[0], rtol=1e-9)
    assert np.ptp(run.position.values[:, 0, 0]) > 0.5
    ends_of = (("left", "point"), ("right", "to_point"))
    near, far = (places(run, n) + rotations(run, n) @ np.array(ends[key]) for n, key in ends_of)
    distance = np.linalg.norm(near - far, axis=1)
    np.testing.assert_allclose(distance, distance[0], rtol=0.0, atol=1e-12)


def test_a_length_makes_the_block_start_elsewhere() -> None:
    block, line = hung_block()
    lower = replace(block, position=(0, 0, -LENGTH * 0.5 / cos(0.5), 0, 0, 0))
    assert "does not close at the start" in refused(scene([lower], {"line": line}, 1.0))
    angle = np.arctan2(LENGTH * sin(0.5), LENGTH * cos(0.5) + 0.5)
    length = LENGTH * sin(0.5) / sin(angle)
    lower = replace(block, position=(0, 0, -0.5, 0, 0, 0))
    completed(scene([lower], {"line": replace(line, length=float(length))}, 1.0))


def test_a_rod_that_is_active_for_a_time_keeps_the_distance_of_its_beginning() -> None:
    block, line = hung_block(out=0.9)
    falls = replace(line, active=Active(When(0.4), When(3.0)))
    run = completed(scene([block], {"line": falls}, 4.0, output_step=0.05))
    eye = places(run, "block") + EYE * rotated_z(run)
    distance = np.linalg.norm(eye, axis=1)
    held = (run.time.values >= 0.4 - 1e-9) & (run.time.values <= 3.0 + 1e-9)
    fallen = np.hypot(LENGTH * sin(0.9), LENGTH * cos(0.9) + 0.5 * G * 0.4**2)
    np.testing.assert_allclose(distance[held], fallen, rtol=0.0, atol=1e-9)
    assert np.abs(distance[~held] - fallen).min() > 1e-3
    assert run.lock_loss[-1] > 1.0
    assert run.attrs["energy_residual_relative"] < 1e-8


def rotated_z(run: xr.Dataset) -> np.ndarray:
    return rotations(run, "block")[:, :, 2]


def test_small_swings_have_the_period_of_the_linear_analysis() -> None:
    """The reaction of the rod turns with it, which restores the block."""
    block, line = hung_block(out=0.0, dofs=PLANE)
    compiled = hs.compile_scene(scene([block], {"line": line}, 1.0))
    modes = hs.natural_modes(hs.linearise(compiled.model, compiled.state))
    found = sorted(2 * np.pi / m.natural_period for m in modes if m.natural_period)
    M = MASS * np.array([[LENGTH**2, LENGTH * EYE], [LENGTH * EYE, EYE**2 + ABOUT / MASS]])
    K = MASS * G * np.diag([LENGTH, EYE])
    exact = np.sort(np.sqrt(np.linalg.eigvals(np.linalg.solve(M, K)).real))
    np.testing.assert_allclose(found, exact, rtol=1e-5)


def test_small_angles_keep_the_distance_along_the_rod_at_rest() -> None:
    block, line = hung_block(dofs=("surge", "heave"))
    given = replace(block, weight=Weight.BALANCED, velocity=(cos(0.5), 0, -sin(0.5), 0, 0, 0))
    run = completed(scene([given], {"line": line}, 2.0, kinematics=Kinematics.LINEAR))
    x, _, z = run.position.values[:, 0, :3].T
    np.testing.assert_allclose(x * sin(0.5) + z * cos(0.5), 0.0, atol=1e-12)
    assert x[-1] == pytest.approx(2.0 * cos(0.5), rel=1e-9)


def test_a_run_goes_on_to_the_bit() -> None:
    block, line = hung_block()
    whole = by_rk4(scene([block], {"line": line}, 6.0), 0.05).with_output(states=True)
    assert_continues(whole, completed(whole), (2.0,), "position", "velocity", "joint_force")


def refused(whole: Scene) -> str:
    with pytest.raises(InputError) as found:
        hs.compile_scene(whole)
    return str(found.value)


def test_mistakes_are_told() -> None:
    block, line = hung_block()
    at_one_place = replace(line, to_point=(-LENGTH * sin(0.5), 0.0, -LENGTH * cos(0.5)))
    text = refused(scene([block], {"line": at_one_place}, 1.0))
    assert "joints.line.to_point: found both ends" in text
    with pytest.raises(InputError, match=r"Rod\.length: found -1\.0"):
        replace(line, length=-1.0)
    twice = {"line": line, "again": line}
    assert "joints.again: found a rod of a distance that" in refused(scene([block], twice, 1.0))
    locked = replace(block, dofs=("sway",))
    assert "joints.line: found a rod" in refused(scene([locked], {"line": line}, 1.0))
    still = Harmonic(0.0, 1.0)
    drives = {name: Drive("block", dof=name, offset=still) for name in ("surge", "heave")}
    upright = replace(block, dofs=("surge", "heave"))
    text = refused(scene([upright], {"line": line}, 1.0, drives))
    assert "drives (surge, heave) of motions that the joints line hold" in text


def test_check_says_what_a_rod_does() -> None:
    block, line = hung_block()
    assert [*describe_joints(scene([block], {"line": line}, 1.0))] == [
        "line: rod between block and the earth; keeps a distance, held by constraint forces"
    ]
