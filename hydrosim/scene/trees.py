"""Questions about the trees of joints of a scene, see `hydrosim.scene.arrangement`."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hydrosim.scene.arrangement import Arrangement
    from hydrosim.scene.joint import Joint
    from hydrosim.scene.scene import Scene


def arrangement(scene: Scene) -> Arrangement:
    """How the joints of a scene arrange its bodies."""
    return scene.arrangement


def joined_with(scene: Scene, body: str) -> frozenset[str]:
    """The body and all bodies that the joints of its tree connect with it."""
    roots = arrangement(scene).roots
    root = roots.get(body)
    return frozenset({body, *(other for other in roots if roots[other] == root)})


def is_anchored(scene: Scene, body: str) -> bool:
    """True if joints to the earth hold a body near its place and heading: they turn about level
    axes, or slide up and down."""
    return arrangement(scene).anchors(body)


def floating_roots(scene: Scene) -> dict[str, tuple[str, ...]]:
    """Roots of trees that do not touch the earth, each with the bodies that the tree carries."""
    found = arrangement(scene)
    carried: dict[str, list[str]] = {}
    for body, root in found.roots.items():
        if root not in found.children and body != root:
            carried.setdefault(root, []).append(body)
    return {root: tuple(bodies) for root, bodies in carried.items()}


def tree_joints(scene: Scene) -> dict[str, Joint]:
    """The joints whose motions are coordinates, in the order of the scene."""
    found = arrangement(scene).branches
    used = {branch.name for branch in found}
    return {name: joint for name, joint in scene.joints.items() if name in used}
