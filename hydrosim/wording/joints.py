"""The joints of a scene, and its prescribed motions, in words."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hydrosim.compiling.joints.drives import drives_of, is_turn, motion_at, sample_times
from hydrosim.forces.drive import Drive
from hydrosim.forces.signal import Harmonic, Recorded
from hydrosim.presentation.nodes import Part, Sentence, Value
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
        restoring = _restoring(bodies[branch.child])
        yield f"{branch.name}: {_bodies_of_joint(branch.joint)}; {how}{restoring}"
    for name in found.loops:
        joint = scene.joints[name]
        role = "keeps a distance" if joint.type == JointType.ROD else "closes a loop"
        yield f"{name}: {_bodies_of_joint(joint)}; {role}, held by constraint forces"
    for name in found.passing:
        yield f"{name}: {_bodies_of_joint(scene.joints[name])}; a constraint while it is closed"


def _bodies_of_joint(joint: Joint) -> str:
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


def describe_drives(scene: Scene, begin: float = 0.0) -> Iterator[Sentence]:
    """A sentence for each drive: what it moves, how far, and how fast."""
    for name, drive in drives_of(scene).items():
        unit = "rad" if is_turn(scene, drive) else "m"
        times = sample_times(drive, begin, begin + scene.duration)
        position, speed, acceleration = np.array([motion_at(drive, float(t)) for t in times]).T
        parts: list[Part] = [
            *(name, drive.driven, _form(drive)),
            *(Value(float(position.min()), unit), Value(float(position.max()), unit)),
            *(Value(float(position[0]), unit), Value(float(speed[0]), f"{unit}/s")),
            Value(float(np.abs(speed).max()), f"{unit}/s"),
            Value(float(np.abs(acceleration).max()), f"{unit}/s^2"),
        ]
        text = "{} moves {} by {}: from {} to {}; it starts at {} with {}; at most {} and {}."
        yield Sentence(text, parts)


def _form(drive: Drive) -> str:
    signal = drive.position
    if isinstance(signal, Harmonic):
        return f"a sine of {signal.period:g} s"
    what = "a record" if isinstance(signal, Recorded) else "a table"
    return f"{what} of {np.size(signal.value)} values"
