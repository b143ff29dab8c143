"""Supports of landings in a replay: arms from its points to their body, columns under its seats.

Both are for illustration: a case has positions, not shapes. They have the colour of the contact's
mode, more intense with a larger force.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from hydrosim.forces.contact.fender import Contact, Fender
from hydrosim.forces.contact.landing import Landing
from hydrosim.report.envelopes import base64_of
from hydrosim.scene import Scene

ARM_HALF_SIDE = 0.008  # of the size of the scene: half the side of an arm or a column
COLUMN_DEPTH = 0.15
"""Of the size of the scene: depth of columns below the water, at most to the bed."""
LEVEL_NORMAL = 0.9  # vertical part of a normal, above which a plane is nearly level
SUPPORTS_NOTE = (
    "Arms and columns at landings are illustrations; the case has positions, not shapes."
)
NO_BODY = -1  # in place of the index of a body


def keel_of(scene: Scene, name: str) -> float | None:
    """Height in the body frame [m] at which a landing or a plane of the body is touched from below;
    None if there is none."""
    found = [z for element in scene.forces.values() for z in _contact_heights(element, name)]
    return min((z for z in found if z < 0.0), default=None)


def _contact_heights(element: object, name: str) -> Iterator[float]:
    if isinstance(element, Landing) and element.body == name:
        yield from map(float, element.points[:, 2])
    elif isinstance(element, Fender) and element.plane.body == name:
        normal = np.asarray(element.plane.normal, float)
        if abs(normal[2]) > LEVEL_NORMAL * np.linalg.norm(normal):
            yield float(element.plane.point[2])


def supports_of(scene: Scene, shapes: Sequence[np.ndarray], size: float) -> list[dict[str, Any]]:
    """Arms and columns as triangles in the frame of a body or the earth, each with the index of its
    contact. ``shapes`` are the triangles of the bodies."""
    numbers = {body.name: k for k, body in enumerate(scene.bodies)}
    depth = min(COLUMN_DEPTH * size, scene.environment.water_depth)
    found: list[dict[str, Any]] = []
    contact = 0
    for element in scene.forces.values():
        if isinstance(element, Landing):
            for k, (point, seat) in enumerate(zip(element.points, element.seats, strict=True)):
                own = numbers[element.body]
                ends = [(own, point, _nearest_in_box(shapes[own], point))]
                if element.on is None:
                    ends += [(NO_BODY, seat, np.array([seat[0], seat[1], -depth]))]
                else:
                    on = numbers[element.on]
                    ends += [(on, seat, _nearest_in_box(shapes[on], seat))]
                found += [
                    {
                        "body": body,
                        "contact": contact + k,
                        "triangles": base64_of(column(a, b, ARM_HALF_SIDE * size).ravel()),
                    }
                    for body, a, b in ends
                ]
        contact += len(element.points) if isinstance(element, Contact) else 0
    return found


def column(one: np.ndarray, other: np.ndarray, half: float) -> np.ndarray:
    """Triangles (12, 3, 3) of a square column between two points, with sides of twice ``half``;
    empty if the points coincide."""
    along = np.asarray(other, float) - one
    if np.linalg.norm(along) == 0.0:
        return np.zeros((0, 3, 3))
    across = np.cross(along, np.eye(3)[int(np.abs(along).argmin())])
    across *= half / np.linalg.norm(across)
    other_way = np.cross(along, across) / np.linalg.norm(along)
    turned = [a * across + b * other_way for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    begin, end = np.asarray(one) + turned, np.asarray(other) + turned
    sides = [(begin[k], begin[k - 1], end[k - 1], end[k]) for k in range(4)]
    quads = np.array([*sides, begin, end[::-1]])
    return np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def _nearest_in_box(triangles: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Position nearest to a point in the box around a shape."""
    corners = triangles.reshape(-1, 3)
    return np.clip(point, corners.min(axis=0), corners.max(axis=0))
