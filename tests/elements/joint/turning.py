"""Scenes that are the same but for where they are, or how they are told."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from jointed import places, rotations
from scipy.spatial.transform import Rotation

import hydrosim as hs
from hydrosim.dofs import about_z
from hydrosim.elements import Spring
from hydrosim.scene import Body, ForceElement, Joint, Scene


def points(run: xr.Dataset, scene: Scene) -> np.ndarray:
    """All named points over time (nt, np, 3), in the order of the bodies of ``scene``."""
    names = [f"{point} of {body.name}" for body in scene.bodies for point in body.points]
    return run.point_position.sel(point=names).values


def turned_back(found: np.ndarray, by: float, shift: Sequence[float] = (0.0, 0.0)) -> np.ndarray:
    """Points of a turned scene (nt, np, 3) where they would be without the turn."""
    return (found - [*shift, 0.0]) @ about_z(by)


def renamed(scene: Scene, names: Mapping[str, str]) -> Scene:
    """The same scene with other names of its bodies."""
    told = {n: (j, names[j.body], names.get(j.to or "")) for n, j in scene.joints.items()}
    joints = {n: replace(joint, body=body, to=to) for n, (joint, body, to) in told.items()}
    bodies = tuple(replace(body, name=names[body.name]) for body in scene.bodies)
    forces = {name: _renamed_force(e, names) for name, e in scene.forces.items()}
    return replace(scene, bodies=bodies, joints=joints, forces=forces)


def _renamed_force(e: ForceElement, names: Mapping[str, str]) -> ForceElement:
    if isinstance(e, Spring) and e.anchor_body is not None:
        return replace(e, body=names[e.body], anchor_body=names[e.anchor_body])
    return replace(e, body=names[e.body])


def at_rest(scene: Scene, name: str | None) -> tuple[np.ndarray, np.ndarray]:
    """Place and rotation of a body at rest, or of the earth."""
    if name is None:
        return np.zeros(3), np.eye(3)
    body = next(body for body in scene.bodies if body.name == name)
    R = about_z(body.heading)
    return np.array([*body.location, 0.0]) + R @ body.centre_of_gravity, R


def swapped(scene: Scene, name: str) -> Scene:
    """The same scene with a joint told from its other body."""
    told = scene.joints[name]
    assert told.to is not None
    place, R = at_rest(scene, told.body)
    to_place, to_R = at_rest(scene, told.to)
    turn = to_R.T @ R
    axes = told.axes() @ turn.T
    first, second = (1, 0) if told.type == "universal" else (0, 1)
    point = tuple(to_R.T @ (place + R @ told.point - to_place))
    lines = {"axis": tuple(axes[first]), "second_axis": tuple(axes[second])}
    keys = {key: line for key, line in lines.items() if key in told.schema_fields()}
    ends = {"body": told.to, "to": told.body, "point": point}
    other = replace(told, **ends, **keys, **_opposite(told, turn))
    return replace(scene, joints={**scene.joints, name: other})


def _opposite(told: Joint, turn: np.ndarray) -> dict[str, Any]:
    """Keys of motions seen from the other body. The first angle of a universal joint becomes the
    second. A ball's rotation has the same axis in both frames; its rate is told in the other
    frame."""
    if isinstance(told, hs.Ball):
        vector, rate = np.array(told.initial.rotation), np.array(told.initial.rate)
        there = Rotation.from_rotvec(vector).inv().apply(rate)
        return {"initial": hs.BallInitial(-turn @ vector, -turn @ there)}
    if isinstance(told, hs.Universal):
        first, second = (replace(form, **_negated(form)) for form in told.resistances)
        return {"first": second, "second": first}
    if isinstance(told, hs.Cylindrical):
        slide, spin = (replace(form, **_negated(form)) for form in told.resistances)
        return {"slide": slide, "turn": spin}
    return _negated(told) if isinstance(told, hs.Hinge | hs.Slider) else {}


def _negated(form: Any) -> dict[str, Any]:
    assert form.stops is None
    start = type(form.initial)(-form.position, -form.velocity)
    return {"neutral": -form.neutral, "initial": start}


def rooted(scene: Scene, root: str, run: xr.Dataset) -> Scene:
    """The scene with ``root`` as the body that keeps its own coordinates. It comes first and starts
    as in ``run``; all joints are told from the side that is farther from it."""
    reached, waiting, found = {root}, dict(scene.joints), scene
    while waiting:
        name = next(n for n, j in waiting.items() if j.body in reached or j.to in reached)
        told = waiting.pop(name)
        if told.body in reached:
            found = swapped(found, name)
        reached |= {told.body, str(told.to)}
    bodies = sorted(found.bodies, key=lambda body: body.name != root)
    return replace(found, bodies=tuple(_started(scene, body, root, run) for body in bodies))


def _started(scene: Scene, body: Body, root: str, run: xr.Dataset) -> Body:
    if body.name != root:
        return replace(body, position=(0.0,) * 6, velocity=(0.0,) * 6)
    place, _ = at_rest(scene, root)
    offset = places(run, root)[0] - place
    yaw, pitch, roll = Rotation.from_matrix(rotations(run, root)[0]).as_euler("ZYX")
    velocity = run.velocity.sel(body=root).values[0]
    position = (*offset, roll, pitch, yaw - body.heading)
    return replace(body, position=position, velocity=tuple(velocity))
