"""Trees of joints: which bodies belong together, and which are anchored, against plain searches."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from hydrosim.scene import Body, Joint, JointType, Scene
from hydrosim.scene.joint import arrange_joints
from hydrosim.scene.scene import arrangement, floating_roots, is_anchored, joined_with


def random_scene(seed: int, count: int = 12) -> Scene:
    """Bodies with hinges about level or upright axes, to bodies before them or to the earth."""
    rng = np.random.default_rng(seed)
    bodies = tuple(Body(f"b{k}", 1.0, np.eye(3)) for k in range(count))
    joints = {}
    for k in range(count):
        if rng.random() < 0.7:
            to = None if k == 0 or rng.random() < 0.3 else f"b{rng.integers(k)}"
            axis = (0.0, 1.0, 0.0) if rng.random() < 0.7 else (0.0, 0.0, 1.0)
            joints[f"j{k}"] = Joint(JointType.HINGE, f"b{k}", to, axis=axis)
    return Scene("trees", 1.0, bodies, joints=joints)


def search_connected(scene: Scene, body: str) -> set[str]:
    """Bodies that joints between bodies connect with one, by searching all edges often."""
    found = {body}
    for _ in scene.bodies:
        for joint in scene.joints.values():
            if joint.to is not None and {joint.body, joint.to} & found:
                found |= {joint.body, joint.to}
    return found


def search_anchored(scene: Scene, body: str) -> bool:
    """Whether a path of level axes leads to the earth: each body has one joint towards it."""
    joint = next((each for each in scene.joints.values() if each.body == body), None)
    if joint is None or joint.axis[2] == 1.0:
        return False
    return joint.to is None or search_anchored(scene, joint.to)


@pytest.mark.parametrize("seed", range(20))
def test_trees_are_those_that_a_search_finds(seed: int) -> None:
    scene = random_scene(seed)
    for body in scene.bodies:
        assert joined_with(scene, body.name) == search_connected(scene, body.name)
        tree = search_connected(scene, body.name)
        grounded = any(j.to is None and j.body in tree for j in scene.joints.values())
        if grounded or len(joined_with(scene, body.name)) == 1:
            assert is_anchored(scene, body.name) == search_anchored(scene, body.name)
        else:
            assert not is_anchored(scene, body.name)
    for root, carried in floating_roots(scene).items():
        assert {root, *carried} == search_connected(scene, root)


def test_a_changed_scene_is_arranged_anew() -> None:
    scene = random_scene(1)
    assert arrangement(scene).branches
    assert not arrangement(replace(scene, joints={})).branches


def test_a_long_chain_is_arranged_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever is asked about its bodies."""
    bodies = tuple(Body(f"b{k}", 1.0, np.eye(3)) for k in range(200))
    joints = {f"j{k}": Joint(JointType.HINGE, f"b{k}", f"b{k - 1}") for k in range(1, 200)}
    made = []

    def counted(*given: Any) -> Any:
        made.append(given)
        return arrange_joints(*given)

    monkeypatch.setattr("hydrosim.scene.scene.arrange_joints", counted)
    scene = Scene("chain", 1.0, bodies, joints=joints)
    for body in bodies:
        joined_with(scene, body.name)
        is_anchored(scene, body.name)
    assert len(made) == 1
