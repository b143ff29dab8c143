"""Replay of a run in three dimensions: data of its page at moments of the run."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from hydrosim.dofs import about_z
from hydrosim.errors import InputError
from hydrosim.files.display_units import units_of
from hydrosim.files.document import Document
from hydrosim.files.document_nodes import Heading, Node, Replay
from hydrosim.report import scenery
from hydrosim.report.page import base64_of_floats
from hydrosim.report.scenery import POINTS_PER_REPLAY_LINE as POINTS_OF_LINE
from hydrosim.report.sentences.sections import title_of
from hydrosim.results.channels import load_variables
from hydrosim.scene import Cylindrical, Hinge, Rod, Scene, Slider, Universal
from hydrosim.scene.contacts import Contact, Fender, Landing

if TYPE_CHECKING:
    import xarray as xr

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
    nodes = list(replay_nodes(run, scenery.scene_of(run)))
    if not nodes:
        raise InputError("the run has fewer than two recorded times: there is nothing to replay.")
    lasts = f"{run.time.values[-1]:g} s"
    return Document(title_of(run), [Heading("Replay", "replay"), *nodes], lasts)


def replay_nodes(run: xr.Dataset, scene: Scene | None) -> Iterator[Node]:
    """Replay of a run with at least two records, in its ``scene``, if its case can be read
    again."""
    if run.time.size < 2:
        return
    shapes = (
        [scenery.shape_of(body, scenery.keel_of(scene, body.name)) for body in scene.bodies]
        if scene
        else [scenery.shape_of(None) for _ in run.body]
    )
    waves, water = scenery.waves_of(scene, run)
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
        "supports": scenery.supports_of(scene, [s.triangles for s in shapes], size)
        if scene
        else [],
        **_contact_frames(frames, scene),
        **_line_frames(frames, scene),
        "joints": list(_joint_shapes(scene, shapes, size)) if scene else [],
        **scenery.tanks_of(frames, scene),
    }
    notes += [scenery.TANKS_NOTE] if data["tanks"] else []
    notes += [scenery.SUPPORTS_NOTE] if data["supports"] else []
    notes += [ENLARGED_NOTE] if data["joints"] else []
    yield Replay(data, notes)


def _records_per_moment(run: xr.Dataset) -> int:
    """Number of records from one moment to the next."""
    single = len(load_variables(run)) + run.sizes.get("fender", 0) + run.sizes.get("tank", 0)
    numbers_per_record = 6 * run.sizes["body"] + single
    numbers_per_record += 2 * POINTS_OF_LINE * run.sizes.get("line", 0)
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
    return [
        list(map(float, about_z(b.heading) @ b.centre_of_gravity + [*b.location, 0.0]))
        for b in scene.bodies
    ]


def _magnification(position: np.ndarray, size: float) -> int:
    """Factor by which motions are first enlarged."""
    moves = float(np.nanstd(position[:, :, :3], axis=0).max())
    turns = size * float(np.nanstd(position[:, :, 3:], axis=0).max())
    wanted = MOTION_FRACTION * size / max(moves, turns, 1e-9)
    return max((f for f in ENLARGEMENTS if f <= wanted), default=1)


def _has_connections(run: xr.Dataset, scene: Scene | None) -> bool:
    """Whether enlarged motions would part what belongs together."""
    return "fender_mode" in run or bool(scene and scene.joints)


def _joint_shapes(
    scene: Scene, shapes: Sequence[scenery.Shape], size: float
) -> Iterator[dict[str, Any]]:
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
        bar = scenery.column(place - half * along, place + half * along, JOINT_HALF_WIDTH * size)
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
    return scenery.NO_BODY if name is None else [body.name for body in scene.bodies].index(name)


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
    shapes = {
        name: base64_of_floats(shape.ravel()) for name, _, shape in scenery.shapes_in(frames, scene)
    }
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
    for name, line in scenery.lines_of(scene).items():
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
