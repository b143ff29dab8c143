"""Named points of bodies over time, and clearances between them, from the motions of a run."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.errors import InputError
from hydrosim.multibody.kinematics import new_motion, place_bodies
from hydrosim.multibody.tree import NO_TREE

if TYPE_CHECKING:
    from hydrosim.integrate.dynamics import Model
    from hydrosim.scene import Clearance, Scene

Frames = tuple[np.ndarray, np.ndarray]
"""Positions of the centres of gravity (nt, nb, 3), and rotation matrices (nt, nb, 3, 3)."""


def point_names(scene: Scene) -> list[str]:
    """All named points, such as "bow of barge"."""
    return [f"{name} of {body.name}" for body in scene.bodies for name in body.points]


def point_positions(scene: Scene, frames: Frames) -> np.ndarray:
    """Positions (nt, np, 3) of all named points in the earth frame [m]."""
    return np.stack([_place(b, point, frames) for b, point in named_points(scene)], axis=1)


def coordinates(scene: Scene) -> dict[str, object]:
    """Coordinates: names of all points, and the body of each."""
    names = point_names(scene)
    owners = [scene.bodies[b].name for b, _ in named_points(scene)]
    attributes = {"long_name": "body of the point"}
    return {"point": ("point", names), "point_body": ("point", owners, attributes)} if names else {}


def named_points(scene: Scene) -> Iterator[tuple[int, tuple[float, ...]]]:
    """Body index and body-frame position of all named points."""
    for b, body in enumerate(scene.bodies):
        yield from ((b, point) for point in body.points.values())


def clearances(scene: Scene, frames: Frames) -> np.ndarray:
    """Clearances (nt, nc) [m]: distances between two points, or between a point and a plane. They
    are negative behind the plane."""
    return np.stack([_clearance(scene, c, frames) for c in scene.clearances.values()], axis=1)


def check_points(scene: Scene) -> None:
    """Raises InputError if a clearance names a point that does not exist."""
    names = point_names(scene)
    bodies = [body.name for body in scene.bodies]
    for name, c in scene.clearances.items():
        for key, point in (("of", c.of), ("to", c.to)):
            if point is not None and point not in names:
                there = ", ".join(names) or (
                    "no point in this scene has a name (bodies.NAME.points)"
                )
                text = f"found {point}; expected one of the named points: {there}"
                raise InputError(f"output.clearances.{name}.{key}: {text}.")
        if c.body is not None and c.body not in bodies:
            expected = f"expected a body of this scene: {', '.join(bodies)}"
            raise InputError(f"output.clearances.{name}.plane.body: found {c.body}; {expected}.")


def frames_of(model: Model, coordinates: np.ndarray) -> Frames:
    """Positions and rotations of the bodies at ``coordinates`` (nt, 6 nb) as they are recorded,
    which tell them without the joints."""
    count = len(model.bodies.each)
    bodies = model.bodies._replace(active=np.arange(6 * count), tree=NO_TREE)
    motion = new_motion(bodies)
    still = np.zeros(6 * count)
    rotation = np.zeros((len(coordinates), count, 3, 3))
    for k, q in enumerate(coordinates):
        place_bodies(q, still, bodies, motion)
        rotation[k] = motion.rotation
    place = coordinates.reshape(len(coordinates), count, 6)[:, :, :3] + bodies.each["origin"]
    return place, rotation


def _place(b: int, point: tuple[float, ...], frames: Frames) -> np.ndarray:
    place, rotation = frames
    return np.asarray(place[:, b] + rotation[:, b] @ np.asarray(point, float))


def _clearance(scene: Scene, c: Clearance, frames: Frames) -> np.ndarray:
    index = {body.name: b for b, body in enumerate(scene.bodies)}
    points = dict(zip(point_names(scene), named_points(scene), strict=True))

    def named_position(name: str) -> np.ndarray:
        return _place(*points[name], frames)

    here = named_position(c.of)
    if c.to is not None:
        return np.asarray(np.linalg.norm(here - named_position(c.to), axis=1))
    normal = np.array(c.normal, float) / np.linalg.norm(c.normal)
    if c.body is None:
        return np.asarray((here - np.array(c.place, float)) @ normal)
    b = index[c.body]
    turned = frames[1][:, b] @ normal
    return np.asarray(np.sum((here - _place(b, c.place, frames)) * turned, axis=1))
