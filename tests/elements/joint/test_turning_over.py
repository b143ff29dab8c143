"""Bodies that turn over on joints: their recorded angles, and attitudes that are given twice."""

from __future__ import annotations

import numpy as np
import pytest
from jointed import carried, completed, joint, scene

from hydrosim.compile.joints import rodrigues
from hydrosim.scene import JointResistance

RATE = 1.5  # rad/s, for 6 s: more than a turn
TILT = np.radians(30.0)


def spinning(axis: tuple[float, float, float]) -> np.ndarray:
    """Roll, pitch and yaw (nt, 3) of a body that turns about an axis through its centre of gravity,
    and the angle of its hinge."""
    body = carried("body", 2.0, [3.0, 4.0, 6.0], (0.0, 0.0, 0.0))
    hinge = joint("hinge", "body", None, JointResistance(velocity=RATE), axis=axis)
    run = completed(scene([body], {"hinge": hinge}, 6.0))
    turned = run.joint_position.values[:, :1]
    assert turned[-1, 0] == pytest.approx(6.0 * RATE, abs=1e-9)
    return np.hstack([run.position.values[:, 0, 3:], turned])


def within_half_a_turn(angle: np.ndarray) -> np.ndarray:
    return np.asarray((angle + np.pi) % (2.0 * np.pi) - np.pi)


@pytest.mark.parametrize("dof", [0, 1])
def test_a_level_hinge_keeps_the_heading_at_every_angle(dof: int) -> None:
    """Roll or pitch is the angle within half a turn; the two others stay zero."""
    axis = (1.0, 0.0, 0.0) if dof == 0 else (0.0, 1.0, 0.0)
    angles = spinning(axis)
    assert np.abs(angles[:, [1 - dof, 2]]).max() < 1e-12
    assert np.abs(within_half_a_turn(angles[:, dof] - angles[:, 3])).max() < 1e-12


def test_a_vertical_hinge_counts_turns() -> None:
    angles = spinning((0.0, 0.0, 1.0))
    assert np.abs(angles[:, 2] - angles[:, 3]).max() < 1e-12


def test_yaw_on_a_leaning_hinge_stays_within_half_a_turn_of_the_heading() -> None:
    """Its heading is the twist, 2 atan2(cos(tilt) sin(angle / 2), cos(angle / 2)), within half a
    turn; its yaw is less than a quarter of a turn from there."""
    angles = spinning((np.sin(TILT), 0.0, np.cos(TILT)))
    half = 0.5 * within_half_a_turn(angles[:, 3])
    heading = 2.0 * np.arctan2(np.cos(TILT) * np.sin(half), np.cos(half))
    assert np.abs(angles[:, 2] - heading).max() < 0.5 * np.pi


def test_rotation_vectors_of_more_than_half_a_turn_are_the_same_rotation() -> None:
    axis = np.array([0.6, 0.0, 0.8])
    for angle in (-300.0, -170.0, 190.0, 360.0, 540.0 - 1e-3, 725.0):
        turn = np.radians(angle)
        nearest = turn - 2.0 * np.pi * np.round(turn / (2.0 * np.pi))
        assert rodrigues(turn * axis) == pytest.approx(rodrigues(nearest * axis), abs=1e-9)
        assert np.linalg.norm(rodrigues(turn * axis)) <= 4.0 + 1e-9
