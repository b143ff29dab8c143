"""Joints that leave nothing to move are refused."""

from __future__ import annotations

import pytest
from jointed import carried, joint, scene

import hydrosim as hs
from hydrosim.errors import InputError


def test_joints_that_hold_all_bodies_are_refused() -> None:
    bodies = [carried(name, 1.0, (1.0, 1.0, 1.0), (0.0, 0.0, 0.0)) for name in ("a", "b")]
    joints = {"pin": joint("fixed", "a"), "weld": joint("fixed", "b", "a")}
    with pytest.raises(InputError, match="they hold all bodies; expected at least one"):
        hs.simulate(scene(bodies, joints, 1.0))
