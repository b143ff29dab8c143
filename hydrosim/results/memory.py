"""Named points and the velocity history of a convolution, in the dataset of a run.

For the history see `hydrosim.water.radiation.history`.
The stored history ends at the last step but one. A continued run computes the node at its start
anew.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.errors import InputError
from hydrosim.integrate.names import memory_names
from hydrosim.multibody.kinematics import new_motion, place_bodies
from hydrosim.multibody.tree import NO_TREE
from hydrosim.results.variables import describe_values
from hydrosim.water.radiation.history import NOW, THEN, VelocityHistory, append_node

if TYPE_CHECKING:
    import xarray as xr

    from hydrosim.integrate.dynamics import Model
    from hydrosim.scene import Clearance, Scene

# Named points of bodies over time, and clearances between them, from the motions of a run.

Frames = tuple[np.ndarray, np.ndarray]
"""Positions of the centres of gravity (nt, nb, 3), and rotation matrices (nt, nb, 3, 3)."""


def point_names(scene: Scene) -> list[str]:
    """All named points, such as "bow of barge"."""
    return [f"{name} of {body.name}" for body in scene.bodies for name in body.points]


def point_positions(scene: Scene, frames: Frames) -> np.ndarray:
    """Positions (nt, np, 3) of all named points in the earth frame [m]."""
    return np.stack([_place_of_point(b, point, frames) for b, point in named_points(scene)], axis=1)


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
    return np.stack(
        [_clearance_over_time(scene, c, frames) for c in scene.output.clearances.values()], axis=1
    )


def check_points(scene: Scene) -> None:
    """Raises InputError if a clearance names a point that does not exist."""
    names = point_names(scene)
    bodies = [body.name for body in scene.bodies]
    for name, c in scene.output.clearances.items():
        for key, point in (("of", c.of), ("to", c.to)):
            if point is not None and point not in names:
                there = ", ".join(names) or (
                    "no point in this scene has a name (bodies.NAME.points)"
                )
                text = f"found {point}; expected one of the named points: {there}"
                raise InputError(f"output.clearances.{name}.{key}: {text}.")
        body = c.plane and c.plane.body
        if body and body not in bodies:
            expected = f"expected a body of this scene: {', '.join(bodies)}"
            raise InputError(f"output.clearances.{name}.plane.body: found {body}; {expected}.")


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


def _place_of_point(b: int, point: tuple[float, ...], frames: Frames) -> np.ndarray:
    place, rotation = frames
    return np.asarray(place[:, b] + rotation[:, b] @ np.asarray(point, float))


def _clearance_over_time(scene: Scene, c: Clearance, frames: Frames) -> np.ndarray:
    index = {body.name: b for b, body in enumerate(scene.bodies)}
    points = dict(zip(point_names(scene), named_points(scene), strict=True))

    def named_position(name: str) -> np.ndarray:
        return _place_of_point(*points[name], frames)

    here = named_position(c.of)
    if c.to is not None:
        return np.asarray(np.linalg.norm(here - named_position(c.to), axis=1))
    assert c.plane is not None
    normal = np.array(c.plane.normal, float) / np.linalg.norm(c.plane.normal)
    if c.plane.body is None:
        return np.asarray((here - np.array(c.plane.point)) @ normal)
    b = index[c.plane.body]
    turned = frames[1][:, b] @ normal
    return np.asarray(np.sum((here - _place_of_point(b, c.plane.point, frames)) * turned, axis=1))


HISTORY_ROWS = ("double integral", "integral", "velocity before", "velocity")
NODE = ("double integral", "integral", "velocity", "acceleration")
MIN_NODE_DISTANCE = (
    1e-6  # of a step of the grid: smaller distances from a point of the grid count as zero
)

MEMORY_PREFIX = "memory_"
"""Begins the names of all that a run keeps of a convolution."""


def encode_history(
    scene: Scene, model: Model, history: VelocityHistory
) -> tuple[dict[str, tuple[tuple[str, ...], np.ndarray]], dict[str, object]]:
    """Points of the grid, oldest first, and the node, with their dimensions and coordinates. Empty
    without a convolution. Before the first point integrals are zero until they are counted anew;
    then those points are kept too."""
    if not history.time[THEN] < np.inf:
        return {}, {}
    dofs, newest = np.unique(model.convolution.column), history.place[2]
    first = history.place[0] + history.place[1] - newest
    oldest = newest + 1 - (history.grid.shape[2] - first)
    if history.place[3] == 0:
        oldest = max(oldest, 0)
    points = np.arange(oldest, newest + 1)
    time = history.begin[0] + points * history.step
    coords: dict[str, object] = {
        "memory_row": describe_values("memory_row", list(HISTORY_ROWS), "remembered quantity"),
        "memory_dof": describe_values("memory_dof", memory_names(scene, model), "coordinate"),
        "memory_time": describe_values("memory_time", time, "time", "s"),
        "memory_node_row": describe_values("memory_node_row", list(NODE), "remembered quantity"),
        "memory_node_time": describe_values((), history.time[THEN], "time", "s"),
        "memory_begin": describe_values((), history.begin[0], "time of point 0", "s"),
        "memory_origin": describe_values(
            (), history.place[3], "index of the point at which integrals begin"
        ),
    }
    past = history.grid[:, dofs][:, :, first + newest - points]
    node = history.node[THEN][:, dofs]
    about = ("memory_row", "memory_dof", "memory_time")
    return {
        "memory_past": (about, past),
        "memory_node": (("memory_node_row", about[1]), node),
    }, coords


def take_over(run: xr.Dataset, dofs: np.ndarray, history: VelocityHistory) -> bool:
    """Fill the empty ``history`` with the history of ``run`` for these ``dofs``, in its order.
    Returns False and changes nothing if the grids differ."""
    time = run.memory_time.values
    begin, step = float(run.memory_begin), history.step
    points = np.rint((time - begin) / step).astype(int)
    if np.any(time != begin + points * step):
        return False
    newest = points[-1]
    columns = history.place[0] + newest - points
    inside = columns < history.grid.shape[2]
    history.grid[:, dofs[:, None], columns[inside]] = run.memory_past.values[:, :, inside]
    history.begin[0], history.place[1:] = begin, (newest, newest, int(run.memory_origin))
    history.time[NOW] = float(run.memory_node_time)
    history.node[NOW][:, dofs] = run.memory_node.values
    return True


def push_again(run: xr.Dataset, until: float, dofs: np.ndarray, history: VelocityHistory) -> None:
    """Fill the empty ``history`` with the history of ``run`` before the time ``until`` [s]: cubics
    between the points of its grid."""
    time, past = run.memory_time.values, run.memory_past.values
    count = int(np.searchsorted(time, until - MIN_NODE_DISTANCE * history.step))
    starts, ends = _one_sided_accelerations(time[:count], past[:, :, :count])
    v, a = np.zeros((2, history.node.shape[2]))
    for i in range(count):
        for velocity, acceleration in ((past[2, :, i], ends[:, i]), (past[3, :, i], starts[:, i])):
            v[dofs], a[dofs] = velocity, acceleration
            append_node(history, time[i], v, a)


def _one_sided_accelerations(time: np.ndarray, past: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Accelerations (dofs, points) after and before each point. They are third derivatives at both
    ends of the polynomials of degree 5 through the double integral; zero before the first point."""
    h, (Y, X) = np.diff(time), past[:2]
    rise, v0, v1 = 60.0 * np.diff(Y), past[3, :, :-1] * h * h, past[2, :, 1:] * h * h
    X0, X1 = X[:, :-1] * h, X[:, 1:] * h
    after = (rise - 36.0 * X0 - 24.0 * X1 - 9.0 * v0 + 3.0 * v1) / h**3
    before = (rise - 24.0 * X0 - 36.0 * X1 - 3.0 * v0 + 9.0 * v1) / h**3
    edge = np.zeros((len(Y), 1))
    return np.hstack([after, before[:, -1:] if h.size else edge]), np.hstack([edge, before])
