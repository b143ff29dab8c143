"""Moments of waves about horizontal axes, on hulls that yaw."""

from dataclasses import replace
from math import radians

import numpy as np
import pytest
from known_box import Box
from scenes import hull, in_waves, motion, scene_of, with_body

import hydrosim as hs
from hydrosim.elements import LinearMooring
from hydrosim.scene import Jonswap, Place, Scene, Solver, Symmetry, WaveForces, WaveTrain
from hydrosim.water.body import is_long, turn_moments

STEEP = WaveTrain(Jonswap(3.0, 11.0, 3.3), heading=radians(150.0), ramp=50.0)
ALIKE = {Place.MEAN: 0.15, Place.SLOW: 0.06}
"""Part of the standard deviation of roll. With moments in the axes at rest, 1.27 and 0.46."""


def yawing(headings: Place, position: Place = Place.MEAN) -> Scene:
    """The barge at moorings, in steep waves from ahead of the beam, that swings by 4 deg."""
    base = in_waves(scene_of("free_floating"), STEEP)
    loads = WaveForces(headings=headings, position=position)
    turned = with_body(base, wave_forces=loads, position=(0.0, 0.0, 0.0, 0.0, 0.0, radians(4.0)))
    moorings = LinearMooring("barge", stiffness=np.diag([2e6, 2e6, 0.0, 0.0, 0.0, 5e9]))
    solver = Solver(step=0.2, symmetry=Symmetry.IGNORE)
    scene = replace(turned, forces={"moorings": moorings}, solver=solver)
    return replace(scene, duration=200.0).with_output(step=0.2)


def roll(scene: Scene) -> np.ndarray:
    return motion(hs.simulate(scene))[:, 3]


@pytest.fixture(scope="module")
def exact() -> np.ndarray:
    """Roll in loads for the momentary heading, which are summed wave by wave."""
    return roll(yawing(Place.INSTANTANEOUS))


@pytest.mark.parametrize("headings", list(ALIKE))
def test_a_yaw_turns_no_pitch_into_roll(headings: Place, exact: np.ndarray) -> None:
    error = np.std(roll(yawing(headings)) - exact)
    assert error < ALIKE[headings] * np.std(exact)


def test_moments_of_long_hulls_turn(box: Box) -> None:
    """Pitch moments of H-851 are many times its roll moments. A hull whose pitch moment is its roll
    moment seen from the side, such as a spar, feels the direction of the waves alone."""
    assert is_long(hull())
    round_about = np.zeros_like(box.excitation)
    round_about[..., 3] = np.sin(box.heading)
    round_about[..., 4] = -np.cos(box.heading)
    assert not is_long(replace(box, excitation=round_about))


def test_turned_moments() -> None:
    """A right angle between the yaw that waves met and the present one: roll becomes pitch, pitch
    becomes the opposite of roll; nothing else changes."""
    load = np.arange(1.0, 13.0)
    coordinates = np.zeros(12)
    coordinates[11] = 0.3 + np.pi / 2
    turn_moments(np.array([1]), coordinates, np.array([0.0, 0.3]), load)
    expected = np.arange(1.0, 13.0)
    expected[9:11] = [-11.0, 10.0]
    np.testing.assert_allclose(load, expected, rtol=1e-14)
