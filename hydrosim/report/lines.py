"""Catenaries of a scene in pictures: their shapes at rest, and at the moments of a run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
import scipy
import xarray as xr

from hydrosim.dofs import about_z
from hydrosim.forces.kind import elements_of
from hydrosim.forces.line.catenary import Catenary, pull_entries
from hydrosim.forces.line.points import line_points
from hydrosim.forces.line.shape import LinePull
from hydrosim.forces.signal import compile_signals, value
from hydrosim.modes import NO_INDEX
from hydrosim.rigid.kinematics import LINE_PIECE
from hydrosim.scene import Scene

POINTS_PER_LINE = 41  # of a line at rest
POINTS_PER_REPLAY_LINE = 13  # of a line in a replay


class BodyPose(NamedTuple):
    """A body: its centre of gravity (3,) [m] and its rotation matrix (3, 3)."""

    centre: np.ndarray
    turn: np.ndarray


def catenaries_at_rest(scene: Scene) -> dict[str, np.ndarray]:
    """Points (n, 3) [m] of each catenary with all bodies at rest, by name, in the earth frame."""
    bodies = {}
    for body in scene.bodies:
        turn = about_z(body.heading)
        bodies[body.name] = BodyPose(turn @ body.centre_of_gravity + [*body.location, 0.0], turn)
    return {
        name: _points(line, bodies, scene, 0.0, POINTS_PER_LINE)
        for name, line in _catenaries(scene)
    }


def shapes_in(frames: xr.Dataset, scene: Scene) -> Iterator[tuple[str, Catenary, np.ndarray]]:
    """Each catenary with its shape (nt, n, 2) at the moments ``frames``: share of the way from the
    fairlead to the anchor, and height [m] above the straight line between them."""
    places = list(_body_poses(frames, scene))
    for name, line in _catenaries(scene):
        found = np.zeros((len(places), POINTS_PER_REPLAY_LINE, 2))
        for k, (t, bodies) in enumerate(zip(frames.time.values, places, strict=True)):
            points = _points(line, bodies, scene, float(t), POINTS_PER_REPLAY_LINE)
            chord = points[-1] - points[0]
            across = chord[:2] @ chord[:2]
            share = (points[:, :2] - points[0, :2]) @ chord[:2] / max(across, 1e-12)
            found[k, :, 0] = share
            found[k, :, 1] = points[:, 2] - points[0, 2] - share * chord[2]
        yield name, line, found


def _catenaries(scene: Scene) -> list[tuple[str, Any]]:
    return elements_of(scene, Catenary)


def _body_poses(frames: xr.Dataset, scene: Scene) -> Iterator[Mapping[str, BodyPose]]:
    """Bodies at each moment."""
    moved = frames.position.transpose("time", "body", "dof").values
    rest = frames.reference_position.values
    for now in moved:
        yield {
            body.name: BodyPose(
                rest[b] + now[b, :3],
                scipy.spatial.transform.Rotation.from_euler(
                    "ZYX", [now[b, 5] + body.heading, now[b, 4], now[b, 3]]
                ).as_matrix(),
            )
            for b, body in enumerate(scene.bodies)
        }


def _points(
    line: Catenary, bodies: Mapping[str, BodyPose], scene: Scene, t: float, count: int
) -> np.ndarray:
    """Points (count, 3) of a line in the earth frame; straight if it has no shape."""
    start = _point_in_earth(bodies, line.body, line.point)
    end = _point_in_earth(bodies, line.anchor_body, line.anchor)
    across = end[:2] - start[:2]
    x = float(np.hypot(*across))
    e = across / x if x > 0.0 else np.array([1.0, 0.0])
    z = float(start[2] - end[2])
    bed, friction = -np.inf, 0.0
    if line.friction is not None:
        bed, friction = min(-scene.environment.water_depth - end[2], 0.0), line.friction
    pieces = _pieces(line, t)
    pull = LinePull(*pull_entries(0, len(pieces), x, z, bed, friction, -1.0, 0.0, pieces))
    if not pull.converged:
        return np.linspace(start, end, count)
    found, _ = line_points(pieces, 0, len(pieces), x, z, bed, friction, pull, count)
    return np.column_stack([start[:2] + found[:, :1] * e, end[2] + found[:, 1]])


def _point_in_earth(
    bodies: Mapping[str, BodyPose], body: str | None, point: tuple[float, ...]
) -> np.ndarray:
    if body is None:
        return np.asarray(point, float)
    return np.asarray(bodies[body].centre + bodies[body].turn @ point)


def _pieces(line: Catenary, t: float) -> np.ndarray:
    pieces = np.zeros(line.length.size, dtype=LINE_PIECE)
    for name in ("length", "weight", "stiffness", "hung"):
        pieces[name] = getattr(line, name)
    if line.paid is not None and line.paying != NO_INDEX:
        each, parts = compile_signals([line.paid])
        pieces["length"][line.paying] = value(t, each[0], parts)
    return pieces
