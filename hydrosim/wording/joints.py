"""The joints of a scene in words."""

from __future__ import annotations

from collections.abc import Iterator

from hydrosim.scene import Body, Joint, Scene, Weight
from hydrosim.scene.joint import JointType
from hydrosim.scene.trees import arrangement


def describe_joints(scene: Scene) -> Iterator[str]:
    """A line for each joint: what it connects, and how its motions are solved."""
    found = arrangement(scene)
    bodies = {body.name: body for body in scene.bodies}
    for branch in found.branches:
        motions = ", ".join(motion.name.replace("_", " ") for motion in branch.joint.motions)
        how = f"coordinates: {motions}" if motions else "no motion"
        yield f"{branch.name}: {_between(branch.joint)}; {how}{_restoring(bodies[branch.child])}"
    for name in found.loops:
        joint = scene.joints[name]
        role = "keeps a distance" if joint.type == JointType.ROD else "closes a loop"
        yield f"{name}: {_between(joint)}; {role}, held by constraint forces"
    for name in found.passing:
        yield f"{name}: {_between(scene.joints[name])}; a constraint while it is closed"


def _between(joint: Joint) -> str:
    other = "the earth" if joint.to is None else joint.to
    return f"{joint.type} between {joint.body} and {other}"


def _restoring(body: Body) -> str:
    """What restores a body that a joint carries, and where that is valid."""
    if body.hydrodynamics is None:
        return ""
    if body.hydrostatics is not None:
        return f". Buoyancy of {body.name}: of its hull, at any attitude"
    weight = "; weight and buoyancy at rest act as forces" if body.weight == Weight.CARRIED else ""
    return (
        f". Stiffness of {body.name}: linear in the displacement and the rotation vector of its"
        f" centre of gravity{weight}"
    )
