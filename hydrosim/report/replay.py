"""Replay of a run in three dimensions: data of its page at moments of the run, and its scenery.

Scenery is from the case of the run: hulls, contacts, lines, supports, tanks, waves. Supports of
landings are for illustration: a case has positions, not shapes. They have the colour of the
contact's mode, more intense with a larger force.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import scipy

from hydrosim.case.load import load_case
from hydrosim.dofs import about_z
from hydrosim.elements.kind import elements_of
from hydrosim.elements.line.catenary import pieces_of_line, pull_entries
from hydrosim.elements.line.hang import SuspendedLine
from hydrosim.elements.line.points import line_points
from hydrosim.elements.line.shape import LinePull
from hydrosim.errors import InputError
from hydrosim.files.display_units import units_of
from hydrosim.files.document import Document
from hydrosim.files.document_nodes import Heading, Nodes, Replay
from hydrosim.report.page import base64_of_floats
from hydrosim.report.sentences.sections import title_of
from hydrosim.results.channels import load_variables
from hydrosim.run.provenance import case_of
from hydrosim.scene import (
    Body,
    Box,
    ChangedDatabase,
    Cylindrical,
    Family,
    Hinge,
    Rod,
    Scene,
    Slider,
    TankMesh,
    Universal,
)
from hydrosim.scene.body import TankShape
from hydrosim.scene.catenary import Catenary
from hydrosim.scene.contacts import Contact, Fender, Landing
from hydrosim.water.components import WaveComponents, sea

if TYPE_CHECKING:
    import xarray as xr

DECK_HEIGHT_RATIO = 1.2  # times the draught: depth of a hull whose recipe gives none
UNKNOWN_BOX_SIDE_M = 10.0  # m: side of the box for a body of unknown size
MIN_SIDE_RATIO = 0.1  # of its longest side: the shortest side of a box
MAX_COMPONENTS = 1200  # wave components on a page
ELEVATION_RTOL = 1e-6  # of the largest elevation: accuracy of recomputed waves
RECORDS_COMPARED = 50  # records at which they are compared
BOX_FACES = np.array(
    [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
)
BOX_CORNERS = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])


class Shape(NamedTuple):
    """Triangles (nt, 3, 3) about the centre of gravity of a body, and their description."""

    triangles: np.ndarray
    said: str


def scene_of(run: xr.Dataset) -> Scene | None:
    """Scene of a run, from the case in it; None if that cannot be read again."""
    try:
        text = case_of(run)
        with TemporaryDirectory() as folder:
            path = Path(folder, "case.yaml")
            path.write_text(text, "utf-8")
            scene = load_case(path).scene()
    except (InputError, KeyError, TypeError, OSError, UnicodeError):
        return None
    return scene if [b.name for b in scene.bodies] == list(map(str, run.body.values)) else None


def shape_of(body: Body | None, keel: float | None = None) -> Shape:
    """Shape of a body: its hull, or else a box with its radii of gyration, down to its ``keel`` [m]
    if known, which is the height at which it is touched from below."""
    if body is None:
        corners = box(np.full(3, UNKNOWN_BOX_SIDE_M))
        return Shape(corners, "a box, because its case cannot be read again")
    if body.hydrostatics is not None:
        return Shape(body.hydrostatics.corners - body.centre_of_gravity, "its hull")
    shape = _recipe_hull(body)
    if shape is not None:
        deck = f"a deck at {DECK_HEIGHT_RATIO:g} times the draught"
        source = f"the hull of its database's recipe, with {deck}"
        return Shape(shape - body.centre_of_gravity, source)
    square = np.diag(body.inertia) / body.mass
    sides = 6.0 * (square.sum() - 2.0 * square)  # of a homogeneous box
    least = max(float(sides.max()), 1e-6) * MIN_SIDE_RATIO**2
    made = box(np.sqrt(np.maximum(sides, least)))
    if keel is None:
        return Shape(made, "a box with its radii of gyration")
    made[..., 2] = np.where(made[..., 2] < 0.0, keel, made[..., 2])
    return Shape(made, "a box with its radii of gyration, down to its contact from below")


def box(sides: np.ndarray) -> np.ndarray:
    """Triangles (12, 3, 3) of a box about the origin."""
    quads = (BOX_CORNERS * sides)[BOX_FACES]
    return np.concatenate([quads[:, [0, 2, 1]], quads[:, [0, 3, 2]]])


def _recipe_hull(body: Body) -> np.ndarray | None:
    """Triangles of the hull of the recipe beside the database, if it exists and has a draught."""
    import netCDF4

    from hydrosim.database.build.recipe import shape_of_recipe

    source = body.hydrodynamics
    if isinstance(source, Family):
        source = source.members[0].source
    if isinstance(source, ChangedDatabase):
        source = source.source
    if not isinstance(source, Path):
        return None
    try:
        with netCDF4.Dataset(source) as file:
            name = str(getattr(file, "recipe", ""))
    except (OSError, RuntimeError):
        return None
    recipe = source.parent / Path(name).name
    if not (name and recipe.is_file()):
        return None
    for depth in (_recipe_depth(recipe, body.database_body), None):
        try:
            return shape_of_recipe(recipe, body.database_body, depth)
        except (InputError, ValueError, OSError):
            continue
    return None


def _recipe_depth(recipe: Path, body: int) -> float | None:
    from hydrosim.database.build.recipe import load_recipe

    parts = load_recipe(recipe).data.parts
    draught = getattr(parts[body - 1].hull, "draught", None) if body <= len(parts) else None
    return DECK_HEIGHT_RATIO * float(draught) if draught else None


def waves_of(scene: Scene | None, run: xr.Dataset) -> tuple[list[WaveComponents], str]:
    """Largest components of the waves of a run, and their description. Empty if the waves of its
    case are not those in the run."""
    if not np.any(run.wave_elevation):
        return [], "There are no waves."
    level = (
        "The water is drawn flat, because the waves of the run cannot be recomputed from its case."
    )
    if scene is None:
        return [], level
    try:
        sets = list(sea(scene.environment))
    except InputError:
        return [], level
    at = np.unique(np.linspace(0, run.time.size - 1, RECORDS_COMPARED).astype(int))
    time, elevation = run.time.values[at], run.wave_elevation.values[at]
    made = np.sum([_elevation_at_origin(waves, time) for waves in sets], axis=0)
    if not np.allclose(
        made, elevation, rtol=0.0, atol=ELEVATION_RTOL * np.abs(run.wave_elevation).max().item()
    ):
        return [], level
    return _largest_components(sets)


def _elevation_at_origin(waves: WaveComponents, time: np.ndarray) -> np.ndarray:
    """Elevation (nt,) at the origin."""
    grown = np.clip(time / waves.ramp, 0.0, 1.0) if waves.ramp > 0.0 else np.ones(time.size)
    angle = np.outer(time, waves.omega) + waves.phase
    return np.asarray(0.5 * (1.0 - np.cos(np.pi * grown)) * (np.cos(angle) @ waves.amplitude))


def _largest_components(sets: list[WaveComponents]) -> tuple[list[WaveComponents], str]:
    amplitude = np.concatenate([waves.amplitude for waves in sets])
    if amplitude.size <= MAX_COMPONENTS:
        return sets, f"The water is the sum of all {amplitude.size} components of the waves."
    least = np.sort(amplitude)[-MAX_COMPONENTS]
    share = np.sum(amplitude[amplitude >= least] ** 2) / np.sum(amplitude**2)
    selected = [_select_components(waves, waves.amplitude >= least) for waves in sets]
    return selected, (
        f"The water is the sum of the {MAX_COMPONENTS} largest of {amplitude.size} components of"
        f" the waves, which have {share:.0%} of their energy."
    )


def _select_components(waves: WaveComponents, these: np.ndarray) -> WaveComponents:
    names = ("omega", "amplitude", "phase", "wavenumber", "heading")
    return replace(waves, **{name: getattr(waves, name)[these] for name in names})


# Catenaries: shapes at rest, and at the moments of a run.

POINTS_PER_LINE = 41  # of a line at rest
POINTS_PER_REPLAY_LINE = 13  # of a line in a replay


class BodyPose(NamedTuple):
    """A body: its centre of gravity (3,) [m] and its rotation matrix (3, 3)."""

    centre: np.ndarray
    turn: np.ndarray


def poses_at_rest(scene: Scene) -> dict[str, BodyPose]:
    """All bodies at rest, by name."""
    turns = {body.name: about_z(body.heading) for body in scene.bodies}
    return {
        b.name: BodyPose(turns[b.name] @ b.centre_of_gravity + [*b.location, 0.0], turns[b.name])
        for b in scene.bodies
    }


def catenaries_at_rest(scene: Scene) -> dict[str, np.ndarray]:
    """Points (n, 3) [m] of each catenary with all bodies at rest, by name, in the earth frame."""
    bodies = poses_at_rest(scene)
    return {
        name: _points_of_line(line, bodies, scene, 0.0, POINTS_PER_LINE)
        for name, line in _catenaries_of_scene(scene)
    }


def shapes_in(frames: xr.Dataset, scene: Scene) -> Iterator[tuple[str, Catenary, np.ndarray]]:
    """Each catenary with its shape (nt, n, 2) at the moments ``frames``: share of the way from the
    fairlead to the anchor, and height [m] above the straight line between them."""
    places = list(_body_poses(frames, scene))
    for name, line in _catenaries_of_scene(scene):
        shapes = np.zeros((len(places), POINTS_PER_REPLAY_LINE, 2))
        for k, (t, bodies) in enumerate(zip(frames.time.values, places, strict=True)):
            points = _points_of_line(line, bodies, scene, float(t), POINTS_PER_REPLAY_LINE)
            chord = points[-1] - points[0]
            across = chord[:2] @ chord[:2]
            share = (points[:, :2] - points[0, :2]) @ chord[:2] / max(across, 1e-12)
            shapes[k, :, 0] = share
            shapes[k, :, 1] = points[:, 2] - points[0, 2] - share * chord[2]
        yield name, line, shapes


def lines_of(scene: Scene) -> dict[str, Any]:
    """The lines and rods from a point of a body to an anchor, by name."""
    forces: Mapping[str, Any] = scene.forces
    return {name: e for name, e in forces.items() if getattr(e, "anchor", None) and e.point}


def _catenaries_of_scene(scene: Scene) -> list[tuple[str, Any]]:
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


def _points_of_line(
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
    pieces = pieces_of_line(line, t)
    suspended = SuspendedLine(pieces, 0, len(pieces), x, z, bed, friction)
    pull = LinePull(*pull_entries(suspended, -1.0, 0.0))
    if not pull.converged:
        return np.linspace(start, end, count)
    line_positions, _ = line_points(suspended, pull, count)
    return np.column_stack([start[:2] + line_positions[:, :1] * e, end[2] + line_positions[:, 1]])


def _point_in_earth(
    bodies: Mapping[str, BodyPose], body: str | None, point: tuple[float, ...]
) -> np.ndarray:
    if body is None:
        return np.asarray(point, float)
    return np.asarray(bodies[body].centre + bodies[body].turn @ point)


# Supports of landings: arms to their body, columns under their seats.

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
    heights = [z for element in scene.forces.values() for z in _contact_heights(element, name)]
    return min((z for z in heights if z < 0.0), default=None)


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
    supports: list[dict[str, Any]] = []
    contact = 0
    for element in scene.forces.values():
        if isinstance(element, Landing):
            for k, (point, seat) in enumerate(zip(element.points, element.on.points, strict=True)):
                body_number = numbers[element.body]
                ends = [(body_number, point, _nearest_in_bounding_box(shapes[body_number], point))]
                if element.on.body is None:
                    ends += [(NO_BODY, seat, np.array([seat[0], seat[1], -depth]))]
                else:
                    on = numbers[element.on.body]
                    ends += [(on, seat, _nearest_in_bounding_box(shapes[on], seat))]
                supports += [
                    {
                        "body": body,
                        "contact": contact + k,
                        "triangles": base64_of_floats(column(a, b, ARM_HALF_SIDE * size).ravel()),
                    }
                    for body, a, b in ends
                ]
        contact += len(element.points) if isinstance(element, Contact) else 0
    return supports


def column(low: np.ndarray, high: np.ndarray, half: float) -> np.ndarray:
    """Triangles (12, 3, 3) of a square column between two points, with sides of twice ``half``;
    empty if the points coincide."""
    along = np.asarray(high, float) - low
    if np.linalg.norm(along) == 0.0:
        return np.zeros((0, 3, 3))
    across = np.cross(along, np.eye(3)[int(np.abs(along).argmin())])
    across *= half / np.linalg.norm(across)
    other_way = np.cross(along, across) / np.linalg.norm(along)
    turned = [a * across + b * other_way for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    begin, end = np.asarray(low) + turned, np.asarray(high) + turned
    sides = [(begin[k], begin[k - 1], end[k - 1], end[k]) for k in range(4)]
    quads = np.array([*sides, begin, end[::-1]])
    return np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def _nearest_in_bounding_box(triangles: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Position nearest to a point in the box around a shape."""
    corners = triangles.reshape(-1, 3)
    return np.clip(point, corners.min(axis=0), corners.max(axis=0))


# Tanks: boxes on their bodies, filled to their level at each moment.

TANKS_NOTE = (
    "Tanks are drawn as boxes, filled to their levels; hulls are translucent. A mesh tank is the"
    " box around it; tanks given by tables have no shape and are left out."
)


def tanks_of(frames: xr.Dataset, scene: Scene | None) -> dict[str, Any]:
    """Corners of tanks about the centres of gravity of their bodies, and the filled fractions of
    their heights (nt, nk)."""
    every = [(k, body) for k, body in enumerate(scene.bodies if scene else ()) if body.tanks]
    levels = _tank_levels(frames)
    drawn, full = [], []
    for number, body in every:
        for tank in body.tanks:
            if (ends := _shape_ends(tank.shape)) is not None:
                low, high = ends - np.asarray(body.centre_of_gravity)
                drawn.append({"name": tank.name, "body": number, "low": [*low], "high": [*high]})
                still = np.full(frames.time.size, tank.level)
                level = levels.get(f"{tank.name} of {body.name}", still)
                full.append(level / (high - low)[2])
    return {"tanks": drawn, "levels": base64_of_floats(np.array(full).T.ravel())}


def _tank_levels(frames: xr.Dataset) -> dict[str, np.ndarray]:
    """Levels (nt,) of the changing tanks."""
    if "tank_level" not in frames:
        return {}
    levels = frames.tank_level.transpose("tank", "time")
    return dict(zip(map(str, frames.tank.values), levels.values, strict=True))


def _shape_ends(shape: TankShape) -> np.ndarray | None:
    """Lowest and highest corner (2, 3) of the box of a tank."""
    if isinstance(shape, Box):
        return np.array([shape.low, shape.high], float)
    if isinstance(shape, TankMesh):
        return np.array([shape.corners.min(axis=(0, 1)), shape.corners.max(axis=(0, 1))])
    return None


# The replay itself: bodies, contacts, lines and joints at moments of the run.

MAX_REPLAY_BYTES = 2_200_000  # bytes of all moments, as 32-bit numbers
ENLARGEMENTS = (1, 2, 5, 10, 20, 50)  # of motions
MAX_WAVE_INTERVAL_S = 1.0  # s: moments further apart do not resolve waves
COARSE_NOTE = ", linearly interpolated: too far apart to follow waves"
INTERPOLATED_NOTE = ", linearly interpolated"
MOTION_FRACTION = 0.02  # of the size of the scene: drawn size of motions
ENLARGED_NOTE = (
    "Joints are drawn as bars along their axes; motions that are enlarged pull them apart."
)
JOINT_HALF_LENGTH = 0.55  # of the size of its body
JOINT_HALF_WIDTH = 0.012  # of the size of the scene: half its side
PLANE_HALF_SIDE = 0.12  # of the size of the scene: half the side of a plane without corners
AXIAL_JOINTS = (Hinge, Slider, Cylindrical, Universal)
"""Types of joints that are drawn along their axes."""


def replay_document(run: xr.Dataset) -> Document:
    """Document with the replay of a run only."""
    nodes = list(replay_nodes(run, scene_of(run)))
    if not nodes:
        raise InputError("the run has fewer than two recorded times: there is nothing to replay.")
    lasts = f"{run.time.values[-1]:g} s"
    return Document(title_of(run), [Heading("Replay", "replay"), *nodes], lasts)


def replay_nodes(run: xr.Dataset, scene: Scene | None) -> Nodes:
    """Replay of a run with at least two records, in its ``scene``, if its case can be read
    again."""
    if run.time.size < 2:
        return
    shapes = (
        [shape_of(body, keel_of(scene, body.name)) for body in scene.bodies]
        if scene
        else [shape_of(None) for _ in run.body]
    )
    waves, water = waves_of(scene, run)
    size = max(float(np.linalg.norm(shape.triangles, axis=-1).max()) for shape in shapes)
    step = _records_per_moment(run)
    frames = run.isel(time=slice(None, None, step))
    notes = [
        water,
        *(f"{b} is drawn as {s.said}." for b, s in zip(run.body.values, shapes, strict=True)),
    ]
    every = float(frames.time[1] - frames.time[0])
    how = COARSE_NOTE if every > MAX_WAVE_INTERVAL_S else INTERPOLATED_NOTE
    notes.append(f"Motions are shown every {every:g} s{how}.")
    names = list(map(str, run.body.values))
    units = units_of(run.attrs)
    data = {
        "bodies": [
            {"name": name, "triangles": base64_of_floats(shape.triangles.ravel())}
            for name, shape in zip(names, shapes, strict=True)
        ],
        "rest": _centres_at_rest(run, scene),
        "heading": [body.heading for body in scene.bodies] if scene else [0.0] * len(names),
        "time": base64_of_floats(frames.time.values),
        "position": base64_of_floats(_displacement_frames(frames).ravel()),
        "size": size,
        "force_unit": units.display_unit("N")._asdict(),
        "length_unit": units.display_unit("m")._asdict(),
        "factor": 1
        if _has_connections(run, scene)
        else _magnification(_displacement_frames(frames), size),
        "waves": [_wave_data(components) for components in waves],
        "planes": list(_plane_shapes(scene, size)) if scene else [],
        "supports": supports_of(scene, [s.triangles for s in shapes], size) if scene else [],
        **_contact_frames(frames, scene),
        **_line_frames(frames, scene),
        "joints": list(_joint_shapes(scene, shapes, size)) if scene else [],
        **tanks_of(frames, scene),
    }
    notes += [TANKS_NOTE] if data["tanks"] else []
    notes += [SUPPORTS_NOTE] if data["supports"] else []
    notes += [ENLARGED_NOTE] if data["joints"] else []
    yield Replay(data, notes)


def _records_per_moment(run: xr.Dataset) -> int:
    """Number of records from one moment to the next."""
    single = len(load_variables(run)) + run.sizes.get("fender", 0) + run.sizes.get("tank", 0)
    numbers_per_record = 6 * run.sizes["body"] + single
    numbers_per_record += 2 * POINTS_PER_REPLAY_LINE * run.sizes.get("line", 0)
    return -(-run.time.size * 4 * numbers_per_record // MAX_REPLAY_BYTES)


def _displacement_frames(frames: xr.Dataset) -> np.ndarray:
    """Displacements (nt, nb, 6)."""
    return np.asarray(frames.position.transpose("time", "body", "dof").values)


def _centres_at_rest(run: xr.Dataset, scene: Scene | None) -> list[list[float]]:
    """Centres of gravity at rest [m]."""
    if "reference_position" in run:
        return [list(map(float, x)) for x in run.reference_position.values]
    if scene is None:
        return [[0.0, 0.0, 0.0] for _ in run.body]
    return [list(map(float, pose.centre)) for pose in poses_at_rest(scene).values()]


def _magnification(position: np.ndarray, size: float) -> int:
    """Factor by which motions are first enlarged."""
    moves = float(np.nanstd(position[:, :, :3], axis=0).max())
    turns = size * float(np.nanstd(position[:, :, 3:], axis=0).max())
    wanted = MOTION_FRACTION * size / max(moves, turns, 1e-9)
    return max((f for f in ENLARGEMENTS if f <= wanted), default=1)


def _has_connections(run: xr.Dataset, scene: Scene | None) -> bool:
    """Whether enlarged motions would part what belongs together."""
    return "fender_mode" in run or bool(scene and scene.joints)


def _joint_shapes(scene: Scene, shapes: Sequence[Shape], size: float) -> Iterator[dict[str, Any]]:
    """Joints as bars along their axes, a little longer than their body, or as cubes if they have no
    axis; each on its body."""
    for name, joint in scene.joints.items():
        if isinstance(joint, Rod):  # a line
            continue
        number = _body_number(scene, joint.body)
        along = joint.axes()[0]
        long = float(np.ptp(shapes[number].triangles.reshape(-1, 3) @ along))
        half = (
            JOINT_HALF_LENGTH * long if isinstance(joint, AXIAL_JOINTS) else JOINT_HALF_WIDTH * size
        )
        place = np.array(joint.point)
        bar = column(place - half * along, place + half * along, JOINT_HALF_WIDTH * size)
        yield {
            "name": name,
            "body": number,
            "point": list(map(float, joint.point)),
            "triangles": base64_of_floats(bar.ravel()),
        }


def _wave_data(waves: Any) -> dict[str, Any]:
    names = ("omega", "amplitude", "phase", "wavenumber", "heading")
    return {name: base64_of_floats(getattr(waves, name)) for name in names} | {"ramp": waves.ramp}


def _body_number(scene: Scene, name: str | None) -> int:
    return NO_BODY if name is None else [body.name for body in scene.bodies].index(name)


def _contact_frames(frames: xr.Dataset, scene: Scene | None) -> dict[str, Any]:
    """Contact points on their bodies, with modes and forces (nt, nf)."""
    if "fender_mode" not in frames or scene is None:
        return {"contacts": [], "modes": "", "forces": ""}
    places = [
        (_body_number(scene, element.body), list(map(float, point)))
        for element in scene.forces.values()
        if isinstance(element, Contact)
        for point in element.points
    ]
    names = map(str, frames.fender.values)
    dims = ("time", "fender")
    return {
        "contacts": [
            {"name": name, "body": body, "point": point}
            for name, (body, point) in zip(names, places, strict=True)
        ],
        "modes": base64_of_floats(frames.fender_mode.transpose(*dims).values.ravel()),
        "forces": base64_of_floats(frames.fender_normal_force.transpose(*dims).values.ravel()),
    }


def _plane_shapes(scene: Scene, size: float) -> Iterator[dict[str, Any]]:
    """Planes of fenders as polygons, and seats of landings as points, each on its body or the
    earth."""
    for element in scene.forces.values():
        if isinstance(element, Fender):
            plane = element.plane
            corners = plane.corners or _square_corners(
                plane.point, plane.normal, PLANE_HALF_SIDE * size
            )
            number = _body_number(scene, plane.body)
            yield {"body": number, "corners": [list(map(float, c)) for c in corners]}
        elif isinstance(element, Landing):
            number = _body_number(scene, element.on.body)
            for seat in element.on.points:
                corners = _square_corners(seat, element.on.axis, 0.15 * PLANE_HALF_SIDE * size)
                yield {"body": number, "corners": [list(map(float, c)) for c in corners]}


def _square_corners(point: Any, normal: Any, half: float) -> np.ndarray:
    n = np.asarray(normal, float) / np.linalg.norm(normal)
    first = np.cross(n, np.eye(3)[int(np.abs(n).argmin())])
    first /= np.linalg.norm(first)
    second = np.cross(n, first)
    around = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    return np.array([point + half * (a * first + b * second) for a, b in around])


def _line_frames(frames: xr.Dataset, scene: Scene | None) -> dict[str, Any]:
    """Lines of all kinds from point to anchor, and rods between their ends, with the sizes (nt, n)
    of their forces. A catenary has a ``shape`` (nt, n, 2), see `shapes_in`."""
    drawn = dict(_ends_of_lines(scene)) if scene else {}
    if scene is None or not drawn:
        return {"lines": [], "tensions": ""}
    variables = load_variables(frames)
    loads = [_load_frames(frames, name, *variables.get(name, ("", ""))) for name in drawn]
    shapes = {name: base64_of_floats(shape.ravel()) for name, _, shape in shapes_in(frames, scene)}
    return {
        "lines": [
            {
                "name": name,
                "body": _body_number(scene, body),
                "point": list(map(float, point)),
                "anchor_body": _body_number(scene, anchor_body),
                "anchor": list(map(float, anchor)),
                "shape": shapes.get(name, ""),
            }
            for name, (body, point, anchor_body, anchor) in drawn.items()
        ],
        "tensions": base64_of_floats(np.abs(np.transpose(loads)).ravel()),
    }


def _ends_of_lines(scene: Scene) -> Iterator[tuple[str, tuple[str | None, Any, str | None, Any]]]:
    """Name of each line and rod; its body with the point on it, and the same of its other end."""
    for name, line in lines_of(scene).items():
        yield name, (line.body, line.point, line.anchor_body, line.anchor)
    for name, joint in scene.joints.items():
        if isinstance(joint, Rod):
            yield name, (joint.body, joint.point, joint.to, joint.to_point)


def _load_frames(frames: xr.Dataset, name: str, variable: str, dim: str) -> np.ndarray:
    """Force (nt,) in a line or rod: its load, or the force of a joint."""
    if variable:
        return np.asarray(frames[variable].sel({dim: name}).values)
    force = frames.joint_force.sel(joint=name).transpose("time", "dof").values
    return np.asarray(np.linalg.norm(force[:, :3], axis=1))
